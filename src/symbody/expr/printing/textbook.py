"""Formulas in the order of a textbook: ``m x'' + d x' + k x``, ``m g l sin(theta)``.

Sums and products are flattened and sorted, which text that is to be read back must not do. A sum begins
with the highest derivatives of coordinates and ends with functions; a product has its number first, then
parameters, coordinates, sums, functions. Neither depends on when nodes were made. How the parts look is
a `Style`.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar, Final, NamedTuple, TypeAlias

from symbody.expr import opcodes as op
from symbody.expr.graph import Constant, Exact, Graph, Symbol, SymbolKind
from symbody.expr.printing.flattening import SUMS, linear_terms, power_factors, without_square_roots
from symbody.expr.printing.layout import (
    ATOM,
    BOTH,
    CHOICE,
    COMPARISON,
    NEGATION,
    POWER,
    PRODUCT,
    ROUND,
    SUM,
    Brackets,
    Layout,
    Notation,
    NotationFor,
    Piece,
    bind_tightly,
    join_pieces,
    no_formula,
)
from symbody.expr.printing.numerals import ALL_DIGITS, Numerals
from symbody.expr.rewrite import node_cost

# Single letters that books put first in a product: masses, inertias, stiffness, gravity. Other names follow
# alphabetically.
_FIRST_LETTERS: Final = "mMIJkKg"
_LINEAR: Final = SUMS | {op.MUL, op.DIV, op.POW}
# Larger powers of numbers stay powers.
_MAX_EXPONENT: Final = 16

NameKey: TypeAlias = tuple[int | str, ...]
Factor: TypeAlias = Sequence[Piece]


@dataclass(frozen=True, slots=True, kw_only=True)
class Style(ABC):
    """How the parts of a formula look.

    Attributes
    ----------
    numerals : Numerals
        How many digits numbers have.
    """

    numerals: Numerals = ALL_DIGITS
    brackets: ClassVar[Brackets] = ROUND
    times: ClassVar[str] = " "
    plus: ClassVar[str] = " + "
    minus: ClassVar[str] = " - "
    negative: ClassVar[str] = "-"  # in front of a sum
    pi: ClassVar[str] = "pi"
    # LT and GT, LE and GE, EQ and NE, AND, OR, NOT
    relations: ClassVar[Sequence[str]] = ("<", ">", "<=", ">=", "==", "!=", "and", "or", "not ")

    @abstractmethod
    def symbol(self, symbol: Symbol) -> str:
        """Return the name of a symbol, with the marks of its derivatives."""

    @abstractmethod
    def number(self, value: Constant) -> str:
        """Return a number >= 0 that is not a ratio."""

    @abstractmethod
    def ratio(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        """Return the quotient of two products, times a ratio of whole numbers."""

    def with_number(
        self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]
    ) -> tuple[list[Factor], list[Factor]]:
        """Return the factors above and below the line with the ratio's numbers in front."""
        top: list[Factor] = [[self.number(ratio.numerator)]] if ratio.numerator != 1 else []
        bottom: list[Factor] = [[self.number(ratio.denominator)]] if ratio.denominator != 1 else []
        return [*top, *above], [*bottom, *below]

    def inline_quotient(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        """Return a quotient of two products on one line."""
        top, bottom = self.with_number(ratio, above, below)
        pieces = join_pieces(self.times, top or [[self.number(1)]])
        if len(bottom) == 1:
            pieces += ["/", *bottom[0]]
        elif bottom:
            opening, closing = self.brackets
            pieces += ["/", opening, *join_pieces(self.times, bottom), closing]
        return Layout(pieces, PRODUCT)

    def line(self, factors: Sequence[Factor]) -> list[Piece]:
        """Return a product that stands alone, above or below the line of a fraction or without one."""
        if len(factors) == 1 and len(factors[0]) == 1:
            return [bind_tightly(factors[0][0], CHOICE)]
        return join_pieces(self.times, factors)

    @abstractmethod
    def power(self, base: Piece, exponent: Piece) -> Layout:
        """Return a power."""

    @abstractmethod
    def function(self, name: str, arguments: Sequence[Piece], exponent: int = 1) -> Layout:
        """Return a function of any number of arguments, to a whole power."""

    @abstractmethod
    def choice(self, cases: Sequence[tuple[Piece, Piece]], otherwise: Piece) -> Layout:
        """Return values with the conditions they have, and the value for the remaining case."""


class SortKey(NamedTuple):
    """What a node is sorted by.

    Attributes
    ----------
    moving : int
        0 without symbols that depend on time, 1 with time, inputs or multipliers, n + 2 with the nth
        derivative of a coordinate, or the one before of a speed; functions are not looked into.
    has_multiplier : bool
        Whether there is a multiplier in it: these terms stand last.
    is_function : bool
        Whether there is a function in it.
    size : int
        Operations; large numbers count as equal.
    low, high : tuple
        First and last of the names in it; empty without names.
    """

    moving: int
    has_multiplier: bool
    is_function: bool
    size: int
    low: NameKey
    high: NameKey


def textbook(
    graph: Graph, roots: Sequence[int], style: Style, leading: Mapping[int, int] | None = None
) -> NotationFor:
    """Return the notation of a style for the nodes that the `roots` are computed from.

    Parameters
    ----------
    leading : mapping of root to node, optional
        The symbol whose terms come first in the sum of a root: its own acceleration.
    """
    keys = _sort_keys(graph, roots)

    def notation(named: Mapping[int, str]) -> Notation:
        return _Page(graph, style, keys, named, leading or {}).layout

    return notation


def name_key(name: str) -> NameKey:
    """Return the sorting key of a name: conventional letters first, then the alphabet, numbers by value."""
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
            is_multiplier = symbol.kind is SymbolKind.MULTIPLIER
            keys[node] = SortKey(_order_of_motion(symbol), is_multiplier, False, 0, name, name)
            continue
        parts = [keys[k] for k in graph.operands(node)]
        is_function = graph.ops[node] not in _LINEAR and bool(parts)
        keys[node] = SortKey(
            0 if is_function else max((key.moving for key in parts), default=0),
            any(key.has_multiplier for key in parts),
            is_function or any(key.is_function for key in parts),
            min(node_cost(graph, node) + sum(key.size for key in parts), 1 << 62),
            min((key.low for key in parts if key.low), default=()),
            max((key.high for key in parts), default=()),
        )
    return keys


def _order_of_motion(symbol: Symbol) -> int:
    if symbol.kind == SymbolKind.PARAMETER:
        return 0
    first = {SymbolKind.COORDINATE: 2, SymbolKind.SPEED: 3}.get(symbol.kind)
    return 1 if first is None else first + symbol.order


@dataclass(frozen=True, slots=True)
class _Page:
    """The notation of one style for one graph."""

    graph: Graph
    style: Style
    keys: Mapping[int, SortKey]
    named: Mapping[int, str]
    leading: Mapping[int, int]

    def layout(self, node: int) -> Layout:
        graph = self.graph
        code, a, b = graph.ops[node], graph.left[node], graph.right[node]
        value = graph.number(node)
        if value is not None and code != op.NEG:
            return self._number(value)
        if code in op.LEAVES:
            return Layout([self._name(node)], ATOM)
        if code in SUMS or code == op.MUL:
            return self._sum(node)
        if code == op.DIV or (code == op.POW and isinstance(graph.number(b), int)):
            return self._product(node, 1, is_open=True)
        if code == op.POW:
            return self.style.power((a, ATOM), (b, CHOICE))
        return self._condition(node) if code in op.CONDITIONS else self._function(node, 1)

    def _name(self, node: int) -> str:
        if self.graph.ops[node] == op.PI:
            return self.style.pi
        return self.style.symbol(self.graph.symbols[self.graph.left[node]])

    def _number(self, value: Constant) -> Layout:
        if not isinstance(value, float) and "/" in self.style.numerals.text(value):
            return self.style.ratio(Fraction(value), [], [])
        return Layout([self.style.number(value)], ATOM)

    def _sum(self, node: int) -> Layout:
        terms = linear_terms(self.graph, node, self.named)
        leading = self._terms_with(terms, self.leading.get(node))
        order = sorted(terms, key=lambda term: (term not in leading, *self._term_key(term)))
        first = next((term for term in order if terms[term] > 0), None)
        if first is not None:  # a minus in front is easily overlooked
            order.remove(first)
            order.insert(0, first)
        pieces: list[Piece] = []
        for term in order:
            weight = terms[term]
            minus = weight < 0
            is_open = term not in self.named or term == node
            part = self._product(term, -weight if minus else weight, is_open=is_open)
            if len(order) == 1 and not minus:
                return part
            style = self.style
            between, first_sign = (style.minus, style.negative) if minus else (style.plus, "")
            pieces += [between if pieces else first_sign, *part.pieces]
        return Layout(pieces or [self.style.number(0)], SUM if pieces else ATOM)

    def _terms_with(self, terms: Iterable[int], symbol: int | None) -> set[int]:
        """Return the terms that a symbol stands in; named parts are not looked into."""
        if symbol is None:
            return set()
        return {term for term in terms if symbol in self.graph.reachable([term])}

    def _term_key(self, term: int) -> tuple[object, ...]:
        key = self.keys[term]
        return (
            key.has_multiplier,
            -key.moving,
            key.is_function,
            not key.low,
            key.size,
            key.low,
            key.high,
            self.graph.hashes[term],
        )

    def _product(self, node: int, coefficient: Exact, *, is_open: bool) -> Layout:
        """Return a product that binds at least as tightly as PRODUCT."""
        graph = self.graph
        above, below = power_factors(graph, node, self.named) if is_open else ({node: 1}, {})
        above, below = without_square_roots(graph, above, below, self.named)
        for factor in [k for k in above if graph.ops[k] == op.RATIONAL and above[k] <= _MAX_EXPONENT]:
            coefficient *= Fraction(graph.constants[graph.left[factor]]) ** above.pop(factor)
        number = self._with_rounded(coefficient, above, below)
        if number == 1 and not below and len(above) == 1:
            ((factor, exponent),) = above.items()
            return self._power(factor, exponent, PRODUCT)
        factors = self._factors(above)
        ratio = Fraction(1)
        if isinstance(number, float) or "/" not in self.style.numerals.text(number):
            if number != 1:
                factors.insert(0, [self.style.number(number)])
        else:
            ratio = Fraction(number)
        return self.style.ratio(ratio, factors, self._factors(below))

    def _with_rounded(
        self, coefficient: Exact, above: dict[int, int], below: dict[int, int]
    ) -> Exact | float:
        """Return a coefficient times the rounded numbers of a product, which are taken out of it."""
        graph = self.graph
        product: Exact | float = coefficient
        for factors, sign in ((above, 1), (below, -1)):
            for node in [k for k in factors if graph.ops[k] == op.FLOAT]:
                value = graph.number(node)
                if isinstance(value, float) and 0.0 < abs(value) and abs(factors[node]) <= _MAX_EXPONENT:
                    product = float(product) * value ** (sign * factors.pop(node))
        return product

    def _factors(self, exponents: Mapping[int, int]) -> list[Factor]:
        order = sorted(exponents, key=self._factor_key)
        return [self._power(factor, exponents[factor], POWER).pieces for factor in order]

    def _factor_key(self, factor: int) -> tuple[object, ...]:
        graph, key = self.graph, self.keys[factor]
        code = graph.ops[factor]
        if code == op.SYMBOL:
            rank = 1 if key.moving == 0 else 3 if key.moving == 1 else 4
        elif code in op.LEAVES:
            rank = 0
        else:
            rank = 6 if key.is_function else 2 if key.moving == 0 else 5
        return (rank, key.moving, key.low, key.high, code, graph.hashes[factor])

    def _power(self, factor: int, exponent: int, strength: int) -> Layout:
        code = self.graph.ops[factor]
        if exponent == 1:
            return Layout([(factor, strength)], strength)
        if code in op.UNARY_FUNCTIONS and factor not in self.named:
            return self._function(factor, exponent)
        return self.style.power((factor, ATOM), self.style.number(exponent))

    def _function(self, node: int, exponent: int) -> Layout:
        graph = self.graph
        code = graph.ops[node]
        operands = graph.operands(node)
        if code == op.SELECT:
            return self._choice(node)
        if code == op.FMA:
            x, y, z = operands
            return Layout([(x, POWER), self.style.times, (y, POWER), self.style.plus, (z, PRODUCT)], SUM)
        if code == op.PICK:
            raise no_formula()
        name = graph.functions[graph.right[node]].name if code == op.CALL else op.NAMES[code]
        return self.style.function(name, [(operand, CHOICE) for operand in operands], exponent)

    def _choice(self, node: int) -> Layout:
        cases: list[tuple[Piece, Piece]] = []
        rest = node
        while self.graph.ops[rest] == op.SELECT and (rest == node or rest not in self.named):
            condition, then, rest = self.graph.operands(rest)
            cases.append(((then, CHOICE), (condition, CHOICE)))
        return self.style.choice(cases, (rest, CHOICE))

    def _condition(self, node: int) -> Layout:
        graph = self.graph
        code, a, b = graph.ops[node], graph.left[node], graph.right[node]
        less, greater, at_most, at_least, equal, unequal, both, either, no = self.style.relations
        if code == op.NOT and graph.ops[a] == op.EQ:
            return Layout([(graph.left[a], SUM), f" {unequal} ", (graph.right[a], SUM)], COMPARISON)
        if code == op.NOT:
            return Layout([no, (a, NEGATION)], NEGATION)
        if code in (op.AND, op.OR):
            strength = BOTH if code == op.AND else CHOICE
            return Layout([(a, strength), f" {both if code == op.AND else either} ", (b, strength)], strength)
        signs = {op.LT: (less, greater), op.LE: (at_most, at_least), op.EQ: (equal, equal)}[code]
        if graph.number(a) is not None:  # x > 0 rather than 0 < x
            return Layout([(b, SUM), f" {signs[1]} ", (a, SUM)], COMPARISON)
        return Layout([(a, SUM), f" {signs[0]} ", (b, SUM)], COMPARISON)
