"""Formulas in the order of a textbook: ``m x'' + d x' + k x``, ``m g l sin(theta)``.

Sums and products are flattened and sorted, which text that is to be read back must not do. A sum begins
with the highest derivatives of coordinates and ends with functions; a product has its number first, then
parameters, coordinates, sums, functions. Neither depends on when nodes were made. How the parts look is
a `Style`.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar, Final, NamedTuple, TypeAlias

from symbody.expr import opcodes as op
from symbody.expr.flattening import SUMS, linear_terms, power_factors
from symbody.expr.graph import Constant, Exact, Graph, Kind, Symbol
from symbody.expr.printing import (
    ATOM,
    BOTH,
    CHOICE,
    COMPARISON,
    NEGATION,
    POWER,
    PRODUCT,
    SUM,
    Brackets,
    Layout,
    Notation,
    NotationFor,
    Piece,
    joined,
    no_formula,
    number_text,
)
from symbody.expr.rewrite import node_cost

# Single letters that books put first in a product, in their order: masses and inertias, stiffness and
# damping, gravity. Other names follow alphabetically.
_FIRST_LETTERS: Final = "mMIJkKcdbg"
_LINEAR: Final = SUMS | {op.MUL, op.DIV, op.POW}

NameKey: TypeAlias = tuple[int | str, ...]


class Style(ABC):
    """How the parts of a formula look."""

    brackets: ClassVar[Brackets] = Brackets()
    times: ClassVar[str] = " "
    pi: ClassVar[str] = "pi"
    # LT and GT, LE and GE, EQ and NE, AND, OR, NOT
    relations: ClassVar[Sequence[str]] = ("<", ">", "<=", ">=", "==", "!=", "and", "or", "not ")

    @abstractmethod
    def symbol(self, symbol: Symbol) -> str:
        """Return the name of a symbol, with the marks of its derivatives."""

    @abstractmethod
    def number(self, value: Constant) -> str:
        """Return a number >= 0 that is no ratio."""

    @abstractmethod
    def ratio(self, ratio: tuple[int, int], above: Sequence[Piece], below: Sequence[Piece]) -> Layout:
        """Return the quotient of two lists of factors, times a ratio of whole numbers; not both empty."""

    @abstractmethod
    def power(self, base: Piece, exponent: Piece) -> Layout:
        """Return a power; the parts are operands or text."""

    @abstractmethod
    def function(self, name: str, arguments: Sequence[Piece], exponent: int = 1) -> Layout:
        """Return a function of any number of arguments, to a whole power."""

    @abstractmethod
    def choice(self, cases: Sequence[tuple[Piece, Piece]], otherwise: Piece) -> Layout:
        """Return values with their conditions, and the value for the remaining case."""


class SortKey(NamedTuple):
    """What a node is sorted by.

    Attributes
    ----------
    moving : int
        0 without symbols that depend on time, 1 with time, inputs or multipliers, n + 2 with the nth
        derivative of a coordinate, or the one before of a speed; functions are not looked into.
    is_function : bool
        Whether there is a function in it.
    size : int
        Operations; large ones are not told apart.
    low, high : tuple
        First and last of the names in it; empty without names.
    """

    moving: int
    is_function: bool
    size: int
    low: NameKey
    high: NameKey


def textbook(graph: Graph, roots: Sequence[int], style: Style) -> NotationFor:
    """Return the notation of a style for the nodes that the `roots` are computed from."""
    keys = _sort_keys(graph, roots)

    def notation(named: Mapping[int, str]) -> Notation:
        return _Page(graph, style, keys, named).layout

    return notation


def name_key(name: str) -> NameKey:
    """Return what names are sorted by: conventional letters first, then the alphabet, numbers by value."""
    parts: list[int | str] = []
    for word, digits in re.findall(r"(\D*)(\d*)", name):
        parts += [word.casefold(), word, int(digits or -1)]
    stem = re.match(r"[A-Za-z]*", name)
    letter = stem.group() if stem else ""
    place = _FIRST_LETTERS.find(letter) if len(letter) == 1 else -1
    return (place if place >= 0 else len(_FIRST_LETTERS), *parts)


def _sort_keys(graph: Graph, roots: Sequence[int]) -> dict[int, SortKey]:
    keys: dict[int, SortKey] = {}
    for node in graph.reachable(roots):
        if graph.ops[node] == op.SYMBOL:
            symbol = graph.symbols[graph.left[node]]
            name = name_key(symbol.name)
            keys[node] = SortKey(_moving(symbol), False, 0, name, name)
            continue
        parts = [keys[k] for k in graph.operands(node)]
        is_function = graph.ops[node] not in _LINEAR and bool(parts)
        keys[node] = SortKey(
            0 if is_function else max((key.moving for key in parts), default=0),
            is_function or any(key.is_function for key in parts),
            min(node_cost(graph, node) + sum(key.size for key in parts), 1 << 62),
            min((key.low for key in parts if key.low), default=()),
            max((key.high for key in parts), default=()),
        )
    return keys


def _moving(symbol: Symbol) -> int:
    if symbol.kind == Kind.PARAMETER:
        return 0
    first = {Kind.COORDINATE: 2, Kind.SPEED: 3}.get(symbol.kind)
    return 1 if first is None else first + symbol.order


@dataclass(frozen=True, slots=True)
class _Page:
    """The notation of one style for one graph."""

    graph: Graph
    style: Style
    keys: Mapping[int, SortKey]
    named: Mapping[int, str]

    def layout(self, node: int) -> Layout:
        graph = self.graph
        code, a, b = graph.ops[node], graph.left[node], graph.right[node]
        if code in op.LEAVES:
            return self._leaf(node)
        if code in SUMS or (code == op.MUL and graph.ops[a] == op.RATIONAL):
            return self._sum(node)
        if code in (op.MUL, op.DIV, op.POW):
            return self._product(node, 1)
        if code in op.CONDITIONS:
            return self._condition(node)
        if code == op.SELECT:
            return self._choice(node)
        if code == op.FMA:
            x, y, z = graph.operands(node)
            return Layout([(x, POWER), self.style.times, (y, POWER), " + ", (z, PRODUCT)], SUM)
        if code == op.PICK:
            raise no_formula()
        return self._function(node, 1)

    def _leaf(self, node: int) -> Layout:
        value = self.graph.number(node)
        if value is not None:
            return self._product(node, 1)
        if self.graph.ops[node] == op.PI:
            return Layout([self.style.pi], ATOM)
        return Layout([self.style.symbol(self.graph.symbols[self.graph.left[node]])], ATOM)

    def _sum(self, node: int) -> Layout:
        terms = linear_terms(self.graph, node, self.named)
        order = sorted(terms, key=self._term_key)
        first = next((term for term in order if terms[term] > 0), None)
        if first is not None:  # a minus in front is easily overlooked
            order.remove(first)
            order.insert(0, first)
        pieces: list[Piece] = []
        for term in order:
            minus = terms[term] < 0
            pieces.append((" - " if minus else " + ") if pieces else "-" if minus else "")
            part = self._product(term, abs(terms[term]))
            if len(order) == 1 and not minus:
                return part
            pieces += self._at_least(part, PRODUCT)
        return Layout(pieces or [self.style.number(0)], SUM if pieces else ATOM)

    def _term_key(self, term: int) -> tuple[object, ...]:
        key = self.keys[term]
        return (-key.moving, key.is_function, not key.low, key.size, key.low, key.high, self.graph.hashes[term])
