"""Fingerprints: the value of every node at two fixed random points of a finite field.

Equal fingerprints mean equal functions, whatever identity makes them equal, because a nonzero
rational function vanishes at a random point with probability of about degree / 2**61, and two
points are used (Schwartz 1980). Sines and cosines are points of the circle, turned by the addition
formulas. Roots of rational numbers are products of those of 2 and 3, of whole numbers, and of random ones;
every other function is a random function of its argument's fingerprint, which can miss an equality but never
invent one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import isqrt
from typing import Final

from symbody.expr.deadline import TICK, check
from symbody.expr.fingerprints.circle import Circle, Pair, root_in_field
from symbody.expr.graph import Graph
from symbody.expr.opcodes import (
    ABS,
    ADD,
    COS,
    DIV,
    FLOAT,
    FMA,
    MAX,
    MIN,
    MUL,
    NEG,
    ODD_FUNCTIONS,
    PI,
    POW,
    RATIONAL,
    SIN,
    SQRT,
    SUB,
    TAN,
)  # fmt: skip

# (PRIME - 1) / 2 is prime too, so no power of 2 below 2**(10**18) is 1: floats, which are whole numbers times
# powers of 2, stay distinct. (In the field of 2**61 - 1 the float 2**-60 is 2.) It is 23 modulo 24, so that
# 2 and 3 have roots and -1 has none, see Circle.
PRIME: Final = 2**61 - 3153
# A residue is read as a rational number up to this over this: of random ones 1 in 10,000 has such a reading.
_LARGEST: Final = 10**7
_HALF: Final = PRIME // 2
_WORD: Final = 2**64 - 1


def fingerprints(graph: Graph, nodes: Sequence[int]) -> dict[int, Pair]:
    """Return the fingerprint of each of `nodes`, which are ascending and closed under operands."""
    return _Fingerprinter(graph, nodes).values


class _Fingerprinter:
    """One pass over the nodes."""

    def __init__(self, graph: Graph, nodes: Sequence[int]) -> None:
        self.graph = graph
        self.values: dict[int, Pair] = {}
        self._circle = Circle(graph, nodes, PRIME, self.values)
        values, ops, left, right, p = self.values, graph.ops, graph.left, graph.right, PRIME
        for node in nodes:  # nearly all are sums and products
            if not node & TICK:
                check()
            op = ops[node]
            if op == MUL:
                (a1, a2), (b1, b2) = values[left[node]], values[right[node]]
                values[node] = (a1 * b1 % p, a2 * b2 % p)
            elif op == ADD:
                (a1, a2), (b1, b2) = values[left[node]], values[right[node]]
                values[node] = ((a1 + b1) % p, (a2 + b2) % p)
            elif op == SUB:
                (a1, a2), (b1, b2) = values[left[node]], values[right[node]]
                values[node] = ((a1 - b1) % p, (a2 - b2) % p)
            else:
                values[node] = self._value(node)

    def _value(self, node: int) -> Pair:
        graph, values = self.graph, self.values
        op, a, b = graph.ops[node], graph.left[node], graph.right[node]
        if op == NEG:
            a1, a2 = values[a]
            return (-a1 % PRIME, -a2 % PRIME)
        if op == POW:
            return self._power(node, values[a])
        if op == DIV:
            return self._quotient(node, values[a], values[b])
        return self._leaf(node) if op <= PI else self._function(node)

    def _leaf(self, node: int) -> Pair:
        op = self.graph.ops[node]
        if op in (RATIONAL, FLOAT):
            value = self.graph.constants[self.graph.left[node]]
            if isinstance(value, int):
                return (value % PRIME, value % PRIME)
            value = Fraction(value)
            residue = value.numerator * pow(value.denominator, -1, PRIME) % PRIME
            return (residue, residue)
        return hash_words(op, self.graph.hashes[node])

    def _power(self, node: int, base: Pair) -> Pair:
        exponent = self.graph.number(self.graph.right[node])
        if isinstance(exponent, int):
            return (pow(base[0], exponent, PRIME), pow(base[1], exponent, PRIME))
        return hash_words(POW, *base, *self.values[self.graph.right[node]])

    def _quotient(self, node: int, a: Pair, b: Pair) -> Pair:
        if b[0] == 0 or b[1] == 0:  # a divisor that vanishes identically: equal to nothing else
            return hash_words(DIV, self.graph.hashes[node])
        return (a[0] * pow(b[0], -1, PRIME) % PRIME, a[1] * pow(b[1], -1, PRIME) % PRIME)

    def _function(self, node: int) -> Pair:
        graph = self.graph
        op = graph.ops[node]
        operands = graph.operands(node)
        if op in (SIN, COS, TAN):
            return self._circular(node, operands[0])
        pairs = [self.values[k] for k in operands]
        if op == FMA:
            a, b, c = pairs
            return ((a[0] * b[0] + c[0]) % PRIME, (a[1] * b[1] + c[1]) % PRIME)
        if op == SQRT:
            return _root(pairs[0])
        if op in ODD_FUNCTIONS or op == ABS:
            pair, flipped = drop_sign(pairs[0])
            value = hash_words(op, *pair)
            return (-value[0] % PRIME, -value[1] % PRIME) if flipped and op != ABS else value
        if op in (MIN, MAX):
            pairs.sort()
        words = [word for pair in pairs for word in pair]
        return hash_words(op, graph.datum(node), *words)

    def _circular(self, node: int, angle: int) -> Pair:
        (c1, c2), (s1, s2) = self._circle.point(angle)
        op = self.graph.ops[node]
        if op == COS:
            return (c1, c2)
        return (s1, s2) if op == SIN else self._quotient(node, (s1, s2), (c1, c2))


def _root(square: Pair) -> Pair:
    """Return the root of a fingerprint: in the field for rational numbers, as far as it lies there."""
    value = _rational(square[0]) if square[0] == square[1] else None
    if value is None or value <= 0:
        return hash_words(SQRT, 0, *square)
    rest, scale = value.numerator * value.denominator, pow(value.denominator, -1, PRIME)
    for factor in (2, 3):
        while rest % factor == 0:
            rest, scale = rest // factor, scale * root_in_field(factor, PRIME) % PRIME
    whole = isqrt(rest)
    first, second = (whole, whole) if whole * whole == rest else hash_words(SQRT, 0, rest, rest)
    return (first * scale % PRIME, second * scale % PRIME)


def _rational(residue: int) -> Fraction | None:
    """Return the rational number of few digits that has a residue, if there is one (Wang 1981)."""
    above, below, before, factor = PRIME, residue, 0, 1
    while below > _LARGEST:
        count = above // below
        above, below, before, factor = below, above - count * below, factor, before - count * factor
    return Fraction(below, factor) if 0 < abs(factor) <= _LARGEST else None


def find_zeros(graph: Graph, nodes: Sequence[int]) -> list[bool]:
    """Return which nodes are identically zero."""
    values = fingerprints(graph, list(graph.reachable(nodes)))
    return [values[node] == (0, 0) for node in nodes]


def drop_sign(pair: Pair) -> tuple[Pair, bool]:
    """Return the smaller of a fingerprint and its negative, and whether the sign was changed."""
    first, second = pair
    if first > _HALF or (not first and second > _HALF):
        return ((-first % PRIME, -second % PRIME), True)
    return (pair, False)


def drop_signs(values: Mapping[int, Pair]) -> tuple[dict[int, Pair], dict[int, bool]]:
    """Return `drop_sign` of the fingerprint of each node: what it is without its sign, and the changes."""
    pairs = dict(values)
    flipped = dict.fromkeys(values, False)
    for node, (first, second) in values.items():
        if first > _HALF or (not first and second > _HALF):
            pairs[node], flipped[node] = (-first % PRIME, -second % PRIME), True
    return pairs, flipped


def hash_words(*words: int) -> Pair:
    """Return a fingerprint that is a random function of `words`."""
    return (_mix(hash((1, *words))) % PRIME, _mix(hash((2, *words))) % PRIME)


def _mix(word: int) -> int:
    """Return 64 bits that no addition relates to those of other words (splitmix64, Steele et al. 2014).

    Hashes of tuples are sums of multiples of their entries but for carries: those of entries 0, 1, 5, 6 of
    one solution may fulfil h0 + h6 = h1 + h5, and then a sum of the solution would be taken for an entry.
    """
    word &= _WORD
    word = (word ^ word >> 30) * 0xBF58476D1CE4E5B9 & _WORD
    word = (word ^ word >> 27) * 0x94D049BB133111EB & _WORD
    return word ^ word >> 31
