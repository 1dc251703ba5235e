"""Degrees of freedom on every branch of linkages that can be put together in several ways, and of merged ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, sin

import numpy as np
import pytest

import symbody as sb
from tests.problems.linkage_branches import (
    assemblies,
    dixon,
    four_bar,
    link_shapes,
    merged,
    peaucellier,
)
from tests.problems.overconstrained import Link, lines, loop
from tests.problems.test_mobility import ALPHA, RIGHT, altmann_links, trihedral_links, twist

HALF = sin(ALPHA)


def goldberg(*shorts: float) -> list[Link]:
    """Bennett linkages one after the other without their common links."""
    whole = Link(sum(shorts), sum(map(twist, shorts)))
    return [Link(1.0, ALPHA), whole, Link(1.0, ALPHA), *(Link(a, twist(a)) for a in shorts)]


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


BRANCHES: dict[str, tuple[Callable[[], sb.Model], int]] = {
    "parallelogram": (lambda: four_bar((1.0, 0.6), False), 1),
    "crossed parallelogram": (lambda: four_bar((1.0, 0.6), True), 1),
    # Where A and C are one point, D goes about it by itself; where B and D are, A and C are held by both arms.
    "Peaucellier, A on C": (lambda: peaucellier("AC"), 2),
    "Peaucellier, B on D": (lambda: peaucellier("BD"), 1),
    "Dixon, first kind": (dixon, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", BRANCHES)
def test_branches_of_plane_linkages_have_their_own_freedoms(name: str) -> None:
    make, expected = BRANCHES[name]
    assert freedoms(make()) == (expected, None, ())


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
