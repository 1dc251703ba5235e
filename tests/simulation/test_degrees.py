"""Degrees and other numbers wherever values are given."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy

import symbody as sb

ANGLE = math.radians(30)


def hinge(applied: str = "0", *elements: Any) -> sb.EquationSet:
    joint = sb.Revolute("J", "ground", "B", axis="z", coordinate="p", torque=sb.Drive(applied=applied))
    parts = [sb.Body("B", mass=1, inertia=(1, 1, 1)), joint, *elements]
    return sb.form_equations(sb.Model("hinge", parts, parameters={"c": 1}, inputs=["T"]))


WAYS: dict[str, Callable[[], Any]] = {
    "drive": lambda: sb.simulate(hinge("30 deg"), 0.1)["p_ddot"][0],
    "sum": lambda: sb.simulate(hinge("30 deg + 1*t"), 0.1)["p_ddot"][0],
    "signal": lambda: sb.simulate(hinge("0", sb.Signal("s", "30 deg")), 0.1)["s"][0],
    "input": lambda: sb.simulate(hinge("T"), 0.1, inputs={"T": "30 deg"})["T"][0],
    "output": lambda: sb.simulate(hinge(), 0.1)["30 deg"][0],
    "event": lambda: sb.simulate(hinge(), 1, {"p_dot": 1}, events=sb.Event("p - 30 deg")).events[0].t,
    "initial": lambda: sb.simulate(hinge(), 0.1, {"p": "30 deg"})["p"][0],
    "sweep": lambda: sb.sweep(hinge(), 0.1, {"c": [1, 2]}, initial={"p": "30 deg"})["p"][0, 0],
    "sweep of texts": lambda: sb.sweep(hinge(), 0.1, {"c": [1, 2]}, initial={"p": ["30 deg", "1 deg"]})["p"][0, 0],
    "sweep's guess": lambda: sb.sweep(hinge(), 0.1, {"c": [1]}, guess={"p": "30 deg"})["p"][0, 0],
    "parameters of a sweep": lambda: sb.sweep(hinge("c"), 0.1, {"c": "30 deg"}, initial={"p": [0, 1]})["c"][0, 0],
    "stepper": lambda: sb.Stepper(hinge(), 0.1, initial={"p": "30 deg"})["p"],
    "assemble": lambda: sb.assemble(hinge(), {"p": "30 deg"})["p"],
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_degrees_are_understood_wherever_formulas_are(way: str) -> None:
    assert WAYS[way]() == pytest.approx(ANGLE, rel=1e-9)


def test_an_action_sets_degrees() -> None:
    event = sb.Event("p - 0.3", action={"p": "30 deg"})
    run = sb.simulate(hinge(), 1, {"p_dot": 1}, events=event)
    assert run["p"][-1] == pytest.approx(ANGLE + 0.7)


def test_lengths_and_masses_are_not_in_degrees() -> None:
    slide = [sb.Body("B", mass=1), sb.Prismatic("K", "ground", "B", axis="x", coordinate="x")]
    eqs = sb.form_equations(sb.Model("slide", slide))
    for refused in (
        lambda: sb.simulate(eqs, 1, {"x": "30 deg"}),
        lambda: sb.simulate(eqs, 1, {"x_dot": "2*30 deg"}),
        lambda: sb.Model("m", [sb.Body("B", mass="30 deg")]),
        lambda: sb.Model("m", [*slide, sb.Distance("d", "ground", "B", "30 deg")]),
    ):
        with pytest.raises(sb.SymbodyError, match="deg is allowed for angles only") as caught:
            refused()
        assert caught.value.problems[0].code == "model.not_an_angle"


def test_values_at_a_time_are_numbers() -> None:
    parts = [part for w in "ab" for part in (sb.Body(f"B{w}", mass=1, inertia=(1, 1, 1)),
             sb.Revolute(f"J{w}", "ground", f"B{w}", axis="z", coordinate=w))]  # fmt: skip
    eqs = sb.form_equations(sb.Model("gear", [*parts, sb.Gear("g", ["a", "b"], 2)]), substitute=True)
    at = sb.simulate(eqs, 1, {"b_dot": 1}).at(0.5)
    for name in ("a", "b", "a_dot", "energy", "2*a"):
        assert isinstance(at[name], float), name
    assert all(isinstance(value, float) for value in at.outputs("a", "energy").values())
    assert at["frame r Ba"].shape == (3,)


@pytest.mark.parametrize(
    "number", [Fraction(1, 2), Decimal("0.5"), sympy.Rational(1, 2), np.float32(0.5), "1/2"]
)
def test_a_constant_of_a_sweep_may_be_any_number(number: Any) -> None:
    sweep = sb.sweep(hinge(), 0.1, {"c": number}, initial={"p": number, "p_dot": [0, 1]})
    np.testing.assert_allclose(sweep["p"][:, 0], 0.5)
    np.testing.assert_allclose(sweep["c"], 0.5)


@pytest.mark.parametrize("seed", [-1, 1.5, True, "x"])
def test_a_seed_is_a_whole_number(seed: Any) -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.sweep(hinge(), 0.1, {"c": sb.Samples("uniform", 0, 1)}, samples=2, seed=seed)
    assert caught.value.problems[0].code in ("sweep.seed", "call.argument")
