"""Expressions as text in symbody's own grammar: parsing the text gives the same node again."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Final

from symbody.errors import ExpressionError, Problem
from symbody.expr import opcodes as op
from symbody.expr.graph import Constant, Graph
from symbody.expr.rewrite import tree_size

# A formula longer than this is no text for a person; longer ones are shown as sequences.
LARGEST: Final = 20_000

_CHOICE, _CONDITION, _SUM, _PRODUCT, _POWER, _ATOM = range(6)
_BINARY: Final[Mapping[int, tuple[str, int]]] = {
    op.ADD: (" + ", _SUM), op.SUB: (" - ", _SUM), op.MUL: ("*", _PRODUCT), op.DIV: ("/", _PRODUCT),
    op.LT: (" < ", _CONDITION), op.LE: (" <= ", _CONDITION), op.EQ: (" == ", _CONDITION),
    op.AND: (" and ", _CHOICE), op.OR: (" or ", _CHOICE),
}  # fmt: skip


def to_text(graph: Graph, node: int) -> str:
    """Return a node as text that parses to the same node.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out, or where an operation has no text.
    """
    size = tree_size(graph, node)
    if size > LARGEST:
        raise ExpressionError(
            Problem("expression.too_long", "", f"written out the expression has {size} operations",
                    f"text is for reading and ends at {LARGEST}", "ask for a sequence or for generated code")
        )  # fmt: skip
    known: dict[int, tuple[str, int]] = {}
    for item in graph.reachable([node]):
        known[item] = _printed(graph, item, known)
    return known[node][0]


def number_text(value: Constant) -> str:
    """Return a constant as text that reads as the same constant: ``3/4``, ``9.81``, 17 digits if rounded."""
    if isinstance(value, float):
        return f"{value:.16e}"
    exact = Fraction(value)
    if exact.denominator == 1:
        return str(exact.numerator)
    decimal = _decimal(exact)
    return decimal if decimal is not None else f"{exact.numerator}/{exact.denominator}"


def _decimal(value: Fraction) -> str | None:
    """Return an exact decimal of at most 15 digits, or None; halves, quarters and eighths stay ratios."""
    rest, twos, fives = value.denominator, 0, 0
    while rest % 2 == 0:
        rest, twos = rest // 2, twos + 1
    while rest % 5 == 0:
        rest, fives = rest // 5, fives + 1
    places = max(twos, fives)
    if rest != 1 or value.denominator < 10:
        return None
    digits = str(abs(value.numerator) * 10**places // value.denominator).rjust(places + 1, "0")
    sign = "-" if value < 0 else ""
    return f"{sign}{digits[:-places]}.{digits[-places:]}" if len(digits) <= 15 else None


def _printed(graph: Graph, node: int, known: Mapping[int, tuple[str, int]]) -> tuple[str, int]:
    """Return the text of a node and how tightly it binds."""
    code = graph.ops[node]
    if code in op.LEAVES:
        return _leaf(graph, node)
    operands = [known[k] for k in graph.operands(node)]
    if code == op.NEG:
        return _negated(graph, graph.left[node], known)
    if code in _BINARY:
        sign, strength = _BINARY[code]
        right = strength + 1
        left = right if strength == _CONDITION else strength
        return f"{_wrapped(operands[0], left)}{sign}{_wrapped(operands[1], right)}", strength
    if code == op.POW:
        return f"{_wrapped(operands[0], _ATOM)}**{_wrapped(operands[1], _ATOM)}", _POWER
    if code == op.NOT:
        return f"not {_wrapped(operands[0], _ATOM)}", _CHOICE
    if code == op.FMA:
        a, b, c = operands
        return f"{_wrapped(a, _PRODUCT)}*{_wrapped(b, _POWER)} + {_wrapped(c, _PRODUCT)}", _SUM
    return f"{_function_name(graph, node)}({', '.join(text for text, _ in operands)})", _ATOM


def _leaf(graph: Graph, node: int) -> tuple[str, int]:
    value = graph.number(node)
    if value is not None:
        text = number_text(value)
        return text, _PRODUCT if "/" in text else _ATOM
    if graph.ops[node] == op.PI:
        return "pi", _ATOM
    return graph.symbols[graph.left[node]].label, _ATOM


def _negated(graph: Graph, inner: int, known: Mapping[int, tuple[str, int]]) -> tuple[str, int]:
    if graph.ops[inner] == op.SUB:  # -(b - a) is a - b
        a, b = known[graph.right[inner]], known[graph.left[inner]]
        return f"{_wrapped(a, _SUM)} - {_wrapped(b, _PRODUCT)}", _SUM
    return f"-{_wrapped(known[inner], _PRODUCT)}", _SUM


def _function_name(graph: Graph, node: int) -> str:
    code = graph.ops[node]
    if code == op.SELECT:
        return "if"
    if code == op.CALL:
        return graph.functions[graph.right[node]].name
    if code in (op.SADDLE, op.PICK):
        raise ExpressionError(
            Problem("expression.no_text", "", "the solution of a constrained system has no formula",
                    "it is computed with pivots", "ask for generated code")
        )  # fmt: skip
    return op.NAMES[code]


def _wrapped(part: tuple[str, int], strength: int) -> str:
    return part[0] if part[1] >= strength else f"({part[0]})"
