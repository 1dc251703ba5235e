"""Speeds eliminated by constraints on velocities: the same mechanics as with multipliers, in fewer speeds."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians, sin

import numpy as np
import pytest
import sympy

import symbody as sb
from tests.formulations import UNLIMITED, name_of

TIGHT = {"rtol": 1e-11, "atol": 1e-13}
SLOPE, SPIN = 9.81 * sin(0.3), 1.7


def skate() -> sb.Model:
    plane = sb.Planar("plane", "ground", "Skate", coordinates=["x", "y", "phi"])
    body = sb.Body("Skate", mass="m", inertia=(0, 0, "I"))
    blade = sb.KnifeEdge("blade", "ground", "Skate")
    return sb.Model(
        "skate", [body, plane, blade], gravity=["s", 0, 0], parameters={"m": 2.5, "I": 0.4, "s": SLOPE}
    )


def ball() -> sb.Model:
    body = sb.Body("Ball", mass="m", inertia=("2/5*m*R^2", "2/5*m*R^2", "2/5*m*R^2"))
    rolling = sb.Rolling("track", "ground", "Ball", radius="R")
    return sb.Model("ball", [body, rolling], parameters={"m": 2.0, "R": 0.2}, gravity=[3.0, 0, -9.0])


def disc() -> sb.Model:
    body = sb.Body("Disc", mass=1.3, inertia=(0.05, 0.05, 0.1))
    names = ["x", "y", "z", "psi", "theta", "phi"]
    free = sb.Free("free", "ground", "Disc", angles="313", coordinates=names)
    rolling = sb.Rolling("road", "ground", "Disc", radius=0.4, axis="z")
    return sb.Model("disc", [body, free, rolling], gravity=[0, 0, -9.81])


def rover() -> sb.Model:
    """A frame on two driven wheels; the ground beneath the right one runs with the speed ``0.3 sin(t)``."""
    plane = sb.Planar("plane", "ground", "Frame.mid", coordinates=["x", "y", "phi"])
    places = {"mid": (-0.1, 0, 0), "L": (-0.1, 0.3, 0), "R": (-0.1, -0.3, 0)}
    frames = {name: sb.Frame(at=place) for name, place in places.items()}
    frame = sb.Body("Frame", mass=3.0, inertia=(0, 0, 0.2), frames=frames)
    wheels = [sb.Body(name, mass=0.4, inertia=(0.01, 0.02, 0.01)) for name in ("Left", "Right")]
    axles = [
        sb.Revolute("left", "Frame.L", "Left", axis="y", coordinate="p", torque=sb.Drive(damping=0.1)),
        sb.Revolute("right", "Frame.R", "Right", axis="y", coordinate="r"),
    ]
    along = "x_dot*cos(phi) + y_dot*sin(phi)"
    ties = sb.Constraint(
        "ties",
        [
            "y_dot*cos(phi) - x_dot*sin(phi)",
            f"{along} - 0.3*phi_dot - R*p_dot",
            f"{along} + 0.3*phi_dot - R*r_dot - 0.3*sin(t)",
        ],
    )
    torque = sb.Torque("motor", "Left", ("0", "0.4*cos(t)", "0"), reaction_on="Frame")
    parts = [frame, *wheels, plane, *axles, ties, torque]
    return sb.Model("rover", parts, parameters={"R": 0.15})


def agree(
    full: sb.EquationSet,
    reduced: sb.EquationSet,
    reactions: Sequence[str] = (),
    extra: Sequence[str] = (),
    *,
    tolerance: float = 1e-10,
) -> None:
    """Compare accelerations, multipliers, energies and reactions at random states that fit the velocities."""
    random = np.random.default_rng(5)
    outputs = [*full.acceleration_names, *full.multiplier_names, *full.coordinate_names]
    outputs += ["kinetic_energy", "power", *extra, *(f"reaction {name}" for name in reactions)]
    speeds = sb.compile(reduced, list(full.speed_names))
    ours, theirs = sb.compile(reduced, outputs), sb.compile(full, outputs)
    for _ in range(5):
        q = random.uniform(0.3, 1.0, len(full.coordinate_names))
        for four in full.quaternions:
            places = [full.coordinate_names.index(name) for name in four]
            q[places] /= np.linalg.norm(q[places])
        u = random.uniform(-1.0, 1.0, len(reduced.speed_names))
        whole = np.array(speeds(0.4, q, u)).ravel()
        for name, a, b in zip(outputs, ours(0.4, q, u), theirs(0.4, q, whole), strict=True):
            # Sums of tens of terms of size 1 .. 100 at conditions below 1e3.
            np.testing.assert_allclose(a, b, rtol=tolerance, atol=tolerance, err_msg=name)


@pytest.mark.parametrize("formulation", UNLIMITED, ids=name_of)
@pytest.mark.parametrize("speed", ["x_dot", "y_dot"])
def test_blade_has_the_same_mechanics(formulation: sb.VirtualWork, speed: str) -> None:
    full = sb.form_equations(skate(), formulation)
    reduced = sb.form_equations(skate(), formulation, dependent_speeds=(speed,))
    assert len(reduced.speed_names) == reduced.degrees_of_freedom == full.degrees_of_freedom == 2
    assert reduced.multiplier_names == ()
    agree(full, reduced, ["blade"])


def test_equations_of_the_blade_are_those_of_books() -> None:
    """With ``y' = x' tan(phi)``: ``m x'' / cos^2 = m s - m x' phi' sin / cos^3`` (Neimark & Fufaev 1972)."""
    eqs = sb.form_equations(skate(), dependent_speeds=("y_dot",))
    m, inertia, s = (sympy.Symbol(name) for name in ("m", "I", "s"))
    _, _, phi = eqs.coordinates
    forward, turning = eqs.speeds
    expected = sympy.diag(m / sympy.cos(phi) ** 2, inertia)
    assert sympy.simplify(eqs.mass_matrix - expected) == sympy.zeros(2, 2)
    force = m * s - m * forward * turning * sympy.sin(phi) / sympy.cos(phi) ** 3
    assert sympy.simplify(eqs.forcing - sympy.Matrix([force, 0])) == sympy.zeros(2, 1)
    energy = m * forward**2 / sympy.cos(phi) ** 2 / 2 + inertia * turning**2 / 2
    assert sympy.simplify(eqs.kinetic_energy - energy) == 0


def test_speeds_along_and_about_the_blade() -> None:
    """In body axes the equations are ``m v' = m s cos(psi)`` and ``I omega' = 0``: no pivot, no division."""
    free = sb.Free("free", "ground", "Skate", angles="321", speeds="twist")
    body = sb.Body("Skate", mass="m", inertia=("I", "I", "I"))
    blade = sb.KnifeEdge("blade", "ground", "Skate")
    v, w = free.translation_speeds, free.rotation_speeds
    assert v is not None and w is not None
    flat = sb.Constraint("flat", [v.names[2], w.names[0], w.names[1]])
    model = sb.Model(
        "skate", [body, free, blade, flat], gravity=["s", 0, 0], parameters={"m": 2, "I": 1, "s": 3}
    )
    dependent = (v.names[1], v.names[2], *w.names[:2])
    eqs = sb.form_equations(model, dependent_speeds=dependent)
    assert eqs.speed_names == (v.names[0], w.names[2])
    m, inertia = sympy.Symbol("m"), sympy.Symbol("I")
    assert eqs.mass_matrix == sympy.diag(m, inertia)
    assert not any("where" in note and "dependent" in note for note in eqs.notes)
    yaw = eqs.coordinates[3]
    level = dict.fromkeys(eqs.coordinates[4:], 0)
    force = sympy.simplify(eqs.forcing.subs(level))
    assert force == sympy.Matrix([m * sympy.Symbol("s") * sympy.cos(yaw), 0])
    agree(sb.form_equations(model), eqs, ["blade"])


def test_blade_draws_its_cycloid_up_to_where_the_choice_fails() -> None:
    """``x = s sin^2 / (2 w^2)``; heading across x at ``w t = pi / 2`` the rate of y does not follow from x'."""
    eqs = sb.form_equations(skate(), dependent_speeds="auto")
    assert any("chosen by column pivoting" in note for note in eqs.notes)
    run = sb.simulate(eqs, 6.0, initial={"phi_dot": SPIN}, **TIGHT)
    t = run.t
    # A hundred steps of 1e-11 each; the pivot of 1e-3 gives away three digits of the last.
    np.testing.assert_allclose(run["x"], SLOPE / (2 * SPIN**2) * np.sin(SPIN * t) ** 2, atol=1e-8)
    np.testing.assert_allclose(run["lambda_blade_1"], 2.5 * 2 * SLOPE * np.sin(SPIN * t), atol=1e-6)
    assert run.status is sb.Status.DEPENDENT_SPEEDS and not run.success
    assert run.t[-1] == pytest.approx(np.pi / 2 / SPIN, abs=1e-3)
    assert run["y_dot_pivot"][-1] == pytest.approx(1e-3, rel=1e-3)
    assert any("y_dot" in note and "hardly follow" in note for note in run.notes) and run.events == ()


def test_start_at_a_vanishing_pivot_is_refused() -> None:
    eqs = sb.form_equations(skate(), dependent_speeds=["x_dot"])
    with pytest.raises(sb.AssemblyError, match="x_dot do not follow") as caught:
        sb.simulate(eqs, 1.0, initial={"phi": 0.0})
    assert "name other dependent_speeds" in caught.value.problems[0].fix


@pytest.mark.parametrize("dependent", ["auto", ("Ball_vx", "Ball_vy"), ("Ball_wx", "Ball_wy")])
def test_ball_rolls_as_with_multipliers(dependent: str | tuple[str, ...]) -> None:
    full, reduced = sb.form_equations(ball()), sb.form_equations(ball(), dependent_speeds=dependent)
    # The height stays a constraint on positions.
    assert len(reduced.speed_names) == len(full.speed_names) - 2
    assert reduced.multiplier_names == ("lambda_track_1",)
    assert reduced.degrees_of_freedom == full.degrees_of_freedom == 3
    agree(full, reduced, ["track"])


def test_ball_on_an_incline_falls_at_five_sevenths() -> None:
    eqs = sb.form_equations(ball(), dependent_speeds=("Ball_vx", "Ball_vy"))
    run = sb.simulate(eqs, 2.0, initial={"Ball_vy": 0.3, "Ball_wz": 2.0}, **TIGHT)
    assert run.success
    np.testing.assert_allclose(run["Ball_x"], 3.0 * 5 / 7 * run.t**2 / 2, atol=1e-8)
    np.testing.assert_allclose(run["Ball_y"], 0.3 * run.t, atol=1e-8)
    np.testing.assert_allclose(run["Ball_vy"], 0.3, atol=1e-8)
    assert np.ptp(run["energy"] - run["work"]) < 1e-8
    np.testing.assert_allclose(run["reaction track Fz"], 18.0, atol=1e-6)
    across = np.hypot(run["reaction track Fx"], run["reaction track Fy"])
    np.testing.assert_allclose(across, 2 / 7 * 6.0, atol=1e-6)


@pytest.mark.parametrize("dependent", [("x_dot", "y_dot"), ("x_dot", "phi_dot")])
@pytest.mark.parametrize(
    "formulation", [sb.VirtualWork(), pytest.param(sb.Lagrange(), marks=pytest.mark.exhaustive)]
)
def test_disc_has_the_same_mechanics(dependent: tuple[str, ...], formulation: sb.VirtualWork) -> None:
    full = sb.form_equations(disc(), formulation)
    reduced = sb.form_equations(disc(), formulation, dependent_speeds=dependent)
    agree(full, reduced, ["road"])


def test_disc_stops_where_its_choice_fails() -> None:
    """Where the disc heads along x, its rolling does not move it along y, so y' does not give phi'."""
    eqs = sb.form_equations(disc(), dependent_speeds=("y_dot", "phi_dot"))
    initial = {
        "psi": 0.5,
        "theta": radians(80),
        "phi": 0.0,
        "psi_dot": -1.5,
        "phi_dot": 3.0,
        "x": 0.0,
        "y": 0.0,
    }
    run = sb.simulate(eqs, 3.0, initial=initial, guess={"z": 0.4 * sin(radians(80))})
    assert run.status is sb.Status.DEPENDENT_SPEEDS
    assert "y_dot" in run.notes[-2] + run.notes[-1]


def test_disc_moves_as_with_multipliers() -> None:
    initial = {"psi": 0.4, "theta": radians(70), "phi": 0.0, "psi_dot": 1.0, "theta_dot": 0.2, "phi_dot": 3.0}
    initial |= {"x": 0.0, "y": 0.0}
    guess = {"z": 0.4 * sin(radians(70))}
    runs = [
        sb.simulate(eqs, 1.0, initial=initial, guess=guess, times=np.linspace(0.0, 1.0, 11), **TIGHT)
        for eqs in (sb.form_equations(disc()), sb.form_equations(disc(), dependent_speeds=("x_dot", "y_dot")))
    ]
    assert all(run.success for run in runs)
    for name in ("x", "y", "z", "psi", "theta", "phi", "y_dot", "lambda_road_2", "lambda_road_3"):
        # Two runs of a hundred steps of 1e-11, second derivatives an order above.
        np.testing.assert_allclose(runs[0][name], runs[1][name], atol=1e-7, err_msg=name)
    assert np.ptp(runs[1]["energy"]) < 1e-8


@pytest.mark.parametrize(
    "dependent",
    ["auto", ("y_dot", "p_dot", "r_dot"), ("x_dot", "y_dot", "phi_dot"), ("x_dot", "p_dot", "y_dot")],
)
def test_several_equations_that_move_in_time(dependent: str | tuple[str, ...]) -> None:
    """Division one after the other, and coupled rows through the kernel with pivots."""
    full, reduced = sb.form_equations(rover()), sb.form_equations(rover(), dependent_speeds=dependent)
    assert len(reduced.speed_names) == full.degrees_of_freedom == 2
    agree(full, reduced, ["left", "right"])


def test_coupled_speeds_are_solved_with_pivots() -> None:
    """The wheels give the motion of the frame whatever its heading: J_d has the determinant 0.6."""
    eqs = sb.form_equations(rover(), dependent_speeds=("x_dot", "y_dot", "phi_dot"))
    run = sb.simulate(eqs, 3.0, initial={"p_dot": 2.0, "r_dot": 1.0}, rtol=1e-10, atol=1e-12)
    assert run.success, run.notes
    elimination = eqs.formed.elimination
    assert elimination is not None and elimination.block.method == "pivoting" and not elimination.pivots
    along = run["x_dot"] * np.cos(run["phi"]) + run["y_dot"] * np.sin(run["phi"])
    np.testing.assert_allclose(along - 0.3 * run["phi_dot"], 0.15 * run["p_dot"], atol=1e-12)
    other = sb.simulate(sb.form_equations(rover()), 3.0, initial={"p_dot": 2.0, "r_dot": 1.0}, times=run.t)
    # Its tolerance is 1e-8 a step.
    np.testing.assert_allclose(run["x"], other["x"], atol=1e-6)
    np.testing.assert_allclose(run["lambda_ties_1"], other["lambda_ties_1"], atol=1e-5)


def test_friction_and_prescribed_motions_go_with_it() -> None:
    """A blade on a slider with dry friction, and a prescribed coordinate: efforts and powers agree."""
    slider = sb.Prismatic("slider", "ground", "Base", axis="x", coordinate="x", friction=sb.Friction(mu=0.2))
    across = sb.Prismatic("across", "Base", "Head", axis="y", coordinate="y")
    turning = sb.Revolute("turning", "Head", "Skate", axis="z", coordinate="phi", motion="0.4 + 0.2*t")
    bodies = [sb.Body(name, mass=1.0 + k, inertia=(0.1, 0.1, 0.1)) for k, name in enumerate(("Base", "Head"))]
    bodies.append(sb.Body("Skate", mass=2.0, inertia=(0.1, 0.2, 0.3)))
    blade = sb.KnifeEdge("blade", "ground", "Skate")
    model = sb.Model("sledge", [*bodies, slider, across, turning, blade], gravity=[3.0, 1.0, -9.0])
    full = sb.form_equations(model)
    reduced = sb.form_equations(model, dependent_speeds=("y_dot",))
    agree(full, reduced, ["slider", "turning", "blade"], ["friction slider", "effort turning"])


def test_eliminated_speeds_stay_names() -> None:
    """Given at the start they fix the independent ones; events and formulas read them."""
    eqs = sb.form_equations(skate(), dependent_speeds=("y_dot",))
    state = sb.assemble(eqs, {"phi": 0.5, "y_dot": 0.3})
    assert state.u["x_dot"] == pytest.approx(0.3 / np.tan(0.5), rel=1e-12)
    with pytest.raises(sb.AssemblyError, match="y_dot = 0.3"):
        sb.assemble(eqs, {"phi": 0.5, "x_dot": 1.0, "y_dot": 0.3})
    event = sb.Event("y_dot - 0.25", action="stop")
    run = sb.simulate(eqs, 1.0, initial={"phi": 0.5}, events=event, **TIGHT)
    assert run.status is sb.Status.STOPPED
    assert run["y_dot"][-1] == pytest.approx(0.25, abs=1e-10)
    assert run["y_ddot"].shape == run.t.shape


def test_guesses_of_eliminated_speeds_count_as_with_multipliers() -> None:
    guess = {"phi": 0.5, "x_dot": 0.7, "y_dot": 0.1}
    starts = [
        sb.assemble(eqs, guess=guess).u["phi_dot"]
        for eqs in (sb.form_equations(skate()), sb.form_equations(skate(), dependent_speeds=("x_dot",)))
    ]
    assert starts[0] == pytest.approx(starts[1])
    full = sb.assemble(sb.form_equations(skate()), guess=guess)
    reduced = sb.assemble(sb.form_equations(skate(), dependent_speeds=("x_dot",)), guess=guess)
    assert reduced.u["y_dot"] == pytest.approx(full.u["y_dot"], rel=1e-12)


@pytest.mark.parametrize(
    ("dependent", "code", "words"),
    [
        (("z_dot",), "equations.unknown_speed", ("z_dot", "x_dot")),
        (("x_dot", "y_dot"), "equations.dependent_number", ("2 different", "lambda_blade_1")),
        (("phi_dot",), "equations.singular_choice", ("phi_dot", "lambda_blade_1", "x_dot, y_dot", "auto")),
    ],
)
def test_wrong_choices_say_what_is_wrong(
    dependent: tuple[str, ...], code: str, words: tuple[str, ...]
) -> None:
    with pytest.raises(sb.FormulationError) as caught:
        sb.form_equations(skate(), dependent_speeds=dependent)
    assert code in [problem.code for problem in caught.value.problems]
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize("dependent", ["auto", ("a_dot",)])
def test_nothing_to_eliminate_is_an_error(dependent: str | tuple[str, ...]) -> None:
    joint = sb.Revolute("pin", "ground", "Arm", axis="z", coordinate="a")
    model = sb.Model("arm", [sb.Body("Arm", mass=1.0, inertia=(1, 1, 1)), joint])
    with pytest.raises(sb.FormulationError, match="no velocity constraint") as caught:
        sb.form_equations(model, dependent_speeds=dependent)
    assert "leave dependent_speeds out" in str(caught.value)
    arm = sb.Body("Arm", mass=1.0, inertia=(1, 1, 1), frames={"tip": sb.Frame(at=(1, 0, 0))})
    loop = sb.Model("loop", [arm, joint, sb.PointOnPlane("table", "ground", "Arm.tip", axis="y")])
    with pytest.raises(sb.FormulationError, match="no velocity constraint"):
        sb.form_equations(loop, dependent_speeds=dependent)
