"""The reference kernel against 50-digit arithmetic, and at its edges."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest

from symbody.expr.sequences.saddle import SaddleSolution, solve_saddle
from tests.saddle_systems import System, exact_solution, gauss, scale_factors, sensitivity, systems

EPS = 2.0**-52


def check_accuracy(system: System) -> None:
    """The error of udot is at most 100 eps cond, with cond as `solve_saddle` defines it.

    (|K^-1| (|K| |x| + |b|))_j is what a relative change of one unit in all data can do to x_j. With one step
    of refinement the computed solution solves a system whose entries are off by a modest multiple of eps
    (Higham, section 12.1): the largest error seen in 2,400 systems was 1.0 eps cond, so 100 leaves
    room for other machines while a solution without refinement (7e3) fails. Accelerations are measured in
    units that bring diag(M) to one.
    """
    m, n = system.J.shape
    solution = solve_saddle(*system.arguments)
    assert solution.ok
    assert solution.rank == len(system.places)
    assert sum(value == 0.0 for value in solution.multipliers) >= m - solution.rank
    exact = exact_solution(system)
    scale = scale_factors(system.M, system.independent)
    allowed = 100 * EPS * sensitivity(system, exact) / scale
    error = [float(abs(a - b)) for a, b in zip(solution.udot, exact[:n], strict=True)] / scale[:n]
    assert error.max() <= allowed[:n].max()
    check_forces(system, solution)


def check_forces(system: System, solution: SaddleSolution) -> None:
    """M udot = F + J^T lambda with any choice of rows: what is left is some eps of the largest term.

    The sums below round n + m + 1 times themselves, at most 45 here; 100 as above for the kernel.
    """
    units = scale_factors(system.M, system.independent)[: len(system.F)]
    multipliers = np.array(solution.multipliers)
    terms = [system.M * solution.udot * units[:, None], system.J.T * multipliers * units[:, None]]
    left = terms[0].sum(axis=1) - terms[1].sum(axis=1) - system.F * units
    size = sum(np.abs(term).sum(axis=1) for term in terms) + np.abs(system.F * units)
    assert np.abs(left).max() <= 145 * EPS * size.max()


@pytest.mark.parametrize("seed", range(4))
def test_random_systems_against_fifty_digits(seed: int) -> None:
    for system in systems(seed, 75):
        check_accuracy(system)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(100, 110))
def test_two_thousand_random_systems(seed: int) -> None:
    for system in systems(seed, 200):
        check_accuracy(system)


def test_atwood_machine() -> None:
    # masses 3 and 1, g = 8: udot = g (m1 - m2) / (m1 + m2), rope force 2 m1 m2 g / (m1 + m2)
    solution = solve_saddle([3.0, 0.0, 0.0, 1.0], [1.0, 1.0], [24.0, 8.0], [0.0])
    assert solution.udot == pytest.approx([4.0, -4.0], abs=8 * EPS)
    assert solution.multipliers == pytest.approx([-12.0], abs=24 * EPS)
    assert (solution.rank, solution.ok) == (1, True)


def test_no_coordinates_and_no_constraints() -> None:
    assert solve_saddle([], [], [], []) == SaddleSolution([], [], 0, ok=True)
    assert solve_saddle([], [], [], [0.0, 1.0]) == SaddleSolution([], [0.0, 0.0], 0, ok=True)
    free = solve_saddle([2.0, 0.0, 0.0, 4.0], [], [2.0, 2.0], [])
    assert free == SaddleSolution([1.0, 0.5], [], 0, ok=True)


def test_massless_body_between_two_springs_of_force() -> None:
    # x1 massless, held to x0 by J; the force on x1 passes on to x0
    solution = solve_saddle([2.0, 0.0, 0.0, 0.0], [1.0, -1.0], [0.0, 6.0], [0.0])
    assert solution.udot == pytest.approx([3.0, 3.0], abs=16 * EPS)
    assert solution.multipliers == pytest.approx([6.0], abs=16 * EPS)


def test_mass_nowhere_but_all_held() -> None:
    solution = solve_saddle([0.0] * 4, [1.0, 1.0, 1.0, -1.0], [1.0, 0.0], [2.0, 0.0])
    assert solution.ok
    assert solution.udot == pytest.approx([1.0, 1.0], abs=8 * EPS)
    assert solution.multipliers == pytest.approx([-0.5, -0.5], abs=8 * EPS)


@pytest.mark.parametrize("factor", [1.0, -1.0, 3.0, 1e-6, 0.1])
def test_first_of_equal_rows_is_kept(factor: float) -> None:
    row = [0.3, 0.7, -0.2]
    J = row + [factor * x for x in row] * 3
    solution = solve_saddle(np.eye(3).ravel().tolist(), J, [1.0, 2.0, 3.0], [1.0] + [factor] * 3)
    assert solution.rank == 1
    assert solution.multipliers[0] != 0.0
    assert solution.multipliers[1:] == [0.0, 0.0, 0.0]


def test_sum_of_two_earlier_rows_is_dropped_and_its_equation_ignored() -> None:
    rng = random.Random(1)
    first, second = ([rng.gauss(0, 1) for _ in range(4)] for _ in range(2))
    J = [*first, *second, *[a + b for a, b in zip(first, second, strict=True)], *[0.0] * 4]
    M, F = np.diag([1.0, 2.0, 3.0, 4.0]).ravel().tolist(), [1.0, 1.0, 1.0, 1.0]
    consistent = solve_saddle(M, J, F, [1.0, 2.0, 3.0, 0.0])
    assert consistent.rank == 2
    assert consistent.multipliers[2:] == [0.0, 0.0]
    assert solve_saddle(M, J, F, [1.0, 2.0, 99.0, 7.0]) == consistent


def test_earlier_row_is_kept_though_a_later_one_is_farther() -> None:
    # angles to the first row: 45 degrees for the second, 90 for the third
    solution = solve_saddle([1.0, 0.0, 0.0, 1.0], [1.0, 0.0, 1.0, 1.0, 0.0, 1.0], [0.0, 0.0], [1.0, 3.0, 2.0])
    assert solution.udot == pytest.approx([1.0, 2.0], abs=16 * EPS)
    assert solution.multipliers == pytest.approx([-1.0, 2.0, 0.0], abs=16 * EPS)


@pytest.mark.parametrize("unit", [1e-14, 1e-6, 1.0, 1e6])
def test_massless_coordinate_in_odd_units(unit: float) -> None:
    solution = solve_saddle([1.0, 0.0, 0.0, 0.0], [1.0, unit, 1.0, -unit], [0.0, 0.0], [2.0, 0.0])
    assert solution.rank == 2
    assert solution.udot == pytest.approx([1.0, 1.0 / unit], rel=16 * EPS)


def test_more_rows_than_coordinates() -> None:
    solution = solve_saddle([1.0], [2.0, 4.0, 1.0], [5.0], [6.0, 12.0, 3.0])
    assert (solution.udot, solution.rank) == ([3.0], 1)
    assert solution.multipliers == [-1.0, 0.0, 0.0]


def test_rank_cut_is_a_choice() -> None:
    J, gamma = [1.0, 0.0, 1.0, 1e-4], [1.0, 1.0]
    assert solve_saddle([1.0, 0.0, 0.0, 1.0], J, [0.0, 0.0], gamma).rank == 2
    coarse = solve_saddle([1.0, 0.0, 0.0, 1.0], J, [0.0, 5.0], gamma, rank_cut=1e-3)
    assert coarse.rank == 1
    assert coarse.udot == [1.0, 5.0]


@pytest.mark.parametrize("small", [1e-3, 1e-9, 1e-17])
def test_leftovers_of_cancellation_do_no_harm(small: float) -> None:
    # An entry of J that should be zero beside massless coordinates: x1 = x2, x0 + x1 + x2 = 0, mass in x0
    entry = solve_saddle([1.0] + [0.0] * 8, [small, 1.0, -1.0, 1.0, 1.0, 1.0], [0.0, 3.0, 3.0], [0.0, 0.0])
    assert entry.udot == pytest.approx([-6 / 2, 1.5, 1.5], rel=4 * small + 64 * EPS)
    # A mass that should be zero; held by two rows, it must not matter
    held = solve_saddle([1.0, 0.0, 0.0, small**2], [1.0, 1.0, 1.0, -1.0], [0.0, 0.0], [2.0, 0.0])
    assert held.rank == 2
    assert held.udot == pytest.approx([1.0, 1.0], abs=8 * EPS)


def test_units_do_not_matter() -> None:
    """Powers of two as units of coordinates and rows change no bit: the scaling absorbs them.

    As long as all positive entries of diag(M) set the scale, that is, within 2^-40 of the largest in either
    units. Coordinates without mass get the scale of those that they are coupled to.
    """
    massless = 0
    for system in systems(17, 80):
        mass = np.diag(system.M)
        if not (mass > 0).any() or np.min(mass[mass > 0]) <= 2.0**-24 * np.max(mass):
            continue
        massless += not (mass > 0).all()
        m, n = system.J.shape
        rng = random.Random(n)
        column = np.array([2.0 ** rng.randint(-4, 4) for _ in range(n)])
        row = np.array([2.0 ** rng.randint(-30, 30) for _ in range(m)])
        M = system.M * np.outer(column, column)
        J = system.J * column * row[:, None]
        plain = solve_saddle(*system.arguments)
        F, gamma = system.F * column, system.gamma * row
        other = solve_saddle(M.ravel().tolist(), J.ravel().tolist(), F.tolist(), gamma.tolist())
        assert (np.array(other.udot) * column).tolist() == plain.udot
        assert (np.array(other.multipliers) * row).tolist() == plain.multipliers
    assert massless > 10


@pytest.mark.parametrize("length", [1e-9, 1e-7, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("teeth", [1, 3])
def test_gears_between_coordinates_without_mass(length: float, teeth: int) -> None:
    """Two bodies of mass 1 and inertias L^2; each turns an angle without mass, and gears couple these.

    Angles are w1 = -teeth w2; with torque T on the first, w1' (I1 + I2/teeth^2) = T. Between the two angles
    a chain of further ones, w -> a -> b -> ... coupled by gears of 1 : 1, changes nothing.
    """
    inertia = length**2
    for chain in range(4):
        n = 6 + chain  # x1, w1, x2, w2, a1, a2, chain
        M = np.zeros((n, n))
        M[range(4), range(4)] = 1.0, 2 * inertia, 1.0, 3 * inertia
        rows = [{1: 1, 4: -1}, {3: 1, 5: -1}]
        links = [4, *range(6, n)]
        rows += [{a: 1, b: -1} for a, b in zip(links[:-1], links[1:], strict=True)]
        rows.append({links[-1]: 1, 5: teeth})
        J = np.zeros((len(rows), n))
        for k, row in enumerate(rows):
            J[k, list(row)] = list(row.values())
        F = np.zeros(n)
        F[0], F[1] = 1 / length, 1.0
        solution = solve_saddle(M.ravel().tolist(), J.ravel().tolist(), F.tolist(), [0.0] * len(rows))
        assert solution.ok and solution.rank == len(rows)
        first = 1 / (2 * inertia + 3 * inertia / teeth**2)
        expected = np.full(n, first)
        expected[[0, 2, 3, 5]] = 1 / length, 0.0, -first / teeth, -first / teeth
        np.testing.assert_allclose(solution.udot, expected, rtol=64 * EPS, atol=16 * EPS / length)


def test_fifty_digits_in_fifty_digits_out() -> None:
    with mpmath.workdps(50):
        for system in systems(23, 20):
            if system.J.shape[0] != len(system.places):
                continue
            given = [[mpmath.mpf(x) for x in argument] for argument in system.arguments]
            solution = solve_saddle(*given)
            exact = exact_solution(system)
            allowed = 1e-45 * sensitivity(system, exact)  # 50 digits less the same factor 100, and some
            for j, value in enumerate(solution.udot):
                assert isinstance(value, mpmath.mpf)
                assert abs(value - exact[j]) <= allowed[j]


def test_mass_missing_on_an_admissible_motion() -> None:
    # x0 and x1 move one body together: M = (1, 1)^T (1, 1); x2 has a body of its own
    M = [1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    free = solve_saddle(M, [0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0])
    assert (free.ok, free.rank) == (False, 1)
    assert all(math.isnan(value) for value in free.udot + free.multipliers)
    held = solve_saddle(M, [1.0, -1.0, 0.0], [1.0, 1.0, 1.0], [0.0])
    assert held.udot == pytest.approx([0.5, 0.5, 1.0], abs=16 * EPS)


def test_indefinite_mass_matrix_fails() -> None:
    assert not solve_saddle([1.0, 0.0, 0.0, -1.0], [], [1.0, 1.0], []).ok


def test_mass_missing_in_any_admissible_direction_fails() -> None:
    """Remove the mass of one admissible direction a: M' = P M P with P = I - a a^T, |a| = 1, J a = 0."""
    cases = 0
    for system in systems(31, 120):
        n, kept = len(system.F), len(system.places)
        if kept == n:
            continue
        scale = scale_factors(system.M, system.independent)
        units = scale[:n]
        J = system.independent * np.outer(scale[n:], units)
        a = np.linalg.svd(J)[2][-1] if kept else np.eye(n)[0]
        P = np.eye(n) - np.outer(a, a)
        M = P @ (system.M * np.outer(units, units)) @ P
        mass = ((M + M.T) / 2 / np.outer(units, units)).ravel().tolist()
        _, rows, F, gamma = system.arguments
        assert not solve_saddle(mass, rows, F, gamma).ok
        cases += 1
    assert cases > 50


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_constraints_that_are_not_finite_fail(bad: float) -> None:
    solution = solve_saddle([1.0, 0.0, 0.0, 1.0], [1.0, 0.0, bad, 1.0], [1.0, 1.0], [0.0, 0.0])
    assert (solution.ok, solution.rank) == (False, 0)


def test_mass_that_is_nan_fails() -> None:
    assert not solve_saddle([1.0, math.nan, math.nan, 1.0], [], [1.0, 1.0], []).ok


def test_derivative_rule() -> None:
    """The derivative solves the same system with F' + J'^T lambda - M' udot and gamma' - J' udot.

    Central differences with step 1e-15 in 50 digits: truncation (1e-30 cond^2) and cancellation (1e-35 cond)
    leave 12 digits while cond stays below 1e9.
    """
    step = mpmath.mpf(10) ** -15
    with mpmath.workdps(50):
        for system in systems(41, 6):
            m, n = system.independent.shape
            rng = random.Random(n)
            data = [system.M.ravel(), system.independent.ravel(), system.F, system.gamma_independent]
            given = [[mpmath.mpf(x) for x in part.tolist()] for part in data]
            rate = [[mpmath.mpf(x) * rng.uniform(-1, 1) for x in part] for part in given]
            for i in range(n):
                for j in range(i):
                    rate[0][i * n + j] = rate[0][j * n + i]
            ahead, behind = (_moved(given, rate, sign * step) for sign in (1, -1))
            difference = [(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
            here = solve_saddle(*given)
            F, gamma = list(rate[2]), list(rate[3])
            for j in range(n):
                F[j] += sum(rate[1][i * n + j] * here.multipliers[i] for i in range(m))
                F[j] -= sum(rate[0][j * n + i] * here.udot[i] for i in range(n))
            for i in range(m):
                gamma[i] -= sum(rate[1][i * n + j] * here.udot[j] for j in range(n))
            derivative = solve_saddle(given[0], given[1], F, gamma)
            size = max(abs(x) for x in difference)
            for a, b in zip(derivative.udot + derivative.multipliers, difference, strict=True):
                assert abs(a - b) <= 1e-12 * size


def _moved(given: list[list[mpmath.mpf]], rate: list[list[mpmath.mpf]], step: mpmath.mpf) -> list[mpmath.mpf]:
    M, J, F, gamma = (
        [x + step * dx for x, dx in zip(part, change, strict=True)]
        for part, change in zip(given, rate, strict=True)
    )
    n, m = len(F), len(gamma)
    top = [M[i * n : i * n + n] + [-J[k * n + i] for k in range(m)] for i in range(n)]
    bottom = [J[k * n : k * n + n] + [mpmath.mpf(0)] * m for k in range(m)]
    return gauss(top + bottom, F + gamma)
