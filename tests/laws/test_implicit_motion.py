"""Motions of random mechanisms by implicit methods: energy, momenta, loops, and the explicit method's places."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from tests.laws.consistent_states import State, consistent_state
from tests.laws.floating import floating
from tests.laws.mechanisms import random_mechanism
from tests.laws.motions import Method, Motion, motion
from tests.laws.parts import Mechanism
from tests.laws.sensitivity import sensitivity
from tests.laws.tally import chunks, name_of
from tests.laws.test_motion import GROWTH, SHARE, STOPPED, tolerance

NUMBER = 200
# A step adds rtol at most, as by every method, where the estimate of its error holds. That is the first term of
# the error alone, so twice as much is allowed; an energy changes twice as much as speeds. Methods of low order
# take many steps: where an explicit one of order 8 takes thousands, of order 2 hundred thousands. CVODE takes its
# steps one by one, which is no test of anything where they are as many.
METHODS = {
    "generalized alpha": Method(sb.GeneralizedAlpha(), 1e-6, 1e-9, 100_000),
    "backward differentiation": Method(sb.Stiff(), 1e-8, 1e-11, 20_000),
}
THOUSANDS = 1000
ESTIMATE = 2.0
ENERGY = 2.0


def allowed(method: Method, found: Motion) -> float:
    """What the errors of all steps add up to at most, relative to the size of what is compared."""
    return ESTIMATE * GROWTH * method.rtol * found.run.statistics.accepted


def check(seeds: Iterable[int]) -> None:
    worst = dict.fromkeys(METHODS, (0.0, 0.0))
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state = consistent_state(mechanism)
        best = motion(mechanism, state, None, SHARE)
        for name, method in METHODS.items():
            found = motion(mechanism, state, None, SHARE, method)
            assert found.run["constraint_violation"].max(initial=0.0) <= method.atol, (seed, name)
            energy = np.ptp(found.unbalanced) / (ENERGY * allowed(method, found) * found.energy)
            apart = distance(mechanism, state, best, found, method)
            assert max(apart, energy) <= 1.0, (seed, name, apart, energy)
            worst[name] = (max(apart, worst[name][0]), max(float(energy), worst[name][1]))
    print(", ".join(f"{name}: apart {x:.2g}, energy {y:.2g}" for name, (x, y) in worst.items()))


def distance(mechanism: Mechanism, state: State, best: Motion, found: Motion, method: Method) -> float:
    """How far apart motions end, in units of what their errors explain; of those that stop, their times."""
    if found.run.status is sb.Status.TOO_MANY_STEPS and best.run.statistics.accepted > THOUSANDS:
        return 0.0
    if not (best.run.success and found.run.success):
        assert best.run.status in STOPPED and found.run.status in STOPPED, mechanism.seed
        reached = [one.run.t[-1] - state.t for one in (best, found)]
        return float(abs(reached[0] - reached[1]) / (1e-2 * max(reached)))
    apart = max(np.abs(best.places[b][-1] - r[-1]).max() for b, r in found.places.items())
    error = float(apart) / mechanism.units.length / (allowed(method, found) + tolerance(best))
    if error <= 1.0:
        return error
    return error * GROWTH / max(GROWTH, sensitivity(mechanism, state, None, best))


def check_momenta(seeds: Iterable[int]) -> None:
    worst = 0.0
    for seed in seeds:
        mechanism = floating(random_mechanism(seed))
        for name, method in METHODS.items():
            found = motion(mechanism, consistent_state(mechanism), None, SHARE, method)
            assert found.run["constraint_violation"].max(initial=0.0) <= method.atol, (seed, name)
            for total, size in zip((found.momentum, found.spin), found.sizes, strict=True):
                share = float(np.ptp(total, axis=0).max() / (allowed(method, found) * size))
                assert share <= 1.0, (seed, name, share)
                worst = max(worst, share)
    print(f"momenta are off by at most {worst:.2g} of what errors explain")


def test_implicit_motions_are_those_of_the_explicit_method() -> None:
    check((3, 20))


@pytest.mark.exhaustive
def test_without_ground_momenta_are_kept() -> None:
    check_momenta((3,))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_implicit_motions_are_those_of_the_explicit_method_often(seeds: range) -> None:
    check(seeds)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_without_ground_momenta_are_kept_often(seeds: range) -> None:
    check_momenta(seeds)
