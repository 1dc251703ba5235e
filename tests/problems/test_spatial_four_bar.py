"""Spatial four-bar (RSSR): a loop in space, its trees, its two freedoms and its reactions."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.graph.trees import TreeChoice, Trees
from tests.problems.mechanisms import (
    EPS,
    Array,
    absolute_values,
    condition,
    equations_of,
    model_of,
    motions,
    numbers_of,
    random_values,
    state_of,
)
from tests.tiers import cases

NAME = "spatial_four_bar"
TREES: dict[str, TreeChoice] = {
    "cut at the ball": Trees(("motor", "hinge", "socket"), ("motor", "hinge", "socket")),
    "cut at the hinge": Trees(("motor", "ball", "socket"), ("motor", "ball", "socket")),
    "joints": "joints",
    "absolute": "absolute",
    "rotation by motor, ball, hinge, translation by motor, ball, socket": Trees(
        ("motor", "ball", "hinge"), ("motor", "ball", "socket")
    ),
}


def angles_321(R: Array, w: Array) -> tuple[Array, Array]:
    """Yaw, pitch, roll of R = Rz Ry Rx, and their rates from the angular velocity in the turned axes."""
    a, b, c = np.arctan2(R[1, 0], R[0, 0]), -np.arcsin(R[2, 0]), np.arctan2(R[2, 1], R[2, 2])
    along = np.array(
        [
            [-np.sin(b), 0, 1],
            [np.cos(b) * np.sin(c), np.cos(c), 0],
            [np.cos(b) * np.cos(c), -np.sin(c), 0],
        ]
    )
    return np.array([a, b, c]), np.linalg.solve(along, w)


def test_two_freedoms_and_three_constraints() -> None:
    eqs = equations_of(NAME)
    assert eqs.coordinate_names == ("theta", "psi", "chi", "sigma", "phi")
    assert eqs.multiplier_names == tuple(f"lambda_socket_{k}" for k in (1, 2, 3))
    assert eqs.degrees_of_freedom == 2
    assert eqs.mass_matrix.shape == (5, 5) and eqs.constraints.shape == (3, 1)


def test_spin_of_the_rod_is_free() -> None:
    """Nothing drives or resists the spin: in a motion at rest nothing moves the rod about itself."""
    eqs = equations_of(NAME)
    rng = np.random.default_rng(8)
    values = random_values(eqs, rng)
    spun = values | {"sigma": values["sigma"] + 1.0}
    udot = sb.compile(eqs, "udot")
    plain, turned = (udot(0.0, st.q, st.u, st.r) for st in (state_of(eqs, values), state_of(eqs, spun)))
    # The rod is the same all round: its position about itself changes nothing.
    assert turned == pytest.approx(plain, abs=100 * EPS * condition(eqs, state_of(eqs, values)) * 10)


def test_power_of_the_reactions_is_zero() -> None:
    """Energy changes by the power of the motor's torque alone."""
    eqs = equations_of(NAME)
    rng = np.random.default_rng(9)
    function = sb.compile(eqs, ["xdot", "power"])
    energy = sb.compile(eqs, "energy")
    for _ in range(10):
        state = state_of(eqs, random_values(eqs, rng))
        rate, power = function(0.0, state.q, state.u, state.r)
        n, h = len(state.u), 1e-6
        ahead, behind = (
            energy(0.0, state.q + k * rate[n:], state.u + k * rate[:n], state.r) for k in (h, -h)
        )
        # eps / h of energies up to 30 and h^2 of third derivatives up to 1e4.
        assert (ahead - behind) / (2 * h) == pytest.approx(power, abs=1e-7)
        assert power == pytest.approx(state.r[0] * state.u[0], abs=1e-14)


@pytest.mark.parametrize("choice", cases(TREES, fast=["cut at the hinge", "absolute"]))
def test_every_tree_gives_the_same_motion_and_reactions(choice: str) -> None:
    reference = equations_of(NAME)
    eqs = sb.form_equations(model_of(NAME), tree=TREES[choice])
    assert eqs.degrees_of_freedom == 2
    if choice == "absolute":
        assert len(eqs.speeds) == 18 and len(eqs.multiplier_names) == 16
    expect, measure = motions(reference), motions(eqs)
    rng = np.random.default_rng(10)
    violations = sb.compile(eqs, ["constraints", "velocity_constraints"])
    for _ in range(100):
        values = random_values(reference, rng)
        start = state_of(reference, values)
        expected = expect(start)
        rod, rocker = expected["frame R Rod ground"], expected["frame R Rocker ground"]
        spin = expected["frame w Rocker ground ground"] - expected["frame w Rod ground ground"]
        angles, rates = angles_321(rod.T @ rocker, rocker.T @ spin)
        values |= {f"socket_{k + 1}": float(angle) for k, angle in enumerate(angles)}
        values |= {f"socket_{k + 1}_dot": float(rate) for k, rate in enumerate(rates)}
        state = state_of(eqs, values | absolute_values(eqs, expected))
        worst = max(condition(reference, start), condition(eqs, state))
        for part in violations(0.0, state.q, state.u, state.r):
            assert np.abs(part).max(initial=0.0) < 10 * EPS * worst
        found = measure(state)
        scale = max(1.0, *(np.abs(entry).max() for entry in expected.values()))
        for name, value in expected.items():
            assert np.abs(found[name] - value).max() < 100 * EPS * worst * scale, name


def test_reactions_hold_the_rod() -> None:
    eqs = equations_of(NAME)
    p = numbers_of(eqs.model)
    measure = motions(eqs)
    rng = np.random.default_rng(11)
    for _ in range(20):
        state = state_of(eqs, random_values(eqs, rng))
        found = measure(state)
        ball = found["frame R Crank ground"] @ found["reaction ball"][:3]
        socket = found["frame R Rod ground"] @ found["reaction socket"][:3]
        weight = np.array([0, 0, -p["G"]])
        force = p["m2"] * (found["frame vdot Rod ground ground"] - weight)
        tolerance = 100 * EPS * condition(eqs, state) * max(1.0, np.abs(ball).max())
        assert np.abs(ball - socket - force).max() < tolerance
        assert np.abs(found["reaction ball"][3:]).max() < tolerance  # no moment in a ball joint
