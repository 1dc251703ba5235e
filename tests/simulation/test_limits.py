"""Ends of joint coordinates and play of gears: rigid ones are stops, compliant ones forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import pytest

import symbody as sb
from tests.formulations import FORMULATIONS, name_of
from tests.tiers import cases

M = 2.0


def cart(speed: float, limits: Mapping[str, object], **joint: object) -> sb.EquationSet:
    """Return a cart that rolls from 0 with a speed."""
    rail = sb.Prismatic(  # type: ignore[misc]
        "rail", "ground", sb.Body("Cart", mass=M), coordinate="x", limits=dict(limits), **joint
    )
    model = sb.Model("cart", [rail], parameters={"k": 5e3, "L": 1}, initial={"x_dot": speed})
    return sb.form_equations(model)


def test_rigid_limits_are_the_stops_that_one_would_write() -> None:
    run = sb.simulate(cart(2.0, {"low": -0.5, "high": "L", "rigid": True, "restitution": 0.5}), 3.0)
    rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=M), coordinate="x")
    stops = [sb.Stop("low", "x + 0.5", restitution=0.5), sb.Stop("high", "L - x", restitution=0.5)]
    model = sb.Model("cart", [rail, *stops], parameters={"L": 1}, initial={"x_dot": 2.0})
    same = sb.simulate(sb.form_equations(model), 3.0)
    assert run["x"] == pytest.approx(same["x"]) and run["gap rail high"] == pytest.approx(same["gap high"])
    events = [(event.name, event.t) for event in run.events]
    assert events == [("rail high impact", pytest.approx(0.5)), ("rail low impact", pytest.approx(2.0))]
    assert run.units["opening_effort rail high"] == "N" and run.units["gap rail low"] == "m"


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_a_compliant_limit_is_a_spring_beyond_the_end(speed: float) -> None:
    run = sb.simulate(cart(speed, {"low": -0.5, "high": 0.5, "stiffness": "k"}), 1.0, rtol=1e-10,
                      times=np.linspace(0, 1, 2001))  # fmt: skip
    depth = np.sqrt(M / 5e3)  # v sqrt(m/k)
    assert np.abs(run["x"]).max() == pytest.approx(0.5 + depth, rel=1e-4)
    assert run["x_dot"][-1] == pytest.approx(-speed, rel=1e-8)
    beyond = np.maximum(np.abs(run["x"]) - 0.5, 0)
    assert run["effort rail"] == pytest.approx(-np.sign(speed) * 5e3 * beyond, abs=1e-9)
    assert run["potential_energy"] == pytest.approx(5e3 * beyond**2 / 2, abs=1e-10)
    assert abs(run.energy_drift) < 1e-8
    assert run.units["k"] == "N/m"


@pytest.mark.parametrize("exponent", [1, 1.5, 2.2])
def test_the_restitution_at_a_speed_is_exact(exponent: float) -> None:
    limits = {"high": 0.2, "stiffness": 1e5, "exponent": exponent, "restitution": 0.6, "speed": 1.5}
    run = sb.simulate(cart(1.5, limits), 0.6, rtol=1e-10)
    assert run["x_dot"][-1] == pytest.approx(-0.6 * 1.5, rel=1e-7)
    assert run["effort rail"].max() <= 0.0
    assert abs(run.energy_drift) < 1e-7


def test_an_end_that_moves_does_work() -> None:
    run = sb.simulate(cart(0.0, {"low": "0.5*t - 0.1", "stiffness": 1e4}), 2.0, rtol=1e-10)
    assert run["x_dot"][-1] == pytest.approx(1.0, rel=1e-7)  # twice the speed of the wall
    assert run["energy"][-1] - run["energy"][0] == pytest.approx(M / 2, rel=1e-7)
    assert abs(run.energy_drift) < 1e-7


def test_an_end_that_moves_strikes() -> None:
    run = sb.simulate(cart(0.0, {"low": "0.5*t - 0.1", "rigid": True, "restitution": 0.4}), 1.0)
    assert run["x_dot"][-1] == pytest.approx(0.7, rel=1e-10)
    assert run.events[0].t == pytest.approx(0.2)


def four_bar(trees: Sequence[str], **limits: object) -> sb.EquationSet:
    """Return a crank-rocker whose rocker has limits."""
    lengths = {"crank": 1.0, "coupler": 3.0, "rocker": 2.5}
    bodies = {
        name: sb.Body(name, mass=length, inertia=(0, 0, length**3 / 12),
                      frames={"a": sb.Frame(at=(-length / 2, 0, 0)), "b": sb.Frame(at=(length / 2, 0, 0))})
        for name, length in lengths.items()
    }  # fmt: skip
    crank, coupler, rocker = bodies.values()
    joints = [
        sb.Revolute("A", "ground", crank["a"], coordinate="alpha"),
        sb.Revolute("B", crank["b"], coupler["a"], coordinate="beta"),
        sb.Revolute("C", coupler["b"], rocker["b"], coordinate="sigma"),
        sb.Revolute("D", "ground.pin", rocker["a"], coordinate="delta", limits=limits or None),
    ]
    model = sb.Model(
        "four bar", joints, gravity=(0, -9.81, 0), ground={"pin": sb.Frame(at=(2.5, 0, 0))},
        initial={"alpha": sb.Initial(0.9, "hold"), "alpha_dot": sb.Initial(-3.0, "hold"), "delta": 1.313, "beta": -0.324, "sigma": 0.737},
    )  # fmt: skip
    return sb.form_equations(model, tree=sb.Trees(list(trees), list(trees)))


@pytest.mark.parametrize(
    "limits",
    [{"high": 1.8, "rigid": True, "restitution": 0.4}, {"high": 1.8, "stiffness": 2e3, "damping": 20}],
)
def test_limits_of_cut_joints_are_those_of_joints_in_the_tree(limits: dict[str, object]) -> None:
    runs = [
        sb.simulate(four_bar(trees, **limits), 1.0, rtol=1e-10, times=np.linspace(0, 1, 41))
        for trees in (["A", "B", "D"], ["A", "B", "C"], ["B", "C", "D"])
    ]
    names = ("frame r crank x", "frame w rocker z", "reaction D Fx", "reaction B Fy", "energy")
    for first, other in pairwise(runs):
        for name in names:
            assert other[name] == pytest.approx(first[name], rel=1e-5, abs=1e-5), name
    free = sb.simulate(four_bar(["A", "B", "D"]), 1.0, rtol=1e-10)
    assert free["delta"].max() > 2.0  # so that the limit was met


def gears(**backlash: object) -> sb.EquationSet:
    """Return two wheels with play, the first of which turns."""
    wheels = [
        sb.Revolute(
            name, "ground", sb.Body(f"Wheel {name}", mass=1, inertia=(0, 0, inertia)), coordinate=name
        )
        for name, inertia in (("a", 0.2), ("b", 0.5))
    ]
    mesh = sb.Gear("mesh", ["a", "b"], ratio=-3, offset=0.1, backlash=backlash)
    model = sb.Model("gears", [*wheels, mesh], parameters={"k": 900.0}, initial={"a": 0.1, "a_dot": 1.0})
    return sb.form_equations(model)


# Of what the play is a coordinate: 1/I = 1/0.2 + 3^2/0.5.
INERTIA = 1 / (1 / 0.2 + 9 / 0.5)


def test_wheels_are_free_within_their_play_and_then_swing() -> None:
    eqs = gears(angle=0.2, stiffness="k")
    assert eqs.speed_names == ("a_dot", "b_dot")
    period = np.pi * np.sqrt(INERTIA / 900)  # half of that of the mesh
    run = sb.simulate(eqs, 0.1 + period, rtol=1e-11, times=np.linspace(0, 0.1 + period, 301))
    free = run.t < 0.1
    assert run["effort mesh"][free] == pytest.approx(0.0) and run["a_dot"][free] == pytest.approx(1.0)
    touching = run.t > 0.1
    expected = -900 * np.sqrt(INERTIA / 900) * np.sin(np.sqrt(900 / INERTIA) * (run.t[touching] - 0.1))
    assert run["effort mesh"][touching] == pytest.approx(expected, abs=1e-5)
    assert run["a_dot"][-1] + 3 * run["b_dot"][-1] == pytest.approx(-1.0, rel=1e-6)
    assert abs(run.energy_drift) < 1e-8
    assert run.units["k"] == "N m/rad" and run.units["effort mesh"] == "N m"


@pytest.mark.parametrize("e", [0.0, 0.6, 1.0])
def test_rigid_teeth_keep_the_momentum_that_no_tooth_acts_on(e: float) -> None:
    run = sb.simulate(gears(angle=0.2, rigid=True, restitution=e), 0.25)
    impact = run.events[0]
    assert impact.name == "mesh high impact" and impact.t == pytest.approx(0.1)
    a, b = run["a_dot"][-1], run["b_dot"][-1]
    assert a + 3 * b == pytest.approx(-e, abs=1e-12)
    assert 3 * 0.2 * a - 0.5 * b == pytest.approx(3 * 0.2)
    assert run["gap mesh high"] + run["gap mesh low"] == pytest.approx(0.2)


def test_a_gear_without_play_is_the_constraint_that_it_was() -> None:
    wheels = [
        sb.Revolute(name, "ground", sb.Body(name.upper(), mass=1, inertia=(0, 0, 1)), coordinate=name)
        for name in "ab"
    ]
    gear = sb.Gear("mesh", ["a", "b"], ratio=-3)
    model = sb.Model("gears", [*wheels, gear])
    assert model.constraints == (gear,)
    assert len(sb.form_equations(model, substitute=True).speed_names) == 1


def test_inverse_dynamics_counts_the_force_of_a_limit() -> None:
    drive = sb.Drive("F")
    rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=M), coordinate="x", force=drive,
                        limits=sb.Limits(high=0.5, stiffness=100))  # fmt: skip
    eqs = sb.form_equations(sb.Model("cart", [rail], inputs=["F"]))
    found = sb.inverse_dynamics(eqs, {"x": "t"}, "F", [0.2, 0.8])
    assert found["F"] == pytest.approx([0.0, 30.0], abs=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=name_of)
@pytest.mark.parametrize(
    "limits", cases([{"rigid": True, "restitution": 0.4}, {"stiffness": 2e3}], fast=[{"stiffness": 2e3}])
)
def test_every_formulation_has_the_same_limits(
    formulation: sb.Formulation, limits: dict[str, object]
) -> None:
    expected = sb.simulate(four_bar(["A", "B", "D"], high=1.8, **limits), 0.5, times=[0.5], rtol=1e-10)
    for trees in (["A", "B", "D"], ["A", "B", "C"]):
        eqs = sb.form_equations(
            four_bar(trees, high=1.8, **limits).model,
            formulation, tree=sb.Trees(trees, trees),
        )  # fmt: skip
        run = sb.simulate(eqs, 0.5, times=[0.5], rtol=1e-10)
        for name in ("frame r crank x", "frame w rocker z", "reaction D Fx", "energy"):
            assert run[name][-1] == pytest.approx(expected[name][-1], rel=1e-6, abs=1e-6), name


@pytest.mark.parametrize("substitute", [False, True])
@pytest.mark.parametrize("limits", [{"rigid": True, "restitution": 0.5}, {"stiffness": 500, "damping": 3}])
def test_couplings_hand_limits_on(substitute: bool, limits: dict[str, object]) -> None:
    """A limit of either wheel acts on both: first on b = -a/3, then on a."""
    ends = []
    for name, end in (("a", {"high": 0.9}), ("b", {"low": -0.3})):
        # behind the ratio a stiffness and a damping are nine times as large for the same motion
        scale = 1 if name == "a" else 9
        law = {
            key: value * scale if key in ("stiffness", "damping") else value for key, value in limits.items()
        }
        wheels = [
            sb.Revolute(x, "ground", sb.Body(f"Wheel {x}", mass=1, inertia=(0, 0, inertia)), coordinate=x,
                        limits={**end, **law} if x == name else None)
            for x, inertia in (("a", 0.2), ("b", 0.5))
        ]  # fmt: skip
        model = sb.Model("gears", [*wheels, sb.Gear("mesh", ["a", "b"], ratio=-3)],
                         initial={"a_dot": 1.0, "b_dot": -1 / 3})  # fmt: skip
        run = sb.simulate(sb.form_equations(model, substitute=substitute), 1.5, times=[1.5], rtol=1e-10)
        ends.append((run["a"][-1], run["a_dot"][-1], run["b_dot"][-1]))
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)
    assert ends[0][1] < 0.0
