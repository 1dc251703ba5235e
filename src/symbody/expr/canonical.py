"""The folding rules: every node is made in canonical form, so equal structure is one node.

Signs float outwards (a NEG is never the operand of a sum, product or quotient), constants stand
left, other operands of commutative operations are ordered by structural hash. Folded are only
identities that hold at every point: ``0*x``, ``1*x``, ``x+0``, ``x-x``, ``x+x``, ``x*x``, equal
bases, whole powers, ``sin(-x)``, ``sqrt(x)**2``, exact constants. Never done: expansion, ``x/x``,
``sqrt(x**2)``, reassociation of rounded constants, rules of exp and log.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from symbody.expr.arithmetic import ONE, TWO, ZERO, add, div, integer_power, mul, neg, sub
from symbody.expr.constants import fold_function
from symbody.expr.graph import Constant, Graph
from symbody.expr.opcodes import (
    ABS,
    ADD,
    AND,
    ATAN2,
    CALL,
    COS,
    DIV,
    EQ,
    EVEN_FUNCTIONS,
    FMA,
    LE,
    LT,
    MAP,
    MAX,
    MIN,
    MUL,
    NEG,
    NOT,
    ODD_FUNCTIONS,
    OR,
    PI,
    PICK,
    POW,
    RATIONAL,
    SADDLE,
    SELECT,
    SIN,
    SQRT,
    SUB,
    TAN,
)  # fmt: skip

__all__ = [
    "ONE", "TWO", "ZERO", "add", "apply", "constant", "div", "make", "mul", "neg", "pi", "power", "select",
    "sub",
]  # fmt: skip


def constant(g: Graph, value: Constant) -> int:
    """Return the node of a number."""
    return g.constant(value)


def pi(g: Graph) -> int:
    """Return the node of the circle constant."""
    return g.pi()


def power(g: Graph, a: int, b: int) -> int:
    """Return ``a ** b``."""
    exponent = g.number(b)
    if isinstance(exponent, float) and exponent.is_integer() and abs(exponent) <= 64:
        exponent = int(exponent)
    if isinstance(exponent, int):
        return integer_power(g, a, exponent)
    if exponent is not None and 2 * exponent == 1:
        return apply(g, SQRT, a)
    if exponent is not None and 2 * exponent == -1:
        return div(g, ONE, apply(g, SQRT, a))
    base = g.number(a)
    if isinstance(base, float) or isinstance(exponent, float):
        folded = None if base is None or exponent is None else fold_function(POW, base, exponent)
        if folded is not None:
            return g.constant(folded)
    return ONE if a == ONE else g.node(POW, a, b)


def apply(g: Graph, op: int, *operands: int) -> int:
    """Return a function, condition or choice by its operation code."""
    if len(operands) == 1 and op != NOT:
        return _apply_unary(g, op, operands[0])
    if op == ATAN2:
        folded = _fold(g, op, *operands)
        return g.node(op, *operands) if folded is None else folded
    if op in (MIN, MAX):
        return _extremum(g, op, *operands)
    if op == SELECT:
        return select(g, *operands)
    if op == FMA:
        return g.many(FMA, operands)
    return _condition(g, op, *operands)


def select(g: Graph, condition: int, then: int, otherwise: int) -> int:
    """Return ``then`` where `condition` holds, else ``otherwise``."""
    decided = g.number(condition)
    if decided is not None:
        return then if decided else otherwise
    if then == otherwise:
        return then
    if g.ops[condition] == NOT:
        return select(g, g.left[condition], otherwise, then)
    return g.many(SELECT, (condition, then, otherwise))


def make(g: Graph, op: int, operands: tuple[int, ...], datum: int = 0) -> int:
    """Return the node of `op` and `operands`, folded; leaves excepted."""
    rule = _RULES.get(op)
    if rule is not None:
        return rule(g, *operands)
    if op == PICK:
        return g.node(PICK, operands[0], datum)
    if op in (CALL, SADDLE, MAP):
        return g.many(op, operands, datum)
    return apply(g, op, *operands)


_RULES: dict[int, Callable[..., int]] = {
    NEG: neg, ADD: add, SUB: sub, MUL: mul, DIV: div, POW: power, SELECT: select,
}  # fmt: skip


def _apply_unary(g: Graph, op: int, a: int) -> int:
    folded = _fold(g, op, a)
    if folded is not None:
        return folded
    if g.ops[a] == NEG and op in ODD_FUNCTIONS:
        return neg(g, _apply_unary(g, op, g.left[a]))
    if g.ops[a] == NEG and op in EVEN_FUNCTIONS:
        return _apply_unary(g, op, g.left[a])
    if op in (SIN, COS, TAN) and (turns := _multiple_of_pi(g, a)) is not None:
        known = _circle_value(g, op, turns)
        if known is not None:
            return known
    return a if op == ABS and g.ops[a] in (ABS, SQRT) else g.node(op, a)


def _multiple_of_pi(g: Graph, a: int) -> Fraction | None:
    if g.ops[a] == PI:
        return Fraction(1)
    if g.ops[a] == MUL and g.ops[g.left[a]] == RATIONAL and g.ops[g.right[a]] == PI:
        return Fraction(g.constants[g.left[g.left[a]]])
    return None


def _circle_value(g: Graph, op: int, turns: Fraction) -> int | None:
    """Return sin, cos or tan of ``turns * pi`` where it is 0, 1, or half a root of 1, 2, 3."""
    if op == TAN:
        sine, cosine = _circle_value(g, SIN, turns), _circle_value(g, COS, turns)
        return None if sine is None or cosine is None or cosine == ZERO else div(g, sine, cosine)
    turns = (turns if op == SIN else turns + Fraction(1, 2)) % 2
    sign = 1
    if turns >= 1:
        turns, sign = turns - 1, -1
    turns = min(turns, 1 - turns)
    if turns == 0:
        return ZERO
    square = {Fraction(1, 6): 1, Fraction(1, 4): 2, Fraction(1, 3): 3, Fraction(1, 2): 4}.get(turns)
    if square is None:
        return None
    value = mul(g, g.constant(Fraction(1, 2)), apply(g, SQRT, g.constant(square)))
    return neg(g, value) if sign < 0 else value


def _extremum(g: Graph, op: int, a: int, b: int) -> int:
    x, y = g.number(a), g.number(b)
    if x is not None and y is not None:
        return a if (x <= y) == (op == MIN) else b
    if a == b:
        return a
    return g.node(op, a, b) if g.hashes[a] <= g.hashes[b] else g.node(op, b, a)


def _condition(g: Graph, op: int, *operands: int) -> int:
    values = [g.number(k) for k in operands]
    if op == NOT:
        if values[0] is not None:
            return ZERO if values[0] else ONE
        return g.left[operands[0]] if g.ops[operands[0]] == NOT else g.node(NOT, operands[0])
    x, y = values
    if op in (AND, OR):
        for value, other in ((x, operands[1]), (y, operands[0])):
            if value is not None:
                return other if bool(value) == (op == AND) else (ZERO if op == AND else ONE)
    elif x is not None and y is not None:
        return ONE if (x < y if op == LT else x <= y if op == LE else x == y) else ZERO
    elif op == LT and operands[0] == operands[1]:
        return ZERO
    a, b = operands
    if op in (EQ, AND, OR) and g.hashes[a] > g.hashes[b]:
        a, b = b, a
    return a if a == b and op in (AND, OR) else g.node(op, a, b)


def _fold(g: Graph, op: int, *operands: int) -> int | None:
    values = [g.number(k) for k in operands]
    if any(value is None for value in values):
        return None
    result = fold_function(op, *(value for value in values if value is not None))
    return None if result is None or not math.isfinite(result) else g.constant(result)
