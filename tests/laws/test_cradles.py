"""Balls that touch hit each other as balls with a gap of a nanometre do.

Equal balls on a rail exchange their speeds at each hit. Speeds come out sorted, after as many hits as pairs of
balls stood in the wrong order. Where all speeds are 0 or v, moving balls exchange places with resting ones
only: then each hit has its place among those that share a ball with it, whatever the gaps. Hits without a
common ball come in any order, so sequences are compared as rounds: a hit belongs to the round after the last
one of a hit that shares a ball with it.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb
from symbody.simulation.results.trajectory import Trajectory
from tests.tiers import cases

END = 0.25
WIDTH = 0.1
GAPS = (0.0, 1e-9)


@cache
def rail(count: int) -> sb.EquationSet:
    joints = [
        sb.Prismatic(f"j{k}", "ground", sb.Body(f"B{k}", mass=1), axis="x", coordinate=f"x{k}")
        for k in range(count)
    ]
    return sb.form_equations(sb.Model("rail", joints))


@cache
def hits(count: int) -> tuple[sb.Event, ...]:
    return tuple(
        sb.Event(f"x{k + 1} - x{k} - {WIDTH}", -1, {f"x{k}_dot": f"x{k + 1}_dot", f"x{k + 1}_dot": f"x{k}_dot"},
                 str(k))
        for k in range(count - 1)
    )  # fmt: skip


def first_values(speeds: np.ndarray, gap: float) -> dict[str, float]:
    places = {f"x{k}": WIDTH * k + gap * k for k in range(len(speeds))}
    return places | {f"x{k}_dot": float(speed) for k, speed in enumerate(speeds)}


def run_cradle(speeds: np.ndarray, gap: float) -> Trajectory:
    count = len(speeds)
    return sb.simulate(rail(count), END, first_values(speeds, gap), events=hits(count))


def names_of(run: Trajectory) -> list[int]:
    return [int(event.name) for event in run.events]


def in_rounds(pairs: list[int]) -> list[tuple[int, int]]:
    """Round and pair of each hit, sorted."""
    last: dict[int, int] = {}
    found = []
    for pair in pairs:
        last[pair] = 1 + max(last.get(k, 0) for k in (pair - 1, pair, pair + 1))
        found.append((last[pair], pair))
    return sorted(found)


def rounds_of(moves: list[bool]) -> list[int]:
    """The pairs that hit, round by round, from left to right in each."""
    found: list[int] = []
    while True:
        pairs = [k for k in range(len(moves) - 1) if moves[k] and not moves[k + 1]]
        if not pairs:
            return found
        for k in pairs:
            moves[k], moves[k + 1] = False, True
        found += pairs


def check_two_speeds(random: np.random.Generator) -> None:
    moves = [bool(choice) for choice in random.integers(0, 2, int(random.integers(2, 10)))]
    speeds = np.where(moves, float(random.uniform(0.1, 3.0)), 0.0)
    expected = rounds_of(list(moves))
    for gap in GAPS:
        run = run_cradle(speeds, gap)
        assert run.success
        assert in_rounds(names_of(run)) == in_rounds(expected), (speeds, gap)
        # a moving ball meets all others within the time in which it passes their gaps and those behind it
        assert all(event.t <= 2.0 * len(moves) * gap / speeds.max() for event in run.events)


def check_any_speeds(random: np.random.Generator) -> None:
    speeds = random.uniform(-2.0, 2.0, int(random.integers(2, 10)))
    pairs = sum(speeds[i] > speeds[k] for k in range(len(speeds)) for i in range(k))
    for gap in GAPS:
        run = run_cradle(speeds, gap)
        assert run.success
        assert len(run.events) == pairs, (speeds, gap)
        np.testing.assert_allclose(
            [run[f"x{k}_dot"][-1] for k in range(len(speeds))], np.sort(speeds), rtol=1e-9
        )


@pytest.mark.parametrize("seed", cases(range(30), fast=range(8)))
def test_touching_balls_hit_as_balls_with_gaps_do(seed: int) -> None:
    check_two_speeds(np.random.default_rng(seed))
    check_any_speeds(np.random.default_rng(seed))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(30, 1030))
def test_many_cradles(seed: int) -> None:
    check_two_speeds(np.random.default_rng(seed))
    check_any_speeds(np.random.default_rng(seed))
