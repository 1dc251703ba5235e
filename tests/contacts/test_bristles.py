"""Bristle friction against closed forms, the equations as they were published, and smooth friction."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from symbody.formats.native import model_from_toml, model_to_toml
from tests.codegen.test_portable import check_bits, random_points
from tests.contacts.pairs import Floats
from tests.formulations import FORMULATIONS
from tests.laws.motion_consumers import WAYS, Question, outcome
from tests.laws.motion_fragments import Fragment
from tests.tiers import cases, rows

G = 9.81
M = 2.0
K = 1e6  # of the floor [N/m]
D = 1e-4  # deflection [m]
T = 2 * math.sqrt(D / G)  # its damping time, where none is given
FLOOR = sb.NormalForce(stiffness=K, exponent=1, damping=2 * math.sqrt(K * M))
FINE: dict[str, Any] = {"rtol": 1e-10, "atol": 1e-13}


def pushed(
    friction: sb.Friction,
    along: str = "0",
    across: str = "0",
    *,
    rigid: bool = False,
    lean: float = 0,
    **start: float,
) -> sb.EquationSet:
    """A block that a force pushes over a floor, or on a slope of an angle; it starts at rest, where it is borne."""
    block = sb.Body("Block", mass=M)
    move = sb.Cartesian("move", "ground", block, coordinates=["x", "y", "z"])
    touch = sb.Contact(
        "floor", "ground", block, ["plane", "point"], normal="rigid" if rigid else FLOOR, friction=friction
    )
    depth = 0 if rigid else M * G * math.cos(lean) / K
    gravity = (G * math.sin(lean), 0, -G * math.cos(lean))
    parts = [move, touch, sb.Force("push", block, (along, across, 0))]
    model = sb.Model("block", parts, gravity, parameters={"b": 0.7}, initial={"z": -depth, **start})
    return sb.form_equations(model)


def published(
    push: Callable[[float], float],
    mu: float,
    breakaway: float | None,
    end: float,
    times: list[float],
    *,
    mu_static: float | None = None,
    stribeck: float = 1.0,
) -> Floats:
    """x, x', z of Dupont et al. 2002, or with no threshold of Canudas de Wit et al. 1995; one direction, in metres."""
    top = mu if mu_static is None else mu_static
    stiffness, damping = top * M * G / D, top * M * G / D * T

    def rates(t: float, y: Floats) -> list[float]:
        _, v, z = y
        steady = (mu + (top - mu) * math.exp(-((v / stribeck) ** 2))) * M * G / stiffness
        alpha = 1.0
        if breakaway is not None:
            low, size = breakaway * steady, abs(z)
            if v * z <= 0 or size <= low:
                alpha = 0.0
            elif size < steady:
                alpha = 0.5 * math.sin(math.pi * (size - (steady + low) / 2) / (steady - low)) + 0.5
        rate = v - alpha * abs(v) * z / steady
        fading = math.sqrt(1 + (T * v / D) ** 2)  # Olsson et al. 1998: damping has to fall with speed
        return [v, (push(t) - stiffness * z - damping * rate / fading) / M, rate]

    run: Any = solve_ivp(rates, (0, end), [0, 0, 0], method="LSODA", rtol=1e-11, atol=1e-14, t_eval=times,
                         max_step=end / 500)  # fmt: skip
    return np.asarray(run.y)


@pytest.mark.parametrize(
    ("integrator", "rigid"),
    rows(product([sb.Explicit(), sb.Stiff(), sb.GeneralizedAlpha()], [False, True]),
         fast=[(sb.Stiff(), True), (sb.GeneralizedAlpha(), False)]),
)  # fmt: skip
def test_what_rests_on_a_slope_stays(rigid: bool, integrator: sb.Stiff) -> None:
    """It deflects by deflection tan(slope)/mu and stays for 1000 s; smooth friction creeps by its formula.

    It settles at 100/s, so that from 10 s on nothing is left of the start.
    """
    eqs = pushed(sb.Friction(mu=0.5, deflection=D), rigid=rigid, lean=0.2)
    run = sb.simulate(eqs, 1000.0, times=[0, 10, 1000], integrator=integrator)
    deflected = D * math.tan(0.2) / 0.5
    assert run["x"][1] == pytest.approx(deflected, abs=1e-9)
    assert abs(run["x"][2] - run["x"][1]) < 1e-9
    assert run["floor_bristle_x"][2] == pytest.approx(math.tan(0.2) / 0.5, abs=1e-8)


def test_smooth_friction_creeps() -> None:
    """By v0 tan(slope)/sqrt(mu^2 - tan^2): in 990 s a distance that bristles do not."""
    v0, lean = 1e-6, math.tan(0.2)
    run = sb.simulate(
        pushed(sb.Friction(mu=0.5, v0=v0), lean=0.2), 1000.0, times=[0, 10, 1000], integrator=sb.Stiff()
    )
    assert run["x"][2] - run["x"][1] == pytest.approx(990 * v0 * lean / math.sqrt(0.25 - lean**2), rel=1e-6)


@pytest.mark.parametrize(
    ("speed", "rigid"),
    rows(product([1e-3, 0.02, 1.0], [False, True]), fast=[(1e-3, True), (0.02, False), (1.0, False)]),
)
def test_what_slips_steadily_has_the_curve_of_stribeck(rigid: bool, speed: float) -> None:
    """(mu + (mu_static - mu) exp(-(v/stribeck)^2)) N against a slip that a motion prescribes."""
    block = sb.Body("Block", mass=M)
    drive = sb.Prismatic("drive", "ground", sb.Body("Cart"), axis="x", coordinate="x", motion=f"{speed}*t")
    rise = sb.Prismatic("rise", "Cart", block, axis="z", coordinate="z")
    friction = sb.Friction(mu=0.3, mu_static=0.45, stribeck=0.02, deflection=1e-6)
    floor = sb.Contact(
        "floor", "ground", block, ["plane", "point"], normal="rigid" if rigid else FLOOR, friction=friction
    )
    start = {"z": 0.0 if rigid else -M * G / K}
    eqs = sb.form_equations(sb.Model("drag", [drive, rise, floor], (0, 0, -G), initial=start))
    run = sb.simulate(eqs, 0.1, times=[0, 0.1], integrator=sb.Stiff(), **FINE)
    coefficient = 0.3 + 0.15 * math.exp(-((speed / 0.02) ** 2))
    # 100 deflections at the least have passed: exp(-100) is left
    assert run["contact_force floor x"][-1] == pytest.approx(-coefficient * M * G, rel=1e-7)
    assert run["floor_bristle_x"][-1] == pytest.approx(coefficient / 0.45, rel=1e-7)


@pytest.mark.parametrize("rigid", cases([False, True], fast=[True]))
def test_linear_equations_have_the_presliding_mode(rigid: bool) -> None:
    """sqrt(mu N/(deflection m)), its damping ratio half of that times the time: where it rests on a slope."""
    for time in (T, 1e-3):
        eqs = pushed(sb.Friction(mu=0.5, deflection=D, damping_time=time), rigid=rigid, lean=0.2)
        share = math.tan(0.2) / 0.5
        at = {"floor_bristle_x": share, "x": 0, "y": 0} | ({} if rigid else {"z": -M * G * math.cos(0.2) / K})
        linear = sb.linearize(eqs, at=at)
        w = math.sqrt(0.5 * G * math.cos(0.2) / D)
        modes = linear.eigenvalues[np.abs(linear.eigenvalues.imag) > 1]
        np.testing.assert_allclose(np.abs(modes), w, rtol=1e-9)  # along x and along y
        np.testing.assert_allclose(-modes.real / w, time * w / 2, rtol=1e-9)
        assert len(modes) == 4 and "switches" not in "".join(linear.notes)


@pytest.mark.parametrize("rigid", cases([False, True], fast=[False]))
def test_an_equilibrium_finds_the_deflection(rigid: bool) -> None:
    """On a slope, where only friction holds it; linear equations about it have the mode of before."""
    eqs = pushed(sb.Friction(mu=0.5, deflection=D), rigid=rigid, lean=0.2)
    rest = sb.find_equilibrium(eqs)
    assert rest["floor_bristle_x"] == pytest.approx(math.tan(0.2) / 0.5, rel=1e-9)
    assert rest["contact_force floor x"] == pytest.approx(-M * G * math.sin(0.2), rel=1e-9)
    assert rest["contact_force floor z"] == pytest.approx(M * G * math.cos(0.2), rel=1e-9)
    assert rest["x"] == 0
    w = math.sqrt(0.5 * G * math.cos(0.2) / D)
    assert np.abs(np.abs(sb.linearize(eqs, rest).eigenvalues) - w).min() < 1e-9 * w


def test_an_equilibrium_of_a_joint_with_bristles() -> None:
    """Those of given strength; what reads a reaction is no part of the search for equilibria."""
    block = sb.Body("Block", mass=M)
    slide = sb.Prismatic("slide", "ground", block, axis="x", coordinate="x", force=sb.Drive(applied=3),
                         friction=sb.Friction(force=8, deflection=D))  # fmt: skip
    rest = sb.find_equilibrium(sb.form_equations(sb.Model("guide", [slide])))
    assert rest["slide_bristle"] == pytest.approx(3 / 8) and rest["x"] == 0


@pytest.mark.exhaustive
def test_a_box_rests_on_all_corners() -> None:
    """Rigid and on a slope: the bristles of four corners bear it together."""
    box = sb.Body("Box", mass=M, inertia=(0.02,) * 3)
    free = sb.Free("J", "ground", box, angles="xyz", coordinates=["x", "y", "z", "a", "b", "c"])
    floor = sb.Contact("floor", "ground", box, ["plane", {"box": (0.3, 0.2, 0.2)}], normal="rigid",
                       friction=sb.Friction(mu=0.5, deflection=D))  # fmt: skip
    gravity = (G * math.sin(0.2), 0, -G * math.cos(0.2))
    rest = sb.find_equilibrium(sb.form_equations(sb.Model("box", [free, floor], gravity, initial={"z": 0.1})))
    assert rest["contact_force floor x"] == pytest.approx(-M * G * math.sin(0.2), rel=1e-9)
    assert rest["contact_force floor z"] == pytest.approx(M * G * math.cos(0.2), rel=1e-9)
    np.testing.assert_allclose([rest[name] for name in "xyzabc"], [0, 0, 0.1, 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize("rigid", cases([False, True], fast=[True]))
def test_a_slow_ramp_breaks_it_away_at_mu_static(rigid: bool) -> None:
    """The greatest force is mu_static N but for what Stribeck's curve takes while the last of it is reached.

    With r the rate of the ramp over mu_static N and e the share of the steady deflection that is missing, the slip is
    v = r deflection/(1 - alpha (1 - e)), and 1 - alpha = (pi e/(2 (1 - breakaway)))^2 or more: w is at least
    1 - e - (1 - mu/mu_static) (v/stribeck)^2 for some e. The inertia keeps it longer; the damper adds r T.
    """
    rate = 0.5
    friction = sb.Friction(mu=0.3, mu_static=0.4, stribeck=0.01, deflection=D, breakaway=0.8)
    top = 0.4 * M * G
    times = np.linspace(0, 17, 3401)
    eqs = pushed(friction, f"{rate}*t", rigid=rigid)
    run = sb.simulate(eqs, 17.0, times=times, integrator=sb.Stiff(), **FINE)
    force = -run["contact_force floor x"]
    r, missing = rate / top, np.linspace(1e-3, 0.1, 1000)
    rest = (math.pi * missing / 0.4) ** 2
    lost = (missing + 0.25 * (r * D / 0.01 / (1 - (1 - rest) * (1 - missing))) ** 2).min()
    assert lost < 8e-3
    assert top * (1 - lost) < force.max() < top * (1 + r * T)
    assert abs(run["x"][times <= 0.8 * top / rate]).max() < 0.8 * D * (1 + 1e-6)  # nothing has slipped before
    assert run["x"][-1] > 100 * D
    hand = published(lambda t: rate * t, 0.3, 0.8, 17, list(times), mu_static=0.4, stribeck=0.01)
    early = times < top / rate - 0.2
    np.testing.assert_allclose(run["x"][early], hand[0][early], atol=1e-9)


@pytest.mark.parametrize(
    ("breakaway", "rigid"), rows(product(["0", "b"], [False, True]), fast=[("0", False), ("b", True)])
)
def test_an_oscillating_force_is_borne_as_published(rigid: bool, breakaway: str) -> None:
    """4 N and 1.3 sin(20 t) of 7.8 N: LuGre's friction drifts by millimetres, that with a threshold does not."""
    friction = sb.Friction(mu=0.4, deflection=D, breakaway=0 if breakaway == "0" else breakaway)
    eqs = pushed(friction, "(4 + 1.3*sin(20*t))*min(1, t)", rigid=rigid)
    period = math.pi / 10
    times = [0, 10 * period, 100 * period]
    run = sb.simulate(eqs, times[-1], times=times, **FINE)

    def push(t: float) -> float:
        return (4 + 1.3 * math.sin(20 * t)) * min(1.0, t)

    hand = published(push, 0.4, None if breakaway == "0" else 0.7, times[-1], times)
    np.testing.assert_allclose(run["x"], hand[0], atol=2e-8)
    drift = run["x"][2] - run["x"][1]
    assert drift > 2e-3 if breakaway == "0" else abs(drift) < 1e-11


@pytest.mark.parametrize("breakaway", cases([0, 0.3, 0.9], fast=[0.3]))
def test_sticking_and_slipping_are_as_published(breakaway: float) -> None:
    """To and fro, with a force beyond the limit in each half."""
    friction = sb.Friction(mu=0.3, mu_static=0.4, stribeck=0.02, deflection=D, breakaway=breakaway)
    times = list(np.linspace(0, 3, 31))
    run = sb.simulate(pushed(friction, "9*sin(4*t)"), 3.0, times=times, **FINE)
    hand = published(
        lambda t: 9 * math.sin(4 * t), 0.3, breakaway or None, 3, times, mu_static=0.4, stribeck=0.02
    )
    np.testing.assert_allclose(run["x"], hand[0], atol=1e-7)
    np.testing.assert_allclose(run["x_dot"], hand[1], atol=1e-6)
    assert np.ptp(run["x"]) > 0.01 and abs(run.energy_drift) < 1e-9


@pytest.mark.parametrize("rigid", [False, True])
@pytest.mark.parametrize("breakaway", [0, 0.7])
def test_across_two_directions_the_deflection_is_dragged(breakaway: float, rigid: bool) -> None:
    """w' = v/d - alpha max(0, v.w)/|w| w/d, without a threshold v/d - |v| w/d, for a force that turns."""
    friction = sb.Friction(mu=0.4, mu_y=0.25, deflection=D, breakaway=breakaway)
    times = [0, 0.5, 1.0]
    run = sb.simulate(pushed(friction, "9*cos(5*t)", "7*sin(5*t)"), 1.0, times=times, **FINE)

    def rates(t: float, y: Floats) -> list[float]:
        v, w = y[2:4], y[4:6]
        size, speed = math.hypot(*w), math.hypot(*v)
        flow = speed / D
        if breakaway:
            begun = min(max((size - breakaway) / (1 - breakaway), 0), 1)
            flow = math.sin(math.pi / 2 * begun) ** 2 * max(0.0, v @ w) / (size * D) if size else 0
        rate = v / D - flow * w
        share = w + T * rate / math.sqrt(1 + (T * speed / D) ** 2)
        push = np.array([9 * math.cos(5 * t), 7 * math.sin(5 * t)])
        return [*v, *(push / M - np.array([0.4, 0.25]) * G * share), *rate]

    hand: Any = solve_ivp(
        rates, (0, 1), np.zeros(6), method="LSODA", rtol=1e-11, atol=1e-14, t_eval=times, max_step=1e-3
    )
    for k, name in enumerate(("x", "y", "x_dot", "y_dot", "floor_bristle_x", "floor_bristle_y")):
        np.testing.assert_allclose(run[name], hand.y[k], atol=1e-7 if k < 4 else 1e-5)
    assert math.hypot(run["x"][-1], run["y"][-1]) > 0.1


@pytest.mark.parametrize("rigid", [False, True])
def test_a_ball_with_spin_ends_rolling(rigid: bool) -> None:
    """What acts in the point of contact keeps m h v + I w there: v + I w h/(m h^2 + I), 5/7 v + 2/7 R w if h = R.

    h is the height of the centre over the middle of the overlap. The bristles swing out by themselves at 50/s.
    """
    R = 0.1
    ball = sb.Body("Ball", mass=M, inertia=(0.4 * M * R * R,) * 3)
    floor = sb.Contact("floor", "ground", ball, ["plane", {"sphere": R}], normal="rigid" if rigid else FLOOR,
                       friction=sb.Friction(mu=0.3, deflection=D))  # fmt: skip
    free = sb.Free("J", "ground", ball, angles="xyz", coordinates=["x", "y", "z", "a", "b", "c"])
    depth = 0 if rigid else M * G / K
    start = {"z": R - depth, "x_dot": 1.0, "a_dot": 5.0}
    eqs = sb.form_equations(sb.Model("ball", [free, floor], (0, 0, -G), initial=start))
    run = sb.simulate(eqs, 1.0, times=[0, 1], rtol=1e-9)
    h, inertia = R - depth / 2, 0.4 * M * R * R
    roll = M * h * h + inertia
    assert run["x_dot"][-1] == pytest.approx(M * h * h / roll, abs=1e-7)
    assert run["y_dot"][-1] == pytest.approx(-inertia * 5 * h / roll, abs=1e-7)
    assert np.abs(run["slip floor"][:, -1]).max() < 1e-8
    assert not run.events and abs(run.energy_drift) < 1e-7


def test_bristles_spring_back_when_the_shapes_part() -> None:
    """exp(-t/T) in the air, whatever moves there; the force falls with that along the normal."""
    eqs = pushed(sb.Friction(mu=0.5, deflection=D, damping_time=0.02), z=0.1, x_dot=1)
    run = sb.simulate(
        eqs, 0.1, {"floor_bristle_x": 0.8, "floor_bristle_y": -0.3}, times=[0, 0.05, 0.1], **FINE
    )
    np.testing.assert_allclose(run["floor_bristle_x"], 0.8 * np.exp(-run.t / 0.02), rtol=1e-8)
    np.testing.assert_allclose(run["floor_bristle_y"], -0.3 * np.exp(-run.t / 0.02), rtol=1e-8)
    assert not run["contact_force floor"].any()


@pytest.mark.parametrize("rigid", [False, pytest.param(True, marks=pytest.mark.exhaustive)])
def test_a_box_stands_on_the_bristles_of_its_corners(rigid: bool) -> None:
    """Eight points have states in both directions; standing askew on a slope it stays for 1000 s."""
    box = sb.Body("Box", mass=M, inertia=(0.02,) * 3)
    free = sb.Free("J", "ground", box, angles="xyz", coordinates=["x", "y", "z", "a", "b", "c"])
    floor = sb.Contact("floor", "ground", box, ["plane", {"box": (0.3, 0.2, 0.2)}], normal="rigid" if rigid else FLOOR,
                       friction=sb.Friction(mu=0.5, deflection=D))  # fmt: skip
    gravity = (G * math.sin(0.2), 0, -G * math.cos(0.2))
    depth = 0 if rigid else M * G * math.cos(0.2) / (4 * K)
    eqs = sb.form_equations(sb.Model("box", [free, floor], gravity, initial={"z": 0.1 - depth, "c": 0.5}))
    assert len(eqs.signal_state_names) == 16 and eqs.signal_state_names[3] == "floor_bristle_2_y"
    run = sb.simulate(eqs, 1000.0, times=[0, 10, 1000], integrator=sb.Stiff())
    for name in ("x", "y", "z"):
        assert abs(run[name][2] - run[name][1]) < 1e-9
    assert 0.3 * D < run["x"][2] < 2 * D
    planar = sb.Planar("J", "ground", box, axis="y", coordinates=["z", "x", "th"])
    names = sb.form_equations(sb.Model("box", [planar, floor], gravity)).signal_state_names
    assert names == tuple(f"floor_bristle_{k}_x" for k in range(1, 9))  # nothing slips along y


@pytest.mark.parametrize("law", [{"mu": 0.4}, {"force": 0.4 * M * G}])
def test_joints_have_bristles_too(law: dict[str, float]) -> None:
    block = sb.Body("Block", mass=M)
    slide = sb.Prismatic("slide", "ground", block, axis="x", coordinate="x", force=sb.Drive(applied="9*sin(4*t)"),
                         friction=sb.Friction(deflection=D, breakaway=0.5, **law))  # fmt: skip
    eqs = sb.form_equations(sb.Model("guide", [slide], (0, 0, -G)))
    times = list(np.linspace(0, 3, 31))
    run = sb.simulate(eqs, 3.0, times=times, **FINE)
    hand = published(lambda t: 9 * math.sin(4 * t), 0.4, 0.5, 3, times)
    np.testing.assert_allclose(run["x"], hand[0], atol=1e-7)
    np.testing.assert_allclose(run["friction slide"], -0.4 * M * G * run["slide_bristle_share"], rtol=1e-12)
    assert not run.events and abs(run.energy_drift) < 1e-9


def test_a_shaft_breaks_away_where_its_bearing_lets_it() -> None:
    """mu radius N: in a turning joint the deflection is an angle."""
    wheel = sb.Body("Wheel", mass=M, inertia=(0, 0.01, 0))
    for torque, turns in ((0.9, False), (1.1, True)):
        pin = sb.Revolute("pin", "ground", wheel, axis="y", coordinate="th", torque=sb.Drive(applied=f"{torque}*0.3*0.05*19.62"),
                          friction=sb.Friction(mu=0.3, radius=0.05, deflection=1e-3, breakaway=0.95))  # fmt: skip
        run = sb.simulate(
            sb.form_equations(sb.Model("wheel", [pin], (0, 0, -G))), 20.0, integrator=sb.Stiff()
        )
        if turns:
            assert run["th_dot"][-1] == pytest.approx(0.1 * 0.3 * 0.05 * M * G / 0.01 * 20, rel=2e-2)
        else:
            assert run["th"][-1] == pytest.approx(0.9e-3, rel=1e-6)


@cache
def shaken(deflection: float = D) -> sb.EquationSet:
    friction = sb.Friction(mu=0.3, deflection=deflection, breakaway="b")
    return pushed(friction, "9*sin(4*t)", "2*cos(4*t)")


def test_sweeps_and_steps_have_the_motion() -> None:
    eqs = shaken()
    runs = sb.sweep(eqs, 1.0, {"b": [0.5, 0.7, 0.9]}, times=[0, 1], **FINE)
    alone = sb.simulate(eqs, 1.0, parameters={"b": 0.9}, times=[0, 1], **FINE)
    assert runs["x"][2, -1] == pytest.approx(alone["x"][-1], abs=1e-9)
    assert abs(runs["x"][0, -1] - alone["x"][-1]) > 1e-7
    stepper = sb.Stepper(eqs, 1e-3)
    for _ in range(1000):
        stepper.step()
    fine = sb.simulate(eqs, 1.0, times=[0, 1], **FINE)
    for name in ("x", "y", "floor_bristle_x"):
        assert stepper.state()[name] == pytest.approx(fine[name][-1], abs=1e-4 if "b" in name else 1e-6)


OFTEN = ("simulate", "simulate GeneralizedAlpha", "Stepper", "LaneStepper", "sweep", "C")
SIZES = {"x": 0.1, "y": 0.1, "x_dot": 1.0, "floor_bristle_x": 10.0, "floor_bristle_y": 10.0}


@dataclass(frozen=True)
class Shaken(Question):
    """The scene of above, with a deflection that steps of fixed length can follow."""

    @property
    def eqs(self) -> sb.EquationSet:
        return shaken(1e-3)


def shaken_reference(t: Floats) -> dict[str, Floats]:
    run = sb.simulate(shaken(1e-3), float(t[-1]), times=np.unique(t), rtol=1e-12, atol=1e-14)
    return {name: np.interp(t, run.t, run[name]) for name in SIZES}


@pytest.mark.skipif(shutil.which("cc") is None or shutil.which("node") is None, reason="needs cc and Node")
@pytest.mark.parametrize("way", cases(WAYS, fast=OFTEN))
def test_everything_that_computes_motions_has_bristles(way: str, tmp_path: Path) -> None:
    """Programs, pages, FMUs, sweeps, lanes: each to its own tolerance.

    Bristles pass errors of speed on 1/d times as large, and forget them in d/v: 10 is their size for that.
    """
    scene = Fragment("shaken", (), shaken_reference, SIZES, initial={"x": 0.0}, freely="x")
    assert outcome(Shaken((scene,), tmp_path, None), way) == "right"


def test_a_file_has_the_words_of_bristles() -> None:
    eqs = pushed(
        sb.Friction(mu=0.3, mu_static=0.4, stribeck=0.01, deflection=D, damping_time=0.01, breakaway=0.8)
    )
    text = model_to_toml(eqs.model)
    assert "mu = 0.3, mu_static = 0.4, stribeck = 0.01, deflection = 0.0001" in text.replace("'", "")
    assert model_from_toml(text) == eqs.model


def test_parts_rename_bristles() -> None:
    """Formulas of a part that read a deflection read its own."""
    foot = sb.Body("Foot", mass=M)
    touch = sb.Contact(
        "touch", "ground", foot, ["plane", "point"], normal=FLOOR, friction=sb.Friction(mu=0.5, deflection=D)
    )
    part = sb.Model("foot", [sb.Cartesian("J", "ground", foot, coordinates=["x", "y", "z"]), touch,
                             sb.Signal("twice", "2*touch_bristle_x")])  # fmt: skip
    whole = sb.Model("two", [sb.Include(part, "L"), sb.Include(part, "R")])
    eqs = sb.form_equations(whole)
    assert eqs.signal_state_names == tuple(f"{side}_touch_bristle_{end}" for side in "LR" for end in "xy")
    assert sb.compile(eqs, "R_twice")(0.0, np.zeros(6), np.zeros(6), s=[1, 2, 3, 4]) == 6


@pytest.mark.parametrize("rigid", cases([False, True], fast=[True]))
def test_all_formulations_have_the_same_bristles(rigid: bool) -> None:
    """On a ball at an arm, whose slip and gap depend on five angles, and whose force passes through joints."""
    ball = sb.Body("Ball", mass=M, inertia=(0.01,) * 3)
    arm = sb.Body("Arm", mass=1, inertia=(0.1, 0.1, 0.1), frames={"tip": sb.Frame(at=(0.5, 0, 0))})
    friction = sb.Friction(mu=0.3, mu_static=0.4, stribeck=0.1, deflection=D, breakaway="b")
    parts = [
        sb.Universal("shoulder", "ground", arm, axes=("z", "y"), coordinates=["a", "b1"]),
        sb.Spherical("wrist", "Arm.tip", ball, angles="xyz", coordinates=["c", "d", "e"]),
        sb.Contact("floor", "ground", ball, ["plane", {"sphere": 0.1}], normal="rigid" if rigid else FLOOR,
                   friction=friction),
    ]  # fmt: skip
    model = sb.Model("arm", parts, (0, 0, -G), parameters={"b": 0.6})
    values = []
    for formulation in FORMULATIONS:
        eqs = sb.form_equations(model, formulation)
        f = sb.compile(eqs, ["udot", "signal_rates", "contact_force floor", "power"])
        found = f(0.0, [0.3, -0.01, 0.1, 0.2, 0.3], [0.3, 0.2, 0.1, -0.2, 0.4], s=[0.8, 0.3])
        values.append(np.concatenate([np.ravel(each) for each in found]))
    for other in values[1:]:
        np.testing.assert_allclose(other, values[0], rtol=1e-9, atol=1e-9 * np.abs(values[0]).max())
    assert values[0][5:7].any() and values[0][-1] != 0


def test_code_has_the_same_bits_in_all_languages(tmp_path: Path) -> None:
    f = sb.compile(shaken(), ["udot", "signal_rates", "contact_force floor"], portable=True)
    check_bits(f, random_points(f, 20, 1), tmp_path)


def test_tolerances_of_bristles_are_those_of_shares() -> None:
    """However small they are at first, as what rounding leaves in an equilibrium."""
    eqs = shaken()
    tiny, none = ({"floor_bristle_x": 0.3, "floor_bristle_y": y} for y in (1e-17, 0))
    runs = [sb.simulate(eqs, 0.5, start, times=[0, 0.5]) for start in (tiny, none)]
    for name in eqs.state_names:
        assert runs[0][name][-1] == pytest.approx(runs[1][name][-1], rel=1e-12, abs=1e-14)


def test_names_of_bristles_are_symbols() -> None:
    """Formulas read them; two elements cannot bring one name."""
    block = sb.Body("Block", mass=M)
    slide = sb.Prismatic("my slide", "ground", block, axis="x", coordinate="x", friction=sb.Friction(force=1, deflection=D),
                         force=sb.Drive(applied="-100*my_slide_bristle"))  # fmt: skip
    model = sb.Model("names", [slide])
    assert sb.compile(sb.form_equations(model), "udot")(0.0, [0.0], [0.0], s=[0.5])[0] == pytest.approx(
        -(100 * 0.5 + 0.5) / 2
    )
    with pytest.raises(sb.ModelError, match="my_slide_bristle_flow") as caught:
        sb.Model("twice", [slide], parameters={"my_slide_bristle_flow": 1})
    assert {problem.code for problem in caught.value.problems} == {"names.duplicate"}


@pytest.mark.parametrize(
    ("friction", "code", "words"),
    [
        ({"mu": 0.3, "deflection": 0}, "model.friction_scale", "deflection is 0"),
        ({"mu": 0.3, "deflection": 1e-4, "damping_time": -1}, "model.friction_scale", "damping_time is -1"),
        ({"mu": 0.3, "deflection": 1e-4, "breakaway": 1}, "model.friction_scale", "breakaway is 1"),
        ({"mu": 0.3, "deflection": 1e-4, "v0": 1e-3}, "model.mixed_friction", "deflection and v0"),
        ({"mu": 0.3, "v0": 1e-3, "breakaway": 0.5}, "model.mixed_friction", "breakaway requires deflection"),
        ({"mu": 0.3, "deflection": 1e-4, "mu_static": 0.4}, "model.mixed_friction", "mu_static and stribeck"),
        ({"mu": 0.3, "deflection": 1e-4, "radius": 0.1}, "contact.friction", "radius is for joints"),
        ({"mu": 0.3, "deflection": 1e-4, "stribeck": 1, "mu_static": 0.2}, "model.static_friction", "less than"),
    ],
)  # fmt: skip
def test_impossible_bristles_are_refused(friction: dict[str, float], code: str, words: str) -> None:
    with pytest.raises(sb.SymbodyError, match=words) as caught:
        pushed(sb.Friction(**friction))
    assert code in {problem.code for problem in caught.value.problems}
