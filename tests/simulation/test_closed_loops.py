"""Motions of closed loops: order with projection and events, drift, dead centres, turned axes."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ellipj, ellipk

import symbody as sb
from tests.mechanisms import example

Floats = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"
MODULUS = 0.5  # sine of half the amplitude


@cache
def free_pendulum() -> sb.EquationSet:
    """A unit pendulum, its body free and its joint closed by two multipliers."""
    body = sb.Body("B", mass=1, inertia=(0, 0, 1), frames={"A": sb.Frame(at=(0, 1, 0))})
    joint = sb.Revolute("j", "ground", "B.A", axis="z", coordinate="theta")
    model = sb.Model("pendulum", [body, joint], gravity=(0, -2, 0))  # theta'' = -sin(theta)
    return sb.form_equations(model, tree="absolute")


def angle(t: Floats) -> Floats:
    return np.asarray(2 * np.arcsin(MODULUS * ellipj(t, MODULUS**2)[0]))


def at_lowest_point(eqs: sb.EquationSet) -> list[float]:
    """The state there, by name: (0, -1), turning at twice the modulus."""
    values = {"B_vx": 2 * MODULUS, "B_wz": 2 * MODULUS, "B_y": -1.0, "B_qw": 1.0}
    return [values.get(name, 0.0) for name in eqs.state_names]


def errors(order: int, duration: float, steps: int) -> tuple[float, float, float]:
    """Largest errors of the angle at the ends of steps and anywhere, and of the times of its zeros."""
    step = duration / steps
    eqs = free_pendulum()
    run = sb.simulate(
        eqs,
        duration,
        initial=dict(zip(eqs.state_names, at_lowest_point(eqs), strict=True)),
        integrator=sb.Explicit(order, max_step=step, first_step=step),
        events=sb.Event("sin(theta)"),
        rtol=1e6,
        atol=1e6,
    )
    assert run.statistics.accepted == steps
    anywhere = np.linspace(0.0, duration, 5003)
    half = 2 * ellipk(MODULUS**2)
    zeros = half * np.arange(1, duration // half + 1)
    found = np.array([t for _, t, _ in run.events])
    return (
        float(np.abs(run["theta"] - angle(run.t)).max()),
        float(np.abs(run.at(anywhere)["theta"] - angle(anywhere)).max()),
        float(np.abs(found - zeros).max()),
    )


# The error constants of order 8 are small, so that over longer times terms of the next orders are seen as well.
@pytest.mark.parametrize(
    ("order", "duration", "counts"), [(5, 10.0, (320, 400, 500, 640)), (8, 4.0, (20, 22, 26, 29, 32, 35))]
)
def test_projection_and_events_keep_the_order(order: int, duration: float, counts: tuple[int, ...]) -> None:
    measured = np.array([errors(order, duration, steps) for steps in counts])
    slopes = np.polyfit(-np.log(counts), np.log(measured[:, :2]), 1)[0]
    # At the ends of steps, and between them; errors of order 8 end near rounding here.
    np.testing.assert_allclose(slopes, order, atol=0.25)
    # Times of events are the state's error over its slope, which is nearly 1 there; how the steps lie about
    # an event changes from count to count, so only the bound has the order.
    assert (measured[:, 2] <= 1.5 * measured[:, 1]).all()


@pytest.mark.parametrize("name", ["spinning_top", "spinning_top_omega"])
def test_energy_of_the_spinning_top(name: str) -> None:
    run = sb.simulate(example(name), 10.0, rtol=1e-10)
    assert run.success
    assert run.energy_drift < 1e-9 * run["kinetic_energy"].max()


def check_closed(run: sb.Trajectory) -> None:
    """At all stored times, relative to size and speed; velocities are projected exactly, up to rounding."""
    assert run.success
    assert run.constraint_violation.max() < 1e-9
    assert run.velocity_violation.max() < 1e-9


def test_a_slider_crank_turns_a_hundred_times() -> None:
    run = sb.simulate(example("slider_crank"), 33.0, initial={"theta_dot": 20.0})
    assert np.ptp(run["theta"]) > 100 * 2 * np.pi
    check_closed(run)
    # about 34 steps a turn at a local error of 1e-8, all of one sign at worst
    assert run.energy_drift < 1e-8 * run.statistics.accepted * run["kinetic_energy"].max()


def test_wanted_samples_are_closed_too() -> None:
    run = sb.simulate(example("slider_crank"), 2.0, times=np.linspace(0, 2, 777))
    assert run.t.size == 777
    check_closed(run)


@pytest.mark.parametrize("start", ["0", "pi"])
def test_a_slider_crank_starts_at_a_dead_centre(start: str) -> None:
    initial = {"theta": start, "theta_dot": 5.0}
    run = sb.simulate(example("slider_crank"), 2.0, initial=initial, guess={"beta": 0.0})
    check_closed(run)
    assert run.u[2, 0] == pytest.approx(0.0, abs=1e-12)  # the piston turns back there
    # the same motion from a little later: what comes before is no matter
    later = {name: float(run.at(0.1)[name]) for name in ("theta", "theta_dot", "s")}
    guess = {"beta": float(run.at(0.1)["beta"]), "s": later.pop("s")}
    again = sb.simulate(example("slider_crank"), 1.9, initial=later, guess=guess)
    # local errors of 1e-8 in some 60 steps
    assert again["theta"][-1] == pytest.approx(run["theta"][-1], abs=60 * 1e-8 * 20)


def test_everything_a_run_tells_is_there_after_it() -> None:
    run = sb.simulate(example("slider_crank"), 1.0, inputs={"F": "sin(t)"})
    count = run.t.size
    wrench = run.reaction("A")
    assert wrench.shape == (6, count)
    # One function computes all six, another one alone: sums of some ten terms may differ in rounding.
    np.testing.assert_allclose(wrench[0], run["reaction A Fx"], rtol=0.0, atol=1e-14 * np.abs(wrench).max())
    np.testing.assert_array_equal(wrench[5], run["reaction A Mz"])
    np.testing.assert_allclose(run["effort D"], np.sin(run.t), rtol=1e-14)
    for name in ("energy", "work", "constraint_violation", "velocity_violation", "(B)", "B_dot"):
        assert run[name].shape == (count,)
    # the angle of the cut joint follows beta - theta through all turns
    np.testing.assert_allclose(np.diff(run["(B)"]), np.diff(run["beta"] - run["theta"]), rtol=0, atol=1e-9)
    assert len(run.columns("reaction A", "theta")) == 7


def test_the_spatial_four_bar() -> None:
    run = sb.simulate(example("spatial_four_bar"), 10.0)
    check_closed(run)
    assert run.energy_drift < 1e-8 * run.statistics.accepted * run["kinetic_energy"].max()


def four_bar(turn: tuple[float, float, float]) -> sb.EquationSet:
    """A planar four-bar of bodies in space, in a ground whose axes are turned: no axis is x, y or z."""
    turns = list(zip("xyz", turn, strict=True))
    frames = {"post": sb.Frame((0.2, -0.1, 0.3), turns), "far": sb.Frame(far(turn), turns)}
    lengths = {"Crank": 0.3, "Rod": 0.9, "Rocker": 0.7}
    bodies = [
        sb.Body(name, mass=1, inertia=(0.01, 0.08, 0.09),
                frames={"near": sb.Frame(at=(-length / 2, 0, 0)), "tip": sb.Frame(at=(length / 2, 0, 0))})
        for name, length in lengths.items()
    ]  # fmt: skip
    joints = [
        sb.Revolute("A", "ground.post", "Crank.near", axis="z", coordinate="a"),
        sb.Revolute("B", "Crank.tip", "Rod.near", axis="z", coordinate="b"),
        sb.Revolute("C", "Rod.tip", "Rocker.tip", axis="z", coordinate="c"),
        sb.Revolute("D", "ground.far", "Rocker.near", axis="z", coordinate="d"),
    ]
    down = matrix(turn) @ np.array([0.0, -9.81, 0.0])
    model = sb.Model("four-bar", [*bodies, *joints], ground=frames, gravity=tuple(down.tolist()))
    return sb.form_equations(model)


def matrix(turn: tuple[float, float, float]) -> Floats:
    """R1 R2 R3 of turns about x, y, z."""
    (a, b, c), result = turn, np.eye(3)
    for angle_, (i, j) in zip((a, b, c), ((1, 2), (2, 0), (0, 1)), strict=True):
        step = np.eye(3)
        step[i, i] = step[j, j] = np.cos(angle_)
        step[i, j], step[j, i] = -np.sin(angle_), np.sin(angle_)
        result = result @ step
    return result


def far(turn: tuple[float, float, float]) -> tuple[float, ...]:
    return tuple((np.array([0.2, -0.1, 0.3]) + matrix(turn) @ np.array([0.8, 0.0, 0.0])).tolist())


def test_a_four_bar_of_spatial_hinges_turns_a_hundred_times() -> None:
    """Three of its constraints follow from the others: dropped with a note, or found by their numbers."""
    eqs, guess = four_bar((0.7, -0.4, 1.1)), {"b": -0.6, "d": 1.4}
    found = sb.redundancy(eqs, guess={"a": 1.0, **guess})
    (note,) = [note for note in eqs.notes if "hold identically and are dropped" in note]
    named = {f"lambda_C_{k}" for k in range(1, 6)} - set(found.kept)
    assert found.degrees_of_freedom == 1 and len(named) == 3
    assert all(name in note or name in found.dropped for name in named)
    run = sb.simulate(eqs, 33.0, initial={"a": 1.0, "a_dot": 20.0}, guess=guess)
    assert np.ptp(run["a"]) > 100 * 2 * np.pi
    check_closed(run)
    assert run.energy_drift < 1e-8 * run.statistics.accepted * run["kinetic_energy"].max()


def test_a_planar_four_bar_in_space_moves_as_it_does_flat() -> None:
    runs = []
    for turn in ((0.0, 0.0, 0.0), (0.7, -0.4, 1.1)):
        run = sb.simulate(four_bar(turn), 3.0, initial={"a": 1.0, "a_dot": 8.0}, guess={"b": -0.6, "d": 1.4})
        check_closed(run)
        assert run.energy_drift < 1e-8 * run.statistics.accepted * run["kinetic_energy"].max()
        runs.append(run)
    times = np.linspace(0.0, 3.0, 50)
    flat, turned = (run.at(times) for run in runs)
    # local errors of 1e-8 in some hundred steps, and what a motion of a hundred radians makes of them
    np.testing.assert_allclose(turned["a"], flat["a"], rtol=0, atol=1e-5)
    np.testing.assert_allclose(turned["reaction A"][:2], flat["reaction A"][:2], rtol=0, atol=1e-3)
