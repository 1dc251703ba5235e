"""Formulas for people: sums and products in the order a textbook prints them.

Sums and products are flattened and sorted, which the exact text of `text` must not do. How the parts
look is a `Style`; plain text and LaTeX are two of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symbody.errors import ExpressionError, Problem
from symbody.expr import opcodes as op
from symbody.expr.graph import Constant, Graph, Kind, Symbol
from symbody.expr.rewrite import tree_size
from symbody.expr.text import LARGEST

SUM, PRODUCT, POWER, ATOM = range(4)


@dataclass(frozen=True, slots=True)
class Shown:
    """A printed part: its text, how tightly it binds, and what it is sorted by.

    Attributes
    ----------
    order : int
        Highest time derivative of a coordinate in it; -1 without coordinates.
    rank : int
        Place among factors: numbers, parameters, symbols of time, functions.
    """

    text: str
    strength: int
    order: int
    rank: int


@dataclass(frozen=True, slots=True)
class Style:
    """How the parts of a formula are written."""

    symbol: Callable[[Symbol], str]
    number: Callable[[Constant], str]
    pi: str
    product: str
    fraction: Callable[[Shown, Shown], Shown]
    power: Callable[[Shown, Shown], Shown]
    root: Callable[[Shown], Shown]
    function: Callable[[str, Sequence[str]], str]
    condition: Callable[[str, Sequence[str]], str]
    choice: Callable[[str, str, str], str]
    brackets: Callable[[str], str]


def show(graph: Graph, node: int, style: Style) -> str:
    """Return a node as a formula.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out.
    """
    size = tree_size(graph, node)
    if size > LARGEST:
        raise ExpressionError(
            Problem("expression.too_long", "", f"written out the formula has {size} operations",
                    f"formulas end at {LARGEST}", "ask for a sequence or for generated code")
        )  # fmt: skip
    known: dict[int, Shown] = {}
    for item in graph.reachable([node]):
        known[item] = _shown(graph, item, known, style)
    return known[node].text


def bracketed(part: Shown, strength: int, style: Style) -> str:
    """Return the text of a part, in brackets if it binds less than `strength`."""
    return part.text if part.strength >= strength else style.brackets(part.text)


def _shown(graph: Graph, node: int, known: dict[int, Shown], style: Style) -> Shown:
    code = graph.ops[node]
    if code in op.LEAVES:
        return _leaf(graph, node, style)
    if code in (op.ADD, op.SUB, op.NEG):
        return _sum(graph, node, known, style)
    if code == op.MUL:
        return _product(graph, node, known, style)
    parts = [known[k] for k in graph.operands(node)]
    if code == op.DIV:
        return style.fraction(*parts)
    if code == op.POW:
        return style.power(*parts)
    if code == op.SQRT:
        return style.root(parts[0])
    return _named(graph, node, parts, style)


def _leaf(graph: Graph, node: int, style: Style) -> Shown:
    value = graph.number(node)
    if value is not None:
        plain = isinstance(value, int) or Fraction(value).denominator == 1
        return Shown(style.number(value), ATOM if plain else PRODUCT, -1, 0)
    if graph.ops[node] == op.PI:
        return Shown(style.pi, ATOM, -1, 0)
    symbol = graph.symbols[graph.left[node]]
    constant = symbol.kind == Kind.PARAMETER
    moving = symbol.kind in (Kind.COORDINATE, Kind.SPEED)
    return Shown(style.symbol(symbol), ATOM, symbol.order if moving else -1, 1 if constant else 2)


def _sum(graph: Graph, node: int, known: dict[int, Shown], style: Style) -> Shown:
    terms: list[tuple[int, Shown]] = []
    stack = [(1, node)]
    while stack:
        sign, item = stack.pop()
        code = graph.ops[item]
        if code == op.NEG:
            stack.append((-sign, graph.left[item]))
        elif code in (op.ADD, op.SUB):
            stack += [(sign if code == op.ADD else -sign, graph.right[item]), (sign, graph.left[item])]
        else:
            terms.append((sign, known[item]))
    terms.sort(key=lambda term: (-term[1].order, term[0] < 0, term[1].rank == 0, term[1].text))
    text = ""
    for sign, part in terms:
        joint = (" + " if sign > 0 else " - ") if text else ("" if sign > 0 else "-")
        text += joint + bracketed(part, PRODUCT, style)
    # A lone negative term binds like a sum: in a product it needs brackets.
    return Shown(text, SUM, max(part.order for _, part in terms), 3)


def _product(graph: Graph, node: int, known: dict[int, Shown], style: Style) -> Shown:
    factors: list[Shown] = []
    divisor = 1
    stack = [node]
    while stack:
        item = stack.pop()
        value = graph.number(item)
        if graph.ops[item] == op.MUL:
            stack += [graph.right[item], graph.left[item]]
        elif isinstance(value, Fraction) and value.denominator < 10:
            divisor *= value.denominator
            if value.numerator != 1:
                factors.append(Shown(style.number(value.numerator), ATOM, -1, 0))
        else:
            factors.append(known[item])
    factors.sort(key=lambda part: (part.rank, part.text))
    order = max(part.order for part in factors)
    text = style.product.join(bracketed(part, PRODUCT if part.rank == 0 else POWER, style) for part in factors)
    shown = Shown(text, PRODUCT, order, 3)
    return shown if divisor == 1 else style.fraction(shown, Shown(style.number(divisor), ATOM, -1, 0))


def _named(graph: Graph, node: int, parts: Sequence[Shown], style: Style) -> Shown:
    code = graph.ops[node]
    texts = [part.text for part in parts]
    order = max((part.order for part in parts), default=-1)
    if code == op.SELECT:
        return Shown(style.choice(*texts), ATOM, order, 3)
    if code in op.CONDITIONS:
        return Shown(style.condition(op.NAMES[code], texts), SUM, order, 3)
    name = graph.functions[graph.right[node]].name if code == op.CALL else op.NAMES[code]
    return Shown(style.function(name, texts), ATOM, order, 3)
