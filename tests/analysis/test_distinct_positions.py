"""Each pose stands once among closed forms: random linkages whose number of poses is known."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import combinations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from tests.tiers import cases

Values = dict[str, float]
theta, beta, gamma, s, y = dynamicsymbols("theta beta gamma s y")
L1, L2, L3, L4 = sp.symbols("L1 L2 L3 L4")


@dataclass(frozen=True)
class Case:
    """A linkage: its closed forms, a draw of its values, its number of poses, and what distinguishes them."""

    solve: Callable[[], sb.PositionSolutions]
    draw: Callable[[random.Random], Values]
    count: Callable[[Values], int | None]
    pose: Callable[[Values], np.ndarray]


def directions(*angles: float) -> np.ndarray:
    return np.array([f(angle) for angle in angles for f in (math.cos, math.sin)])


def four_bar() -> sb.PositionSolutions:
    rows = [L1 * sp.cos(theta) + L2 * sp.cos(beta) - L3 * sp.cos(gamma) - L4,
            L1 * sp.sin(theta) + L2 * sp.sin(beta) - L3 * sp.sin(gamma)]  # fmt: skip
    return sb.solve_positions(rows, [beta, gamma], seconds=120)


def four_bar_count(p: Values) -> int | None:
    """Two circles, of the coupler and of the lever, meet in two points or in none."""
    span = math.hypot(p["L4"] - p["L1"] * math.cos(p["theta"]), p["L1"] * math.sin(p["theta"]))
    room = min(p["L2"] + p["L3"] - span, span - abs(p["L2"] - p["L3"]))
    return None if abs(room) < 1e-3 else 2 * (room > 0.0)


def six_bar() -> sb.PositionSolutions:
    """Two rods on one crank, to a slider along x and to one along y."""
    rows = [L1 * sp.cos(theta) + L2 * sp.cos(beta) - s, L1 * sp.sin(theta) + L2 * sp.sin(beta),
            L1 * sp.cos(theta) + L3 * sp.cos(gamma) - L4, L1 * sp.sin(theta) + L3 * sp.sin(gamma) - y]  # fmt: skip
    return sb.solve_positions(rows, [beta, s, gamma, y], seconds=120)


def six_bar_count(p: Values) -> int | None:
    """Each slider lies on either side of the foot of its rod's circle."""
    rooms = [
        p["L2"] - abs(p["L1"] * math.sin(p["theta"])),
        p["L3"] - abs(p["L4"] - p["L1"] * math.cos(p["theta"])),
    ]
    return None if min(map(abs, rooms)) < 1e-3 else 4 * (min(rooms) > 0.0)


def platform() -> sb.PositionSolutions:
    """A body on a ball joint, three of whose direction cosines are held."""
    body = sb.Body("Top", 1, (1, 1, 1))
    parts = [
        body,
        sb.Spherical("j", "ground", body, angles="xyz", coordinates=["a", "b", "c"]),
        sb.Angle("A1", "ground", body, ["x", "z"], "al"),
        sb.Angle("A2", "ground", body, ["x", "y"], "be"),
        sb.Angle("A3", "ground", body, ["y", "z"], "ga"),
    ]
    model = sb.Model("platform", parts, parameters={"al": 1.3, "be": 1.4, "ga": 1.2})
    return sb.solve_positions(sb.form_equations(model), ["a", "b", "c"], seconds=120)


def platform_count(p: Values) -> int | None:
    """Two entries of the first row of the rotation matrix and two of its last column leave two signs.

    The third entry of each follows up to its sign, and row and column determine the matrix. Each pose has
    two sets of angles, (a, b, c) and (a + pi, pi - b, c + pi).
    """
    al, be, ga = (math.cos(p[name]) ** 2 for name in ("al", "be", "ga"))
    room = min(1.0 - al - be, 1.0 - al - ga)
    return None if abs(room) < 1e-3 else 4 * (room > 0.0)


def turned(p: Values) -> np.ndarray:
    """The rotation matrix about x, y, z of the body."""
    (ca, cb, cc), (sa, sb_, sc) = ([f(p[name]) for name in "abc"] for f in (math.cos, math.sin))
    x = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
    z = np.array([[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]])
    return np.ravel(x @ np.array([[cb, 0, sb_], [0, 1, 0], [-sb_, 0, cb]]) @ z)


def lengths(rng: random.Random) -> Values:
    return {name: rng.uniform(0.3, 2.0) for name in ("L1", "L2", "L3", "L4")} | {"theta": rng.uniform(-3, 3)}


CASES = {
    "four-bar": Case(four_bar, lengths, four_bar_count, lambda p: directions(p["beta"], p["gamma"])),
    "six-bar": Case(six_bar, lengths, six_bar_count,
                    lambda p: np.append(directions(p["beta"], p["gamma"]), [p["s"], p["y"]])),
    "platform": Case(platform, lambda rng: {name: rng.uniform(0.2, 2.9) for name in ("al", "be", "ga")},
                     platform_count, turned),
}  # fmt: skip


@cache
def solved(kind: str) -> sb.PositionSolutions:
    return CASES[kind].solve()


def check_poses(kind: str, seed: int) -> None:
    """As many poses as there are, all different.

    Off double roots by 1e-3 in the length under the root, poses differ by the root of that at least.
    """
    case = CASES[kind]
    values = case.draw(random.Random(seed))
    count = case.count(values)
    if count is None:
        return
    poses = [case.pose(dict(found)) for found in solved(kind).evaluate(values) if found is not None]
    assert len(poses) == count
    assert all(np.abs(a - b).max() > 1e-3 for a, b in combinations(poses, 2))


@pytest.mark.parametrize("kind", cases(CASES, fast=["four-bar", "platform"]))
def test_each_pose_stands_once(kind: str) -> None:
    for seed in range(10):
        check_poses(kind, seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("kind", CASES)
def test_each_pose_stands_once_everywhere(kind: str) -> None:
    for seed in range(1000, 1700):
        check_poses(kind, seed)
