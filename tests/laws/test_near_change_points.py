"""Law: a mechanism beside one with a change point turns where its own branch does, however sharply.

Four-bars and slider-cranks whose lengths miss those of a change point by 1e-3 to 1e-9 of the longest move as
their reduced equations say, computed in 40 digits, by `simulate` and by `sweep`, and nothing speaks of a change
point. From 1e-10 on, where closed positions do not tell the branches apart, either is taken, with a note.
"""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from tests.laws.change_point_neighbours import NAMES, Neighbour, neighbour
from tests.tiers import rows

Floats = NDArray[np.float64]

TIMES = np.linspace(0.0, 0.4, 7)
RTOL = 1e-8
# A passage that is up to 1e3 times as bad as a step is taken (`passage_balance`), and in this time there are at
# most three. Backward differentiation takes as many steps, and its last correction is less exact.
PASSAGES = 3
WORSE = 1000
DEPENDENT = "become dependent (change point)"


def deviation(made: Neighbour, exact: dict[str, Floats], run: sb.Trajectory) -> float:
    """The largest difference of joint coordinates; whole turns are none."""
    parts = []
    for name in NAMES:
        apart = run[name] - exact[name][: run.t.size]
        is_length = made.has_slider and name == "d"
        parts.append(np.abs(apart if is_length else 2.0 * np.sin(apart / 2.0)).max())
    return float(max(parts))


def allowed(steps: int, rates: Floats) -> float:
    """Errors of all steps, each RTOL of the largest state, that go on as positions and, over time, as speeds.

    Along one curve they lead or lag in time, which the fastest part of the motion shows most.
    """
    sizes = np.linalg.norm(rates, axis=1)
    return float(steps * RTOL * np.abs(rates).max() * (1.0 + TIMES[-1]) * sizes.max() / sizes.min())


def arguments(made: Neighbour, exact: dict[str, Floats]) -> dict[str, Any]:
    start = {"a": float(exact["a"][0]), "a_dot": made.speed}
    return {"initial": start, "guess": {name: float(exact[name][0]) for name in "bd"}, "times": TIMES}


def check(seed: int) -> None:
    """Any distance: one decade after the other."""
    distance = 10.0 ** -(3.0 + 6.0 * Random(-seed - 1).random() if seed % 7 else 9.0)
    made = neighbour(seed, distance)
    exact, rates = made.motion(TIMES.tolist())
    eqs, where = sb.form_equations(made.model()), (seed, distance)
    run = sb.simulate(eqs, TIMES[-1], **arguments(made, exact))
    many = sb.sweep(eqs, TIMES[-1], **arguments(made, exact))
    for one in (run, many.trajectory(0)):
        assert one.status is sb.Status.SUCCESS, (where, one.notes)
        assert not any(DEPENDENT in note for note in (*one.notes, *many.notes)), where
        assert deviation(made, exact, one) < allowed(run.statistics.accepted, rates), where


@pytest.mark.parametrize("seed", [0, 7])
def test_near_is_not_at_a_change_point(seed: int) -> None:
    check(seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("chunk", range(200))
def test_many_are_near(chunk: int) -> None:
    for seed in range(10 * chunk, 10 * chunk + 10):
        check(seed)


def check_method(seed: int, distance: float, method: sb.Baumgarte | sb.GGL | sb.Partition) -> None:
    """What is computed is right; a method that finds no way on speaks of branches that come close."""
    made = neighbour(seed, distance)
    exact, rates = made.motion(TIMES.tolist())
    run = sb.simulate(
        sb.form_equations(made.model()), TIMES[-1], **arguments(made, exact), constraints=method
    )
    steps = max(run.statistics.accepted, WORSE * PASSAGES)
    assert deviation(made, exact, run) < allowed(steps, rates), (seed, distance, run.notes)
    assert not any(DEPENDENT in note or "change point" in note for note in run.notes), run.notes
    if isinstance(method, sb.Partition):
        assert run.success, (seed, distance, run.notes)
    assert run.success or any("branches of the mechanism" in note for note in run.notes), run.notes


@pytest.mark.parametrize(
    ("seed", "distance", "method"),
    rows(
        [(1, 1e-4, sb.Partition()), (0, 1e-9, sb.Baumgarte()), (4, 1e-9, sb.GGL())],
        fast=[(0, 1e-9, sb.Baumgarte())],
    ),
)
def test_methods_by_name_turn_or_say_why_not(
    seed: int, distance: float, method: sb.Baumgarte | sb.GGL | sb.Partition
) -> None:
    check_method(seed, distance, method)


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", [sb.Partition(), sb.Baumgarte(), sb.GGL()])
@pytest.mark.parametrize("seed", range(40))
def test_methods_by_name_on_many(seed: int, method: sb.Baumgarte | sb.GGL | sb.Partition) -> None:
    check_method(seed, 10.0 ** -(3.0 + 6.0 * Random(-seed - 1).random()), method)


@pytest.mark.parametrize(
    ("seed", "distance", "rtol"), rows([(4, 1e-9, RTOL), (3, 1e-6, 1e-2)], fast=[(3, 1e-6, 1e-2)])
)
def test_partition_by_name_turns_or_ends_where_a_step_goes_over_to_another_branch(
    seed: int, distance: float, rtol: float
) -> None:
    """Without a judgement it goes on with success and is wrong by 2 rad; at 1e-9 it keeps its branch."""
    made = neighbour(seed, distance)
    exact, rates = made.motion(TIMES.tolist())
    eqs = sb.form_equations(made.model())
    run = sb.simulate(eqs, TIMES[-1], **arguments(made, exact), constraints=sb.Partition(), rtol=rtol)
    switches = any("sb.Partition() switches to another" in note for note in run.notes)
    assert run.success == (distance < 1e-8) and run.success != switches, run.notes
    assert deviation(made, exact, run) < allowed(run.statistics.accepted, rates) * rtol / RTOL


@pytest.mark.parametrize("distance", [1e-10, 1e-12])
def test_closer_than_positions_are_known_either_branch_is_taken_with_a_note(distance: float) -> None:
    made = neighbour(1, distance)
    start = {"a": made.start[0], "a_dot": made.speed}
    guess = {"b": made.start[1] - made.start[0], "d": made.start[2]}
    run = sb.simulate(sb.form_equations(made.model()), TIMES[-1], start, guess=guess)
    assert run.success and any("change point" in note for note in run.notes), run.notes
    # Whichever it is, energy stays: of its largest part a step leaves RTOL, a passage up to 1e3 times as much.
    steps = run.statistics.accepted + WORSE * PASSAGES
    assert np.ptp(run["energy"]) < RTOL * steps * run["kinetic_energy"].max()
