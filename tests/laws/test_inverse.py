"""Inverse dynamics undoes forward dynamics: from the accelerations of random mechanisms follow the inputs that caused them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.kinematics.driven import free_coordinates
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import EPS, condition, equations
from tests.laws.mechanisms import random_mechanism
from tests.laws.tally import BOUND

FAST, MANY = 1, 100


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
        # Forward dynamics of its own, with the inputs found: the accelerations that they were asked for.
        t, q, u = state.t, list(state.q.values()), list(state.u.values())
        found = [run[name][0] for name in eqs.input_names]
        f = sb.compile(eqs, ("udot", "mass_matrix", "jacobian", "forcing", "lambda", "gamma"))(t, q, u, found)
        size = max(map(abs, state.udot.values()), default=0.0) + 1e-300
        error = float(np.abs(f.udot - list(state.udot.values())).max(initial=0.0)) / size
        # Systems of M and J are solved there and back, each with this error; what is asked for closes to 1e-9
        # of its size at worst in assembly, and as a rule to rounding.
        bound = BOUND * EPS * condition(f._asdict()).number
        assert error < bound, (seed, error, bound)
        worst, done, looped = max(worst, error / bound), done + 1, looped + bool(mechanism.loops)
        if done == wanted:
            break
    assert done == wanted and (looped or wanted < MANY)
    print(f"{done} mechanisms, {looped} with loops; accelerations differ by at most {worst:.2g} of the bound")


def test_inverse_of_forward_dynamics() -> None:
    check(range(20), FAST)


@pytest.mark.exhaustive
def test_inverse_of_forward_dynamics_of_many() -> None:
    check(range(1000), MANY)
