"""Expressions as text of symbody's own language: reading the text gives the same node again.

Brackets keep every grouping of the graph, and no more than that. Not all nodes have a text that the
language takes back: it has no names such as ``x_{1}``, no whole powers above 64, no roots of negative
numbers, no functions of the user, no fused products (written ``a*b + c``), and a limited length.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Final

from symbody.errors import ExpressionError, Problem
from symbody.expr import opcodes as op
from symbody.expr.graph import Graph
from symbody.expr.language.caret import printable
from symbody.expr.language.tokens import is_name, normalize
from symbody.expr.printing.layout import (
    ATOM,
    BOTH,
    CHOICE,
    COMPARISON,
    NEGATION,
    POWER,
    PRODUCT,
    SUM,
    Layout,
    Notation,
    NotationFor,
    join_pieces,
    no_formula,
    number_text,
    print_node,
)

# Operations between two operands: the sign, and how tightly it binds.
_INFIX: Final[Mapping[int, tuple[str, int]]] = {
    op.ADD: (" + ", SUM), op.SUB: (" - ", SUM), op.MUL: ("*", PRODUCT), op.DIV: ("/", PRODUCT),
    op.AND: (" and ", BOTH), op.OR: (" or ", CHOICE),
}  # fmt: skip
_COMPARED: Final[Mapping[int, str]] = {op.LT: " < ", op.LE: " <= ", op.EQ: " == "}
# Operand orders are free, and these go on from the left: b + c + a is a + (b + c).
_CHAINED: Final[Mapping[int, tuple[int, ...]]] = {
    op.ADD: (op.ADD, op.SUB), op.MUL: (op.MUL, op.DIV), op.AND: (op.AND,), op.OR: (op.OR,),
}  # fmt: skip


def to_text(graph: Graph, node: int) -> str:
    """Return a node as text that reads as the same node.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out, for names that cannot be written, and for entries of kernels.
    """
    return print_node(graph, node, _notation_for(graph))


def _notation_for(graph: Graph) -> NotationFor:
    def notation(named: Mapping[int, str]) -> Notation:
        return partial(_layout, graph, named)

    return notation


def _layout(graph: Graph, named: Mapping[int, str], node: int) -> Layout:
    code, a, b = graph.ops[node], graph.left[node], graph.right[node]
    if code in op.LEAVES:
        return _leaf(graph, node)
    if code == op.NEG:
        if graph.ops[a] == op.SUB and a not in named:  # -(b - a) is a - b
            return Layout([(graph.right[a], SUM), " - ", (graph.left[a], PRODUCT)], SUM)
        return Layout(["-", (a, PRODUCT)], SUM)
    if code in _INFIX:
        return _infix(graph, named, node)
    if code in _COMPARED:
        return Layout([(a, SUM), _COMPARED[code], (b, SUM)], COMPARISON)
    if code == op.POW:
        return Layout([(a, ATOM), "**", (b, ATOM)], POWER)
    if code == op.NOT:
        if graph.ops[a] == op.EQ:
            return Layout([(graph.left[a], SUM), " != ", (graph.right[a], SUM)], COMPARISON)
        return Layout(["not ", (a, NEGATION)], NEGATION)
    return _function(graph, node)


def _leaf(graph: Graph, node: int) -> Layout:
    value = graph.number(node)
    if value is not None:
        text = number_text(value)
        return Layout([text], PRODUCT if "/" in text else ATOM)
    if graph.ops[node] == op.PI:
        return Layout(["pi"], ATOM)
    label = graph.symbols[graph.left[node]].label
    if not is_name(label) or normalize(label) != label:
        raise ExpressionError(
            Problem(
                "expression.unwritable_name", "", f"'{printable(label)}' cannot be written in an expression",
                "names there have letters, digits and _, begin with no digit, and are not if, and, or, not",
                "rename the quantity, or print LaTeX",
            )
        )  # fmt: skip
    return Layout([label], ATOM)


def _infix(graph: Graph, named: Mapping[int, str], node: int) -> Layout:
    code, a, b = graph.ops[node], graph.left[node], graph.right[node]
    sign, strength = _INFIX[code]
    if code == op.MUL and graph.ops[a] == op.RATIONAL:
        top, _, bottom = number_text(graph.constants[graph.left[a]]).partition("/")
        return Layout(
            [(b, PRODUCT), f"/{bottom}"] if top == "1" else [(a, PRODUCT), "*", (b, POWER)], PRODUCT
        )
    chained = _CHAINED.get(code, ())
    if b not in named and graph.ops[b] in chained and (a in named or graph.ops[a] not in chained):
        a, b = b, a
    return Layout([(a, strength), sign, (b, strength + 1)], strength)


def _function(graph: Graph, node: int) -> Layout:
    code = graph.ops[node]
    operands = graph.operands(node)
    if code == op.FMA:
        a, b, c = operands
        return Layout([(a, PRODUCT), "*", (b, POWER), " + ", (c, PRODUCT)], SUM)
    if code == op.PICK:
        raise no_formula()
    name = graph.functions[graph.right[node]].name if code == op.CALL else op.NAMES[code]
    name = "if" if code == op.SELECT else name
    return Layout([f"{name}(", *join_pieces(", ", [[(operand, CHOICE)] for operand in operands]), ")"], ATOM)
