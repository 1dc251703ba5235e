"""The cone of friction, rows by hand: balls and blocks on planes that slide, roll, turn and stop."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from numpy.typing import NDArray

from symbody.analysis.modes.reduced_modes import ModeCandidate, ModeVerdict, Responses, decide
from symbody.kernels.modes.mode_problem import CONE, HOLDS, LOOSE
from tests.kernels.contact_rows import Plane

Floats = NDArray[np.float64]

G, R, M = 9.81, 0.3, 2.0
# Rates are integrated with rtol = 1e-10; slip ends at 1e-9 of the first instead of 0.
CLOSE = 1e-8


def ball(mu: float, slope: float = 0.0) -> Plane:
    """A sphere; speeds v and w, gravity pulls along x by the slope."""
    mass = np.diag([M] * 3 + [0.4 * M * R * R] * 3)
    force = np.array([M * G * np.sin(slope), 0, -M * G * np.cos(slope), 0, 0, 0])
    slips = np.array([[1, 0, 0, 0, -R, 0], [0, 1, 0, R, 0, 0]], dtype=np.float64)
    return Plane(mass, force, np.array([[0, 0, 1.0, 0, 0, 0]]), lambda _q: slips, mu)


def block(mu: float, slope: float, static: float = 0.0) -> Plane:
    """A particle on an incline, which descends along x."""
    force = np.array([M * G * np.sin(slope), 0, -M * G * np.cos(slope)])
    slips = np.eye(3)[:2]
    return Plane(M * np.eye(3), force, np.eye(3)[2:], lambda _q: slips, mu, static)


def speeds(*values: float) -> Floats:
    return np.array(values, dtype=np.float64)


def test_a_ball_that_slides_rolls_with_five_sevenths_of_its_speed() -> None:
    mu, v = 0.2, 3.0
    plane = ball(mu)
    t, q, u = plane.slide(np.zeros(6), speeds(v, 0, 0, 0, 0, 0), 10.0)
    assert t == pytest.approx(2.0 * v / (7.0 * mu * G), rel=CLOSE)
    assert u == pytest.approx([5.0 * v / 7.0, 0, 0, 0, 5.0 * v / (7.0 * R), 0], abs=CLOSE * v / R)
    rolling = plane.decide(q, u, [False])
    assert rolling.verdict is ModeVerdict.ONE and rolling.modes == (HOLDS, HOLDS)
    assert rolling.efforts == pytest.approx([M * G, 0, 0], abs=1e-12 * M * G)


def test_a_ball_with_side_spin_runs_along_a_parabola() -> None:
    """Its slip keeps its direction, and so does friction: the path is a parabola until the ball rolls."""
    mu, v, spin = 0.2, 3.0, 12.0
    plane = ball(mu)
    t, q, u = plane.slide(np.zeros(6), speeds(v, 0, 0, spin, 0, 0), 10.0)
    slip = np.array([v, R * spin])
    way = slip / np.hypot(*slip)
    end = 2.0 * np.hypot(*slip) / (7.0 * mu * G)
    assert t == pytest.approx(end, rel=CLOSE)
    assert u[:2] == pytest.approx(np.array([v, 0.0]) - mu * G * end * way, abs=CLOSE * v)
    assert q[:2] == pytest.approx(np.array([v, 0.0]) * end - mu * G * end**2 / 2.0 * way, abs=CLOSE * v)
    assert abs(q[1]) > 0.1  # it did leave its first direction


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0])
def test_a_ball_on_a_slope_rolls_as_long_as_friction_suffices(angle: float) -> None:
    """5/7 g sin(slope) while mu >= 2/7 tan(slope); else g (sin - mu cos), with the slip along x."""
    slope, turn = 0.5, np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    edge = 2.0 / 7.0 * np.tan(slope)
    for mu, rolls in ((edge * (1.0 + 1e-6), True), (edge * (1.0 - 1e-6), False), (0.01, False), (0.0, False)):
        plane = ball(mu, slope)
        rows = plane.slips(np.zeros(6))
        turned = Plane(plane.mass, plane.force, plane.gaps, lambda _q, J=turn @ rows: J, mu)
        found = turned.decide(np.zeros(6), np.zeros(6), [False])
        assert found.verdict is ModeVerdict.ONE and found.modes == (HOLDS, HOLDS if rolls else LOOSE)
        forces = turned.force + turned.rows(np.zeros(6)).T @ found.efforts
        expected = 5.0 / 7.0 * np.sin(slope) if rolls else np.sin(slope) - mu * np.cos(slope)
        assert forces[0] / M == pytest.approx(G * expected, rel=1e-12)
        assert abs(forces[1]) < 1e-12 * M * G


def test_the_slip_of_a_block_on_an_incline_turns_and_ends() -> None:
    """With k = mu / tan(slope) and phi the angle to the descent: ``v (k + cos phi)`` falls at a constant rate.

    d/dt [v (k + cos phi)] = g sin(slope) (1 - k^2), and v sin(phi) / tan(phi/2)^k is constant.
    """
    mu, slope, v, phi = 0.6, 0.4, 2.0, 1.9
    k = mu / np.tan(slope)
    rate = G * np.sin(slope) * (k * k - 1.0)
    plane = block(mu, slope)
    start = speeds(v * np.cos(phi), v * np.sin(phi), 0)
    end = v * (k + np.cos(phi)) / rate
    for share in (0.3, 0.6, 0.9):
        _, _, u = plane.slide(np.zeros(3), start, share * end)
        now, angle = np.hypot(u[0], u[1]), np.arctan2(u[1], u[0])
        assert now * (k + np.cos(angle)) == pytest.approx((1.0 - share) * end * rate, rel=CLOSE)
        constant = v * np.sin(phi) / np.tan(phi / 2.0) ** k
        assert now * np.sin(angle) / np.tan(angle / 2.0) ** k == pytest.approx(constant, rel=CLOSE)
    t, q, u = plane.slide(np.zeros(3), start, 2.0 * end)
    assert t == pytest.approx(end, rel=CLOSE)
    rest = plane.decide(q, u, [False])
    assert rest.modes == (HOLDS, HOLDS) and rest.accelerations == pytest.approx([0.0] * 3, abs=1e-12)


def test_a_block_with_a_static_strength_rests_up_to_it() -> None:
    slope = 0.5
    for share, holds in ((1.0 + 1e-8, True), (1.0 - 1e-8, False)):
        found = block(0.5 * np.tan(slope), slope, share * np.tan(slope)).decide(
            np.zeros(3), np.zeros(3), [False]
        )
        assert found.verdict is ModeVerdict.ONE and found.modes[1] == (HOLDS if holds else LOOSE)
        wanted = 0.0 if holds else 0.5 * G * np.sin(slope)
        assert found.accelerations[1] == pytest.approx(wanted, abs=1e-12 * G)


def test_what_responds_unequally_breaks_away_against_its_acceleration() -> None:
    """Of a carriage with different masses along x and y; ``e |a| + mu N a = 0`` by another solver."""
    random = np.random.default_rng(7)
    for _ in range(200):
        root = random.normal(size=(2, 2))
        matrix = root @ root.T + 1e-3 * np.eye(2)
        offsets, bound = random.normal(size=2), 10.0 ** random.uniform(-3.0, 0.0)
        cone = ModeCandidate(CONE, sliding=bound, static=bound)
        found = decide([cone], Responses(offsets, matrix, np.zeros(0), np.zeros((0, 2))))
        assert found.verdict is ModeVerdict.ONE
        holding = np.linalg.solve(matrix, -offsets)
        assert (found.modes == (HOLDS,)) == (np.hypot(*holding) <= bound)
        # the least of a quadratic function on a disc, whose slope is the acceleration
        least = scipy.optimize.brentq(
            lambda s, A=matrix, a=offsets, b=bound: np.hypot(*np.linalg.solve(A + s * np.eye(2), -a)) - b,
            0.0, 1e4, xtol=1e-15, rtol=1e-15,
        ) if found.modes == (LOOSE,) else 0.0  # fmt: skip
        wanted = np.linalg.solve(matrix + least * np.eye(2), -offsets)
        assert found.efforts == pytest.approx(wanted, abs=1e-9 * np.hypot(*wanted))


def puck(mu: float) -> Plane:
    """A disc on three points; speeds v, z' and turns about x, y, z, its z axis vertical."""
    k = 0.7 * R
    mass = np.diag([M, M, M, M * R * R / 4, M * R * R / 4, M * R * R / 2])
    force = np.array([0, 0, -M * G, 0, 0, 0])
    places = [(k * np.cos(a), k * np.sin(a)) for a in (0.0, 2 * np.pi / 3, 4 * np.pi / 3)]
    gaps = np.array([[0, 0, 1, y, -x, 0] for x, y in places])

    def slips(q: Floats) -> Floats:
        c, s = np.cos(q[5]), np.sin(q[5])
        turned = [(c * x - s * y, s * x + c * y) for x, y in places]
        return np.array([row for x, y in turned for row in ((1, 0, 0, 0, 0, -y), (0, 1, 0, 0, 0, x))])

    return Plane(mass, force, gaps, slips, mu)


def test_a_puck_that_spins_in_place_stops_at_once_in_three_points() -> None:
    """w' = -mu g k / (R^2 / 2); at rest three cones hold three freedoms, and no effort is left."""
    mu, spin = 0.3, 8.0
    plane = puck(mu)
    t, q, u = plane.slide(np.zeros(6), speeds(0, 0, 0, 0, 0, spin), 10.0)
    slower = mu * G * 0.7 * R / (R * R / 2.0)
    assert t == pytest.approx(spin / slower, rel=CLOSE)
    assert q[5] == pytest.approx(spin**2 / (2.0 * slower), rel=CLOSE)
    rest = plane.decide(q, u, [False] * 3)
    assert rest.verdict is ModeVerdict.ONE and rest.modes == (HOLDS,) * 6
    assert rest.normals[1::2] == pytest.approx(M * G / 3.0, rel=1e-12)


def test_a_puck_that_spins_fast_slides_as_in_a_fluid() -> None:
    """To first order in v / (w k), v' = -mu g v / (2 w k) and w' as in place, so v ~ w^(R^2 / (4 k^2))."""
    mu, spin, v, k = 0.3, 8.0, 1e-5, 0.7 * R
    slower = mu * G * k / (R * R / 2.0)
    t, _, u = puck(mu).slide(np.zeros(6), speeds(v, 0, 0, 0, 0, spin), 0.5 * spin / slower)
    assert t == 0.5 * spin / slower and u[5] == pytest.approx(0.5 * spin, rel=CLOSE)
    assert u[:2] == pytest.approx([v * 0.5 ** (R * R / (4.0 * k * k)), 0.0], abs=v * 5.0 * v / (spin * k))
