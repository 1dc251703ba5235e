"""Partial derivatives of single operations with respect to their operands."""

from __future__ import annotations

from collections.abc import Callable

from symbody.expr.canonical import ONE, TWO, add, apply, div, mul, neg, power, sub
from symbody.expr.graph import Graph
from symbody.expr.opcodes import (
    ABS,
    ACOS,
    ADD,
    ASIN,
    ATAN,
    ATAN2,
    CALL,
    COS,
    COSH,
    DIV,
    EXP,
    FLOOR,
    FMA,
    LOG,
    MUL,
    NEG,
    POW,
    SIGN,
    SIN,
    SINH,
    SQRT,
    SUB,
    TAN,
    TANH,
)  # fmt: skip


def partials(g: Graph, node: int) -> list[tuple[int, int]]:
    """Return (operand, derivative of `node` by that operand), zero ones left out.

    Conditions have derivative zero, abs that of the branch taken; select, min and max are in `branches`.
    """
    op = g.ops[node]
    rule = _RULES.get(op)
    if rule is not None:
        return rule(g, node, *g.operands(node))
    if op == CALL:
        return _call(g, node)
    return []


def _neg(g: Graph, node: int, a: int) -> list[tuple[int, int]]:
    return [(a, neg(g, ONE))]


def _add(g: Graph, node: int, a: int, b: int) -> list[tuple[int, int]]:
    return [(a, ONE), (b, ONE)]


def _sub(g: Graph, node: int, a: int, b: int) -> list[tuple[int, int]]:
    return [(a, ONE), (b, neg(g, ONE))]


def _mul(g: Graph, node: int, a: int, b: int) -> list[tuple[int, int]]:
    return [(a, b), (b, a)]


def _div(g: Graph, node: int, a: int, b: int) -> list[tuple[int, int]]:
    return [(a, div(g, ONE, b)), (b, neg(g, div(g, node, b)))]


def _pow(g: Graph, node: int, a: int, b: int) -> list[tuple[int, int]]:
    exponent = g.number(b)
    if exponent is not None:
        return [(a, mul(g, b, power(g, a, g.constant(exponent - 1))))]
    by_base = mul(g, b, power(g, a, sub(g, b, ONE)))
    by_exponent = mul(g, node, apply(g, LOG, a))
    # A constant base needs no derivative by it; log of it is then a constant too.
    return [(b, by_exponent)] if g.number(a) is not None else [(a, by_base), (b, by_exponent)]


def _fma(g: Graph, node: int, a: int, b: int, c: int) -> list[tuple[int, int]]:
    return [(a, b), (b, a), (c, ONE)]


def _atan2(g: Graph, node: int, y: int, x: int) -> list[tuple[int, int]]:
    square = add(g, power(g, x, TWO), power(g, y, TWO))
    return [(y, div(g, x, square)), (x, neg(g, div(g, y, square)))]


def _unary(rule: Callable[[Graph, int, int], int]) -> Callable[..., list[tuple[int, int]]]:
    return lambda g, node, a: [(a, rule(g, node, a))]


def _one_minus_square(g: Graph, a: int) -> int:
    return sub(g, ONE, power(g, a, TWO))


def _asin(g: Graph, node: int, a: int) -> int:
    return div(g, ONE, apply(g, SQRT, _one_minus_square(g, a)))


def _call(g: Graph, node: int) -> list[tuple[int, int]]:
    function = g.functions[g.right[node]]
    operands = g.operands(node)
    return [(a, g.many(CALL, operands, g.function(function.derivative(k)))) for k, a in enumerate(operands)]


_RULES: dict[int, Callable[..., list[tuple[int, int]]]] = {
    NEG: _neg, ADD: _add, SUB: _sub, MUL: _mul, DIV: _div, POW: _pow, FMA: _fma, ATAN2: _atan2,
    SIN: _unary(lambda g, node, a: apply(g, COS, a)),
    COS: _unary(lambda g, node, a: neg(g, apply(g, SIN, a))),
    TAN: _unary(lambda g, node, a: add(g, ONE, power(g, node, TWO))),
    ASIN: _unary(_asin),
    ACOS: _unary(lambda g, node, a: neg(g, _asin(g, node, a))),
    ATAN: _unary(lambda g, node, a: div(g, ONE, add(g, ONE, power(g, a, TWO)))),
    SINH: _unary(lambda g, node, a: apply(g, COSH, a)),
    COSH: _unary(lambda g, node, a: apply(g, SINH, a)),
    TANH: _unary(lambda g, node, a: _one_minus_square(g, node)),
    EXP: _unary(lambda g, node, a: node),
    LOG: _unary(lambda g, node, a: div(g, ONE, a)),
    SQRT: _unary(lambda g, node, a: div(g, ONE, mul(g, TWO, node))),
    ABS: _unary(lambda g, node, a: apply(g, SIGN, a)),
    SIGN: lambda g, node, a: [],
    FLOOR: lambda g, node, a: [],
}  # fmt: skip
