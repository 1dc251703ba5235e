"""Sines and cosines in a finite field: rational points of the circle and the addition formulas.

An angle is read as a linear form in atoms: ``theta + 2*beta - pi/2``. Each atom has a random rational
point; multiples and sums of angles are powers and products of the complex numbers c + i s. So the angle of a
link at the end of a chain takes one product, however many joints it is the sum of. Multiples of pi/12 have
their own points, written in the roots of 2 and 3, which are numbers of the field.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Final, NamedTuple

from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, COS, FLOAT, MUL, NEG, PI, RATIONAL, SIN, SUB, TAN

Pair = tuple[int, int]
Complex = tuple[Pair, Pair]  # cosines and sines at the two points
Form = dict[tuple[int, ...], Fraction]  # atom to factor; the atom () is pi

# Atoms have a point for 1/24 of their angle, so that halves, thirds and quarters of angles agree.
_PARTS: Final = 24


_UNIT: Final[Complex] = ((1, 1), (0, 0))


class _Angle(NamedTuple):
    """The point of a sum of whole multiples of atoms, `_UNIT` without any; and pi and numbers beside it."""

    point: Complex
    rest: Form


class Circle:
    """Points of angles, each computed once.

    Parameters
    ----------
    values : mapping of node to pair
        Fingerprints; read for the nodes below the angle that is asked for.
    """

    def __init__(self, graph: Graph, nodes: Sequence[int], prime: int, values: Mapping[int, Pair]) -> None:
        self._graph = graph
        self._prime = prime
        self._values = values
        self._angular = self._nodes_in_angles(nodes)
        self._angles: dict[int, _Angle | None] = {}
        self._forms: dict[int, Form] = {}
        self._points: dict[tuple[tuple[int, ...], Fraction], Complex] = {}

    def point(self, angle: int) -> Complex:
        """Return cosine and sine of an angle."""
        while self._angular and self._angular[-1] <= angle:
            node = self._angular.pop()
            self._angles[node] = self._whole_angle(node)
        whole = self._angles[angle]
        result, form = (_UNIT, self._form(angle)) if whole is None else whole
        for atom, factor in form.items():
            result = self._product(result, self._multiple(atom, factor))
        return result

    def _whole_angle(self, node: int) -> _Angle | None:
        """Return an angle from those below it; None where atoms have factors that are not whole."""
        terms = list(self._terms(node))
        if not terms:
            form = self._computed_form(node)
            if form.keys() <= {(), (1,)}:
                return _Angle(_UNIT, form)
            ((atom, factor),) = form.items()
            return _Angle(self._multiple(atom, factor), {})
        point, rest = _UNIT, Form()
        for operand, factor in terms:
            below = self._angles[operand]
            if below is None or (below.point is not _UNIT and factor.denominator != 1):
                return None
            if below.point is not _UNIT:
                point = self._product(point, self._power(below.point, int(factor)))
            for atom, inner in below.rest.items():
                rest[atom] = rest.get(atom, Fraction(0)) + factor * inner
        return _Angle(point, {atom: factor for atom, factor in rest.items() if factor})

    def _nodes_in_angles(self, nodes: Sequence[int]) -> list[int]:
        """Return, the oldest last, the nodes that stand linearly inside an angle."""
        graph = self._graph
        found: set[int] = set()
        for node in reversed(nodes):
            if graph.ops[node] in (SIN, COS, TAN):
                found.add(graph.left[node])
            elif node in found:
                found.update(operand for operand, _ in self._terms(node))
        return sorted(found, reverse=True)

    def _terms(self, node: int) -> Iterator[tuple[int, Fraction]]:
        """Yield operand and factor if `node` is a linear operation."""
        graph = self._graph
        op, a, b = graph.ops[node], graph.left[node], graph.right[node]
        if op in (ADD, SUB):
            yield a, Fraction(1)
            yield b, Fraction(1 if op == ADD else -1)
        elif op == NEG:
            yield a, Fraction(-1)
        elif op == MUL and graph.ops[a] == RATIONAL:
            yield b, Fraction(graph.constants[graph.left[a]])

    def _form(self, angle: int) -> Form:
        waiting = [angle]
        while waiting:
            node = waiting[-1]
            below = [operand for operand, _ in self._terms(node) if operand not in self._forms]
            if below:
                waiting += below
            else:
                self._forms[waiting.pop()] = self._computed_form(node)
        return self._forms[angle]

    def _computed_form(self, node: int) -> Form:
        op = self._graph.ops[node]
        if op == PI:
            return {(): Fraction(1)}
        if op <= FLOAT:
            return {(1,): Fraction(self._graph.constants[self._graph.left[node]])}
        terms = list(self._terms(node))
        if not terms:
            pair = self._values[node]
            opposite = (-pair[0] % self._prime, -pair[1] % self._prime)
            return {min(pair, opposite): Fraction(1 if pair <= opposite else -1)}
        form: Form = {}
        for operand, factor in terms:
            for atom, inner in self._forms[operand].items():
                form[atom] = form.get(atom, Fraction(0)) + factor * inner
        return {atom: factor for atom, factor in form.items() if factor}

    def _multiple(self, atom: tuple[int, ...], factor: Fraction) -> Complex:
        key = (atom, factor)
        if key not in self._points:
            if atom == () and (12 * factor).denominator == 1:
                self._points[key] = self._power(self._twelfth_of_pi(), int(12 * factor) % 24)
            else:
                self._points[key] = self._power_of_atom(atom, factor)
        return self._points[key]

    def _power_of_atom(self, atom: tuple[int, ...], factor: Fraction) -> Complex:
        count = abs(factor) * _PARTS
        if count.denominator == 1 and atom not in ((), (1,)):
            base, exponent = self._random_point(*atom), int(count)
        else:  # an odd fraction, or a number: an atom of its own
            base, exponent = self._random_point(3, *atom, count.numerator, count.denominator), 1
        return self._power(base, exponent if factor > 0 else -exponent)

    def _power(self, base: Complex, exponent: int) -> Complex:
        if exponent == 1:
            return base
        result, left = _UNIT, abs(exponent)
        while left:
            if left & 1:
                result = self._product(result, base)
            base, left = self._product(base, base), left >> 1
        cosine, sine = result
        return (cosine, (-sine[0] % self._prime, -sine[1] % self._prime)) if exponent < 0 else result

    def _twelfth_of_pi(self) -> Complex:
        """Return the point ((sqrt 3 + 1), (sqrt 3 - 1)) sqrt 2 / 4; its sixth power is a quarter turn."""
        p = self._prime
        two, three = root_in_field(2, p), root_in_field(3, p)
        scale = two * pow(4, -1, p)
        return (((three + 1) * scale % p,) * 2, ((three - 1) * scale % p,) * 2)

    def _random_point(self, *words: int) -> Complex:
        """Return (1 - w^2, 2 w) / (1 + w^2); the prime is 3 mod 4, so 1 + w^2 never vanishes."""
        p = self._prime
        cosines, sines = [], []
        for salt in (5, 7):
            w = hash((salt, *words)) % p
            scale = pow(1 + w * w, -1, p)
            cosines.append((1 - w * w) * scale % p)
            sines.append(2 * w * scale % p)
        return ((cosines[0], cosines[1]), (sines[0], sines[1]))

    def _product(self, x: Complex, y: Complex) -> Complex:
        p = self._prime
        (c1, c2), (s1, s2) = x
        (d1, d2), (t1, t2) = y
        return (
            ((c1 * d1 - s1 * t1) % p, (c2 * d2 - s2 * t2) % p),
            ((s1 * d1 + c1 * t1) % p, (s2 * d2 + c2 * t2) % p),
        )


@cache
def root_in_field(number: int, prime: int) -> int:
    """Return a square root; there is one of 2 and of 3 where the prime is 23 mod 24.

    Either root will do: the two belong to conjugate fields, in which the same identities hold.
    """
    return pow(number, (prime + 1) // 4, prime)
