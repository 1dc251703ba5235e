"""Couplings that are substituted: what is left, what stays an output, what is refused or stays a constraint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb

J1, J2, MASS, RATIO, RADIUS = 0.05, 0.3, 4.0, -3.0, 0.2


def train(*more: Any, **words: Any) -> sb.Model:
    """A motor a, a wheel b in mesh with it, and a rack s that the wheel moves against a spring."""
    wheels = [("motor", "a", J1, sb.Drive("tau")), ("wheel", "b", J2, sb.Drive())]
    elements: list[Any] = []
    for name, coordinate, moment, drive in wheels:
        elements.append(sb.Body(name.title(), mass=1, inertia=[moment, moment, moment]))
        joint = sb.Revolute(name, "ground", name.title(), axis="z", coordinate=coordinate, torque=drive)
        elements.append(joint)
    elements += [
        sb.Body("Rack", mass=MASS, inertia=[1, 1, 1]),
        sb.Prismatic("slide", "ground", "Rack", axis="x", coordinate="s", force=sb.Drive(stiffness=10)),
        sb.Gear("gear", ["a", "b"], ratio="n", offset=0.1),
        sb.RackPinion("pinion", ["s", "b"], radius=RADIUS),
    ]
    values = {"n": RATIO, **words.pop("parameters", {})}
    return sb.Model(
        "train", [*elements, *more], parameters=values, inputs=["tau"], gravity=[0, 0, 0], **words
    )


def pair(*constraints: Any, **words: Any) -> sb.Model:
    """Three wheels x, y, z about parallel axes, and couplings."""
    elements: list[Any] = []
    for k, name in enumerate("xyz"):
        elements.append(sb.Body(f"B{name}", mass=1, inertia=[1 + k, 1 + k, 1 + k]))
        elements.append(sb.Revolute(f"J{name}", "ground", f"B{name}", axis="z", coordinate=name))
    return sb.Model("pair", [*elements, *constraints], gravity=[0, 0, 0], **words)


@pytest.fixture(scope="module")
def eqs() -> sb.EquationSet:
    return sb.form_equations(train(), substitute=True)


def test_one_coordinate_is_left(eqs: sb.EquationSet) -> None:
    assert eqs.coordinate_names == ("b",)
    assert eqs.multiplier_names == ()
    assert eqs.units["lambda_gear_1"] == "N m"
    assert (
        "a = 0.1 + n*b is substituted, from lambda_gear_1; all of them remain available as outputs"
        in eqs.notes
    )
    assert sb.form_equations(train()).coordinate_names == ("a", "b", "s")


@pytest.mark.parametrize(
    "formulation",
    [
        sb.Recursive("articulated"),
        sb.Recursive("composite"),
        sb.VirtualWork(),
        sb.Lagrange(),
        sb.NewtonEuler(),
    ],
    ids=["articulated", "composite", "virtual work", "Lagrange", "Newton-Euler"],
)
def test_acceleration_and_efforts_by_hand(formulation: Any) -> None:
    """n a' = b' and so on: (n^2 J1 + J2 + R^2 m) b'' = n tau - 10 R^2 b."""
    eqs = sb.form_equations(train(), formulation, substitute=True)
    f = sb.compile(eqs, ["udot", "a", "s_dot", "lambda_gear_1", "lambda_pinion_1", "kinetic_energy"])
    b, rate, tau = 0.3, 0.7, 2.0
    udot, a, s_dot, gear, pinion, energy = f(0.0, np.array([b]), np.array([rate]), np.array([tau]))
    inertia = RATIO**2 * J1 + J2 + RADIUS**2 * MASS
    expected = (RATIO * tau - 10 * RADIUS**2 * b) / inertia
    assert udot == pytest.approx([expected])
    assert (a, s_dot) == pytest.approx((RATIO * b + 0.1, RADIUS * rate))
    assert gear == pytest.approx(J1 * RATIO * expected - tau)
    assert pinion == pytest.approx(MASS * RADIUS * expected + 10 * RADIUS * b)
    assert energy == pytest.approx(inertia * rate**2 / 2)


def test_substituted_names_are_legal_everywhere(eqs: sb.EquationSet, tmp_path: Path) -> None:
    state = sb.assemble(eqs, fixed={"a": 0.7, "s_dot": 0.1})
    assert state.q["b"] == pytest.approx((0.7 - 0.1) / RATIO)
    assert state.u["b_dot"] == pytest.approx(0.1 / RADIUS)
    mid = sb.Event("s", action={"a_dot": "-a_dot/2"}, name="mid")
    run = sb.simulate(eqs, 4.0, initial={"a": 0.7}, inputs={"tau": "0.1*s"}, events=mid)
    assert run["a"] == pytest.approx(RATIO * run["b"] + 0.1, abs=1e-12)
    assert run.events[0].name == "mid"
    run.save(tmp_path / "run.npz")
    again = sb.Trajectory.load(tmp_path / "run.npz")
    assert again["lambda_gear_1"] == pytest.approx(run["lambda_gear_1"])
    held = sb.find_equilibrium(eqs, fixed={"a": 0.4}, unknowns="tau")
    assert held.inputs["tau"] == pytest.approx(10 * RADIUS**2 * held.q["b"] / RATIO)
    traced = sb.trace_positions(eqs, {"a": [0.1, 0.4]})
    assert traced["s"] == pytest.approx(RADIUS * (traced["a"] - 0.1) / RATIO)


def test_the_motion_is_that_of_the_constraints(eqs: sb.EquationSet) -> None:
    names = ("a", "s_ddot", "lambda_gear_1", "energy", "work")
    both = [
        sb.simulate(x, 1.0, initial={"a": 0.7}, inputs={"tau": "sin(3*t)"})
        for x in (eqs, sb.form_equations(train()))
    ]
    for name in names:
        assert both[0][name][-1] == pytest.approx(both[1][name][-1], rel=1e-5), name


def test_a_factor_that_vanishes_is_refused() -> None:
    coupling = sb.Constraint("c", "n*x - m*y")
    eqs = sb.form_equations(pair(coupling, parameters={"n": 1, "m": 2}), substitute=True)
    with pytest.raises(sb.FormulationError, match="its factor n in lambda_c_1 is 0 with n = 0") as error:
        sb.compile(eqs, "udot", parameters={"n": 0})
    assert error.value.problems[0].code == "equations.vanishing_factor"
    with pytest.raises(sb.FormulationError, match="is 0 with n = 0"):
        sb.sweep(eqs, 0.1, parameters={"n": [1, 0]})


def test_a_radius_that_vanishes_is_refused() -> None:
    belt = sb.Belt("belt", ["x", "y"], radii=["r1", "r2"])
    eqs = sb.form_equations(pair(belt, parameters={"r1": 1, "r2": 2}), substitute=True)
    with pytest.raises(sb.CompileError, match="r1 is 0 m") as error:
        sb.compile(eqs, "udot", parameters={"r1": 0})
    assert error.value.problems[0].code == "model.no_length"


@pytest.mark.parametrize(
    ("constraint", "reason"),
    [
        (sb.Gear("c", ["x", "y"], ratio=2, offset="sin(t)"), "it depends on time"),
        (sb.Constraint("c", "sin(x) - y"), "it is not linear in the coordinates"),
        (sb.Constraint("c", "x_dot - cos(x)*y_dot"), "it constrains velocities"),
    ],
)
def test_other_couplings_stay_constraints(constraint: Any, reason: str) -> None:
    eqs = sb.form_equations(pair(constraint), substitute=True)
    assert eqs.multiplier_names == ("lambda_c_1",)
    assert f"constraint c: lambda_c_1 remains a constraint, because {reason}" in eqs.notes


def test_couplings_of_cut_joints_stay_constraints() -> None:
    eqs = sb.form_equations(train(), tree="absolute", substitute=True)
    assert sum("remains a constraint, because" in note for note in eqs.notes) == 2


def test_several_couplings_of_one_coordinate() -> None:
    gears = [sb.Gear("g", ["x", "y"], ratio=2), sb.Gear("h", ["x", "z"], ratio="n")]
    eqs = sb.form_equations(pair(*gears, parameters={"n": 3}), substitute=True)
    f = sb.compile(eqs, ["x", "y", "z"])
    assert eqs.coordinate_names == ("z",)
    assert f(0.0, np.array([1.0]), np.array([0.0])) == pytest.approx((3.0, 1.5, 1.0))


def test_a_coupling_said_twice_is_dropped_and_its_contradiction_refused() -> None:
    first = sb.Gear("g", ["x", "y"], ratio=0.1)
    chain = [first, sb.Gear("h", ["y", "z"], ratio=0.3), sb.Gear("k", ["x", "z"], ratio=0.03)]
    eqs = sb.form_equations(pair(*chain), substitute=True)
    assert eqs.coordinate_names == ("z",)
    assert any("lambda_k_1" in note and "dropped" in note for note in eqs.notes)
    with pytest.raises(
        sb.FormulationError, match="remaining constraints: lambda_g_1, lambda_h_1; or form"
    ) as error:
        sb.compile(eqs, "lambda_k_1")
    assert error.value.problems[0].code == "equations.dropped_multiplier"
    with pytest.raises(sb.FormulationError, match="lambda_k_1"):
        sb.form_equations(pair(*chain[:2], sb.Gear("k", ["x", "z"], ratio=0.03, offset=1)), substitute=True)


def test_couplings_that_follow_from_others_by_their_values_stay_constraints() -> None:
    # 0.1 times 0.3 is 0.03 but for rounding, which would be a constraint of its own and hold all wheels.
    gears = [sb.Gear("g", ["x", "y"], ratio="n"), sb.Gear("h", ["y", "z"], ratio=0.3)]
    values = {"n": 0.1, "m": 0.03}
    eqs = sb.form_equations(
        pair(*gears, sb.Gear("k", ["x", "z"], ratio="m"), parameters=values), substitute=True
    )
    assert eqs.multiplier_names == ("lambda_g_1", "lambda_h_1", "lambda_k_1")
    assert sum("together lead to factors that are differences" in note for note in eqs.notes) == 3
    assert sb.simulate(eqs, 0.1, {"z_dot": 1.0})["x_dot"][-1] == pytest.approx(0.03)


def test_ratios_name_what_couplings_give(eqs: sb.EquationSet) -> None:
    ratios = sb.velocity_ratios(eqs)
    assert ratios.independent == ("b_dot",)
    assert any("a_dot, s_dot: couplings determine them" in note for note in ratios.notes)
    with pytest.raises(sb.UsageError, match="name b, or form the equations without") as error:
        sb.velocity_ratios(eqs, "a")
    assert error.value.problems[0].code == "kinematics.coupled_speed"


def chain(number: int, gears: list[Any]) -> sb.Model:
    """A spatial chain of hinges."""
    elements: list[Any] = []
    before = "ground"
    for k in range(number):
        frames = {"start": sb.Frame(at=[0, 0.2, 0]), "end": sb.Frame(at=[0.1, -0.2, 0])}
        elements.append(sb.Body(f"B{k}", mass=1, inertia=[0.1, 0.1, 0.1], frames=frames))
        elements.append(sb.Revolute(f"J{k}", before, f"B{k}.start", axis="xyz"[k % 3], coordinate=f"q{k}"))
        before = f"B{k}.end"
    return sb.Model("chain", [*elements, *gears], gravity=[0, -9.81, 0])


GEARS = [sb.Gear("g", ["q1", "q4"], ratio=2), sb.Gear("h", ["q2", "q3"], ratio=-1)]


@pytest.mark.exhaustive
def test_derivatives_of_coupled_chains_side_by_side() -> None:
    model = chain(10, GEARS)
    recursive, other = (
        sb.form_equations(model, formulation, substitute=True) for formulation in (None, sb.VirtualWork())
    )
    u = np.linspace(0.1, 0.8, 8)
    found = [sb.compile(eqs, "A")(0.0, u, -u) for eqs in (recursive, other)]
    assert found[0] == pytest.approx(found[1], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("number", [1, 2])
def test_a_long_chain_stays_linear(number: int) -> None:
    """Coupled joints far apart in a chain: articulated bodies with one pass a coupling agree with M."""
    model = chain(6, GEARS[:number])
    found = []
    for method in ("articulated", "composite"):
        eqs = sb.form_equations(model, sb.Recursive(method), substitute=True)
        q = np.linspace(0.1, 0.6, len(eqs.coordinate_names))
        found.append(sb.compile(eqs, "udot")(0.0, q, -q))
        assert eqs.formed.dynamics.recursion.chosen_method == method  # type: ignore[attr-defined]
    assert found[0] == pytest.approx(found[1], rel=1e-9)
