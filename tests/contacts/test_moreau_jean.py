"""`MoreauJean`: steps over impacts, against closed forms, the motions located event by event, and the laws."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.kernels.impulses.point_impulse import SCRATCH, solve_point
from symbody.kernels.language import Reals
from symbody.model.contacts.contact_shapes import PAIRS
from symbody.tolerances import CLOSED
from tests.contacts.pairs import Floats

G = 9.81
R = 0.1


def steps(h: float, **others: Any) -> sb.MoreauJean:
    return sb.MoreauJean(step=h, **others)


def bouncing(e: float) -> sb.EquationSet:
    """A mass that falls by 1 m."""
    rail = sb.Prismatic("rail", "ground", sb.Body("Ball", mass=1), axis="z", coordinate="z")
    model = sb.Model(
        "ball", [rail, sb.Stop("floor", "z", restitution=e)], gravity=(0, 0, -G), initial={"z": 1}
    )
    return sb.form_equations(model)


def ball(mu: float, e: float = 0.0, slope: float = 0.0) -> sb.EquationSet:
    """A solid sphere over a plane, on a slope down along x."""
    body = sb.Body("Ball", mass=1, inertia=(0.4 * R**2,) * 3)
    floor = sb.Contact(
        "floor", "ground", body, ["plane", {"sphere": R}], normal="rigid", restitution=e,
        friction=sb.Friction(mu=mu),
    )  # fmt: skip
    gravity = (G * np.sin(slope), 0, -G * np.cos(slope))
    model = sb.Model("ball", [sb.Free("move", "ground", body), floor], gravity=gravity, initial={"move_z": R})
    return sb.form_equations(model)


def box(
    mu: float, edges: Sequence[float], m: float = 1.0, e: float = 0.0, slope: float = 0.0
) -> sb.EquationSet:
    """A box on its corners over a plane, on a slope down along x."""
    x, y, z = (edge**2 for edge in edges)
    body = sb.Body("Box", mass=m, inertia=(m * (y + z) / 12, m * (x + z) / 12, m * (x + y) / 12))
    floor = sb.Contact(
        "floor", "ground", body, ["plane", {"box": list(edges)}], normal="rigid", restitution=e,
        friction=sb.Friction(mu=mu),
    )  # fmt: skip
    gravity = (G * np.sin(slope), 0, -G * np.cos(slope))
    joint = sb.Free("move", "ground", body)
    return sb.form_equations(
        sb.Model("box", [joint, floor], gravity=gravity, initial={"move_z": edges[2] / 2})
    )


def last_bounce(h: float) -> float:
    """When a ball with e = 0.8 last moves faster than one and a half steps of free fall."""
    run = sb.simulate(bouncing(0.8), 4.5, integrator=steps(h))
    return float(run.t[np.flatnonzero(np.abs(run.u[0]) > 1.5 * G * h)[-1]])


def test_a_ball_comes_to_rest_when_its_bounces_end() -> None:
    """After sqrt(2 h/g) (1 + e)/(1 - e)."""
    end = np.sqrt(2 / G) * 9
    assert end == pytest.approx(4.063712769, abs=1e-9)
    for h in (1e-2, 1e-3, 1e-4, 1e-5):
        # Each of the ln(sqrt(2/g)/h)/ln(1/e) bounces that are seen is off by less than a step.
        bounces = np.log(np.sqrt(2 / G) / h) / np.log(1 / 0.8)
        assert abs(last_bounce(h) - end) < bounces * h


@pytest.mark.parametrize("share", [0.8, 1.25])
def test_a_sphere_on_a_slope_rolls_or_slides(share: float) -> None:
    """Sliding is exact: all forces are constant. Rolling begins in the first step, whose middle is at rest."""
    slope, h = 0.4, 1e-3
    mu = share * 2 / 7 * np.tan(slope)
    run = sb.simulate(ball(mu, slope=slope), 1.0, integrator=steps(h))
    rolls = share > 1
    expected = 5 / 7 * G * np.sin(slope) if rolls else G * (np.sin(slope) - mu * np.cos(slope))
    assert run["move_vx"][-1] == pytest.approx(expected, rel=h if rolls else 1e-9)
    assert run["contact_force floor"][2, 1:] == pytest.approx(G * np.cos(slope), rel=1e-9)
    assert run["mode floor friction"][-1] == (0.0 if rolls else 1.0)


def test_a_block_on_a_slope_does_not_creep() -> None:
    run = sb.simulate(
        box(0.5, (0.2, 0.3, 0.4), slope=0.4), 1000.0, integrator=steps(0.01), times=np.linspace(0, 1000, 11)
    )
    assert np.abs(run.q - run.q[:, :1]).max() < 1e-9
    assert run.statistics.residual is not None and run.statistics.residual < 1e-10


def test_a_block_slides_with_its_coefficient() -> None:
    slope, mu = 0.4, 0.3
    run = sb.simulate(box(mu, (0.2, 0.3, 0.4), slope=slope), 1.0, integrator=steps(1e-3))
    assert run["move_vx"][-1] == pytest.approx(G * (np.sin(slope) - mu * np.cos(slope)), rel=1e-9)


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_three_balls_obey_newtons_law_at_once(e: float) -> None:
    """Balls 2 and 3 are at rest and touch: they leave together, behind ball 1 by e."""
    parts: list[Any] = []
    for k in range(3):
        parts.append(sb.Prismatic(f"r{k}", "ground", sb.Body(f"B{k}", mass=1), axis="x", coordinate=f"x{k}"))
    spheres: list[Any] = [{"sphere": R}, {"sphere": R}]
    parts += [
        sb.Contact(f"c{k}", f"B{k}", f"B{k + 1}", spheres, normal="rigid", restitution=e) for k in range(2)
    ]
    start = {"x0": -0.05, "x1": 2 * R, "x2": 4 * R, "x0_dot": 1.0}
    run = sb.simulate(sb.form_equations(sb.Model("row", parts, initial=start)), 0.1, integrator=steps(1e-3))
    behind = (1 + e) / 3
    assert run.u[:, -1] == pytest.approx([behind - e, behind, behind], abs=1e-9)


@pytest.mark.parametrize("share", [0.5, 2.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_painleves_rod_goes_on(share: float, way: float) -> None:
    """Beyond the singular coefficient it jams and strikes in one step, which loses energy; before, it slides
    with the normal force of the rigid motion."""
    p = np.arctan(2.0)
    s, c = np.sin(p), np.cos(p)
    mu = share * (1 + 3 * c**2) / (3 * s * c)
    body = sb.Body("Rod", mass=1, inertia=(1 / 12,) * 3, frames={"tip": sb.Frame(at=(-0.5, 0, 0))})
    joint = sb.Planar("move", "ground", body, axis="y", coordinates=["z", "x", "a"])
    tip = sb.Contact(
        "tip", "ground", "Rod.tip", ["plane", "point"], normal="rigid", friction=sb.Friction(mu=mu)
    )
    eqs = sb.form_equations(sb.Model("rod", [body, joint, tip], gravity=(0, 0, -G)))
    start = {"a": -p, "z": 0.5 * s, "x": 0.0, "x_dot": way, "z_dot": 0.0, "a_dot": 0.0}
    run = sb.simulate(eqs, 0.3, start, integrator=steps(1e-4))
    assert run.success and np.isfinite(run.q).all()
    assert run["energy"].max() <= run["energy"][0] * (1 + 1e-6)
    assert run["gap tip"].min() > -1e-9
    assert run.statistics.residual is not None
    if run.statistics.residual > 1e-10:
        assert any("miss their laws" in note for note in run.notes)
    if share < 1:
        pressing = G / (1 + 3 * c * (c + way * mu * s))
        assert run["contact_force tip"][2, 1] == pytest.approx(pressing, rel=1e-2)


@pytest.mark.parametrize("h", [1e-2, 1e-3])
def test_a_box_tumbles_without_gaining_energy(h: float) -> None:
    """Impulses do no work. Displacements lift what has come in too deep, by h v/2 at most at the rate v: below
    v = g h impacts lose less than that, so that a step may gain m g (g h) h/2; the midpoint rule of a
    spinning body has errors of order h^3 of its energy."""
    m = 2.0
    eqs = box(0.5, (0.4, 0.2, 0.3), m=m, e=0.3)
    start = {
        "move_z": 0.6, "move_qw": 0.95, "move_qx": 0.2, "move_qy": 0.2, "move_qz": 0.1, "move_vx": 1.0,
        "move_vy": 0.2, "move_wx": 1.0, "move_wy": -1.0, "move_wz": 2.0,
    }  # fmt: skip
    run = sb.simulate(eqs, 2.0, start, integrator=steps(h))
    assert run.success
    energy = run["energy"]
    spin = 3.0 * h**3 * energy[0]  # (w h)^3 at w of some rad/s
    assert np.diff(energy).max() < m * (G * h) ** 2 / 2 + spin
    assert energy.max() < energy[0] + spin
    gaps = np.array([run[f"row_gap floor {k}"] for k in range(1, 9)])
    assert gaps.min() > -CLOSED
    assert run["move_z"][-1] == pytest.approx(0.1, abs=G * h**2)
    assert np.abs(run.u[:, -1]).max() < 1e-3


def ends(eqs: sb.EquationSet, start: dict[str, float], end: float, hs: Sequence[float]) -> Floats:
    """How far the places are from those of the rigid motion at the end, for some steps."""
    exact = sb.simulate(eqs, end, start, rtol=1e-10)
    assert exact.success
    runs = [sb.simulate(eqs, end, start, integrator=steps(h)) for h in hs]
    return np.array([np.abs(run.q[:3, -1] - exact.q[:3, -1]).max() for run in runs])


def test_a_spinning_ball_tends_to_its_rigid_motion() -> None:
    """It moves at 2.5 m/s at most and strikes twice, each time off by less than a step."""
    start = {"move_z": 0.5, "move_vx": 1.0, "move_wy": -20.0, "move_wx": 3.0}
    hs = (4e-3, 4e-4, 4e-5)
    errors = ends(ball(0.3, e=0.6), start, 1.0, hs)
    assert (errors < 2 * 2.5 * np.array(hs)).all()


def test_a_loop_on_a_stop_tends_to_its_rigid_motion() -> None:
    """Loops stay closed; impulses act through them."""
    rails = [
        sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy"
    ]  # fmt: skip
    parts = [*rails, sb.Distance("rod", "X", "Y", 5), sb.Stop("floor", "y - 1", restitution=0.5)]
    eqs = sb.form_equations(sb.Model("ladder", parts, gravity=(0, -G, 0), initial={"x": 3, "y": 4}))
    exact = sb.simulate(eqs, 1.5, rtol=1e-10)
    errors = []
    for h in (4e-3, 4e-4, 4e-5):
        run = sb.simulate(eqs, 1.5, integrator=steps(h))
        assert run.constraint_violation.max() < 1e-9 and run["gap floor"].min() > -1e-9
        errors.append(abs(float(run["x"][-1] - exact["x"][-1])))
    assert errors[2] < errors[0] / 10 and errors[2] < 1e-4


def test_friction_of_a_joint_sticks_and_slips() -> None:
    """2 N on 1 kg: it stops after 0.5 s, and moves again with 3 N from 1 s on; ends of phases lie on steps."""
    rail = sb.Prismatic(
        "rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x", friction=sb.Friction(force=2.0),
        force=sb.Drive(applied="F"),
    )  # fmt: skip
    eqs = sb.form_equations(sb.Model("cart", [rail], inputs=["F"], initial={"x_dot": 1}))
    run = sb.simulate(eqs, 2.0, inputs={"F": "if(t < 1, 0, 3)"}, integrator=steps(1e-3))
    assert run["x"][750] == pytest.approx(0.25, abs=1e-9) and run["x"][-1] == pytest.approx(0.75, abs=1e-9)
    assert run["friction rail"][[250, 750, -1]] == pytest.approx([-2, 0, -2], abs=1e-9)
    assert list(run["mode rail"][[250, 750, -1]]) == [1, 0, 1]


def test_without_contacts_it_is_the_midpoint_rule() -> None:
    rail = sb.Prismatic(
        "rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x", force=sb.Drive(stiffness=100)
    )
    eqs = sb.form_equations(sb.Model("cart", [rail], initial={"x": 0.1}))
    errors = [
        abs(float(sb.simulate(eqs, 1.0, integrator=steps(h))["x"][-1]) - 0.1 * np.cos(10))
        for h in (1e-2, 1e-3)
    ]
    assert errors[1] < errors[0] / 80


def test_a_rope_holds_and_limits_end_a_slide() -> None:
    rails = [
        sb.Prismatic("x", "ground", sb.Body("X", mass=0.001), axis="x", coordinate="x"),
        sb.Prismatic("z", "X", sb.Body("Z", mass=1), axis="z", coordinate="z"),
    ]
    rope = sb.Distance("rope", "ground", "Z", 1.0, rope=True)
    eqs = sb.form_equations(sb.Model("rope", [*rails, rope], gravity=(0, 0, -G), initial={"x": 0.5, "z": 0}))
    errors = ends(eqs, {}, 2.0, (1e-3, 1e-4))
    assert errors[1] < errors[0] / 3
    run = sb.simulate(eqs, 2.0, integrator=steps(1e-3))
    assert run["rope_slack rope"].min() > -1e-9
    assert run["rope_tension rope"][-1] > G / 2


# Random scenes

SHAPES: dict[str, Any] = {
    "sphere": {"sphere": 0.2}, "capsule": {"capsule": (0.12, 0.3)}, "box": {"box": (0.3, 0.25, 0.35)},
}  # fmt: skip


def scene(seed: int, *, shuffled: bool = False) -> tuple[sb.Model, dict[str, float]]:
    """One to twelve bodies over a floor, with up to 40 points of contact, and mu by contact."""
    chance = random.Random(seed)
    count = chance.randint(1, 4) if seed < 6 else chance.randint(1, 12)
    bodies, initial = [], {}
    words = [chance.choice(sorted(SHAPES)) for _ in range(count)]
    for k in range(count):
        bodies.append(sb.Body(f"B{k}", mass=chance.uniform(0.5, 2), inertia=(0.02, 0.025, 0.03)))
        at = (0.55 * (k % 2), 0.55 * (k // 2 % 2), 0.4 + 0.6 * (k // 4))
        for letter, place in zip("xyz", at, strict=True):
            initial[f"B{k}_{letter}"] = place
            initial[f"B{k}_v{letter}"] = chance.uniform(-1, 1)
            initial[f"B{k}_w{letter}"] = chance.uniform(-3, 3)
    mus: dict[str, float] = {}
    contacts = []

    def touch(name: str, sides: Sequence[Any], shapes: Sequence[Any]) -> None:
        mus[name] = chance.uniform(0.1, 0.9)
        contacts.append(
            sb.Contact(
                name, sides[0], sides[1], list(shapes), normal="rigid", restitution=chance.uniform(0, 0.6),
                friction=sb.Friction(mu=mus[name]),
            )
        )  # fmt: skip

    points = 0
    for k in range(count):
        size = {"sphere": 1, "capsule": 2, "box": 8}[words[k]]
        if points + size <= 30:
            points += size
            touch(f"F{k}", ("ground", bodies[k]), ("plane", SHAPES[words[k]]))
    for j in range(count):
        for k in range(j):
            fits = bool({(words[j], words[k]), (words[k], words[j])} & PAIRS)
            if fits and points < 40:
                points += 1
                touch(f"C{j}_{k}", (bodies[j], bodies[k]), (SHAPES[words[j]], SHAPES[words[k]]))
    parts: list[Any] = [*bodies, *contacts]
    if shuffled:
        parts.reverse()
    return sb.Model("scene", parts, initial=initial, gravity=(0, 0, -G)), mus


FAST, ALL = range(3), range(3, 40)


@pytest.mark.parametrize("seed", [*FAST, *(pytest.param(k, marks=pytest.mark.exhaustive) for k in ALL)])
def test_laws_hold_on_random_scenes(seed: int) -> None:
    """At ends of steps: gaps are closed to tolerance, forces are in their cones and press where shapes were to
    meet in that step. Energy is lost alone, but for what displacements and spin make of a step, of which there
    are ten between samples; all of it is work, up to errors of order 1."""
    h, (model, mus) = 5e-4, scene(seed)
    run = sb.simulate(sb.form_equations(model), 0.5, integrator=steps(h), times=np.linspace(0, 0.5, 101))
    assert run.success, run.notes
    residual = run.statistics.residual
    assert residual is not None and residual < 1e-3
    assert (residual <= 1e-10) is not any("miss their laws" in note for note in run.notes)
    energy, mass = run["energy"], sum(float(body.mass.text) for body in model.bodies)
    fastest = np.sqrt(2 * run["kinetic_energy"].max() / 0.5)
    assert np.diff(energy).max() < 10 * mass * (G * h) ** 2 / 2 + 1e-6 * energy[0]
    assert np.diff(run["work"]).max() < 10 * mass * (G * h) ** 2
    assert abs(run.energy_drift) < 2 * mass * G * fastest * h
    for name, mu in mus.items():
        gap, force = run[f"gap {name}"], run[f"contact_force {name}"]
        assert gap.min() > -1e-9
        assert force[2].min() >= 0.0
        assert (np.hypot(force[0], force[1]) - mu * force[2]).max() <= 1e-9 * (1 + np.abs(force).max())
        assert gap[force[2] > 0.0].max(initial=0.0) < 3 * fastest * h


@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.exhaustive) for k in range(3, 12))])
def test_the_order_of_bodies_and_contacts_means_nothing(seed: int) -> None:
    """Up to the tolerance, which impacts and stick-slip magnify."""
    one, two = (sb.form_equations(scene(seed, shuffled=shuffled)[0]) for shuffled in (False, True))
    first, second = (sb.simulate(eqs, 0.2, integrator=steps(1e-3), times=[0, 0.2]) for eqs in (one, two))
    for name in one.coordinate_names:
        assert second[name][-1] == pytest.approx(first[name][-1], abs=1e-6)


def bowl(count: int, mu: float | None = 0.3) -> sb.EquationSet:
    """Balls in a hollow sphere of 1 m."""
    parts: list[Any] = []
    initial: dict[str, float] = {}
    side = int(np.ceil(count ** (1 / 3) - 1e-9))
    chance = random.Random(1)
    for k in range(count):
        parts.append(sb.Free(f"move{k}", "ground", sb.Body(f"Ball{k}", mass=1, inertia=(0.4 * R**2,) * 3)))
        for c, i in zip("xyz", (k % side, k // side % side, k // side**2), strict=True):
            initial[f"move{k}_{c}"] = (i - (side - 1) / 2) * 2.2 * R + chance.uniform(-0.005, 0.005)
    friction = None if mu is None else sb.Friction(mu=mu)
    shapes: list[Any] = [{"socket": 1.0}, {"sphere": R}]
    pair: list[Any] = [{"sphere": R}, {"sphere": R}]
    parts.append(sb.Contact("bowl", "ground", "Ball*", shapes, normal="rigid", friction=friction))
    parts.append(sb.Contact("pair", "Ball*", "Ball*", pair, normal="rigid", friction=friction))
    return sb.form_equations(sb.Model("balls", parts, gravity=(0, 0, -G), initial=initial))


@pytest.mark.parametrize("count", [4, *(pytest.param(k, marks=pytest.mark.exhaustive) for k in (8, 27, 64))])
def test_balls_in_a_bowl_come_to_rest(count: int) -> None:
    """Nothing resists rolling, so that friction alone does not stop a ball: most of the energy is lost."""
    h, end = 2e-3, 4.0
    tolerance = 1e-10 if count < 10 else 1e-6
    run = sb.simulate(
        bowl(count), end, integrator=steps(h, tolerance=tolerance), times=np.linspace(0, end, 41)
    )
    assert run.success
    kinetic, energy = run["kinetic_energy"], run["energy"]
    assert kinetic[-5:].max() < 0.02 * kinetic.max()
    assert np.diff(energy).max() < count * (G * h) ** 2 / 2
    places = np.array([run[f"frame r Ball{k}"] for k in range(count)])  # (count, 3, N)
    assert np.linalg.norm(places, axis=1).max() < 0.9 + 1e-9
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + np.eye(count)[:, :, None]
    assert apart.min() > 2 * R - 1e-9


# One point


@pytest.mark.parametrize("seed", range(200))
def test_a_point_obeys_coulombs_law(seed: int) -> None:
    """For any symmetric positive response and any rates: it opens, sticks, or slips against its impulse."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 4))
    A[2] *= 10.0 ** rng.uniform(-3, 0)
    response, b, mu = A @ A.T, rng.normal(size=3), float(rng.uniform(0, 1.5))
    if seed % 3:
        b[0] = -abs(b[0])
    P = Reals([0.0] * 3)
    share = solve_point(
        3, 1, mu, mu, 0.0, Reals(response.ravel().tolist()), Reals(b.tolist()),
        float(rng.choice([0.0, 1e-200, 0.3, 1.0])), P, Reals([0.0] * SCRATCH),
    )  # fmt: skip
    impulse = np.array([P[k] for k in range(3)])
    rate = b + response @ impulse
    size = np.abs(b).max()
    if b[0] >= 0:
        assert not impulse.any()
        return
    assert impulse[0] > 0 and abs(rate[0]) < 1e-9 * size
    across = np.linalg.norm(impulse[1:])
    assert across <= mu * impulse[0] * (1 + 1e-9)
    slip = np.linalg.norm(rate[1:])
    if slip > 1e-9 * size:
        assert share > 0 or mu == 0
        assert across == pytest.approx(mu * impulse[0], rel=1e-9)
        assert rate[1:] @ impulse[1:] == pytest.approx(-slip * across, rel=1e-6)


# What composes, and what does not


def test_times_events_and_files() -> None:
    eqs = ball(0.3, e=0.6)
    start = {"move_z": 0.5, "move_vx": 1.0}
    whole = sb.simulate(eqs, 1.0, start, integrator=steps(1e-3))
    some = sb.simulate(eqs, 1.0, start, integrator=steps(1e-3), times=np.linspace(0, 1, 7))
    for name in ("move_z", "contact_force floor", "gap floor"):
        assert some[name] == pytest.approx(whole.at(some.t)[name], abs=1e-12)
    ended = sb.simulate(
        eqs, 1.0, start, integrator=steps(1e-3), events=sb.Event("move_x - 0.2", action="stop")
    )
    assert ended.status is sb.Status.STOPPED and ended["move_x"][-1] == pytest.approx(0.2)
    turned = sb.simulate(
        eqs,
        1.0,
        start,
        integrator=steps(1e-3),
        events=sb.Event("move_x - 0.2", action={"move_vx": "-move_vx"}),
    )
    assert turned.success and turned["move_x"].max() == pytest.approx(0.2)
    assert turned["contact_force floor"][2].max() > 100.0


def test_an_event_on_a_force_is_refused() -> None:
    with pytest.raises(sb.UsageError, match="simulation.impulse_event"):
        sb.simulate(ball(0.3), 1.0, integrator=steps(1e-3), events=sb.Event("'contact_force floor z' - 5"))


def test_a_sampled_force_follows_the_motion() -> None:
    rail = sb.Prismatic(
        "rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x",
        limits=sb.Limits(high=1, rigid=True, restitution=0.5), force=sb.Drive(applied="F"),
    )  # fmt: skip
    law = sb.Signal("F", "-2*(x - 2) - x_dot", sample=0.01)
    eqs = sb.form_equations(sb.Model("cart", [rail, law], initial={"x": 0.5}))
    run = sb.simulate(eqs, 4.0, integrator=steps(1e-3))
    assert run["x"][-1] == pytest.approx(1.0, abs=1e-5) and run["F"][-1] == pytest.approx(2.0, abs=1e-4)
    assert run["opening_effort rail high"][-1] == pytest.approx(2.0, abs=1e-4)
    assert run.statistics.residual is not None and run.statistics.residual <= 1e-10


def test_steppers_and_sweeps_take_the_same_steps() -> None:
    eqs = ball(0.3, e=0.6)
    run = sb.simulate(eqs, 0.5, {"move_z": 0.5}, integrator=steps(1e-3))
    stepper = sb.Stepper(eqs, 0.01, initial={"move_z": 0.5}, integrator=steps(1e-3))
    for _ in range(50):
        stepper.step()
    assert stepper["move_z"] == pytest.approx(run["move_z"][-1], abs=1e-12)


@pytest.mark.parametrize(
    ("friction", "end", "constraints", "code"),
    [
        (sb.Friction(mu=0.3, v0=1e-3), 1.0, None, "simulation.impulse_friction"),
        (sb.Friction(mu=0.3), (1.0, 0.0), None, "simulation.impulses_backwards"),
        (sb.Friction(mu=0.3), 1.0, sb.Baumgarte(), "simulation.combination"),
    ],
)
def test_what_does_not_compose_is_refused(
    friction: sb.Friction, end: Any, constraints: Any, code: str
) -> None:
    body = sb.Body("Ball", mass=1, inertia=(0.4 * R**2,) * 3)
    floor = sb.Contact("floor", "ground", body, ["plane", {"sphere": R}], normal="rigid", friction=friction)
    eqs = sb.form_equations(sb.Model("ball", [sb.Free("move", "ground", body), floor], initial={"move_z": 1}))
    with pytest.raises(sb.UsageError, match=code):
        sb.simulate(eqs, end, integrator=steps(1e-3), constraints=constraints)


def test_a_jump_of_prescribed_rates_is_refused() -> None:
    crane = sb.Prismatic(
        "crane", "ground", sb.Body("C", mass=1), axis="x", coordinate="x", motion="if(t < 1, 0, t - 1)"
    )
    load = sb.Prismatic("load", "C", sb.Body("L", mass=1), axis="x", coordinate="s")
    eqs = sb.form_equations(sb.Model("crane", [crane, load]))
    with pytest.raises(sb.UsageError, match="simulation.impulse_jumps"):
        sb.simulate(eqs, 2.0, integrator=steps(1e-3))


@pytest.mark.parametrize(
    "wrong", [{"step": 0.0}, {"step": 1e-3, "tolerance": -1.0}, {"step": 1e-3, "sweeps": 0}]
)
def test_numbers_that_make_no_sense_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(sb.UsageError, match="simulation.moreau_jean"):
        sb.MoreauJean(**wrong)


def test_too_few_sweeps_are_told() -> None:
    run = sb.simulate(
        box(0.5, (0.4, 0.2, 0.3), e=0.3), 1.0, {"move_z": 0.5, "move_wx": 3.0, "move_wy": 1.0},
        integrator=steps(1e-3, sweeps=2),
    )  # fmt: skip
    assert run.success
    assert any("miss their laws by more than the tolerance" in note for note in run.notes)
