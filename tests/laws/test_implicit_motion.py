"""Motions of random mechanisms by the generalized-alpha method: energy, loops, and the explicit method's places."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from tests.laws.consistent_states import consistent_state
from tests.laws.mechanisms import random_mechanism
from tests.laws.motions import Method, motion
from tests.laws.sensitivity import sensitivity
from tests.laws.tally import chunks, name_of
from tests.laws.test_motion import GROWTH, SHARE, STOPPED, tolerance

NUMBER = 200
# Order 2 with its third derivatives: a step adds RTOL at most, as by every method, where the estimate holds. It
# is the first term of the error alone, so twice as much is allowed; an energy changes twice as much as speeds.
RTOL = 1e-6
METHOD = Method(sb.GeneralizedAlpha(), RTOL, 1e-9)
ESTIMATE = 2.0
ENERGY = 2.0


def check(seeds: Iterable[int]) -> None:
    worst = 0.0
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state = consistent_state(mechanism)
        best = motion(mechanism, state, None, SHARE)
        found = motion(mechanism, state, None, SHARE, METHOD)
        assert found.run["constraint_violation"].max(initial=0.0) <= METHOD.atol, seed
        allowed = ESTIMATE * GROWTH * RTOL * found.run.statistics.accepted
        assert np.ptp(found.unbalanced) <= ENERGY * allowed * found.energy, seed
        if not (best.run.success and found.run.success):
            assert best.run.status in STOPPED and found.run.status in STOPPED, seed
            reached = [one.run.t[-1] - state.t for one in (best, found)]
            assert reached[0] == pytest.approx(reached[1], rel=1e-2), seed
            continue
        apart = max(np.abs(best.places[b][-1] - r[-1]).max() for b, r in found.places.items())
        error = float(apart) / mechanism.units.length / (allowed + tolerance(best))
        if error > 1.0:
            error *= GROWTH / max(GROWTH, sensitivity(mechanism, state, None, best))
        assert error <= 1.0, (seed, error)
        worst = max(worst, error)
    print(f"apart by at most {worst:.2g} of what errors explain")


def test_implicit_motions_are_those_of_the_explicit_method() -> None:
    check((3, 20))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_implicit_motions_are_those_of_the_explicit_method_often(seeds: range) -> None:
    check(seeds)
