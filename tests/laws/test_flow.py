"""Linear equations against simulated motions: A is the derivative of the flow, at rest and on the move.

A motion is disturbed to both sides; half the difference of both motions grows as ``x' = A(t) x`` says, with A along
the motion between. Rotations have every parametrization there is.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from scipy.linalg import expm

import symbody as sb
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import equations
from tests.laws.mechanisms import turning_mechanism
from tests.laws.parts import Units
from tests.laws.rotations import Array
from tests.laws.tally import chunks, name_of
from tests.laws.test_linearization import between

SPAN = 0.01  # in units of time of the mechanism
# Deviations of STEP to both sides are linear to its square; the runs are good to 1e-11, 1e-7 of a deviation.
STEP = 1e-4
NEAR = 1e-6
UNITS = Units(1.0, 1.0, 1.0)


def motion(eqs: sb.EquationSet, at: sb.State, known: dict[str, float], times: Array) -> Array:
    """(u, q) of the motion through a state at some times, one row each."""
    run = sb.simulate(
        eqs, (times[0], times[-1]), guess=known, inputs=at.inputs, times=times, rtol=1e-11, atol=1e-13
    )
    assert run.success, run.notes
    return np.array([run[name] for name in (*eqs.speed_names, *eqs.coordinate_names)]).T


def flow_error(eqs: sb.EquationSet, at: sb.State, rng: np.random.Generator) -> float:
    """How far the difference of two motions is from what A makes of it, in units of what explains that.

    ``exp(A T)`` with A at half time leaves out commutators and second changes of A, together below
    ``(|A| T)^3 / 3`` (Blanes et al., Phys. Rep. 470 (2009), 151-238, section 5.4).
    """
    names = (*eqs.speed_names, *eqs.coordinate_names)
    values = np.array([*at.u.values(), *at.q.values()])
    times = at.t + SPAN * np.array([0.0, 0.5, 1.0])
    off = STEP * rng.uniform(-1, 1, len(values))
    here, ahead, behind = (
        motion(eqs, at, dict(zip(names, (values + s * off).tolist(), strict=True)), times) for s in (0, 1, -1)
    )
    known = dict(zip(names, here[1].tolist(), strict=True))
    half_way = sb.assemble(eqs, guess=known, inputs=at.inputs, t=float(times[1]))
    lin = sb.linearize(eqs, half_way)
    start, end = (half_between(eqs, lin.state_names, here[k], ahead[k], behind[k]) for k in (0, 2))
    left_out = (SPAN * float(np.linalg.norm(lin.A, 2))) ** 3 / 3
    error = float(np.abs(end - expm(SPAN * lin.A) @ start).max() / np.abs(start).max())
    return error / (NEAR + left_out)


def half_between(
    eqs: sb.EquationSet, names: tuple[str, ...], here: Array, ahead: Array, behind: Array
) -> Array:
    one, other = (np.array(between(eqs, names, here, there)) for there in (ahead, behind))
    found: Array = (one - other) / 2
    return found


def check(seeds: Iterable[int]) -> None:
    worst = 0.0
    for seed in seeds:
        mechanism = turning_mechanism(seed, UNITS)
        state = consistent_state(mechanism)
        eqs = equations(mechanism)
        if not mechanism.freedoms:
            continue
        known = {name: state.known[name] for name in (*eqs.coordinate_names, *eqs.speed_names)}
        inputs = {name: state.known[name] for name in eqs.input_names}
        at = sb.assemble(eqs, guess=known, inputs=inputs, t=state.t)
        error = flow_error(eqs, at, np.random.default_rng(seed))
        assert error < 1, (seed, error)
        worst = max(worst, error)
    print(f"flows are off by at most {worst:.2g} of what errors explain")


def test_disturbed_motions_follow_the_linear_equations() -> None:
    check((9, 10))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_disturbed_motions_follow_the_linear_equations_often(seeds: range) -> None:
    check(seeds)
