"""Motions of random mechanisms: energy is balanced, loops stay closed, and no choice of trees makes a difference.

A random loop may run into a position beyond which nothing can move; then every choice of trees has to stop
there, at the same time.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.graph.trees import TreeChoice
from tests.laws.consistent_states import State, consistent_state
from tests.laws.evaluation import equations
from tests.laws.mechanisms import random_mechanism
from tests.laws.parts import Mechanism
from tests.laws.tally import chunks, name_of

SHARE = 0.3  # of the mechanism's unit of time
RTOL = 1e-9
# Global errors: some tens of steps of RTOL each, through motions that part by at most a factor of 1e3 in this time.
AGREEMENT = 1e5 * RTOL
STOPPED = (sb.Status.STEP_COLLAPSE, sb.Status.TOO_MANY_STEPS, sb.Status.SINGULAR)


def motion(mechanism: Mechanism, state: State, tree: TreeChoice) -> sb.Trajectory:
    eqs = equations(mechanism, tree)
    known = {name: state.known[name] for name in (*eqs.coordinate_names, *eqs.speed_names)}
    return sb.simulate(
        eqs,
        (state.t, state.t + SHARE * mechanism.units.time),
        guess=known,
        inputs={name: state.known[name] for name in eqs.input_names},
        rtol=RTOL,
        atol=1e-12,
        max_steps=5000,
    )


def ends(run: sb.Trajectory, mechanism: Mechanism) -> np.ndarray:
    bodies = [run[f"frame r {body.name} ground ground"][:, -1] for body in mechanism.bodies]
    return np.concatenate(bodies) / mechanism.units.length


def check(seeds: Iterable[int]) -> None:
    stopped = 0
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state = consistent_state(mechanism)
        first, second = (motion(mechanism, state, tree) for tree in (None, "absolute"))
        for run in (first, second):
            assert run["constraint_violation"].max(initial=0.0) < 1e-9, seed
            drift = np.ptp(run["energy"] - run["work"])
            assert drift < AGREEMENT * max(run["kinetic_energy"].max(), np.ptp(run["potential_energy"])), seed
        if first.status is sb.Status.SUCCESS and second.status is sb.Status.SUCCESS:
            assert np.abs(ends(first, mechanism) - ends(second, mechanism)).max() < AGREEMENT, seed
        else:
            stopped += 1
            assert first.status in STOPPED and second.status in STOPPED, seed
            reached = (first.t[-1] - state.t, second.t[-1] - state.t)
            assert reached[0] == pytest.approx(reached[1], rel=1e-2), seed
    print(f"{stopped} stopped")


def test_motions_do_not_depend_on_the_trees() -> None:
    check(range(4))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(200), ids=name_of)
def test_motions_do_not_depend_on_the_trees_often(seeds: range) -> None:
    check(seeds)
