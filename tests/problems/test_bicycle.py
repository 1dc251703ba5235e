"""The Whipple bicycle against its benchmark.

Meijaard, Papadopoulos, Ruina, Schwab, Linearized dynamics equations for the balance and steer of a bicycle: a
benchmark and review, Proc. R. Soc. A 463 (2007), 1955-1982; figures from its tables 1 and 2 and section 5.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb
from tests.problems.mechanisms import Array, equations_of
from tests.spectra import assert_same_spectrum

NAME = "bicycle"
ANGLES = ("lean", "steer")
RADIUS, G = 0.3, 9.81
UPRIGHT = dict.fromkeys(("x", "y", "yaw", "rear", "front", "lean", "steer", "lean_dot", "steer_dot"), 0.0)
# M q'' + v C1 q' + (g K0 + v^2 K2) q = 0, with q = (lean, steer), steer positive to the right.
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0.0, 76.59734589573222], [0.0, 2.65431523794604]])
C1 = np.array([[0.0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
CYCLIC = ("x", "y", "yaw", "rear", "front")
# Figures of the paper have 15 digits; here 1e5 N/m-like terms of condition 30 cancel to order one.
NEAR = 1e-10


@cache
def linear(v: float) -> sb.Linearization:
    """Small deviations from riding straight on at a forward speed."""
    return sb.linearize(equations_of(NAME), UPRIGHT | {"rear_dot": v / RADIUS}, cyclic=CYCLIC)


def columns(v: float, rates: bool) -> Array:
    """How the accelerations of lean and steer change with these angles, or with their rates."""
    lin = linear(v)
    rows = [lin.state_names.index(f"{name}_dot") for name in ANGLES]
    found: Array = lin.A[np.ix_(rows, rows if rates else [lin.state_names.index(name) for name in ANGLES])]
    return found


def first_order(by_rates: Array, by_angles: Array) -> Array:
    """The matrix of the first-order equations of (rates, angles)."""
    return np.block([[by_rates, by_angles], [np.eye(2), np.zeros((2, 2))]])


def test_three_freedoms_of_nine_speeds() -> None:
    eqs = equations_of(NAME)
    assert eqs.degrees_of_freedom == 3
    assert (len(eqs.speed_names), len(eqs.multiplier_names), len(eqs.constraints)) == (9, 6, 2)
    found = sb.redundancy(eqs)
    assert found.degrees_of_freedom == 3 and not found.dropped


def test_it_stands_upright_though_some_starts_end_where_forces_are_not_finite() -> None:
    state = sb.find_equilibrium(equations_of(NAME))
    assert state.q["lean"] == pytest.approx(0.0, abs=1e-9) and state.q["z"] == pytest.approx(RADIUS)
    assert max(map(abs, state.udot.values())) < 1e-6


def test_steady_ride_upright() -> None:
    state = sb.assemble(equations_of(NAME), UPRIGHT | {"rear_dot": 5 / RADIUS})
    assert state["z"] == pytest.approx(RADIUS, abs=1e-12) and state["x_dot"] == pytest.approx(5, abs=1e-12)
    assert max(map(abs, state.udot.values())) < 1e-11
    # Moments about the front contact: 2 kg at 1.02 m, 85 kg at 0.72 m, 4 kg at 0.12 m before it.
    rear = G * (2 * 1.02 + 85 * 0.72 + 4 * 0.12) / 1.02
    assert state.multipliers["lambda_rear_tyre_1"] == pytest.approx(rear, rel=1e-12)
    assert state.multipliers["lambda_front_tyre_1"] == pytest.approx(94 * G - rear, rel=1e-12)


def test_eigenvalues_at_five_metres_a_second() -> None:
    lin = linear(5.0)
    assert lin.is_stationary and sorted(lin.state_names) == sorted(
        ("lean_dot", "rear_dot", "steer_dot", "lean", "steer")
    )
    weave = -0.775341882195845 + 4.46486771378823j
    # The fifth is the forward speed, which nothing changes.
    expected = np.array([-14.0783896927982, weave.conjugate(), weave, -0.322866429004087, 0.0])
    assert_same_spectrum(lin.eigenvalues, expected, atol=NEAR)
    assert lin.verdict == "marginal" and linear(8.0).verdict == linear(3.5).verdict == "unstable"


@pytest.mark.exhaustive
@pytest.mark.parametrize("v", [0.0, 1.0, 4.0, 5.0, 8.0])
def test_linear_equations_of_the_paper(v: float) -> None:
    flip = np.diag([1.0, -1.0])  # the steer angle here is positive to the left
    by_rates = -flip @ np.linalg.solve(M, v * C1) @ flip
    by_angles = -flip @ np.linalg.solve(M, G * K0 + v**2 * K2) @ flip
    np.testing.assert_allclose(columns(v, True), by_rates, atol=NEAR)
    np.testing.assert_allclose(columns(v, False), by_angles, atol=NEAR)


@pytest.mark.exhaustive
def test_weave_and_capsize_speeds() -> None:
    """Rates enter in proportion to the speed, angles with a constant and its square: two speeds determine them."""
    still, fast = columns(0.0, False), columns(5.0, False)

    def growth(v: float) -> Array:
        matrix = first_order(columns(5.0, True) * v / 5, still + (fast - still) * (v / 5) ** 2)
        return np.linalg.eigvals(matrix)

    weave, capsize = 4.29238253634111, 6.02426201538837
    # Real parts change by about 1 per m/s at the weave speed and 0.1 per m/s at the capsize speed.
    oscillating = growth(weave)
    assert np.abs(oscillating[np.abs(oscillating.imag) > 1].real).max() < NEAR
    assert np.abs(growth(capsize)).min() < NEAR
    assert growth(weave - 0.01).real.max() > 0 > growth(weave + 0.01).real.max()
    assert growth(capsize - 0.01).real.max() < 0 < growth(capsize + 0.01).real.max()


def test_a_small_lean_dies_out() -> None:
    start = UPRIGHT | {"lean": 0.02, "rear_dot": 5 / RADIUS}
    run = sb.simulate(equations_of(NAME), 12.0, start)
    assert run.success
    # The slowest of the four motions is the capsize: exp(-0.3229 t).
    lean = run.at(np.array([8.0, 12.0]))["lean"]
    assert lean[1] / lean[0] == pytest.approx(np.exp(-0.3228664 * 4), rel=0.02)
    assert np.abs(run["lean"][-1]) < 0.02 * np.exp(-0.32 * 12) * 2
    assert run.constraint_violation.max() < 1e-9 and run.velocity_violation.max() < 1e-9
    # A local error of 1e-8 of the speeds in each step, all of one sign at worst.
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()


@pytest.mark.exhaustive
@pytest.mark.parametrize(("v", "steady"), [(3.5, False), (4.6, True), (5.5, True)])
def test_stable_between_the_two_speeds(v: float, steady: bool) -> None:
    run = sb.simulate(equations_of(NAME), 8.0, UPRIGHT | {"lean_dot": 0.01, "rear_dot": v / RADIUS})
    late = np.abs(run["lean"][run.t > 6.0]).max()
    early = np.abs(run["lean"][run.t < 2.0]).max()
    assert run.success and (late < early) == steady


@pytest.mark.exhaustive
def test_speeds_eliminated_by_pivoting_ride_alike() -> None:
    """Rolling takes four of nine speeds, contacts on positions stay: the same eigenvalues, the same ride."""
    eqs = sb.form_equations(equations_of(NAME).model, dependent_speeds="auto")
    assert len(eqs.speed_names) == 5 and set(eqs.multiplier_names) == {
        "lambda_rear_tyre_1",
        "lambda_front_tyre_1",
    }
    assert any("chosen by column pivoting" in note for note in eqs.notes)
    found = sb.linearize(eqs, UPRIGHT | {"rear_dot": 5 / RADIUS}, cyclic=CYCLIC).eigenvalues
    expected = linear(5.0).eigenvalues
    assert_same_spectrum(found, expected, atol=NEAR)
    start, times = UPRIGHT | {"lean": 0.02, "rear_dot": 5 / RADIUS}, np.linspace(0.0, 3.0, 7)
    runs = [sb.simulate(each, 3.0, start, times=times) for each in (eqs, equations_of(NAME))]
    for name in ("lean", "steer", "yaw", "x", "y", "steer_dot", "lambda_rear_tyre_2"):
        # Local errors of 1e-8 in some fifty steps; forces of 500 N follow from accelerations.
        close = 1e-3 if name.startswith("lambda") else 1e-5
        assert np.abs(runs[0][name] - runs[1][name]).max() < close, name
