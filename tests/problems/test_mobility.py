"""Degrees of freedom of linkages that move although a count of their constraints says otherwise.

Each against what the literature says of it: J. E. Baker, Mech. Mach. Theory 14 (1979), 239-253 (Bennett,
Goldberg, Myard) and 15 (1980), 267-286 (Bricard); J. Phillips, Freedom in Machinery, vol. 2 (1990), chapter 20
(Sarrus, Altmann, Delassus); A. C. Dixon, Messenger of Mathematics 29 (1899), 1-21; for the focal linkage of
Kempe and Burmester see `focal_linkages`. Where branches of the motion meet, each of them is looked at.
"""

from __future__ import annotations

from collections.abc import Callable
from math import asin, cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import least_squares

import symbody as sb
from tests.problems.focal_linkages import QUADRILATERAL, Focal, burmester, focal_linkage
from tests.problems.overconstrained import Link, closed_angles, closing, lines, loop, plates
from tests.tiers import cases

RIGHT = pi / 2
ALPHA = pi / 3
RANDOM = np.random.default_rng(0)
POINTS, DIRECTIONS = RANDOM.uniform(-1, 1, (6, 3)), RANDOM.standard_normal((6, 3))


def twist(length: float) -> float:
    """Bennett's condition: sin(alpha) / a is the same for all links; a = 1 has 60 degrees."""
    return asin(length * sin(ALPHA))


def closed(*links: Link, guess: tuple[float, ...], first: float = 1.0) -> sb.Model:
    return loop(links, closed_angles(links, guess, {0: first}))


def bennett() -> sb.Model:
    long, short = Link(1.0, ALPHA), Link(0.7, twist(0.7))
    return closed(long, short, long, short, guess=(1.0, 2.9, -1.0, -2.9))


def goldberg(*shorts: float) -> sb.Model:
    """Bennett linkages one after the other, with their common links taken out: 5 or 6 hinges."""
    whole = Link(sum(shorts), sum(map(twist, shorts)))
    long = Link(1.0, ALPHA)
    guess = (1.0, 2.0, -1.0, *(1.0 for _ in shorts))
    return closed(long, whole, long, *(Link(a, twist(a)) for a in shorts), guess=guess)


def myard() -> sb.Model:
    """Two Bennett linkages with right angles, mirror images of each other."""
    half = sin(ALPHA)
    return closed(Link(half, ALPHA), Link(1, RIGHT), Link(0, pi - 2 * ALPHA), Link(1, RIGHT), Link(half, pi - ALPHA),
                  guess=(1, 2, 1, 1, 1))  # fmt: skip


def line_symmetric() -> sb.Model:
    half_turn = np.diag([-1.0, -1.0, 1.0])
    points, directions = POINTS[:3], DIRECTIONS[:3]
    return lines(np.vstack([points, points @ half_turn]), np.vstack([directions, directions @ half_turn]))


def plane_symmetric() -> sb.Model:
    """Hinges 1 and 4 lie in the plane, the others are mirror images."""
    mirror, order = np.diag([1.0, -1.0, 1.0]), [0, 1, 2, 3]
    points, directions = POINTS[order].copy(), DIRECTIONS[order].copy()
    points[[0, 3], 1] = directions[[0, 3], 1] = 0.0
    return lines(
        np.vstack([points, points[[2, 1]] @ mirror]), np.vstack([directions, directions[[2, 1]] @ mirror])
    )


def trihedral_links() -> list[Link]:
    """Sums of squares of every other length are equal, all twists are right angles."""
    a = [1.0, 0.9, 0.8, 0.7, 0.95]
    a.append(sqrt(a[0] ** 2 + a[2] ** 2 + a[4] ** 2 - a[1] ** 2 - a[3] ** 2))
    return [Link(length, RIGHT if k % 2 == 0 else -RIGHT) for k, length in enumerate(a)]


def trihedral() -> sb.Model:
    return closed(*trihedral_links(), guess=(1, 1, 1, 1, 1, 1))


def altmann_links() -> list[Link]:
    return [Link(1.0, RIGHT), Link(0.0, RIGHT), Link(0.7, -RIGHT)] * 2


def altmann() -> sb.Model:
    links = altmann_links()
    return loop(links, closed_angles(links, (1.0, 0.5, -1) * 2, {0: 1.0, 3: 1.0}))


def delassus(*pitches: float) -> sb.Model:
    """A parallelogram of screws: it moves if its plates stay together, p1 + p3 = p2 + p4."""
    angles = (1.0, pi - 1.0, 1.0, pi - 1.0)
    lift = -sum(pitch * angle for pitch, angle in zip(pitches, angles, strict=True))
    links = [Link(1.0 if k % 2 == 0 else 0.6, 0.0, lift if k == 3 else 0.0, p) for k, p in enumerate(pitches)]
    assert abs(closing(links, angles)).max() < 1e-14
    return loop(links, angles)


def locomotive(wheels: int, angle: float) -> sb.Model:
    """Wheels of equal cranks on one rod."""
    places = [0.0, 1.0, 2.3, 3.1, 4.5, 5.2][:wheels]
    centres = {chr(97 + k): (x, 0.0) for k, x in enumerate(places)}
    pins = {chr(65 + k): (x + 0.4 * cos(angle), 0.4 * sin(angle)) for k, x in enumerate(places)}
    cranks = [a + b for a, b in zip(centres, pins, strict=True)]
    return plates(centres | pins, ["".join(centres), "".join(pins), *cranks])


def scissor(stages: int, angle: float = 0.6) -> sb.Model:
    """Crossed bars of length 2, one over the other; the lower ends are joined by ground and a slide."""
    x, y = cos(angle), sin(angle)
    elements: list[object] = []
    for k in range(stages):
        for side, name in ((1, "l"), (-1, "r")):
            frames = {
                "low": sb.Frame(at=(-side * x, -y, 0)),
                "mid": sb.Frame(),
                "up": sb.Frame(at=(side * x, y, 0)),
            }
            elements.append(sb.Body(f"{name}{k}", mass=1, inertia=(0.1, 0.1, 0.1), frames=frames))
        elements.append(sb.Revolute(f"cross{k}", f"l{k}.mid", f"r{k}.mid", coordinate=f"m{k}"))
        if k:  # the left upper end is that of the bar that starts at the right
            elements += [
                sb.Revolute(f"left{k}", f"r{k - 1}.up", f"l{k}.low", coordinate=f"a{k}"),
                sb.Revolute(f"right{k}", f"l{k - 1}.up", f"r{k}.low", coordinate=f"b{k}"),
            ]
    elements += [
        sb.Revolute("pivot", "ground.p", "l0.low", coordinate="a0"),
        sb.PinSlot("slot", "ground.q", "r0.low", axes=["z", "x"], coordinates=["b0", "s"]),
    ]
    ground = {"p": sb.Frame(at=(-x, -y, 0)), "q": sb.Frame(at=(x, -y, 0))}
    return sb.Model("scissor", elements, ground=ground)


def peaucellier() -> sb.Model:
    half = sqrt(1.3**2 - 1)
    points = {"O": (0.0, 0.0), "Q": (1 - half / 2, 0.0), "A": (2.0, 1.0), "C": (2.0, -1.0), "B": (2 - half, 0.0),
              "D": (2 + half, 0.0)}  # fmt: skip
    return plates(points, ["OQ", "OA", "OC", "AB", "BC", "CD", "DA", "QB"])


def hart() -> sb.Model:
    """Hart's inversor: a crossed parallelogram, pinned to ground and to a crank at two bars."""
    x, y, z = 1.0, 0.3, 0.75  # half widths of its parallel sides, and half its height
    corners = {"A": (-x, z), "B": (x, z), "C": (-y, -z), "D": (y, -z)}  # bars AD, BC, AC, BD
    share = 0.6  # of the way from A and from B, on one line parallel to AB

    def between(a: str, b: str) -> tuple[float, float]:
        return tuple((1 - share) * p + share * q for p, q in zip(corners[a], corners[b], strict=True))  # type: ignore[return-value]

    points = corners | {"O": between("A", "D"), "P": between("A", "C")}
    px, py = points["P"]
    points |= {"G": ((px + points["O"][0]) / 2, py - 0.4)}
    return plates(points, ["OG", "AOD", "APC", "BC", "BD", "GP"])


def parallelograms_inside() -> sb.Model:
    """A quadrilateral ABCD with bars from a point F to points of its sides, but F is no focus.

    The four-bars APFS and FQCR, and PBQF and SFRD, are similar, not as mirror images; so PBQF and SFRD are
    parallelograms.
    """

    def points(x: np.ndarray) -> dict[str, np.ndarray]:
        a, d, b, c, f = np.zeros(2), np.array([1.0, 0.0]), x[:2], x[2:4], x[4:6]
        p, q, r, s = a + x[6] * (b - a), b + x[7] * (c - b), c + x[8] * (d - c), d + x[9] * (a - d)
        return dict(zip("ABCDFPQRS", (a, b, c, d, f, p, q, r, s), strict=True))

    def ratios(x: np.ndarray) -> list[float]:
        place = points(x)

        def logs(*pairs: str) -> list[float]:
            sizes = [
                np.log(hypot(*(place[w[0]] - place[w[1]])) / hypot(*(place[w[2]] - place[w[3]])))
                for w in pairs
            ]
            return [float(size - sizes[0]) for size in sizes[1:]]

        return [*logs("APFQ", "PFQC", "FSCR", "SARF"), *logs("PBSF", "BQFR", "QFRD", "FPDS")]

    start = np.array([0.2, 1.0, 1.3, 0.8, 0.6, 0.45, 0.5, 0.5, 0.5, 0.5])
    found = least_squares(ratios, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert np.abs(found.fun).max() < 1e-12
    place = {name: (float(x), float(y)) for name, (x, y) in points(found.x).items()}
    return plates(place, ["ASD", "APB", "BQC", "CRD", "FP", "FQ", "FR", "FS"])


CASES: dict[str, tuple[Callable[[], sb.Model], int]] = {
    "Bennett": (bennett, 1),
    "Goldberg 5R": (lambda: goldberg(0.6, 0.5), 1),
    "Goldberg 6R": (lambda: goldberg(0.4, 0.35, 0.3), 1),
    "Myard": (myard, 1),
    "Bricard, line-symmetric": (line_symmetric, 1),
    "Bricard, plane-symmetric": (plane_symmetric, 1),
    "Bricard, trihedral": (trihedral, 1),
    "six hinges in general": (lambda: lines(POINTS, DIRECTIONS), 0),
    "Sarrus": (lambda: lines(POINTS, np.array([[1, 0, 0]] * 3 + [[0, 1, 0]] * 3, dtype=float)), 1),
    "Altmann": (altmann, 1),
    "spherical four-bar": (lambda: lines(np.zeros((4, 3)), DIRECTIONS[:4]), 1),
    "planar five-bar": (lambda: lines(POINTS[:5], np.array([[0.0, 0.0, 1.0]] * 5)), 2),
    "Delassus, equal screws": (lambda: delassus(0.1, 0.1, 0.1, 0.1), 1),
    "Delassus, different screws": (lambda: delassus(0.1, 0.2, 0.3, 0.2), 1),
    "four screws in general": (lambda: delassus(0.1, 0.2, 0.3, 0.4), 0),
    **{f"locomotive, {n} wheels": (lambda n=n: locomotive(n, 0.7), 1) for n in (2, 3, 4, 6)},
    **{f"scissor, {n} stages": (lambda n=n: scissor(n), 1) for n in (1, 2, 3, 5)},
    "Peaucellier": (peaucellier, 1),
    "Hart": (hart, 1),
    "Kempe focal": (lambda: focal_linkage(Focal().points(1.5, 1)), 1),
    "Burmester focal": (lambda: focal_linkage(burmester(*QUADRILATERAL, 0.7)), 1),
    "four-bar with two parallelograms in it": (parallelograms_inside, 1),
}  # fmt: skip


# Of each family those with few links; all are in the exhaustive tier.
LONG = {
    "Bricard, plane-symmetric", "Bricard, line-symmetric", "Goldberg 6R", "Kempe focal", "six hinges in general",
    "scissor, 3 stages", "scissor, 5 stages", "locomotive, 4 wheels", "locomotive, 6 wheels",
}  # fmt: skip


@pytest.mark.parametrize("name", cases(CASES, fast=lambda name: name not in LONG))
def test_mobility_is_that_of_the_literature(name: str) -> None:
    make, freedoms = CASES[name]
    eqs = sb.form_equations(make())
    count = eqs.mobility
    assert (count.degrees_of_freedom, count.notes) == (freedoms, ())
    found = sb.redundancy(eqs)
    assert (found.degrees_of_freedom, found.instantaneous, found.notes) == (freedoms, None, ())
    assert len(found.kept) == len(eqs.speed_names) - freedoms


@pytest.mark.parametrize("wheels", cases([2, 3, 4, 6], fast=[2, 3]))
def test_flat_wheels_have_two_freedoms_for_an_instant(wheels: int) -> None:
    """All cranks along the rod: the rod may turn a little, too, to first order."""
    count = sb.form_equations(locomotive(wheels, 0.0)).mobility
    assert (count.degrees_of_freedom, count.instantaneous) == (1, 2)
    assert "branches of the motion meet there" in count.notes[0]
