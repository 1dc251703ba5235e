"""Inverse dynamics: published torques, closed forms, forward simulation, and questions without an answer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from tests.problems.mechanisms import equations_of

EPS = np.finfo(float).eps
SWING = {"beta_1": "pi*t**2", "beta_2": "pi*t**2"}


def four_bar(**drives: sb.Drive) -> sb.Model:
    """Crank 1, coupler 3, rocker 2.5, ground 3.2: the crank turns all round."""
    lengths = {"Crank": (1, 1.0), "Coupler": (2, 3.0), "Rocker": (1.5, 2.5)}
    bars = [
        sb.Body(
            name,
            mass=mass,
            inertia=(0, 0, mass * length**2 / 12),
            frames={"P": sb.Frame(at=(-length / 2, 0, 0)), "Q": sb.Frame(at=(length / 2, 0, 0))},
        )
        for name, (mass, length) in lengths.items()
    ]
    return sb.Model(
        "four-bar",
        [
            *bars,
            sb.Revolute("A", "ground", "Crank.P", coordinate="theta", torque=drives.get("A", sb.Drive(applied="T"))),
            sb.Revolute("B", "Crank.Q", "Coupler.P", coordinate="beta"),
            sb.Revolute("C", "Coupler.Q", "Rocker.Q", tree=False, coordinate="psi"),
            sb.Revolute("D", "ground.O", "Rocker.P", coordinate="phi",
                        torque=sb.Drive(applied="U", damping=0.3)),
        ],
        ground={"O": sb.Frame(at=(3.2, 0, 0))},
        gravity=(0, -9.81, 0),
        inputs=["T", "U"],
        initial={"beta": 0.5, "phi": 1.5},
    )  # fmt: skip


def slider_crank(load: str = "F") -> sb.Model:
    """Massless rod and crank without inertia, so that the torque is that of virtual work on the slider alone."""
    return sb.Model(
        "slider-crank",
        [
            sb.Body("Crank", inertia=(0, 0, "J"), frames={"B": sb.Frame(at=(1, 0, 0))}),
            sb.Body("Rod", frames={"C": sb.Frame(at=(3, 0, 0))}),
            sb.Body("Slider", mass=2),
            sb.Revolute("A", "ground", "Crank", coordinate="theta", torque=sb.Drive(applied="T")),
            sb.Revolute("B", "Crank.B", "Rod", coordinate="beta"),
            sb.Revolute("C", "Rod.C", "Slider", tree=False),
            sb.Prismatic("D", "ground", "Slider", coordinate="s", force=sb.Drive(applied=load)),
        ],
        inputs=["T", "F"],
        parameters={"J": 0},
    )


FOUR_BAR = sb.form_equations(four_bar())
TIMES = np.linspace(0.0, 2.0, 41)


def test_torques_of_the_rr_robot() -> None:
    """Checklist D-45."""
    run = sb.inverse_dynamics(equations_of("rr_robot"), SWING, ["T1", "T2"], [0, 0.25, 0.5, 0.75, 1])
    T1 = [140.530965, 135.580744, 68.829169, -90.293881, 5.132741]
    T2 = [47.699112, 47.659180, 47.976235, 57.002201, 22.566371]
    # The figures have six decimals.
    assert run["T1"] == pytest.approx(T1, abs=6e-7) and run["T2"] == pytest.approx(T2, abs=6e-7)
    assert run.success and run["beta_1_ddot"] == pytest.approx(2 * np.pi, abs=1e-13)


def test_motions_in_all_their_forms_agree() -> None:
    eqs, t = equations_of("rr_robot"), dynamicsymbols._t
    first = sb.inverse_dynamics(eqs, SWING, ["T1", "T2"], [0.2, 0.4])
    forms = {"beta_1": np.pi * t**2, "beta_2": lambda t: (np.pi * t**2, 2 * np.pi * t, 2 * np.pi)}
    second = sb.inverse_dynamics(eqs, forms, ["T1", "T2"], [0.2, 0.4])
    knots = np.linspace(0, 1, 11)
    third = sb.inverse_dynamics(
        eqs, {"beta_1": (knots, np.pi * knots**2), "beta_2": "pi*t**2"}, ["T1", "T2"], [0.2, 0.4]
    )
    for other in (second, third):  # a spline is exact for a parabola
        assert other["T1"] == pytest.approx(first["T1"], rel=1e-12)


def test_slider_crank_torque_is_that_of_virtual_work() -> None:
    run = sb.inverse_dynamics(
        sb.form_equations(slider_crank()),
        {"theta": "0.3 + 2*t"},
        "T",
        TIMES,
        inputs={"F": "-5"},
        guess={"s": 4},
    )
    a = 0.3 + 2 * TIMES
    sin, cos, w = np.sin(a), np.cos(a), 2.0
    root = np.sqrt(9 - sin**2)
    slope = -sin - sin * cos / root
    curve = -cos - ((cos**2 - sin**2) * root**2 + sin**2 * cos**2) / root**3
    # T theta' + (F - m s'') s' = 0 with s' = slope theta', s'' = curve theta'^2.
    assert run["s"] == pytest.approx(cos + root, abs=20 * EPS)
    assert run["T"] == pytest.approx(-(-5 - 2 * curve * w**2) * slope, abs=1e-12)


def test_the_torque_found_makes_the_motion_by_forward_simulation() -> None:
    run = sb.inverse_dynamics(FOUR_BAR, {"theta": "0.4 + t**2"}, ["T"], np.linspace(0, 2, 61))
    assert run.notes == ("input U has no value and is 0 N m",)
    assert run.constraint_violation.max() < 1e-13
    # Forward dynamics with this torque: the accelerations asked for.
    assert run["theta_ddot"] == pytest.approx(2.0, abs=1e-11)
    assert run["reaction C Fx"].shape == (61,) and run["lambda_C_1"].shape == (61,)
    first = {"theta": 0.4, "theta_dot": 0.0}
    forward = sb.simulate(
        FOUR_BAR, 2.0, first, guess={n: run[n][0] for n in ("beta", "phi")}, times=run.t,
        inputs={"T": sb.Table(run.t, run["T"], kind="cubic")},
    )  # fmt: skip
    # The spline of the torque: 5/384 h^4 T'''' with h = 1/30 and T'''' about 1e3, twice integrated over 2 s.
    assert forward["theta"] == pytest.approx(run["theta"], abs=5 / 384 / 30**4 * 1e3 * 2)
    # Work is a cubic spline of the power at the samples: 5/384 h^4 P'''' over 2 s.
    assert run.energy_drift < 1e-4


def test_a_coordinate_of_the_cut_joint_can_be_driven() -> None:
    start = sb.assemble(FOUR_BAR, {"theta": 0.4})["psi"]
    run = sb.inverse_dynamics(FOUR_BAR, {"psi": f"{start} + 0.1*sin(t)"}, "T", TIMES, guess={"theta": 0.4})
    assert run["psi"] == pytest.approx(start + 0.1 * np.sin(TIMES), abs=1e-13)
    assert run["theta"][0] == pytest.approx(0.4, abs=1e-9)
    assert run["psi_ddot"] == pytest.approx(-0.1 * np.sin(TIMES), abs=1e-11)


def test_redundant_drives_share_by_least_squares() -> None:
    run = sb.inverse_dynamics(FOUR_BAR, {"theta": "0.4 + t"}, ["T", "U"], TIMES)
    alone = sb.inverse_dynamics(FOUR_BAR, {"theta": "0.4 + t"}, "T", TIMES)
    assert any("least sum of squares" in note for note in run.notes)
    ratio = run["phi_dot"] / run["theta_dot"]
    # T + ratio U is what one drive does alone; the least share of each is along (1, ratio).
    assert run["T"] + ratio * run["U"] == pytest.approx(alone["T"], abs=1e-11)
    assert run["U"] == pytest.approx(ratio * run["T"], abs=1e-11)


def test_friction_in_the_driven_joint_is_overcome() -> None:
    rubbing = sb.Model(
        "block",
        [
            sb.Body("B", mass=2),
            sb.Prismatic("J", "ground", "B", axis="x", coordinate="x", force=sb.Drive(applied="F"),
                         friction=sb.Friction(mu=0.3, v0=1e-3)),
        ],
        gravity=(0, -10, 0), inputs=["F"],
    )  # fmt: skip
    run = sb.inverse_dynamics(sb.form_equations(rubbing), {"x": "t + t**2"}, "F", [0.0, 1.0])
    v = np.array([1.0, 3.0])
    # m a + mu m g sin(atan(v / v0))
    assert run["F"] == pytest.approx(4 + 6 * np.sin(np.arctan(v / 1e-3)), rel=1e-9)


QUESTIONS: Mapping[str, tuple[dict[str, object], type[sb.SymbodyError], tuple[str, ...]]] = {
    "inverse.out_of_reach": ({"motion": {"phi": "2 - t"}, "unknowns": "T"}, sb.SimulationError, ("joint", "t = ")),
    "assembly.conflict": ({"motion": {"phi": "0"}, "unknowns": "T"}, sb.AssemblyError, ("phi = 0",)),
    "inverse.no_motion": ({"motion": {}, "unknowns": "T"}, sb.UsageError, ("motion",)),
    "inverse.underactuated": ({"motion": {"theta": "t"}, "unknowns": []}, sb.SimulationError, ("theta", "t = 0")),
    "kinematics.unknown_coordinate": ({"motion": {"thta": "t"}, "unknowns": "T"}, sb.UsageError, ("'theta'",)),
    "kinematics.speed_held": ({"motion": {"theta_dot": "t"}, "unknowns": "T"}, sb.UsageError, ("speed",)),
    "kinematics.motion_law": ({"motion": {"theta": "phi"}, "unknowns": "T"}, sb.UsageError, ("phi",)),
    "inverse.unknown_input": ({"motion": {"theta": "t"}, "unknowns": "V"}, sb.UsageError, ("T, U",)),
    "inverse.always_known": ({"motion": {"theta": "t"}, "unknowns": "lambda_C_1"}, sb.UsageError, ("run[",)),
    "inverse.repeated": ({"motion": {"theta": "t"}, "unknowns": ["T", "T"]}, sb.UsageError, ("twice",)),
    "inverse.known_unknown": (
        {"motion": {"theta": "t"}, "unknowns": "T", "inputs": {"T": 1}}, sb.UsageError, ("inputs",),
    ),
    "inverse.times": ({"motion": {"theta": "t"}, "unknowns": "T", "times": [1, 0]}, sb.UsageError, ("do not increase",)),
    "inverse.table_corners": (
        {"motion": {"theta": sb.Table([0, 3], [0, 1])}, "unknowns": "T"}, sb.UsageError, ("cubic",),
    ),
    "inverse.table_span": ({"motion": {"theta": ([0, 1], [0, 1])}, "unknowns": "T"}, sb.UsageError, ("1 s",)),
    "inverse.motion_function": ({"motion": {"theta": lambda t: t}, "unknowns": "T"}, sb.UsageError, ("three",)),
}  # fmt: skip


@pytest.mark.parametrize("code", QUESTIONS)
def test_impossible_questions_are_answered_with_cause_and_cure(code: str) -> None:
    words, kind, told = QUESTIONS[code]
    question: dict[str, Any] = {"times": np.linspace(0, 2, 21), "guess": {"theta": 0.4, "phi": 1.8}} | words
    with pytest.raises(kind) as caught:
        sb.inverse_dynamics(FOUR_BAR, **question)
    (problem,) = caught.value.problems
    assert problem.code == code and problem.fix
    assert all(word in str(problem) for word in told), str(problem)


def test_freedoms_left_are_counted_and_named() -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.inverse_dynamics(equations_of("rr_robot"), {"beta_1": "t"}, ["T1", "T2"], [0, 1])
    (problem,) = caught.value.problems
    assert (
        problem.code == "inverse.freedoms_left" and "1 degree of freedom is left: beta_2_dot" in problem.what
    )


def test_a_motion_that_breaks_constraints_is_told_with_its_time() -> None:
    with pytest.raises(sb.SimulationError) as caught:
        start = sb.assemble(FOUR_BAR, {"theta": 0.4}).q["phi"]
        sb.inverse_dynamics(
            FOUR_BAR, {"theta": "0.4 + 0.1*t", "phi": f"{start} + 0.1*t"}, ["T", "U"], [0.0, 1.0],
            guess={"theta": 0.4},
        )  # fmt: skip
    (problem,) = caught.value.problems
    assert problem.code == "inverse.motion_conflict" and "t = 0 s" in problem.what


def test_an_unknown_of_higher_degree_is_named() -> None:
    eqs = sb.form_equations(four_bar(A=sb.Drive(applied="T^2")))
    with pytest.raises(sb.UsageError) as caught:
        sb.inverse_dynamics(eqs, {"theta": "t"}, "T", [0.0, 1.0])
    (problem,) = caught.value.problems
    assert problem.code == "inverse.not_affine" and "T" in problem.where and "theta_dot" in problem.what


def test_a_force_at_its_dead_centre_drives_nothing() -> None:
    eqs = sb.form_equations(slider_crank())
    with pytest.raises(sb.SimulationError) as caught:
        sb.inverse_dynamics(
            eqs, {"theta": "t"}, "F", [0.0], parameters={"J": 1}, inputs={"T": 1}, guess={"s": 4}
        )
    (problem,) = caught.value.problems
    assert problem.code == "inverse.underactuated" and "F cannot influence" in problem.why


def test_a_uniform_motion_needs_what_holds_the_other_forces() -> None:
    bob = sb.Body("Bob", mass=1, frames={"top": sb.Frame(at=[0, 1, 0])})
    hinge = sb.Revolute("hinge", "ground", "Bob.top", axis="z", coordinate="theta",
                        torque=sb.Drive(applied="T", damping=0.1))  # fmt: skip
    eqs = sb.form_equations(sb.Model("pendulum", [bob, hinge], gravity=(0, "-9.81", 0), inputs=["T"]))
    run = sb.inverse_dynamics(eqs, {"theta": "t"}, "T", times=np.linspace(0, 1, 11))
    # m g l sin(t) + d: a few roundings of numbers below 10
    assert run["T"] == pytest.approx(9.81 * np.sin(run.t) + 0.1, abs=1e-13)
    assert sb.inverse_dynamics(eqs, {"theta": "pi"}, [], times=[0.0, 1.0]).success  # rests upside down
