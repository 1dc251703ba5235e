"""Trigonometric polynomials with rational coefficients, and the shortest of the ways to write one.

There are three, and each angle or group of angles has its own: powers of its cosine with a sine at
most, powers of its sine with a cosine at most, or sines and cosines of sums and multiples. So
``cos(a)*cos(a+b) + sin(a)*sin(a+b)`` becomes ``cos(b)``, ``1 - cos(a)**2`` becomes ``sin(a)**2``, and
``sin(a)*cos(b)`` stays.

Angles are vectors of whole numbers over a basis of independent angles. Variables of these polynomials
are negative: sine and cosine of basis angle i are -1-2i and -2-2i, others follow as they turn up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import comb, prod
from operator import add, neg, sub
from typing import Final, NamedTuple

from symbody.expr.graph import Exact
from symbody.expr.opcodes import COS, SIN
from symbody.expr.trigonometry.polynomial import (
    UNIT,
    Monomial,
    Polynomial,
    accumulate,
    cost,
    divide,
    product,
    term_cost,
    times,
)

Vector = tuple[int, ...]

# Ways to write the functions of one angle; groups of angles written as sums are numbered from 0.
_BY_COSINE: Final = -1
_BY_SINE: Final = -2
_MAX_EFFORT: Final = 30_000  # terms made in the search, for all polynomials of one root: tenths of a second
_MAX_SUMS: Final = 30_000  # terms made of one polynomial when products are turned into sums


class Harmonic(NamedTuple):
    """Sine or cosine (operation code) of an angle."""

    op: int
    angle: Vector


# A product of e sines and cosines as a sum, times 2**e: the factors are whole numbers, which are much faster.
Series = dict[Harmonic, int]
Terms = list[tuple[Monomial, int]]
Ways = tuple[tuple[int, int], ...]  # angle and the way to write it


class Harmonics:
    """The sines and cosines over one basis of angles, and what each costs.

    Parameters
    ----------
    size : number of basis angles
    angle_cost : operations of one angle written out
    """

    def __init__(self, size: int, angle_cost: Callable[[Vector], int]) -> None:
        self._table: list[Harmonic] = []
        self._places: dict[Harmonic, int] = {}
        self._weights: list[int] = []
        self._angle_cost = angle_cost
        self._sums: dict[Monomial, Terms] = {}
        self._shortest: dict[frozenset[tuple[Monomial, Exact]], Polynomial] = {}
        self._size = size
        self._effort = 0
        for i in range(size):
            for op in (SIN, COS):
                self.variable(Harmonic(op, self.unit(i)))

    def unit(self, i: int) -> Vector:
        """Return the basis angle `i`."""
        return tuple([int(i == k) for k in range(self._size)])

    def variable(self, harmonic: Harmonic) -> int:
        """Return the variable of a sine or cosine."""
        if harmonic not in self._places:
            self._table.append(harmonic)
            self._places[harmonic] = -len(self._table)
            self._weights.append(1 + self._angle_cost(harmonic.angle))
        return self._places[harmonic]

    def harmonic(self, name: int) -> Harmonic:
        """Return the sine or cosine that a variable stands for."""
        return self._table[-1 - name]

    def weight(self, name: int) -> int:
        """Return the operations of a variable."""
        return self._weights[-1 - name]

    def shortest(self, p: Polynomial) -> Polynomial:
        """Return a polynomial in the functions of the basis angles, written in fewest operations."""
        key = frozenset(p.items())
        if key not in self._shortest:
            total: Polynomial = {}
            for part in _classes(p):
                accumulate(total, self._shortest_of_class(part))
            self._shortest[key] = total
        return self._shortest[key]

    def length(self, p: Polynomial) -> int:
        """Return the operations of `p`, and one for each term more: it will be multiplied by something."""
        return cost(p, self.weight) + len(p)

    def _shortest_of_class(self, p: Polynomial) -> Polynomial:
        angles = sorted({angle_of(name) for monomial in p for name, _ in monomial})
        if len(p) == 1 and all(degree == 1 for degree in _degrees(p).values()):
            return p
        best = p
        tried: dict[Ways, Polynomial] = {}
        for start in (_BY_COSINE, _BY_SINE, 0):
            best = min(best, self._descend(p, dict.fromkeys(angles, start), tried), key=self.length)
        return best

    def _descend(self, p: Polynomial, ways: dict[int, int], tried: dict[Ways, Polynomial]) -> Polynomial:
        """Change the way of one angle at a time as long as that makes the sum shorter."""
        best, improved = self._rewrite(p, ways), True
        shortest = self.length(best)
        while improved:
            improved = False
            for change in list(_changes(ways)):
                if self._effort > _MAX_EFFORT:
                    return best
                key = tuple(change.items())
                if key not in tried:
                    tried[key] = self._rewrite(p, change)
                length = self.length(tried[key])
                if length < shortest:
                    best, shortest, ways, improved = tried[key], length, change, True
        return best

    def _rewrite(self, p: Polynomial, ways: dict[int, int]) -> Polynomial:
        for angle, way in ways.items():
            if way == _BY_SINE:
                p = reduce_cosines(p, angle)
                self._effort += len(p)
        for group in sorted({way for way in ways.values() if way >= 0}):
            p = self._as_sums(p, {angle for angle, way in ways.items() if way == group})
        of_one_function = all(len(monomial) < 2 and monomial[0][1] == 1 for monomial in p if monomial)
        return self._pair_terms(p) if of_one_function and set(ways.values()) == {0} else p

    def _as_sums(self, p: Polynomial, angles: set[int]) -> Polynomial:
        """Write the functions of a group of angles as sines and cosines of their sums."""
        inside = {name for angle in angles for name in (sine(angle), sine(angle) - 1)}
        # A product of e functions of one angle is a sum over e + 1 multiples of it.
        if sum(prod([e + 1 for k, e in monomial if k in inside]) for monomial in p) > _MAX_SUMS:
            return p
        halvings = _degree(p)
        result: Polynomial = {}
        for monomial, coefficient in p.items():
            inner = tuple([factor for factor in monomial if factor[0] in inside])
            outer = tuple([factor for factor in monomial if factor[0] not in inside])
            scale = 2 ** (halvings - sum(e for _, e in inner)) * coefficient
            terms = {product(outer, term): scale * factor for term, factor in self._sum_of(inner)}
            accumulate(result, terms)
            self._effort += len(terms)
        return {monomial: divide(c, 2**halvings) for monomial, c in result.items()}

    def _monomial(self, harmonic: Harmonic) -> Monomial:
        return ((self.variable(harmonic), 1),) if any(harmonic.angle) else UNIT

    def _sum_of(self, monomial: Monomial) -> Terms:
        """Return a product of sines and cosines, times a power of two, as a sum of them."""
        if monomial not in self._sums:
            series: Series = {Harmonic(COS, (0,) * self._size): 1}
            for name, exponent in monomial:
                for _ in range(exponent):
                    series = _multiply(series, self._table[-1 - name])
            self._sums[monomial] = [(self._monomial(each), factor) for each, factor in series.items()]
        return self._sums[monomial]

    def _pair_terms(self, p: Polynomial) -> Polynomial:
        """Turn sums of two sines or cosines into products where these are shorter."""
        done: Polynomial = {}
        left = dict(p)
        while left:
            first = next(iter(left))
            coefficient = left.pop(first)
            for second, other in left.items():
                pair = {first: coefficient, second: other}
                term = self._as_product(first, second, coefficient, other)
                if term is not None and cost(pair, self.weight) + 1 > term_cost(*term, self.weight):
                    del left[second]
                    first, coefficient = term
                    break
            accumulate(done, {first: coefficient})
        return done

    def _as_product(self, a: Monomial, b: Monomial, x: Exact, y: Exact) -> tuple[Monomial, Exact] | None:
        """Return ``x a + y b`` as a product of two functions of half angles."""
        if abs(x) != abs(y):
            return None
        f, g = self._single(a, b), self._single(b, a)
        total = tuple([i + k for i, k in zip(f.angle, g.angle, strict=True)])
        gap = tuple([i - k for i, k in zip(f.angle, g.angle, strict=True)])
        if f.op != g.op or any(k % 2 for k in (*total, *gap)):
            return None
        half_total, half_gap = tuple([k // 2 for k in total]), tuple([k // 2 for k in gap])
        ops, sign = _PRODUCTS[f.op, x == y]
        result: Polynomial = {UNIT: 2 * x * sign}
        for op, angle in zip(ops, (half_total, half_gap), strict=True):
            harmonic, factor = _upright(op, angle)
            result = times(result, {self._monomial(harmonic): factor})
        return next(iter(result.items()), None)

    def _single(self, a: Monomial, b: Monomial) -> Harmonic:
        """Return the function that a monomial of degree one is; 1 is the cosine of 0."""
        return self.harmonic(a[0][0]) if a else Harmonic(COS, (0,) * len(self.harmonic(b[0][0]).angle))


# f(p) + f(q) and f(p) - f(q): functions of half the sum and half the difference, and a sign.
_PRODUCTS: Final = {
    (COS, True): ((COS, COS), 1),
    (COS, False): ((SIN, SIN), -1),
    (SIN, True): ((SIN, COS), 1),
    (SIN, False): ((COS, SIN), 1),
}


def angle_of(name: int) -> int:
    """Return the basis angle of a variable."""
    return (-1 - name) // 2


def sine(angle: int) -> int:
    """Return the variable of the sine of a basis angle; its cosine is one less."""
    return -1 - 2 * angle


def reduce_sines(p: Polynomial) -> Polynomial:
    """Return `p` with sin**2 written as 1 - cos**2, which makes equal polynomials equal."""
    result: Polynomial = {}
    for monomial, coefficient in p.items():
        if all(exponent == 1 or name >= 0 or name % 2 == 0 for name, exponent in monomial):
            accumulate(result, {monomial: coefficient})
            continue
        term: Polynomial = {UNIT: coefficient}
        for name, exponent in monomial:
            count = exponent // 2 if name < 0 and name % 2 else 0
            if exponent > 2 * count:
                term = times(term, {((name, exponent - 2 * count),): 1})
            if count:
                term = times(term, _one_minus_square(name - 1, count))
        accumulate(result, term)
    return result


def reduce_cosines(p: Polynomial, angle: int) -> Polynomial:
    """Return `p` with cos**2 written as 1 - sin**2, except for what is a factor of all terms."""
    name = sine(angle) - 1
    exponents = [dict(monomial).get(name, 0) for monomial in p]
    kept = min(exponents) // 2 * 2
    result: Polynomial = {}
    for (monomial, coefficient), exponent in zip(p.items(), exponents, strict=True):
        if exponent - kept < 2:
            accumulate(result, {monomial: coefficient})
            continue
        rest = tuple([factor for factor in monomial if factor[0] != name])
        odd = exponent % 2
        cosine: Polynomial = {((name, kept + odd),): coefficient} if kept + odd else {UNIT: coefficient}
        sines = _one_minus_square(name + 1, (exponent - kept) // 2)
        accumulate(result, times(times({rest: 1}, cosine), sines))
    return result


def _one_minus_square(name: int, count: int) -> Polynomial:
    """Return ``(1 - name**2) ** count``."""
    return {((name, 2 * k),) if k else UNIT: (-1) ** k * comb(count, k) for k in range(count + 1)}


def _classes(p: Polynomial) -> Iterable[Polynomial]:
    """Split into parts that no identity mixes: by the parity of each angle's degree, and of all sines."""
    result: dict[tuple[frozenset[int], int], Polynomial] = {}
    for monomial, coefficient in p.items():
        odd: frozenset[int] = frozenset()
        sines = 0
        for name, exponent in monomial:
            odd ^= {angle_of(name)} if exponent % 2 else set()
            sines += exponent if name % 2 else 0
        result.setdefault((odd, sines % 2), {})[monomial] = coefficient
    return result.values()


def _degree(p: Polynomial) -> int:
    return max((sum(exponent for _, exponent in monomial) for monomial in p), default=0)


def _degrees(p: Polynomial) -> dict[int, int]:
    degrees: dict[int, int] = {}
    for monomial in p:
        for name, exponent in monomial:
            degrees[angle_of(name)] = degrees.get(angle_of(name), 0) + exponent
    return degrees


def _changes(ways: dict[int, int]) -> Iterator[dict[int, int]]:
    """Yield every other choice in which one angle is written differently."""
    groups = {way for way in ways.values() if way >= 0}
    new = 1 + max(groups, default=-1)
    for angle, way in ways.items():
        for other in (_BY_COSINE, _BY_SINE, *sorted(groups), new):
            if other != way:
                yield {**ways, angle: other}


def _multiply(series: Series, factor: Harmonic) -> Series:
    """Multiply by one sine or cosine, and by 2: products become sums and differences."""
    result: Series = {}
    for harmonic, coefficient in series.items():
        for sign, combine in ((1, add), (-1, sub)):
            angle = tuple(map(combine, harmonic.angle, factor.angle))
            op = COS if harmonic.op == factor.op else SIN
            # 2 sin sin = cos(a-b) - cos(a+b), 2 cos sin = sin(a+b) - sin(a-b), else both signs are +
            flip = -1 if factor.op == SIN and sign == (1 if harmonic.op == SIN else -1) else 1
            upright, turn = _upright(op, angle)
            if turn:
                result[upright] = result.get(upright, 0) + coefficient * flip * turn
    return {harmonic: coefficient for harmonic, coefficient in result.items() if coefficient}


def _upright(op: int, angle: Vector) -> tuple[Harmonic, int]:
    """Return the function with the first nonzero multiple positive, and the sign that this takes."""
    for lead in angle:
        if lead > 0:
            return Harmonic(op, angle), 1
        if lead:
            return Harmonic(op, tuple(map(neg, angle))), -1 if op == SIN else 1
    return Harmonic(COS, angle), int(op == COS)
