"""The focal linkage: a four-bar ABCD, and a point F with four bars to points P, Q, R, S of its sides.

A. B. Kempe, On conjugate four-piece linkages, Proc. London Math. Soc. 9 (1878), 133-147, has it from four-bars
that are similar, and L. Burmester, Z. Math. Phys. 38 (1893), 193-223, from foci: F sees opposite sides under
angles whose sum is 180 degrees, as a focus of a conic does that touches all sides. W. Wunderlich, J. Mechanisms 3
(1968), 79-86, and E. A. Dijksman, Mech. Mach. Theory 10 (1975), 445-460, treat it as one linkage.

Kempe's way: let the four-bars APFS and FRCQ be similar as mirror images, in a ratio of 1 to k, and PBQF and RFSD
in a ratio of 1 to m. With AP, PF, FS, SA = a, b, c, d the other lengths follow::

    FR, RC, CQ, QF = k (a, b, c, d),    PB = k a/m,   BQ = c/m,   SD = m k d,   DR = m b.

The angles at P, and at R, are p and 180 degrees - p in the four-bars on both sides, those at Q and S are s and
180 degrees - s. So the diagonals AF and BF are, in every pose,

    a^2 + b^2 - 2 a b cos p = c^2 + d^2 - 2 c d cos s,
    (k a/m)^2 + b^2 + 2 (k/m) a b cos p = (c/m)^2 + (k d)^2 + 2 (k/m) c d cos s.

Both say the same where ``(k + m)(k a^2 + m b^2) = (1 + k m)(c^2 + k m d^2)``; then the four-bars agree while they
move. Angles at F sum up to those of ABCD.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq

import symbody as sb
from tests.problems.overconstrained import plates

Points = dict[str, complex]
QUADRILATERAL = 0j, 1.7 + 0j, 1.9 + 1.2j, 0.3 + 1.6j
WORDS = ("ASD", "APB", "BQC", "CRD", "FP", "FQ", "FR", "FS")


@dataclass(frozen=True)
class Focal:
    """Kempe's lengths a, b, c and ratios k, m."""

    a: float = 1.0
    b: float = 0.9
    c: float = 0.8
    k: float = 0.85
    m: float = 1.2

    @property
    def d(self) -> float:
        """What is left of the condition."""
        a, b, c, k, m = self.a, self.b, self.c, self.k, self.m
        return sqrt(((k + m) * (k * a * a + m * b * b) / (1 + k * m) - c * c) / (k * m))

    def points(self, angle: float, side: int) -> Points:
        """All points, with the angle p, and APFS open (1) or folded over AF (-1)."""
        a, b, c, d, k, m = self.a, self.b, self.c, self.d, self.k, self.m
        A, P = 0j, complex(a)
        F = P + b * np.exp(1j * (pi - angle))
        S = meeting((A, d), (F, c), side)
        B, D = P * (1 + k / m), S * (1 + k * m)
        ways = []
        for first, second in product((1, -1), repeat=2):
            Q, R = meeting((B, c / m), (F, k * d), first), meeting((D, m * b), (F, k * a), second)
            ends = Q + k * m * (Q - B), R + (k / m) * (R - D)
            ways.append((abs(ends[0] - ends[1]), Q, R, ends[0]))
        gap, Q, R, C = min(ways, key=lambda way: way[0])
        assert gap < 1e-13
        return dict(zip("ABCDFPQRS", (A, B, C, D, F, P, Q, R, S), strict=True))


def meeting(first: tuple[complex, float], second: tuple[complex, float], side: int) -> complex:
    """Where two circles meet, on the left (1) or right (-1) of the way from the first centre to the second."""
    (p, r), (q, s) = first, second
    apart = abs(q - p)
    x = (r * r - s * s + apart * apart) / (2 * apart)
    return p + (q - p) / apart * (x + 1j * side * sqrt(r * r - x * x))


def similar_ratios(points: Points) -> tuple[list[float], list[float]]:
    """By what sides of APFS are larger than those of FRCQ, and those of RFSD than those of PBQF."""

    def ratios(*pairs: str) -> list[float]:
        return [float(abs(points[w[0]] - points[w[1]]) / abs(points[w[2]] - points[w[3]])) for w in pairs]

    return ratios("APFR", "PFRC", "FSCQ", "SAQF"), ratios("RFPB", "FSBQ", "SDQF", "DRFP")


def focal_linkage(points: Points) -> sb.Model:
    return plates({name: (float(z.real), float(z.imag)) for name, z in points.items()}, WORDS)


def seen(points: Points, first: str, second: str) -> float:
    """The angle under which F sees a pair of points."""
    return float(np.angle((points[second] - points["F"]) / (points[first] - points["F"])))


def burmester(A: complex, B: complex, C: complex, D: complex, height: float) -> Points:
    """The linkage of a four-bar: F at this height where opposite sides are seen under 180 degrees together.

    F sees P and S under the angle at C, Q and R under that at A, and so on, as the similar four-bars want; the
    direction of P is the one for which these are similar.
    """
    corners = dict(zip("ABCD", (A, B, C, D), strict=True))

    def sum_of_angles(x: float) -> float:
        points = corners | {"F": complex(x, height)}
        return seen(points, "A", "B") + seen(points, "C", "D") - pi

    F = complex(_root(sum_of_angles, 0.05, 1.5), height)
    at_C, at_D = (float(np.angle((u - v) / (w - v))) for u, v, w in ((B, C, D), (C, D, A)))
    at_A = float(np.angle((D - A) / (B - A)))

    def points(turn: float) -> Points:
        ways = {"P": turn, "Q": turn + at_D, "R": turn + at_D + at_A, "S": turn - at_C}
        sides = {"P": (A, B), "Q": (B, C), "R": (C, D), "S": (D, A)}
        met = {name: _crossing(F, np.exp(1j * ways[name]), *sides[name]) for name in ways}
        return {**corners, "F": F, **met}

    def unlike(turn: float) -> float:
        p = points(turn)
        lengths = [abs(p[u] - p[v]) for u, v in ("AP", "PF", "FR", "RC")]
        return float(np.log(lengths[0] * lengths[3] / (lengths[1] * lengths[2])))

    return points(_root(unlike, *_between(F, A, B)))


def _between(F: complex, A: complex, B: complex) -> tuple[float, float]:
    """The directions from F to two points, a little less apart."""
    first, apart = float(np.angle(A - F)), float(np.angle((B - F) / (A - F)))
    return first + 0.02 * apart, first + 0.98 * apart


def _crossing(start: complex, way: complex, first: complex, second: complex) -> complex:
    """Where a line from a point meets the line through two others."""
    side = second - first
    share = ((start - first) * way.conjugate()).imag / (side * way.conjugate()).imag
    return first + share * side


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """The first change of sign that is no jump."""
    places = np.linspace(low, high, 400)
    values = [function(float(x)) for x in places]
    for k, (v, w) in enumerate(zip(values, values[1:], strict=False)):
        if v * w < 0 and abs(v - w) < 1:
            return float(brentq(function, places[k], places[k + 1], xtol=1e-15, rtol=1e-15))
    raise AssertionError("no root")
