"""Degrees of freedom on every branch of linkages that can be put together in several ways, and of merged ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from math import pi, sin

import numpy as np
import pytest

import symbody as sb
from tests.problems.focal_linkages import (
    QUADRILATERAL,
    Focal,
    burmester,
    focal_linkage,
    seen,
    similar_ratios,
)
from tests.problems.linkage_branches import (
    assemblies,
    dixon,
    four_bar,
    hart,
    link_shapes,
    merged,
    peaucellier,
)
from tests.problems.overconstrained import Link, lines, loop
from tests.problems.test_mobility import ALPHA, RIGHT, altmann_links, trihedral_links, twist
from tests.tiers import cases

HALF = sin(ALPHA)


def goldberg(*shorts: float) -> list[Link]:
    """Bennett linkages one after the other without their common links."""
    whole = Link(sum(shorts), sum(map(twist, shorts)))
    return [Link(1.0, ALPHA), whole, Link(1.0, ALPHA), *(Link(a, twist(a)) for a in shorts)]


def plane_symmetric_links() -> list[Link]:
    """Hinges 0 and 3 lie in the plane of symmetry, twists and offsets of the others are mirrored."""
    half = [Link(1.0, 1.1), Link(0.8, 0.7, 0.3), Link(0.9, 1.4, -0.2)]
    offsets = (0.0, 0.2, -0.3)
    return [
        *half,
        *(Link(link.a, -link.alpha, d) for link, d in zip(reversed(half), offsets, strict=True)),
    ]


LOOPS: dict[str, Sequence[Link]] = {
    "Bennett": [Link(1.0, ALPHA), Link(0.7, twist(0.7))] * 2,
    "Goldberg 5R": goldberg(0.6, 0.5),
    "Goldberg 6R": goldberg(0.4, 0.35, 0.3),
    "Myard": [
        Link(HALF, ALPHA),
        Link(1, RIGHT),
        Link(0, pi - 2 * ALPHA),
        Link(1, RIGHT),
        Link(HALF, pi - ALPHA),
    ],
    "Bricard, trihedral": trihedral_links(),
    "Bricard, line-symmetric": [Link(0.7, 0.9, 0.1), Link(1.0, 1.2, -0.3), Link(0.9, 0.7, 0.2)] * 2,
    "Bricard, plane-symmetric": plane_symmetric_links(),
    "Altmann": altmann_links(),
}


def freedoms(model: sb.Model) -> tuple[int, int | None, tuple[str, ...]]:
    eqs = sb.form_equations(model)
    count, found = eqs.mobility, sb.redundancy(eqs)
    assert count.degrees_of_freedom == found.degrees_of_freedom
    return count.degrees_of_freedom, found.instantaneous, count.notes


def check_assemblies(name: str, first: float) -> int:
    """A way to close a loop with any angle of its first hinge lies on a branch on which this angle changes."""
    found = assemblies(LOOPS[name], first)
    for angles in found:
        assert freedoms(loop(LOOPS[name], angles)) == (1, None, ()), (name, angles)
    return len(found)


def test_both_assemblies_of_myards_linkage_have_one_freedom() -> None:
    assert check_assemblies("Myard", 1.0) == 2


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("first", [-2.2, -0.9, 0.4, 1.0, 1.9])
def test_every_assembly_of_a_loop_has_one_freedom(name: str, first: float) -> None:
    check_assemblies(name, first)


def symmetry_gap(name: str, angles: Sequence[float]) -> float:
    """How far angles are from those of a symmetric pose."""
    partners = {"Bricard, line-symmetric": [3, 4, 5, 0, 1, 2], "Bricard, plane-symmetric": [0, 5, 4, 3, 2, 1]}
    turned = np.exp(1j * np.array(angles))
    return float(np.abs(turned - turned[partners[name]]).max())


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["Bricard, line-symmetric", "Bricard, plane-symmetric"])
def test_bricards_linkages_close_in_symmetric_poses_alone(name: str) -> None:
    """Two for each angle, on branches of one freedom each (Baker 1980)."""
    found = assemblies(LOOPS[name], 1.0)
    assert len(found) == 2
    assert max(symmetry_gap(name, angles) for angles in found) < 1e-9
    for angles in found:
        assert freedoms(loop(LOOPS[name], angles)) == (1, None, ()), angles


BRANCHES: dict[str, tuple[Callable[[], sb.Model], int]] = {
    "parallelogram": (lambda: four_bar((1.0, 0.6), False), 1),
    "crossed parallelogram": (lambda: four_bar((1.0, 0.6), True), 1),
    # Where A and C are one point, D goes about it by itself; where B and D are, A and C are held by both arms.
    "Peaucellier, A on C": (lambda: peaucellier("AC"), 2),
    "Peaucellier, B on D": (lambda: peaucellier("BD"), 1),
    "Dixon, first kind": (dixon, 1),
    "Hart, crossed": (lambda: hart(0.9, True), 1),
    "Hart, uncrossed": (lambda: hart(0.9, False), 1),
    "Hart, crossed, guided in its line": (lambda: hart(0.9, True, guided=True), 1),
    "Hart, uncrossed, guided": (lambda: hart(0.9, False, guided=True), 0),
    **{f"Kempe focal, {'open' if side > 0 else 'folded'}, {angle} rad":
       (lambda side=side, angle=angle: focal_linkage(Focal().points(angle, side)), 1)
       for side in (1, -1) for angle in (1.2, 2.1)},
    "Burmester focal": (lambda: focal_linkage(burmester(*QUADRILATERAL, 0.5)), 1),
    "no focus": (lambda: focal_linkage(Focal().points(1.5, 1) | {"F": 0.7 + 0.9j}), 0),
}  # fmt: skip


@pytest.mark.parametrize("name", cases(BRANCHES, fast=list(BRANCHES)[::2]))
def test_branches_of_plane_linkages_have_their_own_freedoms(name: str) -> None:
    make, expected = BRANCHES[name]
    assert freedoms(make()) == (expected, None, ())


@pytest.mark.exhaustive
def test_two_merged_goldberg_linkages_have_one_freedom() -> None:
    """Wohlhart's double Goldberg linkage; that its links are rigid is looked at in several poses."""

    def links(first: float, second: float) -> list[Link]:
        # the links that are taken out come first; twists of common links agree, as both are of one ratio
        whole = Link(first + second, twist(first) + twist(second))
        return [
            Link(1.0, ALPHA),
            Link(first, twist(first)),
            Link(second, twist(second)),
            Link(1.0, ALPHA),
            whole,
        ]

    parts = links(0.6, 0.5), links(0.6, 0.35)
    guesses = [assemblies(part, 1.0)[0] for part in parts]
    axes = merged(*parts, -2.6, guesses)
    for angle in (-2.7, -2.3, 2.5):
        np.testing.assert_allclose(
            link_shapes(*merged(*parts, angle, guesses)), link_shapes(*axes), atol=1e-12
        )
    assert freedoms(lines(*axes)) == (1, None, ())


def test_the_linkage_of_kempe_is_that_of_burmester() -> None:
    """Kempe's has F in a focus in every pose, Burmester's has Kempe's similar four-bars and keeps its lengths."""
    linkage = Focal()
    for side, angle in product((1, -1), (1.2, 1.5, 1.8, 2.1)):
        points = linkage.points(angle, side)
        lengths = [abs(points[p] - points[q]) for p, q in ("AB", "BC", "CD", "DA")]
        open_ones = linkage.points(1.5, 1)
        np.testing.assert_allclose(
            lengths, [abs(open_ones[p] - open_ones[q]) for p, q in ("AB", "BC", "CD", "DA")]
        )
        for pairs in (("AB", "CD"), ("BC", "DA")):
            turned = sum(seen(points, *pair) for pair in pairs)
            assert np.exp(1j * turned) == pytest.approx(-1.0, abs=1e-12)
    for height in (0.5, 0.7, 0.9):
        for ratios in similar_ratios(burmester(*QUADRILATERAL, height)):
            np.testing.assert_allclose(ratios, ratios[0], rtol=1e-9)
