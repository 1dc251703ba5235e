"""How much of an error made on the way is left at the end of a motion: found by disturbing the motion itself."""

from __future__ import annotations

import random
from collections.abc import Iterator

import numpy as np

import symbody as sb
from symbody.graph.trees import TreeChoice
from tests.laws.consistent_states import State
from tests.laws.evaluation import equations
from tests.laws.motions import ATOL, MOST_STEPS, RTOL, Motion
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array

# Far above the errors of integration, which are what is to be judged, and small enough to be a derivative.
DISTURBED = 1e-5
# A slope that another step would change by more than this share is none.
STRAIGHT = 0.1
TIMES = 8
DIRECTIONS = 4


def sensitivity(mechanism: Mechanism, state: State, tree: TreeChoice, found: Motion) -> float:
    """How far the last places move, in lengths, when all states are changed by a relative error of one.

    That is what the integrator bounds in each step: errors relative to the states. The mean is taken over
    places along the steps, of the largest of some directions, each of random signs.
    """
    rng = random.Random(f"sensitivity {mechanism.seed}")
    starts = np.linspace(0, found.run.t.size - 1, TIMES, endpoint=False).astype(int)
    slopes = [max(_slopes(mechanism, state, tree, found, int(k), rng)) for k in starts]
    return float(np.mean(slopes)) / mechanism.units.length


def _slopes(
    mechanism: Mechanism, state: State, tree: TreeChoice, found: Motion, start: int, rng: random.Random
) -> Iterator[float]:
    x = np.concatenate([found.run.q[:, start], found.run.u[:, start]])
    span = (float(found.run.t[start]), float(found.run.t[-1]))
    middle = _last_places(mechanism, state, tree, span, x)
    for _ in range(DIRECTIONS):
        signs = np.array([rng.choice((-1.0, 1.0)) for _ in x])
        ahead, behind = (
            _last_places(mechanism, state, tree, span, x * (1.0 + side * DISTURBED * signs))
            for side in (1.0, -1.0)
        )
        apart = float(np.abs(ahead - behind).max())
        assert np.abs(ahead + behind - 2.0 * middle).max() <= STRAIGHT * apart, mechanism.seed
        yield apart / (2.0 * DISTURBED)


def _last_places(
    mechanism: Mechanism, state: State, tree: TreeChoice, span: tuple[float, float], x: Array
) -> Array:
    """Centres of mass at the end of a motion from the closest state that fits the constraints."""
    eqs = equations(mechanism, tree)
    known = dict(zip((*eqs.coordinate_names, *eqs.speed_names), x, strict=True))
    inputs = {name: state.known[name] for name in eqs.input_names}
    run = sb.simulate(
        eqs, span, guess=known, inputs=inputs, times=span[1:], rtol=RTOL, atol=ATOL, max_steps=MOST_STEPS
    )  # fmt: skip
    assert run.success, mechanism.seed
    words = [f"frame r {body.name} ground ground" for body in mechanism.bodies]
    found = sb.compile(eqs, words)(run.t, run.q.T, run.u.T, list(inputs.values()))
    return np.array(found)[:, -1]
