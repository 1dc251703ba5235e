"""Motions with friction: smooth laws, Painleve's end, and joints that stick and slip."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import symbody as sb
from tests.equations.test_friction import MU, TREES, by_hand, slider_crank
from tests.tiers import cases

M, G, K, SPEED = 1.5, 9.81, 40.0, 0.3
MU_STATIC, MU_SLIDING = 0.3, 0.2
OMEGA = np.sqrt(K / M)


def dragged(events: bool = True) -> sb.Model:
    """A block on a table, dragged by a spring whose far end moves at constant speed."""
    block = sb.Body("Block", "m")
    friction = sb.Friction(mu="mu", mu_static="mus", v0=None if events else 1e-5)
    pull = sb.Drive(applied="k*(V*t - x)")
    guide = sb.Prismatic("guide", "ground", block, coordinate="x", friction=friction, force=pull)
    numbers = {"m": M, "g": G, "k": K, "V": SPEED, "mu": MU_SLIDING, "mus": MU_STATIC}
    return sb.Model("dragged", [block, guide], gravity=(0, 0, "-g"), parameters=numbers)


@cache
def dragged_run() -> sb.Trajectory:
    return sb.simulate(sb.form_equations(dragged()), 3.0, rtol=1e-10, atol=1e-12)


def first_slip() -> tuple[float, float, float]:
    """Return when the block breaks away, when it sticks again, and where, in closed form."""
    start = MU_STATIC * M * G / (K * SPEED)
    rest = -SPEED * start + MU_SLIDING * G / OMEGA**2  # about where it would be carried along steadily

    def rate(s: float) -> float:
        return float(SPEED - rest * OMEGA * np.sin(OMEGA * s) - SPEED * np.cos(OMEGA * s))

    s = brentq(rate, 0.01, 2.0 * np.pi / OMEGA - 1e-6, xtol=1e-14)
    x = (
        SPEED * (start + s)
        - MU_SLIDING * G / OMEGA**2
        + rest * np.cos(OMEGA * s)
        - SPEED / OMEGA * np.sin(OMEGA * s)
    )
    return start, start + s, float(x)


def test_modes_of_a_motion_and_of_a_stepper() -> None:
    """A block slides to rest, 2 m/s over mu g, and stays there: 3 N of spring are below mu m g."""
    slide = sb.Prismatic("slide", "ground", sb.Body("Block", mass=2), axis="x", coordinate="x",
                         friction=sb.Friction(0.25))  # fmt: skip
    eqs = sb.form_equations(sb.Model("block", [slide], (0, 0, -9.81), initial={"x_dot": 2.0}))
    rest = 2.0 / (0.25 * 9.81)
    run = sb.simulate(eqs, 1.5)
    assert [(change.name, change.mode) for change in run.modes] == [
        ("slide", "slips forward"), ("slide", "sticks"),
    ]  # fmt: skip
    assert run.modes[1].t == pytest.approx(rest, abs=1e-9)
    slips = run["mode slide"][run.t < rest - 1e-9]
    assert (slips == 1.0).all() and run["mode slide"][-1] == 0.0
    at_rest = np.flatnonzero(run.t == run.modes[1].t)
    assert run["mode slide"][at_rest].tolist() == [
        1.0,
        0.0,
    ]  # of two samples at a change the first is before it
    stepper = sb.Stepper(eqs, 0.5)
    assert stepper.step().modes == {"slide": "slips forward"}
    assert stepper.step().modes == {"slide": "sticks"}


def test_a_dragged_block_sticks_and_slips() -> None:
    run = dragged_run()
    assert run.success
    names = [event.name for event in run.events]
    assert names[:3] == ["guide slips forward", "guide sticks", "guide slips forward"]
    away, back, x = first_slip()
    # Errors of the integration, at rtol = 1e-10 over some 100 steps, and of v = 0 where v' is about 2 m/s^2.
    assert run.events[0].t == pytest.approx(away, abs=1e-10)
    assert run.events[1].t == pytest.approx(back, abs=1e-8)
    assert run.events[1].state["x"] == pytest.approx(x, abs=1e-9)
    # It sticks until the spring has gained what lies between the sliding pull and the static limit.
    again = (MU_STATIC * M * G / K + x) / SPEED
    assert run.events[2].t == pytest.approx(again, abs=1e-8)


def test_friction_is_reported_in_both_modes() -> None:
    run = dragged_run()
    sticking = run.t < run.events[0].t
    assert run["friction guide"][sticking] == pytest.approx(-K * SPEED * run.t[sticking], abs=1e-9)
    slipping = (run.t > run.events[0].t) & (run.t < run.events[1].t)
    assert run["friction guide"][slipping] == pytest.approx(-MU_SLIDING * M * G, rel=1e-12)
    assert run["reaction guide Fz"] == pytest.approx(M * G, rel=1e-12)
    assert run.at(0.1)["x"] == 0.0
    # What the spring gives (no potential: its end moves) less what friction takes is the kinetic energy.
    assert run.energy_drift < 1e-9


def test_wanted_times_are_the_samples() -> None:
    times = np.linspace(0.0, 3.0, 31)
    run = sb.simulate(sb.form_equations(dragged()), 3.0, times=times, rtol=1e-10, atol=1e-12)
    assert (run.t == times).all()
    assert run["x"] == pytest.approx(dragged_run().at(times)["x"], abs=1e-8)
    assert run["work"] == pytest.approx(dragged_run().at(times)["work"], abs=1e-8)


def test_the_smooth_law_comes_near_the_events() -> None:
    """With mu_static = mu both laws have the same limit, and the smooth one creeps at v0 instead of sticking."""
    numbers = {"mus": MU_SLIDING}
    dry = sb.simulate(sb.form_equations(dragged()), 1.5, parameters=numbers)
    smooth = sb.simulate(sb.form_equations(dragged(events=False)), 1.5, parameters=numbers)
    assert dry.success and smooth.success
    assert [event.name for event in dry.events] == ["guide slips forward"]
    assert abs(float(dry["x"][-1]) - float(smooth["x"][-1])) < 1e-4  # creep of up to 10 v0 before it slips


def test_a_block_thrown_up_an_incline_stops_and_stays_or_slides_back() -> None:
    block = sb.Body("Block", "m")
    friction = sb.Friction(mu="mu")
    guide = sb.Prismatic("guide", "ground.i", block, coordinate="x", friction=friction)
    model = sb.Model("incline", [block, guide], gravity=(0, "-g", 0), ground={"i": sb.Frame(rotate=[("z", "a")])},
                     parameters={"m": M, "g": G, "a": 0.5, "mu": 0.3})  # fmt: skip
    eqs = sb.form_equations(model)
    for mu, after in ((0.3, "guide slips backward"), (0.6, "guide sticks")):
        run = sb.simulate(eqs, 2.0, {"x_dot": 3.0}, parameters={"mu": mu}, rtol=1e-10, atol=1e-12)
        slower = G * (np.sin(0.5) + mu * np.cos(0.5))
        (event,) = run.events
        assert event.name == after
        assert event.t == pytest.approx(3.0 / slower, rel=1e-9)
        back = max(G * (np.sin(0.5) - mu * np.cos(0.5)), 0.0)
        assert run["x"][-1] == pytest.approx(4.5 / slower - back * (2.0 - event.t) ** 2 / 2.0, abs=1e-9)


def test_smooth_friction_in_a_loop_against_free_bodies() -> None:
    """A slider-crank with friction in all its joints, its equation of motion written by hand."""
    eqs = sb.form_equations(slider_crank(MU), tree=sb.Trees("ACD", "ACD"))
    start = {"theta": 0.5, "theta_dot": 5.0}
    guess = {"beta": -0.2, "s": 1.3}
    run = sb.simulate(eqs, 0.3, start, guess=guess, inputs={"F": 20.0}, rtol=1e-9, atol=1e-11)
    assert run.success
    assert np.abs(run["friction_residual"]).max() < 1e-9

    def slope(t: float, y: np.ndarray) -> list[float]:
        return [y[1], by_hand(float(y[0]), float(y[1]), 20.0, MU)[0]]

    found = solve_ivp(slope, (0.0, 0.3), [0.5, 5.0], rtol=1e-9, atol=1e-11)
    assert run["theta"][-1] == pytest.approx(found.y[0, -1], abs=1e-7)
    assert run["theta_dot"][-1] == pytest.approx(found.y[1, -1], abs=1e-6)
    assert run.energy_drift < 1e-7


@pytest.mark.parametrize(
    "tree", cases(TREES, fast=["cut at B", "absolute", "rotation at A B D, translation at A C D"])
)
def test_dry_friction_in_joints_that_trees_cut(tree: str) -> None:
    """A slider-crank with dry friction in its slider and the pin at B falls and turns back: in each tree alike."""
    first, other = fallen("absolute"), fallen(tree)
    assert first.success and other.success
    for name in ("B slips backward", "D slips forward"):
        times = [[event.t for event in run.events if event.name == name] for run in (first, other)]
        assert times[0] and times[1] == pytest.approx(times[0], abs=1e-7)
    assert other["theta"][-1] == pytest.approx(first["theta"][-1], abs=1e-6)
    assert np.abs(other["constraints"]).max(initial=0.0) < 1e-8
    assert other.energy_drift < 1e-7


@cache
def fallen(tree: str) -> sb.Trajectory:
    laws = {"B": sb.Friction(force=0.2), "D": sb.Friction(force=2.0)}
    model = slider_crank({})
    elements = [replace(element, friction=laws[element.name]) if element.name in laws else element
                for element in model.elements]  # fmt: skip
    dry = sb.Model("dry", elements, gravity=(0, "-G", 0), parameters=model.parameters, inputs=["F"])
    guess = {"beta": -0.2, "s": 1.3, "phi": -0.7}
    return sb.simulate(sb.form_equations(dry, tree=TREES[tree]), 2.0, {"theta": 0.5}, guess=guess,
                       inputs={"F": 0.0}, rtol=1e-10, atol=1e-12)  # fmt: skip


def test_dry_friction_holds_a_loop() -> None:
    """A slider-crank under its weight and a force that grows: sticks, then moves as with the smooth law."""
    model = slider_crank({"D": 0.25})
    dry = [sb.Prismatic("D", "ground", "Piston", coordinate="s", friction=sb.Friction(force=30.0))
           if element.name == "D" else element for element in model.elements]  # fmt: skip
    eqs = sb.form_equations(
        sb.Model("dry", dry, gravity=(0, "-G", 0), parameters=model.parameters, inputs=["F"]),
        tree=sb.Trees("ACD", "ACD"),
    )
    run = sb.simulate(
        eqs, 1.0, {"theta": 1.0, "theta_dot": 0.0}, guess={"beta": -0.34, "s": 1.1}, inputs={"F": "100*t"}
    )
    assert run.success
    (away, *_) = run.events
    assert away.name == "D slips forward"
    assert run.at(away.t)["s_dot"] == pytest.approx(0.0, abs=1e-9)
    # Statics: virtual work of the weights and of F along the only motion, with s_dot = 1.
    beta = -np.arcsin(0.4 * np.sin(1.0))
    beta_dot = -0.4 * np.cos(1.0) / np.cos(beta)
    s_dot = -0.4 * np.sin(1.0) - beta_dot * np.sin(beta)
    weight = (
        -G * (1.0 * 0.2 * np.cos(1.0) + 1.5 * (0.4 * np.cos(1.0) + 0.5 * np.cos(beta) * beta_dot)) / s_dot
    )
    assert weight + 100.0 * away.t == pytest.approx(30.0, abs=1e-6)
    assert run.energy_drift < 1e-6


def rod_on_a_slider(mu: float) -> sb.EquationSet:
    """A rod hinged on a nearly massless slider on a rough guide (Painleve's rod)."""
    slider, rod = (
        sb.Body("Slider", "M"),
        sb.Body("Rod", "m", (0, 0, "m*l^2/3"), frames={"e": sb.Frame(at=("-l", 0, 0))}),
    )
    guide = sb.Prismatic("guide", "ground", slider, coordinate="x", friction=sb.Friction(mu=mu, v0=1e-3))
    hinge = sb.Revolute("hinge", slider, "Rod.e", coordinate="theta")
    numbers = {"M": 0.01, "m": 1.0, "l": 0.5, "g": G}
    return sb.form_equations(
        sb.Model("painleve", [slider, rod, guide, hinge], gravity=(0, "-g", 0), parameters=numbers)
    )


def margin(mu: float, theta: float) -> float:
    """Return 1 - mu |dN/df|, from the two equations of the rod and the slider."""
    determinant = 1.01 * 0.25 * 4.0 / 3.0 - 0.25 * np.sin(theta) ** 2
    return 1.0 - mu * abs(0.25 * np.sin(theta) * np.cos(theta)) / determinant


def test_where_friction_is_not_determined_the_motion_ends_by_name() -> None:
    eqs = rod_on_a_slider(1.6)
    f = sb.compile(eqs, ("friction_margin", "udot"))
    assert f(0.0, [0.0, 0.6], [3.0, 0.0])[0][0] == pytest.approx(margin(1.6, 0.6), abs=1e-6)  # v0 / v is 3e-4
    run = sb.simulate(eqs, 5.0, {"theta": 0.3, "x_dot": 30.0, "theta_dot": 6.0})
    assert run.status is sb.Status.FRICTION and not run.success
    (note,) = [note for note in run.notes if "joint guide" in note]
    assert f"t = {run.t[-1]:.9g} s" in note
    slip = abs(run["x_dot"][-1]) / np.hypot(run["x_dot"][-1], 1e-3)
    assert abs(margin(1.6 * slip, float(run["theta"][-1]))) < 1e-3
    assert margin(1.6, 0.9) < 0.0
    assert np.isnan(f(0.0, [0.0, 0.9], [3.0, 0.0])[1]).all()


def test_a_motion_that_starts_undetermined_ends_at_once() -> None:
    run = sb.simulate(rod_on_a_slider(1.6), 5.0, {"theta": 0.9, "x_dot": 3.0})
    assert run.status is sb.Status.FRICTION
    assert any("t = 0 s" in note and "joint guide" in note for note in run.notes)


def test_less_friction_lets_the_rod_pass() -> None:
    run = sb.simulate(rod_on_a_slider(1.2), 0.3, {"theta": 0.3, "x_dot": 30.0, "theta_dot": 6.0})
    assert run.success and run["theta"][-1] > 1.5
    assert run["friction_margin"].min() > 0.0
    assert run.energy_drift < 1e-6


def test_what_cannot_go_with_sticking_is_refused() -> None:
    eqs = sb.form_equations(dragged())
    with pytest.raises(sb.UsageError, match=r"simulation\.stick_slip_backwards"):
        sb.simulate(eqs, (1.0, 0.0))


def test_several_joints_stick_at_once() -> None:
    """A train of three blocks between springs, pulled at one end: they break away one after the other."""
    blocks = [sb.Body(f"B{k}", "m") for k in range(3)]
    friction = sb.Friction(force="f")
    guides = [sb.Prismatic(f"g{k}", "ground", block, coordinate=f"x{k}", friction=friction)
              for k, block in enumerate(blocks)]  # fmt: skip
    forces = [sb.Force("pull", "B2", ("20*t", 0, 0))]
    forces += [sb.Force(f"s{k}", f"B{k}", (f"k*(x{k + 1} - x{k})", 0, 0)) for k in range(2)]
    forces += [sb.Force(f"r{k}", f"B{k + 1}", (f"-k*(x{k + 1} - x{k})", 0, 0)) for k in range(2)]
    numbers = {"m": 1.0, "k": 400.0, "f": 3.0}
    eqs = sb.form_equations(
        sb.Model("train", [*blocks, *guides, *forces], gravity=(0, 0, 0), parameters=numbers)
    )
    run = sb.simulate(eqs, 0.6, rtol=1e-9, atol=1e-11)
    assert run.success and run.energy_drift < 1e-8
    away = [event for event in run.events if event.name.endswith("slips forward")]
    first = {name: next(e for e in away if e.name.startswith(name)) for name in ("g0", "g1", "g2")}
    assert first["g2"].t == pytest.approx(3.0 / 20.0, abs=1e-10)
    # The next breaks away where the spring before it carries the friction.
    assert 400.0 * (first["g1"].state["x2"] - first["g1"].state["x1"]) == pytest.approx(3.0, abs=1e-7)
    assert first["g2"].t < first["g1"].t < first["g0"].t
    assert np.abs(run["friction g0"]).max() <= 3.0 + 1e-7
    still = run.t < first["g2"].t
    assert (run["x2"][still] == 0.0).all()


@cache
def rubbing_crank() -> sb.EquationSet:
    return sb.form_equations(slider_crank({"A": 0.1, "D": 0.25}), tree=sb.Trees("ACD", "ACD"))


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("held", "integrator", "close"),
    [(sb.Baumgarte(), None, 1e-5), (sb.GGL(), None, 1e-5), (sb.Partition(), None, 1e-7),
     (sb.Projection(), sb.Stiff(), 1e-6)],
)  # fmt: skip
def test_smooth_friction_however_constraints_are_held(held: object, integrator: object, close: float) -> None:
    start, guess = {"theta": 0.5, "theta_dot": 5.0}, {"beta": -0.2, "s": 1.3}
    words = {"inputs": {"F": 20.0}, "rtol": 1e-9, "atol": 1e-11}
    run = sb.simulate(
        rubbing_crank(), 0.3, start, guess=guess, constraints=held, integrator=integrator, **words
    )
    reference = sb.simulate(rubbing_crank(), 0.3, start, guess=guess, **words)
    assert run.success
    assert run["theta"][-1] == pytest.approx(reference["theta"][-1], abs=close)
