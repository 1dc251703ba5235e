"""Rigid contacts: rolling, sliding, impacts with friction and rest, against closed forms and published values."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import symbody as sb
from symbody.kernels.modes.mode_problem import LOOSE
from symbody.kernels.modes.mode_switch import SHOCK
from symbody.simulation.hybrid.mode_record import ModalElements, shock_notes
from symbody.simulation.status import Status
from tests.contacts.pairs import Floats

G = 9.81
R = 0.1
INERTIA = 0.4 * R**2


def ball_on_plane(mu: float, e: float = 0.0, slope: float = 0.0, *, planar: bool = False) -> sb.EquationSet:
    """Return a solid sphere of 1 kg over a plane, on a slope down along x."""
    ball = sb.Body("Ball", mass=1, inertia=(INERTIA,) * 3)
    friction = sb.Friction(mu=mu) if mu else None
    floor = sb.Contact(
        "floor", "ground", ball, ["plane", {"sphere": R}], normal="rigid", restitution=e, friction=friction
    )
    joint = sb.Planar("move", "ground", ball, axis="y") if planar else sb.Free("move", "ground", ball)
    gravity = (G * np.sin(slope), 0, -G * np.cos(slope))
    return sb.form_equations(sb.Model("ball", [joint, floor], gravity=gravity))


def first(eqs: sb.EquationSet, height: float, v: tuple[float, ...], w: tuple[float, ...]) -> dict[str, float]:
    """Return the first values of a ball: height of its lowest point, velocity and angular velocity."""
    if len(eqs.coordinate_names) == 3:  # z, x and the angle about y
        values = [R + height, 0.0, 0.0, v[2], v[0], w[1]]
    else:
        values = [0.0, 0.0, R + height, 1.0, 0.0, 0.0, 0.0, *v, *w]
    return dict(zip((*eqs.coordinate_names, *eqs.speed_names), map(float, values), strict=True))


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("share", [0.8, 1.25])
def test_a_sphere_on_a_slope_rolls_with_enough_friction_and_slides_with_less(
    share: float, planar: bool
) -> None:
    slope = 0.4
    mu = share * 2 / 7 * np.tan(slope)
    eqs = ball_on_plane(mu, slope=slope, planar=planar)
    run = sb.simulate(eqs, 1.0, first(eqs, 0.0, (0, 0, 0), (0, 0, 0)), rtol=1e-10)
    rolls = share > 1
    expected = 5 / 7 * G * np.sin(slope) if rolls else G * (np.sin(slope) - mu * np.cos(slope))
    x = eqs.coordinate_names[1 if planar else 0]
    assert 2 * run[x][-1] == pytest.approx(expected, rel=1e-8)
    assert run.modes[0].mode.startswith("sticks" if rolls else "slips")
    assert run["contact_force floor"][2] == pytest.approx(G * np.cos(slope), rel=1e-9)
    assert np.abs(run["slip floor"][0, -1]) < 1e-9 if rolls else run["slip floor"][0, -1] > 0.1


def test_a_ball_thrown_with_spin_slides_and_then_rolls() -> None:
    eqs, mu = ball_on_plane(0.2), 0.2
    v, w = np.array([1.0, 0.0, 0.0]), np.array([5.0, -3.0, 2.0])
    run = sb.simulate(eqs, 1.0, first(eqs, 0.0, (*v,), (*w,)), rtol=1e-10)
    slip = (v + np.cross(w, (0, 0, -R)))[:2]
    (stuck,) = (event.t for event in run.events if event.name == "floor friction sticks")
    assert stuck == pytest.approx(2 * np.linalg.norm(slip) / (7 * mu * G), rel=1e-7)
    assert run.u[:2, -1] == pytest.approx(v[:2] - 2 / 7 * slip, rel=1e-6)
    assert abs(run.energy_drift) < 1e-8


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize(("mu", "e"), [(0.05, 0.5), (0.05, 0.0), (0.6, 0.5), (0.6, 0.9), (0.0, 0.7)])
def test_an_impact_with_friction_is_that_of_a_sphere(mu: float, e: float, planar: bool) -> None:
    eqs = ball_on_plane(mu, e, planar=planar)
    v = np.array([1.0, 0.0 if planar else -0.5, 0.0])
    w = np.array([0.0, -4.0, 0.0]) if planar else np.array([3.0, -4.0, 2.0])
    run = sb.simulate(eqs, 0.3, first(eqs, 0.3, (*v,), (*w,)), rtol=1e-10)
    slip = (v + np.cross(w, (0, 0, -R)))[:2]
    fall = np.sqrt(2 * G * 0.3)
    impulse = min(2 / 7 * np.linalg.norm(slip), mu * (1 + e) * fall)
    change = -impulse * slip / np.linalg.norm(slip)
    place = next(k for k, event in enumerate(run.events) if event.name == "floor impact")
    t = run.events[place].t
    after = run.at(t + 1e-9)
    names = eqs.speed_names
    moved = (names[1],) if planar else names[:2]
    assert [after[name] for name in moved] == pytest.approx((v[:2] + change)[: len(moved)], abs=1e-6)
    assert after[names[0 if planar else 2]] == pytest.approx(e * fall, abs=1e-6)
    assert abs(run.energy_drift) < 1e-9


def block(e: float = 0.0, mu: float = 0.7) -> sb.EquationSet:
    """Return a block of 0.2 by 0.5 m in its plane."""
    inertia = (0.2**2 + 0.5**2) / 12
    box = sb.Body("Box", mass=1, inertia=(inertia,) * 3)
    floor = sb.Contact(
        "floor", "ground", box, ["plane", {"box": [0.2, 0.1, 0.5]}], normal="rigid", restitution=e,
        friction=sb.Friction(mu=mu),
    )  # fmt: skip
    joint = sb.Planar("move", "ground", box, axis="y", coordinates=["z", "x", "tilt"])
    return sb.form_equations(sb.Model("block", [joint, floor], gravity=(0, 0, -G)))


def test_a_rocking_block_loses_what_housner_says() -> None:
    tilt = 0.1
    start = {"tilt": tilt, "z": 0.25 * np.cos(tilt) + 0.1 * np.sin(tilt), "x": 0.0}
    run = sb.simulate(block(), 0.5, start, rtol=1e-10)
    strikes = [event for event in run.events if event.name.endswith("impact")]
    t = strikes[0].t
    rates = strikes[0].state["tilt_dot"], float(run.at(t + 1e-9)["tilt_dot"])
    assert rates[1] / rates[0] == pytest.approx(1 - 1.5 * np.sin(np.arctan(0.2 / 0.5)) ** 2, rel=1e-6)


def test_a_block_at_rest_stays_where_it_is() -> None:
    run = sb.simulate(block(), 1000.0, {"tilt": 0.0, "z": 0.25, "x": 0.0})
    assert np.abs(run["x"]).max() < 1e-9 and np.abs(run["z"] - 0.25).max() < 1e-9
    assert run["contact_force floor"][2] == pytest.approx(G, rel=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_impacts_in_several_points_never_raise_the_energy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    eqs = block(e=float(rng.uniform(0, 1)), mu=float(rng.uniform(0.05, 1.2)))
    tilt = float(rng.uniform(-1.2, 1.2))
    start = {
        "tilt": tilt,
        "z": 0.6,
        "x": 0.0,
        "x_dot": float(rng.normal()),
        "tilt_dot": float(3 * rng.normal()),
    }
    run = sb.simulate(eqs, 1.5, start, max_steps=20_000)
    assert run.success
    energy = run["energy"]
    assert np.diff(energy).max() <= 1e-7 * np.abs(energy).max()
    assert run["gap floor"].min() > -1e-7
    force = run["contact_force floor"]
    assert force[2].min() >= -1e-6


def rod(mu: float) -> sb.EquationSet:
    """Return a uniform rod of 1 m whose tip touches the ground."""
    body = sb.Body("Rod", mass=1, inertia=(1 / 12,) * 3, frames={"tip": sb.Frame(at=(-0.5, 0, 0))})
    joint = sb.Planar("move", "ground", body, axis="y", coordinates=["z", "x", "a"])
    tip = sb.Contact(
        "tip", "ground", "Rod.tip", ["plane", "point"], normal="rigid", friction=sb.Friction(mu=mu)
    )
    return sb.form_equations(sb.Model("rod", [body, joint, tip], gravity=(0, 0, -G)))


@pytest.mark.parametrize("share", [0.5, 0.97, 1.03, 2.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_painleves_rod_has_no_motion_beyond_its_coefficient(share: float, way: float) -> None:
    p = np.arctan(2.0)
    singular = (1 + 3 * np.cos(p) ** 2) / (3 * np.sin(p) * np.cos(p))
    start = {"a": -p, "z": 0.5 * np.sin(p), "x": 0.0, "x_dot": way, "z_dot": 0.0, "a_dot": 0.0}
    run = sb.simulate(rod(share * singular), 0.01, start)
    assert run.status is (Status.FRICTION if share > 1 and way < 0 else Status.SUCCESS)
    if run.success:
        mu = way * share * singular  # friction along -x turns the rod into the ground where it slips back
        s, c = np.sin(p), np.cos(p)
        assert run["contact_force tip"][2, 0] == pytest.approx(G / (1 + 3 * c * (c + mu * s)), rel=1e-9)


def table(short: float, mu: float) -> sb.EquationSet:
    """Return a table of 10 kg whose first leg is too short."""
    corners = [(0.4, 0.3), (0.4, -0.3), (-0.4, 0.3), (-0.4, -0.3)]
    frames = {f"f{k}": sb.Frame(at=(x, y, -0.5 + (0 if k else short))) for k, (x, y) in enumerate(corners)}
    top = sb.Body("Top", mass=10, inertia=(1, 1.2, 1.5), frames=frames)
    legs = [
        sb.Contact(
            f"leg{k}", "ground", f"Top.f{k}", ["plane", "point"], normal="rigid", friction=sb.Friction(mu=mu)
        )
        for k in range(4)
    ]
    return sb.form_equations(sb.Model("table", [top, *legs], gravity=(0, 0, -G)))


@pytest.mark.parametrize("short", [0.0, 0.01])
def test_a_table_that_falls_on_its_legs_rests_without_friction(short: float) -> None:
    eqs = table(short, 0.5)
    run = sb.simulate(eqs, 0.6, {"Top_z": 0.52, "Top_qw": 1.0, "Top_x": 0.0, "Top_y": 0.0})
    forces = np.array([run[f"contact_force leg{k}"][:, -1] for k in range(4)])
    assert run.success
    assert forces[:, :2] == pytest.approx(np.zeros((4, 2)), abs=1e-6)
    shares = [0, 0.5, 0.5, 0] if short else [0.25] * 4
    assert forces[:, 2] == pytest.approx(np.array(shares) * 10 * G, abs=1e-6)
    rest = sb.find_equilibrium(eqs, {"Top_z": 0.5})
    assert [float(rest[f"contact_force leg{k} z"]) for k in range(4)] == pytest.approx(forces[:, 2], abs=1e-6)


def scene(seed: int) -> tuple[sb.EquationSet, dict[str, float], dict[str, float]]:
    """Return balls over a floor and each other, their first values, and mu by contact."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    radii, masses = rng.uniform(0.05, 0.15, n), rng.uniform(0.2, 2.0, n)
    parts: list[sb.Body | sb.Free | sb.Contact] = []
    start: dict[str, float] = {}
    mus: dict[str, float] = {}

    def touch(name: str, *sides: str, shapes: list[object]) -> sb.Contact:
        mus[name] = float(rng.uniform(0.1, 0.9))
        e = float(rng.uniform(0.0, 0.8))
        friction = sb.Friction(mu=mus[name])
        return sb.Contact(name, *sides, shapes, normal="rigid", restitution=e, friction=friction)

    for k in range(n):
        inertia = 0.4 * masses[k] * radii[k] ** 2
        parts += [
            sb.Body(f"B{k}", mass=masses[k], inertia=(inertia,) * 3),
            sb.Free(f"f{k}", "ground", f"B{k}"),
        ]
        parts.append(touch(f"floor{k}", "ground", f"B{k}", shapes=["plane", {"sphere": radii[k]}]))
        parts += [
            touch(f"c{j}{k}", f"B{j}", f"B{k}", shapes=[{"sphere": radii[j]}, {"sphere": radii[k]}])
            for j in range(k)
        ]
        place = (*rng.uniform(-0.1, 0.1, 2), 0.35 * k + radii[k] + rng.uniform(0.01, 0.05))
        start |= {f"f{k}_{c}": float(x) for c, x in zip("xyz", place, strict=True)}
        start |= {f"f{k}_q{c}": float(c == "w") for c in "wxyz"}
        start |= {f"f{k}_v{c}": float(rng.normal()) for c in "xyz"}
        start |= {f"f{k}_w{c}": float(5 * rng.normal()) for c in "xyz"}
    return sb.form_equations(sb.Model("scene", parts, gravity=(0, 0, -G))), start, mus


@pytest.mark.parametrize(
    "seed", [*range(3), *(pytest.param(k, marks=pytest.mark.exhaustive) for k in range(3, 30))]
)
def test_random_balls_keep_the_laws_of_contacts(seed: int) -> None:
    eqs, start, mus = scene(seed)
    run = sb.simulate(eqs, 1.5, start, rtol=1e-9, max_steps=50_000)
    assert run.success, run.notes
    energy = run["energy"]
    assert np.diff(energy).max() <= 1e-6 * np.abs(energy).max()
    assert abs(run.energy_drift) < 1e-5
    for name, mu in mus.items():
        gap, force = run[f"gap {name}"], run[f"contact_force {name}"]
        assert gap.min() > -1e-6
        assert force[2].min() > -1e-6
        assert (np.hypot(force[0], force[1]) - mu * force[2]).max() <= 1e-6 * (1 + np.abs(force).max())
        assert np.abs(force[2] * np.maximum(gap, 0.0)).max() < 1e-6 * (1 + force[2].max())


@pytest.mark.parametrize(("across", "along"), list(permutations("xyz", 2)))
def test_what_is_pressed_against_a_guided_body_holds_it(across: str, along: str) -> None:
    """With 9.81 N of friction, for each direction of the normal: its axes are others where x is along it."""
    bodies = [sb.Body("Guided", mass=1), sb.Body("Presses", mass=0.05)]
    parts = [
        *bodies,
        sb.Prismatic("guide", "ground", bodies[0], axis=along, coordinate="q"),
        sb.Prismatic("press", "ground", bodies[1], axis=across, coordinate="p", force=sb.Drive(applied="40")),
        sb.Contact("touch", bodies[1], bodies[0], ["point", {"sphere": R}], normal="rigid",
                   friction=sb.Friction(mu=0.6)),
    ]  # fmt: skip
    weight = tuple(-G * float(axis == along) for axis in "xyz")
    run = sb.simulate(
        sb.form_equations(sb.Model("pressed", parts, gravity=weight, initial={"p": -R})), 1.0, rtol=1e-9
    )
    assert [(change.name, change.mode) for change in run.modes] == [
        ("touch friction", "sticks"),
        ("touch", "closed"),
    ]
    assert run["q"] == pytest.approx(0, abs=1e-12)
    x, y, pressed = run["contact_force touch"]
    assert np.hypot(x, y) == pytest.approx(G, rel=1e-9) and pressed == pytest.approx(40, rel=1e-9)


@pytest.mark.parametrize("mu", [0.0, 0.5])
@pytest.mark.parametrize("speed", [0.0, 1.0])
@pytest.mark.parametrize("integrator", [None, sb.Stiff()], ids=["", "Stiff"])
def test_feet_whose_forces_end_together_let_go_together(
    mu: float, speed: float, integrator: sb.Stiff | None
) -> None:
    """A body on two feet, lifted by 20 t: off the floor at t = g/20, none of its feet pulls."""
    body = sb.Body(
        "B", mass=1, inertia=(0.1,) * 3, frames={"l": sb.Frame((-R, 0, -R)), "r": sb.Frame((R, 0, -R))}
    )
    friction = sb.Friction(mu=mu) if mu else None
    parts = [
        body,
        sb.Planar("move", "ground", body, axis="y", coordinates=["z", "x", "turn"]),
        *(
            sb.Contact(n, "ground", f"B.{n}", ["plane", "point"], normal="rigid", friction=friction)
            for n in "lr"
        ),
        sb.Force("lift", on="B", vector=[0, 0, "20*t"]),
    ]
    eqs = sb.form_equations(sb.Model("lifted", parts, gravity=(0, 0, -G)))
    run = sb.simulate(eqs, 1.0, {"z": R, "x_dot": speed}, rtol=1e-10, integrator=integrator)
    flies = 1 - G / 20
    assert [event.t for event in run.events if event.name in ("l open", "r open")] == pytest.approx(
        [G / 20] * 2
    )
    assert run["z"][-1] == pytest.approx(R + 20 * flies**3 / 6, abs=1e-9)
    assert min(run[f"contact_force {n}"][2].min() for n in "lr") > -1e-9


def test_what_a_rigid_contact_cannot_have_is_refused() -> None:
    for friction in (sb.Friction(mu=0.3, radius=0.1), sb.Friction(mu=0.3, mu_y=0.2)):
        with pytest.raises(sb.ModelError, match="contact.friction"):
            sb.Contact("c", "ground", "B", ["plane", "point"], normal="rigid", friction=friction)
    with pytest.raises(sb.ModelError, match="restitution"):
        sb.Contact(
            "c", "ground", "B", ["plane", "point"], normal=sb.NormalForce(stiffness=1), restitution=0.5
        )
    with pytest.raises(sb.ModelError, match="rigid"):
        sb.Contact("c", "ground", "B", ["plane", "point"], normal="stiff")


def test_the_mode_of_a_gap_is_open_or_closed() -> None:
    eqs = ball_on_plane(0.2)
    run = sb.simulate(eqs, 0.5, first(eqs, 0.3, (0, 0, 0), (0, 0, 0)))
    assert run["mode floor"][0] == 0.0 and run["mode floor"][-1] == float(LOOSE)


def test_a_box_that_comes_to_rest_by_bounces_stays_there() -> None:
    """Where its corners close for good the speeds change, and with them the direction in which it slips."""
    inertia = 2.0 * (0.4**2 + 0.3**2) / 12
    box = sb.Body("Box", mass=2, inertia=(inertia,) * 3)
    floor = sb.Contact(
        "floor", "ground", box, ["plane", {"box": [0.4, 0.2, 0.3]}], normal="rigid", restitution=0.3,
        friction=sb.Friction(mu=0.5),
    )  # fmt: skip
    joint = sb.Planar("move", "ground", box, axis="y", coordinates=["z", "x", "tilt"])
    model = sb.Model("box", [joint, floor], gravity=(0, 0, -G))
    start = {"z": 0.6, "x": 0.0, "tilt": 0.5, "x_dot": 1.0, "tilt_dot": -1.0}
    run = sb.simulate(sb.form_equations(model), 2.0, start, rtol=1e-10)
    assert np.diff(run["energy"]).max() <= 1e-7 * run["energy"].max()
    rest = run.t > 0.6
    assert np.ptp(run["x"][rest]) < 1e-9 and np.abs(run["z"][rest] - 0.15).max() < 1e-9
    assert np.abs(run.u[:, -1]).max() < 1e-9


@pytest.mark.parametrize("output", ["contact_force flor", "contact_force flor z", "slip flor", "gap flor"])
def test_an_output_of_a_contact_that_is_not_there_is_no_zero(output: str) -> None:
    with pytest.raises(sb.FormulationError, match="flor"):
        sb.compile(ball_on_plane(0.2), output)


def flat_box() -> sb.EquationSet:
    """A box of 1 kg that moves in a vertical plane, above the floor."""
    box = sb.Body("Box", mass=1, inertia=(0.1, 0.1, 0.1))
    floor = sb.Contact("floor", "ground", box, ["plane", {"box": (0.4, 0.2, 0.2)}], normal="rigid")
    joint = sb.Planar("move", "ground", box, axis="y", coordinates=["z", "x", "turn"])
    return sb.form_equations(sb.Model("box", [joint, floor], gravity=(0, 0, -9.81)))


def test_a_box_lies_flat_on_the_corners_of_a_face() -> None:
    """Four corners, two and two in one place: each bears a quarter; on one edge alone the box would fall."""
    rest = sb.find_equilibrium(flat_box(), {"z": 0.3, "turn": 0.0})
    assert rest.q == pytest.approx({"z": 0.1, "x": 0.0, "turn": 0.0}, abs=1e-12)
    efforts = [float(rest[f"opening_effort floor {k}"]) for k in range(1, 9)]
    assert sorted(efforts) == pytest.approx([0, 0, 0, 0, *[9.81 / 4] * 4])
    assert sum("closed with 2.4525" in note for note in rest.notes) == 4


def test_symmetric_limits_do_not_close_together() -> None:
    """An inverted pendulum midway between its limits leans on either."""
    arm = sb.Body("Arm", mass=1, inertia=(1, 1, 1), frames={"pin": sb.Frame(at=(0, 0, -1))})
    pin = sb.Revolute("pin", "ground", "Arm.pin", axis="y", coordinate="a",
                      limits={"low": -0.5, "high": 0.5, "rigid": True})  # fmt: skip
    rest = sb.find_equilibrium(sb.form_equations(sb.Model("m", [arm, pin], gravity=(0, 0, -10))), {"a": 0})
    found = {round(one.q["a"], 9): one.verdict for one in (rest, *rest.branches)}
    assert found == {0.0: "unstable", 0.5: "stable", -0.5: "stable"}


def test_an_edge_whose_corners_coincide_is_no_edge_between_two_modes() -> None:
    """On a lower edge of the box two corners share the weight, and it falls over to either side."""
    rest = sb.find_equilibrium(flat_box(), {"z": 0.223, "turn": 1.1})
    assert rest.q["z"] == pytest.approx(np.hypot(0.2, 0.1)) and rest.verdict == "unstable"
    efforts = [float(rest[f"opening_effort floor {k}"]) for k in range(1, 9)]
    assert sorted(efforts) == pytest.approx([*[0] * 6, 9.81 / 2, 9.81 / 2])
    assert not any("without effort" in note for note in rest.notes)


def test_contacts_are_called_contacts_and_their_points_points() -> None:
    eqs = flat_box()
    assert any(note.startswith("contact floor: the equations are for") for note in eqs.notes)
    rest = sb.find_equilibrium(eqs, {"z": 0.3, "turn": 0.0})
    assert sum("contact floor, point " in note and "2.4525 N" in note for note in rest.notes) == 4
    with pytest.raises(sb.UsageError, match="whether a contact is open") as refusal:
        sb.inverse_dynamics(eqs, {"z": "0.1", "x": 0, "turn": 0}, [], [0.0])
    assert str(refusal.value).count("contact floor, point 1") == 1
    with pytest.raises(sb.FormulationError, match="no rope, stop or rigid contact"):
        sb.compile(eqs, "gap_ddot flor")
    assembled = sb.assemble(eqs, {"z": 0.1, "turn": 0.0})
    linear = sb.linearize(eqs, at=assembled.q)
    assert not any("stop" in note for note in linear.notes)


def test_impacts_of_contacts_and_shocks_of_ropes_are_told_apart() -> None:
    """A ball on a rope that bounces on the floor."""
    ball = sb.Body("Ball", mass=1)
    rail = sb.Prismatic("rail", "ground", ball, axis="z", coordinate="z")
    floor = sb.Contact("floor", "ground", ball, ["plane", "point"], normal="rigid", restitution=0.9)
    rope = sb.Distance("rope", "ground.top", ball, 1.2, rope=True)
    model = sb.Model("ball", [rail, floor, rope], gravity=(0, 0, -G), ground={"top": sb.Frame(at=(0, 0, 1))})
    run = sb.simulate(sb.form_equations(model), 1.0, {"z": 0.5})
    (told,) = [note for note in run.notes if "impact" in note]
    assert told.startswith("contact floor: ") and "impacts, the last at" in told
    both = ModalElements((), ("r", "floor"), ("rope", "stop"), ("rope r", "contact floor"))
    shocks, strikes = shock_notes(np.array([[SHOCK, 0.5, 1.0, 2.0, 3.0]]), both)
    assert shocks == "at t = 0.5 s ropes go taut with an impact: r by 2 N s; 1 J are lost"
    assert strikes.startswith("contact floor: an impact, the last at t = 0.5 s")


def test_efforts_that_vanish_beside_others_are_0() -> None:
    """Two points on the floor: of one a force bears the weight of 29.43 N, up to rounding."""
    parts: list[Any] = []
    for name, force in (("borne", sb.Drive(applied="F")), ("lying", None)):
        ball = sb.Body(name, mass=3)
        parts += [
            sb.Prismatic(f"rail {name}", "ground", ball, axis="z", coordinate=f"z_{name}", force=force),
            sb.Contact(f"floor {name}", "ground", ball, ["plane", "point"], normal="rigid"),
        ]
    model = sb.Model("m", parts, gravity=(0, 0, -9.81), parameters={"F": 29.43 - 2e-14})
    eqs, at = sb.form_equations(model), {"z_borne": 0, "z_lying": 0}
    assert 0.0 < abs(float(sb.assemble(eqs, at)["opening_effort floor borne"])) < 1e-13
    notes = sb.linearize(eqs, at=at).notes
    assert any("contact floor borne is closed with 0 N" in note for note in notes)
    assert any("contact floor lying is closed with 29.43 N" in note for note in notes)
    assert any("contact floor borne switches at this state" in note for note in notes)


PUSH, MU_PUSHED = "6*cos(5*t)", 0.1
PUSHED_TIMES = np.linspace(0.0, 2.0, 41)


def pushed_body() -> sb.EquationSet:
    """Return a body that does not turn, on two carriers, pushed along x and y over a floor."""
    carriers = [sb.Body(name, mass=0.01) for name in ("C1", "C2")]
    body = sb.Body("B", mass=1)
    parts = [
        sb.Prismatic("px", "ground", carriers[0], axis="x", coordinate="x"),
        sb.Prismatic("py", *carriers, axis="y", coordinate="y"),
        sb.Prismatic("pz", carriers[1], body, axis="z", coordinate="z"),
        sb.Contact("floor", "ground", body, ["plane", {"sphere": R}], normal="rigid",
                   friction=sb.Friction(mu="mu")),
        sb.Force("push", on=body, vector=["F", "0.3*sin(3*t)", 0]),
    ]  # fmt: skip
    start = {"z": R, "x_dot": -0.5, "y_dot": 0.01}
    model = sb.Model(
        "pushed", parts, gravity=(0, 0, -G), inputs=["F"], parameters={"mu": MU_PUSHED}, initial=start
    )
    return sb.form_equations(model)


def check_pushed(place: Floats, velocity: Floats, force: Floats, within: float) -> None:
    """Compare places (2, N), velocities and forces on the way with laws and with SciPy."""
    weight = MU_PUSHED * G

    def rates(t: float, y: Floats) -> list[float]:
        friction = weight * y[2:] / np.hypot(*y[2:])
        push = 6 * np.cos(5 * t), 0.3 * np.sin(3 * t)
        return [y[2], y[3], (push[0] - friction[0]) / 1.02, (push[1] - friction[1]) / 1.01]

    hand: Any = solve_ivp(rates, (0, 2), [0, 0, -0.5, 0.01], "DOP853", PUSHED_TIMES, rtol=1e-11, atol=1e-13)
    times = place.shape[1]  # steppers have no sample at 0
    assert np.count_nonzero(np.diff(np.sign(hand.y[2]))) >= 3  # its heading turns around
    assert force[2] == pytest.approx(np.full(times, G), rel=1e-9)
    np.testing.assert_allclose(force[:2], -weight * velocity / np.hypot(*velocity), rtol=0, atol=1e-12)
    np.testing.assert_allclose(place, hand.y[:2, -times:], rtol=0, atol=within)


def python_push(t: float, *_: object) -> float:
    return float(6 * np.cos(5 * t))


@pytest.mark.parametrize("law", [PUSH, python_push], ids=["formula", "Python"])
@pytest.mark.parametrize(
    ("integrator", "within"),
    [(sb.Explicit(), 1e-7), (sb.Stiff(), 1e-6), (sb.GeneralizedAlpha(), 1e-5)],
    ids=["Explicit", "Stiff", "GeneralizedAlpha"],
)
def test_friction_opposes_slip_of_any_heading(
    integrator: sb.Explicit | sb.Stiff | sb.GeneralizedAlpha, within: float, law: str | Callable[..., float]
) -> None:
    """Errors are those of the methods at rtol = 1e-8; the force follows the velocity to rounding."""
    eqs = pushed_body()
    run = sb.simulate(eqs, 2.0, times=PUSHED_TIMES, inputs={"F": law}, integrator=integrator, rtol=1e-8)
    check_pushed(run.q[:2], run.u[:2], run["contact_force floor"], within)


@pytest.mark.parametrize("law", [PUSH, python_push], ids=["formula", "Python"])
def test_friction_opposes_slip_in_sweeps(law: str | Callable[..., float]) -> None:
    runs = sb.sweep(
        pushed_body(), 2.0, {"mu": [MU_PUSHED, 0.2]}, times=PUSHED_TIMES, inputs={"F": law}, rtol=1e-8
    )
    place, velocity = ([runs[name][0] for name in names] for names in (("x", "y"), ("x_dot", "y_dot")))
    check_pushed(np.array(place), np.array(velocity), runs["contact_force floor"][0], 1e-7)


@pytest.mark.parametrize("lanes", [0, 2])
def test_friction_opposes_slip_in_steppers(lanes: int) -> None:
    eqs = pushed_body()
    stepper: Any
    if lanes:
        stepper = sb.LaneStepper(eqs, 0.05, lanes, inputs={"F": PUSH})
    else:
        stepper = sb.Stepper(eqs, 0.05, inputs={"F": PUSH})
    samples = []
    for _ in PUSHED_TIMES[1:]:
        stepper.step()
        force = np.atleast_2d(stepper["contact_force floor"])[0]
        samples.append([*np.atleast_2d(stepper.q)[0, :2], *np.atleast_2d(stepper.u)[0, :2], *force])
    place, velocity, force = np.split(np.transpose(samples), [2, 4])
    check_pushed(place, velocity, force, 1e-7)


def thrown_boxes(chosen: Collection[int]) -> Iterator[tuple[sb.Trajectory, Floats]]:
    """Yield some motions of a box thrown at random onto a floor, with its energy [J]; the floor is 0."""
    mass, edges = 2.0, np.array([0.4, 0.2, 0.3])
    inertia = mass / 12 * (np.sum(edges**2) - edges**2)
    box = sb.Body("Box", mass=mass, inertia=tuple(inertia))
    floor = sb.Contact(
        "floor", "ground", box, ["plane", {"box": list(edges)}],
        normal="rigid", restitution=0.3, friction=sb.Friction(mu=0.3),
    )  # fmt: skip
    eqs = sb.form_equations(sb.Model("box", [sb.Free("move", "ground", box), floor], gravity=(0, 0, -9.81)))
    rng = np.random.default_rng(1)
    for k in range(30):
        angles, velocity, rates = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3), rng.uniform(-4, 4, 3)
        if k not in chosen:
            continue
        x, y, z, w = Rotation.from_euler("xyz", angles).as_quat()
        start = {"move_z": 0.6, "move_qw": w, "move_qx": x, "move_qy": y, "move_qz": z}
        start |= {f"move_v{axis}": value for axis, value in zip("xyz", velocity, strict=True)}
        start |= {f"move_w{axis}": value for axis, value in zip("xyz", rates, strict=True)}
        run = sb.simulate(eqs, 2.0, start)
        v, w = (np.column_stack([run[f"move_{kind}{axis}"] for axis in "xyz"]) for kind in "vw")
        yield run, 0.5 * mass * np.sum(v**2, axis=1) + 0.5 * w**2 @ inertia + mass * 9.81 * run["move_z"]


@pytest.mark.parametrize(
    "chosen",
    [pytest.param({2, 10, 22}, id="three"), pytest.param(range(30), id="all", marks=pytest.mark.exhaustive)],
)
def test_a_thrown_box_never_gains_energy(chosen: Collection[int]) -> None:
    """It lands on corners, edges and faces, slips, turns over edges, and comes to rest."""
    for run, energy in thrown_boxes(chosen):
        assert np.isfinite(energy).all()
        assert np.diff(energy).max() < 1e-7  # of 12 J, with rtol 1e-8
        assert run["gap floor"].min() > -1e-7
        assert run.success


class SpinningBox:
    """A box that slides and spins on its four lower corners, forces along which are a plane over the floor.

    That is the share of least norm: N = a + b x + c y follows from the weight and from two moments.
    """

    mass, edges = 2.0, np.array([0.4, 0.3, 0.6])

    def __init__(self, mu: float) -> None:
        self.mu = mu
        self.inertia = self.mass / 12 * (np.sum(self.edges**2) - self.edges**2)
        x, y, _ = self.edges / 2
        self.corners = np.array([[x, y], [x, -y], [-x, y], [-x, -y]])

    def equations(self) -> sb.EquationSet:
        box = sb.Body("Box", mass=self.mass, inertia=tuple(self.inertia))
        floor = sb.Contact(
            "floor", "ground", box, ["plane", {"box": list(self.edges)}],
            normal="rigid", friction=sb.Friction(mu="mu"),
        )  # fmt: skip
        elements = [sb.Free("move", "ground", box), floor]
        return sb.form_equations(sb.Model("box", elements, gravity=(0, 0, -G), parameters={"mu": self.mu}))

    def slips(self, state: Floats) -> tuple[Floats, Floats]:
        """Return the corners about the center of mass, (4, 2), and their velocities; the state is x, y, a, rates."""
        a, v, w = state[2], state[3:5], state[5]
        arms = self.corners @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
        return arms, v + w * np.column_stack([-arms[:, 1], arms[:, 0]])

    def forces(self, state: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the normal forces, those of friction, (4, 2), and the arms."""
        arms, slips = self.slips(state)
        rubs = -self.mu * slips / np.linalg.norm(slips, axis=1)[:, None]
        height = self.edges[2] / 2
        balance = np.array([np.ones(4), arms[:, 1] + height * rubs[:, 1], arms[:, 0] + height * rubs[:, 0]])
        shape = np.column_stack([np.ones(4), arms])
        normal = shape @ np.linalg.solve(balance @ shape, [self.mass * G, 0.0, 0.0])
        return normal, rubs * normal[:, None], arms

    def rates(self, _: float, state: Floats) -> Floats:
        _, rubs, arms = self.forces(state)
        turn = np.sum(arms[:, 0] * rubs[:, 1] - arms[:, 1] * rubs[:, 0])
        return np.array([*state[3:], *rubs.sum(axis=0) / self.mass, turn / self.inertia[2]])

    def slides(self, start: Floats) -> Any:
        """Return the motion until a corner is almost at rest, or bears nothing."""

        def left(_: float, state: Floats) -> float:
            slowest = np.linalg.norm(self.slips(state)[1], axis=1).min() - 0.02  # m/s
            return float(min(slowest, self.forces(state)[0].min()))

        left.terminal = True  # type: ignore[attr-defined]
        return solve_ivp(self.rates, (0, 2), start, rtol=1e-11, atol=1e-13, events=left)


@pytest.mark.parametrize(
    ("mu", "throws"),
    [
        pytest.param(0.35, 2),
        pytest.param(0.5, 5),
        pytest.param(0.35, 12, marks=pytest.mark.exhaustive),
        pytest.param(0.5, 14, marks=pytest.mark.exhaustive),
        pytest.param(0.7, 3, marks=pytest.mark.exhaustive),
    ],
)
def test_corners_of_a_box_that_slides_and_spins_share_its_weight_by_least_norm(
    mu: float, throws: int
) -> None:
    """With mu = 0.5 some corners come to bear nothing before the box stops, and with 0.7 it rises on an edge."""
    box = SpinningBox(mu)
    eqs = box.equations()
    rng = np.random.default_rng(5)
    compared = 0
    for _ in range(throws):
        vx, vy, spin = rng.uniform(-1, 1, 3) * [2, 2, 8]
        start = np.array([0, 0, 0, vx, vy, spin])
        first_values = {"move_z": box.edges[2] / 2, "move_vx": vx, "move_vy": vy, "move_wz": spin}
        run = sb.simulate(eqs, 1.5, first_values, rtol=1e-10, atol=1e-12)
        v, w = (np.column_stack([run[f"move_{kind}{axis}"] for axis in "xyz"]) for kind in "vw")
        energy = 0.5 * box.mass * np.sum(v**2, axis=1) + 0.5 * w**2 @ box.inertia
        energy += box.mass * G * (run["move_z"] - box.edges[2] / 2)
        assert run.success and energy[-1] < 1e-9
        assert np.diff(energy).max() < 1e-9 * energy[0]
        assert run["gap floor"].min() > -3e-9
        if box.forces(start)[0].min() > 0:
            known = box.slides(start)
            found = run.at(known.t[-1:])
            names = [f"move_{name}" for name in ("x", "y", "vx", "vy", "wz")]
            assert np.concatenate([found[name] for name in names]) == pytest.approx(
                known.y[[0, 1, 3, 4, 5], -1], rel=1e-7, abs=1e-8
            )
            compared += 1
    assert mu == 0.7 or compared > 0


def test_a_stop_that_rises_takes_a_body_off_the_one_it_lies_on() -> None:
    """Both are closed until the second one moves: then their rows contradict each other, and one opens."""
    body = sb.Body("Body", mass=1)
    rail = sb.Prismatic("rail", "ground", body, axis="z", coordinate="z")
    stops = [sb.Stop("low", gap="z"), sb.Stop("up", gap="z - max(0, t - 0.4)^2")]
    eqs = sb.form_equations(sb.Model("lift", [rail, *stops], gravity=(0, 0, -G)))
    run = sb.simulate(eqs, 1.0, {"z": 0.0}, scales={"length": 1.0})
    assert run.success and run["z"][-1] == pytest.approx(0.36, rel=1e-9)
    assert [(change.name, change.mode) for change in run.modes if change.t > 0] == [("low", "open")]
    assert run.modes[-1].t == pytest.approx(0.4, abs=1e-9)


@pytest.mark.parametrize("lifts", [(0, 1), (1, 0), (0.5, 2, 1), (-1, 0, 0.5), (1, 1)])
def test_stops_that_rise_from_the_start_on(lifts: tuple[float, ...]) -> None:
    """All are closed at t = 0, where their rows contradict each other: the highest holds, z = a t^2."""
    body = sb.Body("Body", mass=2)
    rail = sb.Prismatic("rail", "ground", body, axis="z", coordinate="z")
    stops = [sb.Stop(f"stop{k}", gap=f"z - {a}*t^2") for k, a in enumerate(lifts)]
    eqs = sb.form_equations(sb.Model("lift", [rail, *stops], gravity=(0, 0, -G)))
    a = max(lifts)
    state = sb.assemble(eqs)
    assert state["z_ddot"] == pytest.approx(2 * a)
    assert sum(state.multipliers.values()) == pytest.approx(2 * (G + 2 * a))
    run = sb.simulate(eqs, 1.0, scales={"length": 1.0})
    assert run.success and run["z"][-1] == pytest.approx(a, rel=1e-9)
    stepper = sb.Stepper(eqs, 0.25, scales={"length": 1.0})
    for _ in range(4):
        stepper.step()
    assert stepper["z"] == pytest.approx(a, rel=1e-9)


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param([0, 1, 2, 11], id="few"),
        pytest.param(range(8, 60), id="many", marks=pytest.mark.exhaustive),
    ],
)
def test_a_tripod_that_slides_and_spins_comes_to_rest(seeds: range) -> None:
    """Three feet share its weight in one way; where one of them nearly stops, its slip turns at once.

    Friction takes energy all the time. In the last instants the others turn about that foot.
    """
    angles = np.radians([0, 120, 240])
    feet = {f"f{k}": sb.Frame((0.2 * np.cos(a), 0.15 * np.sin(a), -0.1)) for k, a in enumerate(angles)}
    mass, inertia = 2.0, np.array([0.02, 0.04, 0.03])
    body = sb.Body("Body", mass=mass, inertia=tuple(inertia), frames=feet)
    floors = [
        sb.Contact(
            foot, "ground", f"Body.{foot}", ["plane", "point"], normal="rigid", friction=sb.Friction(mu=0.3)
        )
        for foot in feet
    ]
    eqs = sb.form_equations(
        sb.Model("tripod", [sb.Free("move", "ground", body), *floors], gravity=(0, 0, -G))
    )
    for seed in seeds:
        vx, vy, spin = np.random.default_rng(seed).uniform(-1, 1, 3) * [0.5, 0.5, 3]
        run = sb.simulate(eqs, 2.0, {"move_z": 0.1, "move_vx": vx, "move_vy": vy, "move_wz": spin})
        v, w = (np.column_stack([run[f"move_{kind}{axis}"] for axis in "xyz"]) for kind in "vw")
        energy = 0.5 * mass * np.sum(v**2, axis=1) + 0.5 * w**2 @ inertia
        assert run.success and energy[-1] < 1e-12
        assert np.diff(energy).max() < 1e-8 * energy[0]
