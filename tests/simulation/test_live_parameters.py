"""Analyses with new values of parameters and new initial values: nothing is compiled anew, and all is right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.codegen import shared_code
from tests.simulation.test_rope import ball as rope_ball
from tests.tiers import rows

EXAMPLES = Path(__file__).parents[2] / "examples"
CALLS = 100
NEAR = {"s": 1.3}


def equations(name: str) -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLES / name / f"{name}.toml"))


@dataclass
class Compilations:
    count: int = 0


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> Compilations:
    counter = Compilations()
    compile_code = shared_code.SharedCode.__init__

    def counted(self: shared_code.SharedCode, *given: Any, **choices: Any) -> None:
        counter.count += 1
        compile_code(self, *given, **choices)

    monkeypatch.setattr(shared_code.SharedCode, "__init__", counted)
    return counter


def simulate(eqs: sb.EquationSet, k: int) -> Any:
    values = {"m2": 1.0 + 0.01 * k, "L2": 0.9 + 0.002 * k}
    return sb.simulate(eqs, 0.05, {"theta": 0.01 * k}, guess=NEAR, parameters=values, inputs={"F": 0.5 + k})[
        "energy"
    ]


def assemble(eqs: sb.EquationSet, k: int) -> Any:
    return sb.assemble(
        eqs, {"theta": 0.01 * k, "theta_dot": 1 + k}, NEAR, parameters={"L1": 0.3 + 0.001 * k}
    )["energy"]


def linearize(eqs: sb.EquationSet, k: int) -> Any:
    state = sb.assemble(
        eqs, {"theta": 0.01 * k, "theta_dot": 0.1 * k}, NEAR, parameters={"m1": 1.0 + 0.1 * k}
    )
    return sb.linearize(eqs, state).A


def inverse_dynamics(eqs: sb.EquationSet, k: int) -> Any:
    values = {"m2": 1.0 + 0.01 * k, "L2": 0.9 + 0.002 * k}
    return sb.inverse_dynamics(eqs, {"theta": "0.5 + t"}, "F", [0.0, 0.1], guess=NEAR, parameters=values)["F"]


def find_equilibrium(eqs: sb.EquationSet, k: int) -> Any:
    return sb.find_equilibrium(eqs, guess={"x": 0.01 * k}, parameters={"k": 10.0 + k, "m": 1.0 + k}).q


def sweep(eqs: sb.EquationSet, k: int) -> Any:
    cases = {"m1": [1.0, 2.0 + k], "m2": 1.0 + 0.01 * k}
    return sb.sweep(eqs, 0.02, cases, initial={"theta": 0.3 + 0.001 * k}, guess=NEAR)["theta"]


@pytest.mark.parametrize(
    ("call", "name", "times"),
    rows([
        (simulate, "slider_crank", CALLS), (assemble, "slider_crank", CALLS), (linearize, "slider_crank", CALLS),
        (inverse_dynamics, "slider_crank", CALLS), (find_equilibrium, "spring_mass_damper", CALLS // 4),
        (sweep, "slider_crank", CALLS // 4),
    ], fast=lambda call, *_: call is not inverse_dynamics),
)  # fmt: skip
def test_new_values_compile_nothing(
    call: Callable[[sb.EquationSet, int], Any], name: str, times: int, compilations: Compilations
) -> None:
    eqs = equations(name)
    call(eqs, 1)
    first = compilations.count
    for k in range(2, times + 1):
        call(eqs, k)
    assert 0 < first == compilations.count


def test_each_set_of_values_has_the_motion_of_equations_formed_for_it() -> None:
    """A parallelogram and back, equal lengths, no gravity, a massless coupler: one set of equations all the time."""
    eqs = equations("four_bar")
    start = {"theta": 1.0, "theta_dot": 5.0}
    for values in (
        {}, {"L1": 0.3, "L3": 0.3}, {"L1": 0.5}, {"G": 0}, {"L1": 0.3, "L3": 0.3, "m2": 0, "I2": 0}, {"m2": 0}, {},
    ):  # fmt: skip
        given = {name: f"{value}" for name, value in values.items()}
        model = sb.load_model(EXAMPLES / "four_bar" / "four_bar.toml")
        text = (EXAMPLES / "four_bar" / "four_bar.toml").read_text(encoding="utf-8")
        for name, value in given.items():
            old = next(line for line in text.splitlines() if line.startswith(f"{name} = "))
            text = text.replace(old, f"{name} = {value}")
        own = sb.form_equations(model_of(text))
        guess = {"phi": 1.7}
        run = sb.simulate(eqs, 0.3, start, guess=guess, parameters=dict(values), rtol=1e-10)
        alone = sb.simulate(own, 0.3, start, guess=guess, rtol=1e-10)
        assert run.status == alone.status and model.name == run.name
        at = np.linspace(0.0, 0.3, 7)
        np.testing.assert_allclose(run.at(at)["phi"], alone.at(at)["phi"], rtol=0, atol=1e-8)
        np.testing.assert_allclose(run["energy"][-1], alone["energy"][-1], rtol=1e-7, atol=1e-7)


def model_of(text: str) -> sb.Model:
    from symbody.formats.native import model_from_toml

    return model_from_toml(text, "test")


def test_a_repeated_motion_has_the_same_bits() -> None:
    eqs = equations("slider_crank")
    runs = [
        sb.simulate(eqs, 0.2, {"theta": 0.4}, guess=NEAR, parameters={"m2": 2.0 + k % 2}) for k in range(4)
    ]
    for one, other in ((0, 2), (1, 3)):
        np.testing.assert_array_equal(runs[one].q, runs[other].q)
    fresh = sb.simulate(equations("slider_crank"), 0.2, {"theta": 0.4}, guess=NEAR, parameters={"m2": 2.0})
    np.testing.assert_allclose(fresh.q[:, -1], runs[0].q[:, -1], rtol=0, atol=1e6 * np.finfo(float).eps)


def test_impossible_values_are_refused_by_analyses_each_time() -> None:
    eqs = equations("slider_crank")
    for _ in range(2):
        with pytest.raises(sb.CompileError, match="mass"):
            sb.simulate(eqs, 0.1, {"theta": 0.4}, guess=NEAR, parameters={"m2": -1.0})
        assert sb.simulate(eqs, 0.1, {"theta": 0.4}, guess=NEAR, parameters={"m2": 1.0}).success


def test_ropes_that_go_taut_and_slack_compile_once(compilations: Compilations) -> None:
    """Each set of taut ropes has equations of its own, which stay with the mechanism's."""
    eqs = sb.form_equations(rope_ball())
    start = {"x": 0.1, "y": 0.0, "x_dot": 1.5, "y_dot": 4.0}
    runs = []
    for k in range(3):
        runs.append(sb.simulate(eqs, 0.8, start, parameters={"L": 0.8, "m": 1.0 + k}))
        if k == 0:
            compilations.count = 0
    assert compilations.count == 0
    assert all(len(run.events) == len(runs[0].events) >= 2 for run in runs)
    fresh = sb.simulate(sb.form_equations(rope_ball()), 0.8, start, parameters={"L": 0.8, "m": 3.0})
    np.testing.assert_allclose(runs[-1]["y"], fresh["y"], rtol=1e-12, atol=1e-12)
