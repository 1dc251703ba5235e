"""Inverse dynamics undoes forward dynamics: the accelerations of random mechanisms ask for the inputs they came from."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.kinematics.held import free_coordinates
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import equations
from tests.laws.mechanisms import random_mechanism

FAST, MANY = 3, 100


def question(eqs: sb.EquationSet, state: sb.State) -> dict[str, str]:
    """The motions of all coordinates that were those of the state for an instant: parabolas in time."""
    found = {}
    for name in free_coordinates(eqs):
        if name not in eqs.coordinate_names or any(name in four for four in eqs.quaternions):
            continue
        value, rate, second = (float(state[word]) for word in (name, f"{name}_dot", f"{name}_ddot"))
        found[name] = f"{value!r} + {rate!r}*(t - {state.t!r}) + {second / 2!r}*(t - {state.t!r})^2"
    return found


def check(seeds: Iterable[int], wanted: int) -> None:
    done, looped, worst = 0, 0, 0.0
    for seed in seeds:
        mechanism = random_mechanism(seed)
        if not mechanism.inputs:
            continue
        known = consistent_state(mechanism).known
        eqs = equations(mechanism, None)
        if eqs.quaternions or eqs.formed.friction:
            continue
        guess = {name: known[name] for name in (*eqs.coordinate_names, *eqs.speed_names)}
        inputs = {name: known[name] for name in eqs.input_names}
        state = sb.assemble(eqs, guess=guess, inputs=inputs, t=known["t"])
        try:
            run = sb.inverse_dynamics(eqs, question(eqs, state), eqs.input_names, [state.t], guess=guess)
        except sb.UsageError as error:  # an input of a spring's length or of another law of higher degree
            assert {p.code for p in error.problems} == {"inverse.not_affine"}, seed
            continue
        again = run["udot"][:, 0]  # of forward dynamics with the inputs found
        size = max(map(abs, state.udot.values()), default=0.0) + 1e-300
        error = float(np.abs(again - list(state.udot.values())).max(initial=0.0)) / size
        # Systems of M are solved twice; the generator keeps their condition below about 1e8.
        assert error < 1e8 * 64 * np.finfo(float).eps, (seed, error)
        worst, done, looped = max(worst, error), done + 1, looped + bool(mechanism.loops)
        if done == wanted:
            break
    assert done == wanted and (looped or wanted < MANY)
    print(f"{done} mechanisms, {looped} with loops; accelerations differ by at most {worst:.2g}")


def test_inverse_of_forward_dynamics() -> None:
    check(range(60), FAST)


@pytest.mark.exhaustive
def test_inverse_of_forward_dynamics_of_many() -> None:
    check(range(1000), MANY)
