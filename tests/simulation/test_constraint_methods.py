"""All ways to hold constraints give one motion where rows are nonholonomic, or belong to no joint."""

from __future__ import annotations

from functools import cache
from math import sin
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

import symbody as sb
from symbody.cli.summary import summary
from tests.tiers import cases

ALL = {
    "projection": {},
    "Baumgarte": {"constraints": sb.Baumgarte()},
    "partition": {"constraints": sb.Partition()},
    "stiff": {"integrator": sb.Stiff()},
    "GGL": {"constraints": sb.GGL()},
}


@cache
def disc() -> sb.EquationSet:
    mass, radius = 1.3, 0.4
    body = sb.Body("Disc", mass=mass, inertia=[mass * radius**2 * k for k in (0.25, 0.25, 0.5)])
    free = sb.Free("free", "ground", "Disc", angles="313", coordinates=["x", "y", "z", "psi", "theta", "phi"])
    rolling = sb.Rolling("road", "ground", "Disc", radius=radius, axis="z")
    return sb.form_equations(sb.Model("disc", [body, free, rolling], gravity=[0, 0, -9.81]))


@cache
def four_bar() -> sb.EquationSet:
    parts = [
        sb.Body("Crank", mass=1, inertia=(0, 0, 0.1), frames={"B": sb.Frame(at=(1, 0, 0))}),
        sb.Body("Rocker", mass=2, inertia=(0, 0, 0.3), frames={"C": sb.Frame(at=(1.8, 0, 0))}),
        sb.Revolute("A", "ground", "Crank", coordinate="a", torque=sb.Drive(applied=0.5)),
        sb.Revolute("D", "ground.D", "Rocker", coordinate="d"),
        sb.Distance("rod", "Crank.B", "Rocker.C", 2.2),
    ]
    ground = {"D": sb.Frame(at=(2.5, 0, 0))}
    return sb.form_equations(sb.Model("four-bar", parts, gravity=(0, -9.81, 0), ground=ground))


CASES = {
    "disc": (
        disc,
        {"psi": 0.4, "theta": 1.2, "phi": 0.0, "psi_dot": 1.0, "theta_dot": 0.3, "phi_dot": 4.0, "x": 0, "y": 0},
        {"z": 0.4 * sin(1.2)},
        3,
    ),
    "four-bar": (four_bar, {"a": 1.0, "a_dot": 2.0}, {"d": 1.8}, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", cases(CASES, fast=lambda name: name != "four-bar"))  # as in test_ggl
def test_all_ways_to_hold_constraints_give_one_motion(name: str) -> None:
    make, fixed, guess, freedoms = CASES[name]
    eqs = make()
    assert (
        eqs.degrees_of_freedom == sb.redundancy(eqs, guess={**fixed, **guess}).degrees_of_freedom == freedoms
    )
    times = np.linspace(0.0, 1.0, 6)
    reference = sb.simulate(eqs, 1.0, fixed, guess=guess, times=times, rtol=1e-11, atol=1e-12)
    for way, words in ALL.items():
        run = sb.simulate(eqs, 1.0, fixed, guess=guess, times=times, **words)
        assert run.success
        # Some tens of explicit steps of 1e-8, or a thousand implicit ones.
        bound = 5e-5 if way in ("stiff", "GGL") else 1e-6
        assert np.abs(run.q - reference.q).max() < bound, way
        assert np.abs(run.u - reference.u).max() < 20 * bound, way  # rates of some 10/s
        assert run["constraint_violation"].max() < 1e-6 and run["velocity_violation"].max() < 1e-5
        assert np.ptp(run["energy"] - run["work"]) < 20 * bound, way


def test_the_way_of_a_rolling_disc_is_its_spin() -> None:
    """The contact point goes forward by radius times the spin relative to its own frame."""
    _, fixed, guess, _ = CASES["disc"]
    run = sb.simulate(disc(), 1.0, fixed, guess=guess, rtol=1e-10, atol=1e-12)
    v = run["frame v road ground road"]
    np.testing.assert_allclose(np.abs(v[0]), 0.4 * np.abs(run["phi_dot"]), atol=1e-9)
    np.testing.assert_allclose(v[1:], 0.0, atol=1e-9)
    assert run.units["lambda_road_1"] == run.units["reaction road Fz"] == "N"


def test_what_check_tells_of_constraints() -> None:
    lines = summary(disc().model, disc())
    assert "  road  rolling  ground -> Disc  holds 1 in position and 2 in velocity" in lines
    lines = summary(four_bar().model, four_bar())
    assert "  rod  distance  Crank.B -> Rocker.C  holds 1 in position" in lines
    gear = [sb.Gear("g", ["a", "d"], 2), sb.Constraint("idle", "a - a")]
    model = sb.Model("geared", [*four_bar().model.elements[:4], *gear], ground=four_bar().model.ground)
    lines = summary(model, sb.form_equations(model))
    assert "  g     gear      a, d  holds 1 in position" in lines
    assert "  idle  equation        holds nothing that is not already held" in lines


def test_code_and_plots_of_constrained_motions() -> None:
    eqs = disc()
    compiled = sb.compile(eqs, ["udot", "lambda"])
    q, u = np.array([0.1, 0.2, 0.35, 0.4, 1.1, 0.3]), np.array([0.3, -0.1, 0.2, 0.4, -0.5, 0.6])
    namespace: dict[str, Any] = {}
    text = sb.generate_code(eqs, ["udot", "lambda"], language="python")
    exec(compile(text, "disc", "exec"), namespace)  # what users do with the text
    first, second = namespace["f"](0.0, q, u)
    np.testing.assert_allclose(first, compiled(0.0, q, u)[0], rtol=1e-12)
    np.testing.assert_allclose(second, compiled(0.0, q, u)[1], rtol=1e-12)
    assert "lambda" in sb.generate_code(eqs, ["udot", "lambda"], language="c")
    run = sb.simulate(four_bar(), 0.2, {"a": 1.0}, guess={"d": 1.8})
    ax = sb.plot(run, "lambda_rod_1", "reaction rod Fx")
    assert ax.get_ylabel().endswith("[N]") or "N" in ax.get_ylabel()
    pyplot.close(ax.figure)
