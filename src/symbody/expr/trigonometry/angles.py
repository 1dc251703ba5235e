"""Angles as whole-number vectors over a basis of independent angles.

An angle is a linear form with rational factors in what is not linear itself: ``theta + 2*beta - pi/2``
has the axes theta and beta, and a quarter turn back. The unit of an axis is the largest angle of which all
its multiples are whole; quarter turns are counted apart. The basis is chosen so that the angles of
the formula have few components: for ``a, a+b, a+b+c`` these three and not ``a, b, c``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import floor, gcd, prod
from typing import Final

from symbody.expr.canonical import ZERO, add, mul, neg
from symbody.expr.graph import Graph
from symbody.expr.opcodes import COS, PI, RATIONAL, SIN
from symbody.expr.printing.flattening import linear_terms
from symbody.expr.rewrite import node_cost, tree_size
from symbody.expr.trigonometry.harmonics import Vector

# Functions of longer angles are not expanded: k times a basis angle makes k + 1 terms out of one.
_MAX_EXPANSION: Final = 256
_MAX_MULTIPLE: Final = 16
_MAX_BASIS: Final = 12  # the search for a better basis grows with its fourth power

Form = dict[int, Fraction]  # node to factor


@dataclass(frozen=True, slots=True)
class AngleForm:
    """Components over the basis, and quarter turns to be added."""

    components: Vector
    quarter_turns: int


class Angles:
    """The angles of all sines and cosines among `nodes`, which are in an order with operands first."""

    def __init__(self, graph: Graph, nodes: Sequence[int]) -> None:
        self._graph = graph
        arguments = dict.fromkeys(graph.left[node] for node in nodes if graph.ops[node] in (SIN, COS))
        forms = {argument: _split_quarter_turns(graph, argument) for argument in arguments}
        self._units = _units(form for form, _ in forms.values())
        vectors = [
            tuple([int(form.get(axis, 0) / unit) for axis, unit in self._units.items()])
            for form, _ in forms.values()
        ]
        self._basis, vectors = _short_basis(len(self._units), vectors)
        self._angles = {
            argument: AngleForm(vector, turns)
            for (argument, (_, turns)), vector in zip(forms.items(), vectors, strict=True)
            if sum(map(abs, vector)) <= _MAX_MULTIPLE and prod(abs(k) + 1 for k in vector) <= _MAX_EXPANSION
        }
        self._named = {
            angle.components: argument
            for argument, angle in reversed(self._angles.items())
            if not angle.quarter_turns
        }
        sizes: dict[int, int] = {}
        for node in nodes:
            sizes[node] = node_cost(graph, node) + sum([sizes[k] for k in graph.operands(node)])
        # Axes that are constants were made just now.
        self._sizes = [sizes[axis] if axis in sizes else tree_size(graph, axis) for axis in self._units]

    @property
    def size(self) -> int:
        """Number of basis angles."""
        return len(self._basis)

    @property
    def axes(self) -> Iterable[int]:
        """What the angles are linear in."""
        return self._units.keys()

    def angle_of(self, argument: int) -> AngleForm | None:
        """Return the angle that an argument of a sine or cosine is; None if it has too many components."""
        return self._angles.get(argument)

    def cost(self, vector: Vector) -> int:
        """Return the operations of an angle written out."""
        terms = [
            size + (abs(k) * unit != 1)
            for k, size, unit in zip(self._in_axes(vector), self._sizes, self._units.values(), strict=True)
            if k
        ]
        return sum(terms) + max(len(terms) - 1, 0)

    def node(self, vector: Vector, new: Mapping[int, int]) -> int:
        """Return the node of an angle; `new` gives what arguments and axes have become so far."""
        opposite = tuple([-k for k in vector])
        if self._named.get(vector) in new:
            return new[self._named[vector]]
        if self._named.get(opposite) in new:
            return neg(self._graph, new[self._named[opposite]])
        total = ZERO
        for k, (axis, unit) in zip(self._in_axes(vector), self._units.items(), strict=True):
            if k:
                term = mul(self._graph, self._graph.constant(k * unit), new.get(axis, axis))
                total = add(self._graph, total, term)
        return total

    def _in_axes(self, vector: Vector) -> list[int]:
        pairs = [(k, base) for k, base in zip(vector, self._basis, strict=True) if k]
        return [sum(k * base[i] for k, base in pairs) for i in range(len(self._basis))]


def _split_quarter_turns(graph: Graph, argument: int) -> tuple[Form, int]:
    """Return an angle without its quarter turns, and their number.

    Other constants become axes of their own, so that no unit mixes them.
    """
    turns = 0
    result: Form = {}
    for node, factor in linear_terms(graph, argument, distribute=True).items():
        if graph.ops[node] == PI:
            turns = floor(2 * factor)
            rest = mul(graph, graph.constant(factor - Fraction(turns, 2)), node)
            result |= {rest: Fraction(1)} if rest != ZERO else {}
        elif graph.ops[node] == RATIONAL:
            value = factor * Fraction(graph.constants[graph.left[node]])
            result[graph.constant(abs(value))] = Fraction(1 if value > 0 else -1)
        else:
            result[node] = Fraction(factor)
    return result, turns


def _units(forms: Iterable[Form]) -> Form:
    """Return for each axis the greatest common divisor of its factors."""
    units: Form = {}
    for form in forms:
        for axis, factor in form.items():
            unit = units.get(axis, Fraction(0))
            units[axis] = Fraction(
                gcd(unit.numerator * factor.denominator, factor.numerator * unit.denominator),
                unit.denominator * factor.denominator,
            )
    return units


def _short_basis(size: int, vectors: list[Vector]) -> tuple[list[Vector], list[Vector]]:
    """Return a basis, and the `vectors` in it, with small components."""
    basis = [tuple([int(i == k) for k in range(size)]) for i in range(size)]
    while (exchange := _exchange(vectors)) is not None:
        i, instead = exchange
        basis[i] = tuple(
            [sum(k * base[j] for k, base in zip(instead, basis, strict=True)) for j in range(size)]
        )
        vectors = [_exchange_basis(vector, instead, i) for vector in vectors]
    return basis, vectors


def _exchange(vectors: list[Vector]) -> tuple[int, Vector] | None:
    """Return a place in the basis and the vector that makes components smaller if it is put there."""
    extent = _extent(vectors)
    for instead in dict.fromkeys(vectors):
        if len(instead) > _MAX_BASIS or sum(map(abs, instead)) == 1:
            continue
        for i, k in enumerate(instead):
            if abs(k) == 1 and _extent(_exchange_basis(vector, instead, i) for vector in vectors) < extent:
                return i, instead
    return None


def _exchange_basis(vector: Vector, instead: Vector, i: int) -> Vector:
    """Return the components of `vector` after basis angle `i` has become `instead`."""
    factor = vector[i] * instead[i]  # instead[i] is 1 or -1
    return tuple([factor if j == i else k - factor * instead[j] for j, k in enumerate(vector)])


def _extent(vectors: Iterable[Vector]) -> int:
    return sum(abs(k) for vector in set(vectors) for k in vector)
