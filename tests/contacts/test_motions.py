"""Motions with contacts against closed forms and equations written by hand: impacts, rolling, sliding, rest."""

from __future__ import annotations

import io
import math
import shutil
import subprocess
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from tests.contacts.pairs import Floats
from tests.tiers import cases, rows

G = 9.81
V0 = math.sqrt(2 * G)  # of a fall by 1 m


def impact(law: sb.NormalForce, **parameters: float) -> float:
    """The speed after an impact of a point of 2 kg on ground, without weight, over that before."""
    ball = sb.Body("Ball", mass="m")
    rail = sb.Prismatic("rail", "ground", ball, axis="z", coordinate="z")
    floor = sb.Contact("floor", "ground", ball, ["plane", "point"], normal=law)
    values = {"m": 2, "v0": V0, **parameters}
    model = sb.Model("impact", [rail, floor], parameters=values, initial={"z": 1e-3, "z_dot": "-v0"})
    run = sb.simulate(sb.form_equations(model), 0.05, times=[0, 0.05], rtol=1e-11, atol=1e-13)
    return float(run["z_dot"][-1] / V0)


@pytest.mark.parametrize("exponent", [1, 1.5, 2.2])
@pytest.mark.parametrize(
    ("dissipation", "restitution"), [(0.02, 0.94421685), (0.1, 0.77083722), (0.4, 0.44308419)]
)
def test_restitution_of_hunt_and_crossley(exponent: float, dissipation: float, restitution: float) -> None:
    """ln((1 + a)/(1 - a e)) = a (1 + e), a = c v0, for each exponent; solved here with 8 digits."""
    law = sb.NormalForce(stiffness=1e6, exponent=exponent, dissipation=dissipation)
    assert impact(law) == pytest.approx(restitution, abs=6e-9)
    e, a = impact(law), dissipation * V0
    assert math.log((1 + a) / (1 - a * e)) == pytest.approx(a * (1 + e), rel=1e-8)


@pytest.mark.parametrize("restitution", cases([1, 0.9999, 0.8, 0.5, 0.2, 0.05, 0.01], fast=[1, 0.5, 0.01]))
def test_a_restitution_asked_for_is_that_of_the_impact(restitution: float) -> None:
    """As a number and as a parameter, which stays a symbol until the function is called."""
    for given in (restitution, "e"):
        law = sb.NormalForce(stiffness=1e6, restitution=given, speed="v0")
        assert impact(law, e=restitution) == pytest.approx(restitution, abs=1e-8)
    softer = sb.NormalForce(stiffness=3e5, exponent=1, restitution="e", speed="v0")
    assert impact(softer, e=restitution, m=0.3) == pytest.approx(restitution, abs=1e-8)


def test_a_spring_and_damper_rebound_as_in_books() -> None:
    """Where the force would pull, it lets go: exp(-zeta/sqrt(1 - zeta^2) (pi - ..)), Schwager & Poeschel 2007."""
    k, zeta, m = 1e6, 0.2, 2.0
    w, b = math.sqrt(k / m), zeta * math.sqrt(k / m)
    wd = math.sqrt(w * w - b * b)
    e = math.exp(-b / wd * (math.pi - math.atan2(2 * b * wd, wd * wd - b * b)))
    law = sb.NormalForce(stiffness=k, exponent=1, damping=2 * zeta * m * w)
    assert impact(law) == pytest.approx(e, abs=1e-7)
    ramped = sb.NormalForce(stiffness=k, exponent=1, damping=2 * zeta * m * w, depth=1e-9)
    assert impact(ramped) == pytest.approx(e, abs=1e-6)


def test_a_law_of_the_user_is_the_law_it_says() -> None:
    written = sb.NormalForce(law="1e6*(-gap)^1.5*(1 - 0.1*gap_rate)")
    assert impact(written) == pytest.approx(0.77083722, abs=1e-8)
    curve = sb.NormalForce(law=sb.Curve(x=(0, 1), y=(0, 1e6)))
    assert impact(curve) == pytest.approx(1, abs=1e-9)
    assert impact(sb.NormalForce(law="-1e6*gap")) == pytest.approx(1, abs=1e-9)


def slope(mu: float, angle: float = 0.3, stiffness: float = 1e7) -> sb.EquationSet:
    """A ball of radius 0.1 m, at rest on a slope, in a plane."""
    R = 0.1
    ball = sb.Body("Ball", mass=1, inertia=(0.4 * R * R,) * 3)
    plane = sb.Planar("J", "ground", ball, axis="y", coordinates=["z", "x", "th"])
    law = sb.NormalForce(stiffness=stiffness, exponent=1, damping=2 * math.sqrt(stiffness))
    floor = sb.Contact("floor", "ground", ball, ["plane", {"sphere": R}], normal=law,
                       friction=sb.Friction(mu=mu, v0=1e-5))  # fmt: skip
    weight = (G * math.sin(angle), 0, -G * math.cos(angle))
    depth = G * math.cos(angle) / stiffness
    return sb.form_equations(sb.Model("slope", [plane, floor], gravity=weight, initial={"z": R - depth}))


@pytest.mark.parametrize("share", [0.2, 0.97, 1.03, 3.0])
def test_a_ball_on_a_slope_rolls_or_slides(share: float) -> None:
    """It rolls with 5/7 g sin(angle) while mu >= 2/7 tan(angle), else slides with g (sin - mu cos)."""
    mu = share * 2 / 7 * math.tan(0.3)
    run = sb.simulate(slope(mu), 0.5, times=[0, 0.5], rtol=1e-9)
    rolls = 5 / 7 * G * math.sin(0.3)
    slides = G * (math.sin(0.3) - mu * math.cos(0.3))
    expected = rolls if share > 1 else slides
    assert run["x_dot"][-1] == pytest.approx(expected * 0.5, abs=4e-4 if 0.9 < share < 1.1 else 5e-5)
    slip = run["x_dot"][-1] - 0.1 * run["th_dot"][-1]
    assert slip < 2e-4 if share > 1 else slip > 0.02
    # The contact itself: slip at its point, and friction against it.
    np.testing.assert_allclose(run["slip floor"][0, -1], slip, atol=1e-5)
    assert run["contact_force floor"][2, -1] == pytest.approx(G * math.cos(0.3), rel=1e-6)
    assert abs(run.energy_drift) < 1e-6


def test_a_box_that_falls_askew_moves_as_by_equations_written_by_hand() -> None:
    """It lands on two corners, tumbles and slides to rest. In space each edge has two corners."""
    k, mu, v0, c = 1e6, 0.5, 1e-3, 0.1
    a, h, m = 0.4, 0.3, 2.0
    inertia = m * (a * a + h * h) / 12
    box = sb.Body("Box", mass=m, inertia=(inertia,) * 3)
    law = sb.NormalForce(stiffness=k / 2, dissipation=c)
    floor = sb.Contact("floor", "ground", box, ["plane", {"box": (a, 0.2, h)}], normal=law,
                       friction=sb.Friction(mu=mu, v0=v0))  # fmt: skip
    plane = sb.Planar("J", "ground", box, axis="y", coordinates=["z", "x", "th"])
    start = {"z": 0.6, "th": 0.5, "x_dot": 1.0, "th_dot": -1.0}
    model = sb.Model("box", [plane, floor], gravity=(0, 0, -G), initial=start)
    run = sb.simulate(sb.form_equations(model), 2, times=[0, 0.6, 2], rtol=1e-10, atol=1e-12)

    def rates(_: float, y: Floats) -> list[float]:
        z, _, th, vz, vx, w = y
        force = np.zeros(3)
        for sx, sz in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            X = math.cos(th) * sx * a / 2 + math.sin(th) * sz * h / 2
            Z = -math.sin(th) * sx * a / 2 + math.cos(th) * sz * h / 2
            gap = z + Z
            if gap < 0:
                reach = Z - gap / 2
                slip, rate = vx + w * reach, vz - w * X
                N = k * (-gap) ** 1.5 * max(0.0, 1 - c * rate)
                F = -mu * N * slip / math.hypot(slip, v0)
                force += (N, F, reach * F - X * N)
        return [vz, vx, w, force[0] / m - G, force[1] / m, force[2] / inertia]

    hand: Any = solve_ivp(rates, (0, 2), [0.6, 0, 0.5, 0, 1, -1], method="DOP853", rtol=1e-10, atol=1e-12,
                          t_eval=[0, 0.6, 2])  # fmt: skip
    for k_, name in enumerate(("z", "x", "th")):
        np.testing.assert_allclose(run[name], hand.y[k_], atol=2e-6)
    assert abs(run.energy_drift) < 1e-6 and run["x"][-1] > 0.3


def balls(gap: float, order: tuple[int, ...] = (0, 1, 2)) -> list[float]:
    """Speeds of three equal balls in a row after the first has struck the second with 1 m/s."""
    bodies = [sb.Body(f"B{k}", mass=1) for k in range(3)]
    rails = [sb.Prismatic(f"J{k}", "ground", bodies[k], axis="x", coordinate=f"x{k}") for k in range(3)]
    law = sb.NormalForce(stiffness=1e8)
    sphere = {"sphere": 0.1}
    contacts = [sb.Contact(f"C{k}", bodies[k], bodies[k + 1], [sphere, sphere], normal=law) for k in range(2)]
    start = {"x0": 0, "x1": 0.2 + gap, "x2": 0.4 + 2 * gap, "x0_dot": 1}
    parts = [
        *(bodies[k] for k in order),
        *(rails[k] for k in order),
        *contacts[:: 1 if order[0] == 0 else -1],
    ]
    run = sb.simulate(sb.form_equations(sb.Model("row", parts, initial=start)), 0.05, times=[0, 0.05],
                      rtol=1e-11, atol=1e-12)  # fmt: skip
    return [float(run[f"x{k}_dot"][-1]) for k in range(3)]


def test_balls_in_a_row_strike_one_after_the_other() -> None:
    """Apart (0, 0, 1), as each impact swaps the speeds; where they touch Hertz's law spreads a little."""
    np.testing.assert_allclose(balls(1e-3), [0, 0, 1], atol=1e-8)
    touching = balls(0)
    assert sum(touching) == pytest.approx(1) and sum(v * v for v in touching) == pytest.approx(1)
    assert touching[0] < -0.05 and touching[2] > 0.98
    np.testing.assert_allclose(balls(1e-3, (2, 0, 1)), balls(1e-3), atol=1e-9)


METHODS = [sb.Explicit(), sb.Stiff(), sb.GeneralizedAlpha()]


@pytest.mark.parametrize("integrator", METHODS, ids=lambda method: type(method).__name__)
@pytest.mark.parametrize("radius", [0.01, 0.001])
def test_fast_balls_are_met_in_free_flight(
    radius: float, integrator: sb.Explicit | sb.Stiff | sb.GeneralizedAlpha
) -> None:
    """In free flight steps grow without bound; no ball flies through another one, and none is written down."""
    speed = 50.0
    rails = [
        sb.Prismatic(f"J{k}", "ground", sb.Body(f"B{k}", mass=1), axis="x", coordinate=f"x{k}")
        for k in (0, 1)
    ]
    sphere = {"sphere": radius}
    contact = sb.Contact("C", "B0", "B1", [sphere, sphere], normal=sb.NormalForce(stiffness=1e10))
    model = sb.Model("shot", [*rails, contact], initial={"x0": -2, "x0_dot": speed})
    run = sb.simulate(sb.form_equations(model), 0.06, integrator=integrator, rtol=1e-8)
    assert run.success and run.events == ()
    assert run["x1_dot"][-1] == pytest.approx(speed, rel=1e-4)
    assert run["x0_dot"][-1] == pytest.approx(0, abs=5e-3)
    assert (np.diff(run.t) > 0).all()


def dipping_ball(depth: float, end: object) -> sb.EquationSet:
    """A point of 1 kg that gravity turns around, as deep behind z = 0 as no end would stop it."""
    rail = {"limits": {"low": 0, "stiffness": 1e8}} if end == "limits" else {}
    joint = sb.Prismatic("rail", "ground", sb.Body("B", mass=1), axis="z", coordinate="z", **rail)  # type: ignore[arg-type]
    lift = sb.Force("lift", on="B", vector=[0, 0, "F"])
    parts: list[sb.Prismatic | sb.Force | sb.Contact] = [joint, lift]
    if end == "contact":
        parts.append(
            sb.Contact(
                "C", "ground", "B", ["plane", "point"], normal=sb.NormalForce(stiffness=1e8, exponent=1)
            )
        )
    start = {"z": 5 - depth, "z_dot": -10}
    return sb.form_equations(sb.Model("dip", parts, parameters={"F": 10}, initial=start))


def dipped(depth: float) -> tuple[float, float]:
    """Return place and speed 2 s later: z'' = 10, and while z < 0 z'' = 10 - 1e8 z."""
    at_touch = math.sqrt(2 * 10 * depth)  # speed v there
    until = (10 - at_touch) / 10
    omega = 1e4
    # (10/w^2) (1 - cos w s) - (v/w) sin w s = 0
    inside = 2 * math.atan(at_touch * omega / 10) / omega
    left = 2 - until - inside
    return at_touch * left + 5 * left**2, at_touch + 10 * left


@pytest.mark.parametrize(
    ("depth", "end"),
    rows(product([1e-2, 1e-4, 1e-6], ["contact", "limits"]), fast=[(1e-2, "contact"), (1e-6, "limits")]),
)
def test_shallow_arcs_are_seen(depth: float, end: str) -> None:
    """They leave no trace in the ends of long steps, by whatever computes a whole motion.

    An error of a place before the touch, 1e-7 m at most, grows by dz(2)/dz(0) = 10/v.
    """
    eqs, exact = dipping_ball(depth, end), dipped(depth)
    within = 1e-7 * 10 / math.sqrt(20 * depth)
    for integrator in METHODS:
        run = sb.simulate(eqs, 2.0, integrator=integrator, rtol=1e-9)
        assert (run["z"][-1], run["z_dot"][-1]) == pytest.approx(exact, abs=within)
    cases = sb.sweep(eqs, 2.0, {"F": [10.0, 9.0]}, times=[0, 2], rtol=1e-9)
    assert float(cases["z"][0, -1]) == pytest.approx(exact[0], abs=within)


WAYS: list[dict[str, object]] = [
    *({"integrator": method} for method in METHODS),
    {"constraints": sb.GGL()}, {"constraints": sb.Partition()}, {"constraints": sb.Baumgarte()},
]  # fmt: skip


@pytest.mark.parametrize(
    "way", cases(WAYS, fast=[WAYS[0], *WAYS[-2:]]), ids=lambda way: type(next(iter(way.values()))).__name__
)
def test_a_step_that_is_taken_again_leaves_one_motion(way: dict[str, object]) -> None:
    """On the way to a shallow arc and back, what happens happens once, beside dry friction and samples."""
    slide = sb.Prismatic("slide", "ground", sb.Body("S", mass=1), axis="x", coordinate="x",
                         friction=sb.Friction(mu=0.2), force=sb.Drive(applied="u"))  # fmt: skip
    plane = sb.Planar("J", "ground", sb.Body("B", mass=1, inertia=(1, 1, 1)), axis="y",
                      coordinates=["z", "y", "th"])  # fmt: skip
    law = sb.NormalForce(stiffness=1e8, exponent=1)
    parts = [
        plane, slide, sb.Contact("C", "ground", "B", ["plane", "point"], normal=law), sb.Constraint("tie", "y - th"),
        sb.Force("lift", on="B", vector=[0, 0, 10]), sb.Force("press", on="S", vector=[0, 0, -10]),
        sb.Signal("u", "3*sin(5*t)", sample=0.07),
    ]  # fmt: skip
    model = sb.Model("dip", parts, initial={"z": 5 - 1e-3, "z_dot": -10})
    events = [sb.Event("z - 0.05", name="level"), sb.Event("z_dot", name="bottom")]
    run = sb.simulate(sb.form_equations(model), 2.0, events=events, rtol=1e-9, **way)  # type: ignore[arg-type]
    assert run["z"][-1] == pytest.approx(dipped(1e-3)[0], abs=1e-4)  # 1e-6 m before it grow 70 times
    assert [event.name for event in run.events if event.name in ("level", "bottom")] == [
        "level",
        "bottom",
        "level",
    ]


def test_a_program_sees_shallow_arcs(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("a program needs cc")
    text = sb.generate_simulation(dipping_ball(1e-4, "contact"), 2.0, "c", times=[0, 2], rtol=1e-9)
    (tmp_path / "dip.c").write_text(text)
    subprocess.run([compiler, "-O1", "dip.c", "-o", "dip", "-lm"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "dip"], capture_output=True, text=True, check=True).stdout
    rows = np.genfromtxt(io.StringIO(printed), delimiter=",", names=True)
    assert rows["z"][-1] == pytest.approx(dipped(1e-4)[0], abs=1e-5)


@pytest.mark.parametrize("mu", cases([1.2, 1.5, 2.0], fast=[1.5]))
def test_the_rod_of_painleve_goes_on(mu: float) -> None:
    """Pushed along at tan p = 2 it has no rigid motion from mu = 4/3 on; compliance has, and loses energy."""
    p = math.atan(2)
    rod = sb.Body("Rod", mass=1, inertia=(0, 1 / 12, 1 / 12), frames={"tip": sb.Frame(at=(-0.5, 0, 0))})
    law = sb.NormalForce(stiffness=1e6, dissipation=0.1)
    contact = sb.Contact("tip", "ground", "Rod.tip", ["plane", "point"], normal=law,
                         friction=sb.Friction(mu=mu, v0=1e-3))  # fmt: skip
    plane = sb.Planar("J", "ground", rod, axis="y", coordinates=["z", "x", "th"])
    start = {"z": math.sin(p) / 2, "th": -p, "x_dot": -2.0}
    model = sb.Model("rod", [plane, contact], gravity=(0, 0, -G), initial=start)
    run = sb.simulate(sb.form_equations(model), 0.3, times=np.linspace(0, 0.3, 601), rtol=1e-8)
    assert run.status is sb.Status.SUCCESS
    assert run["contact_force tip"][2].max() > 50 and run["contact_force tip"][2].min() == 0
    assert np.diff(run["energy"]).max() < 1e-6 and abs(run.energy_drift) < 1e-5
