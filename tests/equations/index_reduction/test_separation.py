"""Derivatives separated from hidden constraints: the notes' way to initial conditions, step by step."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb

T = dynamicsymbols._t
x, y, vx, vy, lam = dynamicsymbols("x y vx vy lam")
m, g, L, k = sp.symbols("m g L k")

PENDULUM = [m * vx.diff(T) + 2 * lam * x, m * vy.diff(T) + 2 * lam * y + m * g, x.diff(T) - vx, y.diff(T) - vy,
            x**2 + y**2 - L**2]  # fmt: skip
UNKNOWNS = [x, y, vx, vy, lam]
RATES = [unknown.diff(T) for unknown in UNKNOWNS]


def same(a: sp.Expr, b: sp.Expr) -> bool:
    """Whether two expressions are proportional: an equation = 0 says the same times a factor without unknowns."""
    ratio = sp.cancel(sp.together(a / b))
    return ratio != 0 and not ratio.atoms(sp.Function)


def test_pendulum_in_cartesian_coordinates_takes_three_calls() -> None:
    dae1, alg1 = sb.separate_derivatives(PENDULUM, RATES)
    dae2, alg2 = sb.separate_derivatives(dae1, RATES)
    last = sb.separate_derivatives(dae2, RATES)
    ode, alg3 = last
    # Hairer & Wanner 1996, section VII.1, example (1.19): positions, velocities, accelerations.
    assert [len(alg1), len(alg2), len(alg3)] == [1, 1, 1]
    assert same(alg1[0], x**2 + y**2 - L**2)
    assert same(alg2[0], x * vx + y * vy)
    assert same(alg3[0], m * (vx**2 + vy**2) - m * g * y - 2 * lam * (x**2 + y**2))
    assert len(ode) == 5 and sb.separate_derivatives(ode, RATES).algebraic == []
    assert last.assumed_nonzero == (m,)


def test_the_ordinary_equations_have_the_known_rates() -> None:
    reduced = sb.reduce_index(PENDULUM, UNKNOWNS)
    assert reduced.index == 3 and len(reduced.ode) == 5
    at = {x: sp.Rational(3, 5), y: -sp.Rational(4, 5), vx: 4, vy: 3, m: 2, g: 10, L: 1}
    # By hand: v^2 + x x'' + y y'' = 0 gives 2 lam L^2 = m (v^2 - g y) = 66; v . v' = -g vy, so that
    # 2 lam' L^2 = m (2 v . v' - g vy) = -3 m g vy = -180.
    assert sp.solve(reduced.algebraic[2][0].subs(at), lam) == [33]
    letters = sp.symbols("r:5")
    rows = [row.subs(dict(zip(RATES, letters, strict=True))).subs(lam, 33).subs(at) for row in reduced.ode]
    (rates,) = sp.linsolve(rows, letters)
    # x'' = -2 lam x / m, y'' = -2 lam y / m - g
    assert list(rates) == [4, 3, -sp.Rational(99, 5), sp.Rational(132, 5) - 10, -90]


def two_bodies() -> tuple[list[sp.Expr], list[sp.Expr], list[sp.Expr], list[sp.Expr]]:
    """The notes' count: a revolute and a prismatic joint to ground and a rod; equations, q, v, reactions."""
    x1, y1, a1, x2, y2, a2 = q = dynamicsymbols("x10 y10 theta1 x20 y20 theta2")
    v, reactions = list(dynamicsymbols("v1:7")), list(dynamicsymbols("R1:6"))
    m1, m2, I1, I2, L1, L2 = sp.symbols("m1 m2 I1 I2 L1 L2")
    tip = (x1 + L1 * sp.cos(a1), y1 + L1 * sp.sin(a1))
    Phi = [x1 - L1 * sp.cos(a1), y1 - L1 * sp.sin(a1), x2 - 2, a2,
           (x2 - tip[0]) ** 2 + (y2 - tip[1]) ** 2 - L2**2]  # fmt: skip
    J = sp.Matrix(Phi).jacobian(q)
    M = sp.diag(m1, m1, I1, m2, m2, I2)
    gravity = sp.Matrix([0, -m1 * g, 0, 0, -m2 * g, 0])
    motion = list(M * sp.Matrix(v).diff(T) - gravity - J.T * sp.Matrix(reactions))
    return [*(a.diff(T) - b for a, b in zip(q, v, strict=True)), *motion, *Phi], list(q), v, reactions


DATA = {"m1": 1.5, "m2": 0.7, "I1": 0.2, "I2": 0.1, "L1": 1.0, "L2": 2.5, "g": 9.81}


def test_two_bodies_have_17_equations_and_15_hidden_constraints() -> None:
    equations, q, v, reactions = two_bodies()
    unknowns = [*q, *v, *reactions]
    rates = [unknown.diff(T) for unknown in unknowns]
    dae1, alg1 = sb.separate_derivatives(equations, rates)
    dae2, alg2 = sb.separate_derivatives(dae1, rates)
    ode, alg3 = sb.separate_derivatives(dae2, rates)
    assert len(equations) == 6 + 6 + 5 == 17 == len(ode)
    hidden = [*alg1, *alg2, *alg3]
    assert len(hidden) == 3 * 5
    # One freedom: theta1 and its rate are given; 5 positions, 5 velocities and 5 reactions are the unknowns.
    dependent = [s for s in unknowns if s not in (q[2], v[2])]
    assert len(dependent) == 15 == len(hidden)
    values = solve_hidden(
        hidden, unknowns, {q[2]: 0.2, v[2]: 0.1}, [0.98, 0.2, 0.2, 2.0, 2.5, 0.0] + [0.1] * 6
    )
    _check_against_augmented(values, equations, q, v, reactions)


def solve_hidden(
    rows: list[sp.Expr], unknowns: list[sp.Expr], given: dict[sp.Expr, float], guess: list[float]
) -> dict[sp.Expr, float]:
    """All unknowns at once by Newton's method, as `solve(alg_constr, unknowns)` of the notes with numbers."""
    numbers = {sp.Symbol(name): value for name, value in DATA.items()} | given
    open_ = [unknown for unknown in unknowns if unknown not in given]
    letters = sp.symbols(f"w:{len(open_)}")
    named = [row.subs(dict(zip(open_, letters, strict=True))).subs(numbers) for row in rows]
    F = sp.lambdify([letters], named)
    slope = sp.lambdify([letters], sp.Matrix(named).jacobian(letters))
    start = dict(zip(unknowns, [*guess, *[0.0] * (len(unknowns) - len(guess))], strict=True))
    w = np.array([start[unknown] for unknown in open_])
    for _ in range(30):
        w = w - np.linalg.solve(np.array(slope(w), float), np.array(F(w), float))
    assert np.abs(F(w)).max() < 1e-10
    return dict(zip(open_, w, strict=True)) | given


def _check_against_augmented(
    values: dict[sp.Expr, float],
    equations: list[sp.Expr],
    q: list[sp.Expr],
    v: list[sp.Expr],
    r: list[sp.Expr],
) -> None:
    """4.4.2, the special way: [[M, N], [Phi_q, 0]] (v', R) = (f, -(Phi_q v)_q v) at the same state."""
    numbers = {sp.Symbol(name): value for name, value in DATA.items()}
    motion, Phi = equations[6:12], sp.Matrix(equations[12:])
    J = Phi.jacobian(q)
    change = (J * sp.Matrix(v)).jacobian(q) * sp.Matrix(v)
    A = sp.Matrix(motion).jacobian([*sp.Matrix(v).diff(T), *r]).col_join(J.row_join(sp.zeros(5)))
    still = {rate: 0 for rate in [*sp.Matrix(v).diff(T), *r]}
    b = (-sp.Matrix(motion).subs(still)).col_join(-change)
    state = {s: values[s] for s in (*q, *v)}
    solved = np.linalg.solve(*(np.array(X.subs(state).subs(numbers), float) for X in (A, b)))[:, 0]
    # Two ways through systems of condition below 1e4: a few hundred eps each.
    assert [values[s] for s in r] == pytest.approx(list(solved[6:]), rel=1e-9, abs=1e-9)


def test_pivots_that_could_vanish_are_listed() -> None:
    a, b = dynamicsymbols("a b")
    parted = sb.separate_derivatives(
        [x * a.diff(T) + b.diff(T) * y - 1, x**2 * a.diff(T) + k * b], [a.diff(T), b.diff(T)]
    )
    assert parted.algebraic == [] and len(parted.assumed_nonzero) == 2
    singular = sb.separate_derivatives([x * a.diff(T) - 1, x**2 * a.diff(T) - k * b], [a.diff(T), b.diff(T)])
    assert singular.assumed_nonzero == (x,)
    assert same(singular.algebraic[0], x * (x - k * b))  # x (x^2 a' - k b) - x^2 (x a' - 1)


def test_an_equation_that_follows_is_dropped_and_told() -> None:
    parted = sb.separate_derivatives([x.diff(T) - y, 2 * x.diff(T) - 2 * y], [x.diff(T), y.diff(T)])
    assert parted.dropped == (1,) and parted.algebraic == [] and len(parted.equations) == 1


def test_cosine_squared_plus_sine_squared_is_seen() -> None:
    a = dynamicsymbols("a")
    rows = [sp.cos(a) ** 2 * x.diff(T) - y, (1 - sp.sin(a) ** 2) * x.diff(T) - vx]
    parted = sb.separate_derivatives(rows, [x.diff(T), y.diff(T)])
    assert len(parted.algebraic) == 1 and not parted.algebraic[0].has(sp.Derivative)


def test_equations_may_be_written_with_two_sides() -> None:
    one = sb.separate_derivatives([sp.Eq(x.diff(T), y), sp.Eq(x, 3 * k)], [x.diff(T), y.diff(T)])
    assert one.algebraic == [-3 * k + x] and one.equations[1] == x.diff(T)


REFUSED = {
    "reduction.inconsistent": ([x - 1, x.diff(T) - y, 2 * x.diff(T) - 2 * y + k], [x, y, vx]),
    "reduction.number": ([x.diff(T) - y], [x, y]),
    "reduction.not_linear": ([x.diff(T) ** 2 - y, y.diff(T)], [x, y]),
    "reduction.undetermined": ([x.diff(T) - y, 2 * x.diff(T) - 2 * y], [x, y]),
    "reduction.derivative": ([x.diff(T) - y, y.diff(T)], [x, x]),
}


@pytest.mark.parametrize("code", REFUSED)
def test_refusals_name_cause_and_cure(code: str) -> None:
    equations, unknowns = REFUSED[code]
    with pytest.raises(sb.FormulationError) as caught:
        sb.reduce_index(equations, unknowns)
    (problem, *_) = caught.value.problems
    assert problem.code == code and problem.what and problem.fix


def test_without_mass_a_pivot_vanishes_on_the_constraints() -> None:
    reduced = sb.reduce_index([row.subs(m, 0) for row in PENDULUM], UNKNOWNS)
    # lam x = lam y = 0 on the circle: lam = 0, and a pivot that was listed is 0 there.
    at = {lam: 0, x: sp.Rational(3, 5), y: sp.Rational(4, 5), L: 1}
    assert any(pivot.subs(at) == 0 for pivot in reduced.assumed_nonzero)


def test_constraints_that_contradict_each_other_are_named() -> None:
    rows = [*PENDULUM[:4], x - 1, x - 2]
    mu = dynamicsymbols("mu")
    with pytest.raises(sb.FormulationError) as caught:
        sb.reduce_index(rows, [*UNKNOWNS, mu])
    assert caught.value.problems[0].code in ("reduction.inconsistent", "reduction.undetermined")


def test_unknowns_have_to_be_given_with_a_list() -> None:
    with pytest.raises(sb.FormulationError, match="unknowns"):
        sb.reduce_index(PENDULUM)
