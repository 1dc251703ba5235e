"""Bennett's linkage: four hinges in space that move, though a count of constraints says they cannot.

G. T. Bennett, A new mechanism, Engineering 76 (1903), 777-778; J. E. Baker, The Bennett, Goldberg and Myard
linkages in perspective, Mech. Mach. Theory 14 (1979), 239-253.
"""

from __future__ import annotations

from functools import cache
from math import asin, cos, pi, sin, tan

import numpy as np
import pytest

import symbody as sb

A, B, ALPHA = 1.0, 0.7, pi / 3
BETA = asin(B / A * sin(ALPHA))  # sin(alpha) / a = sin(beta) / b
GUESS = {"t2": 2.9, "t4": -2.9}


@cache
def linkage(beta: str = "asin(b/a*sin(alpha))") -> sb.EquationSet:
    """Links of lengths b, a, b on ground, which is a; each hinge is turned from the one before by its twist."""
    links = [
        sb.Body(name, mass=mass, inertia=(0.01, 0.1, 0.1), frames={
            "inner": sb.Frame(at=(f"-{length}/2", 0, 0)),
            "outer": sb.Frame(at=(f"{length}/2", 0, 0), rotate=[("x", twist)]),
        })
        for name, length, twist, mass in
        (("Input", "b", "beta", 1.0), ("Coupler", "a", "alpha", 1.5), ("Output", "b", "beta", 1.2))
    ]  # fmt: skip
    ends = ("ground.far", "Input", "Coupler", "Output", "ground")
    hinges = []
    for k, name in enumerate("ABCD"):
        start = ends[k] if k == 0 else f"{ends[k]}.outer"
        end = ends[k + 1] if k == 3 else f"{ends[k + 1]}.inner"
        hinges.append(sb.Revolute(name, start, end, axis="z", coordinate=f"t{k + 1}"))
    model = sb.Model(
        "Bennett", [*links, *hinges], gravity=(0, -9.81, 0),
        parameters={"a": A, "b": B, "alpha": ALPHA, "beta": beta},
        ground={"far": sb.Frame(at=("a", 0, 0), rotate=[("x", "alpha")])},
    )  # fmt: skip
    return sb.form_equations(model)


def test_mobility_is_one_though_a_count_says_minus_two() -> None:
    """6 (4 - 1) - 4 * 5 = -2; three of the rows of the cut hinge follow from the two others."""
    eqs = linkage()
    assert 6 * 3 - 4 * 5 == len(eqs.speed_names) - len(eqs.multiplier_names) == -2
    found = sb.redundancy(eqs, guess={"t1": 1.0, **GUESS})
    assert found.degrees_of_freedom == 1
    assert found.kept == ("lambda_C_1", "lambda_C_2")
    assert found.dropped == ("lambda_C_3", "lambda_C_4", "lambda_C_5")


def test_other_twists_do_not_move() -> None:
    eqs = linkage("asin(b/a*sin(alpha)) + 0.1")
    with pytest.raises(sb.AssemblyError):
        sb.assemble(eqs, {"t1": 1.0}, GUESS)


def test_input_output_relation() -> None:
    """tan(theta/2) tan(phi/2) = sin((beta + alpha)/2) / sin((beta - alpha)/2), all around."""
    constant = sin((BETA + ALPHA) / 2) / sin((BETA - ALPHA) / 2)
    state = sb.assemble(linkage(), {"t1": 0.3}, GUESS)
    for angle in np.linspace(0.3, 2.9, 6):
        state = sb.assemble(linkage(), {"t1": float(angle)}, {name: state[name] for name in ("t2", "t4")})
        t1, t2, t3, t4 = (float(state[f"t{k}"]) for k in (1, 2, 3, 4))
        # eps over the slope of the tangent at 2.9 / 2, twice.
        assert tan(t1 / 2) * tan(t4 / 2) == pytest.approx(constant, rel=1e-12)
        assert abs(tan(t1 / 2) * tan(t2 / 2)) == pytest.approx(abs(constant), rel=1e-12)
        assert cos(t2) == pytest.approx(cos(t4), abs=1e-12)
        assert cos(t3) == pytest.approx(cos(t1), abs=1e-12)


def check(run: sb.Trajectory) -> None:
    assert run.success
    assert sum("sb.redundancy()" in note for note in run.notes) == 1
    assert run.constraint_violation.max() < 1e-9 and run.velocity_violation.max() < 1e-9
    # A local error of 1e-8 in the speeds in each step, all of one sign at worst.
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()
    # It goes through its flat positions: the relation holds on, without poles.
    constant = sin((BETA + ALPHA) / 2) / sin((BETA - ALPHA) / 2)
    t1, t4 = run["t1"] / 2, run["t4"] / 2
    gap = np.sin(t1) * np.sin(t4) - constant * np.cos(t1) * np.cos(t4)
    assert np.abs(gap).max() < 1e-11  # angles up to 230 rad, closed to their rounding, times the constant
    assert run["t1"][-1] - run["t1"][0] > 2 * pi


def test_moves_through_flat_positions() -> None:
    check(sb.simulate(linkage(), 3.0, {"t1": 1.0, "t1_dot": 6.0}, guess=GUESS))


@pytest.mark.exhaustive
def test_moves_for_a_minute() -> None:
    check(sb.simulate(linkage(), 60.0, {"t1": 1.0, "t1_dot": 6.0}, guess=GUESS))
