"""Motions of random mechanisms: energy is balanced, loops stay closed, and no choice of trees makes a difference.

A random loop may run into a position beyond which nothing can move; then every choice of trees has to stop
there, at the same time. Mechanisms that hang on nothing keep their momentum and angular momentum.
"""

from __future__ import annotations

import random
from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.graph.trees import TreeChoice
from tests.laws.agreement import random_trees
from tests.laws.consistent_states import State, consistent_state
from tests.laws.floating import floating
from tests.laws.mechanisms import random_mechanism
from tests.laws.motions import ATOL, RTOL, Motion, motion
from tests.laws.parts import Mechanism
from tests.laws.sensitivity import sensitivity
from tests.laws.tally import chunks, name_of

# Three or four seconds each, with all its trees: most of it forming and compiling.
NUMBER = 2000
SHARE = 0.3  # of the mechanism's unit of time
STOPPED = (sb.Status.STEP_COLLAPSE, sb.Status.SINGULAR)
# Each step adds an error of RTOL at most. Speeds and forces are of order one in the mechanism's own units, and
# so are the rates at which motions part, say three: what a step adds grows by exp(3 SHARE) to the end. Where it
# does not, as where bodies are flung about by a nearly singular loop, the growth is measured.
GROWTH = float(np.exp(3 * SHARE))


def tolerance(*found: Motion) -> float:
    """What the errors of all steps add up to at most, relative to the size of what is compared."""
    return GROWTH * RTOL * sum(one.run.statistics.accepted for one in found)


def choices(mechanism: Mechanism) -> list[TreeChoice]:
    """The automatic choice, absolute coordinates, and for loops a random pair of trees: other chords."""
    found: list[TreeChoice] = [None, "absolute"]
    if mechanism.loops:
        found.append(random_trees(mechanism, random.Random(f"motion {mechanism.seed}")))
    return found


def difference(mechanism: Mechanism, state: State, *pair: tuple[TreeChoice, Motion]) -> float:
    """How far apart two motions by different trees end, in units of what their errors explain."""
    first, other = (found for _, found in pair)
    apart = [np.abs(first.places[b][-1] - r[-1]).max() for b, r in other.places.items()]
    error = float(max(apart)) / mechanism.units.length / tolerance(first, other)
    if error <= 1.0:
        return error
    measured = max(sensitivity(mechanism, state, tree, found) for tree, found in pair)
    return error * GROWTH / max(GROWTH, measured)


def check_alone(found: Motion, seed: int) -> None:
    """Energy is balanced, and all samples are as closed as they are said to be."""
    assert found.run["constraint_violation"].max(initial=0.0) <= ATOL, seed
    assert np.ptp(found.unbalanced) <= tolerance(found) * found.energy, seed


def check(seeds: Iterable[int]) -> None:
    stopped, worst = 0, 0.0
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state = consistent_state(mechanism)
        trees = choices(mechanism)
        first, *others = [motion(mechanism, state, tree, SHARE) for tree in trees]
        for one in (first, *others):
            check_alone(one, seed)
        stopped += not first.run.success
        for tree, other in zip(trees[1:], others, strict=True):
            if first.run.success and other.run.success:
                error = difference(mechanism, state, (trees[0], first), (tree, other))
                assert error <= 1.0, (seed, error)
                worst = max(worst, error)
                continue
            assert first.run.status in STOPPED and other.run.status in STOPPED, seed
            reached = [one.run.t[-1] - state.t for one in (first, other)]
            assert reached[0] == pytest.approx(reached[1], rel=1e-2), seed
    print(f"{stopped} stopped; others are apart by at most {worst:.2g} of what errors explain")


def check_momenta(seeds: Iterable[int]) -> None:
    for seed in seeds:
        mechanism = floating(random_mechanism(seed))
        found = motion(mechanism, consistent_state(mechanism), None, SHARE)
        check_alone(found, seed)
        for total, size in zip((found.momentum, found.spin), found.sizes, strict=True):
            assert np.ptp(total, axis=0).max() <= tolerance(found) * size, seed


def test_motions_do_not_depend_on_the_trees() -> None:
    check((3,))


def test_rounding_of_fast_motions_stops_nothing() -> None:
    # Speeds of 1e4 beside some that are zero but for rounding, energies of 1e12 beside work that starts at 0.
    mechanism = random_mechanism(168)
    found = motion(mechanism, consistent_state(mechanism), None, SHARE)
    assert found.run.success, found.run.notes
    check_alone(found, 168)


@pytest.mark.exhaustive
def test_what_constraints_hold_still_is_no_singular_position() -> None:
    # Loads on a mechanism that cannot move: its speeds and accelerations are nothing but rounding.
    check((1754,))


def test_without_ground_momenta_are_kept() -> None:
    check_momenta((3,))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_motions_do_not_depend_on_the_trees_often(seeds: range) -> None:
    check(seeds)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_without_ground_momenta_are_kept_often(seeds: range) -> None:
    check_momenta(seeds)
