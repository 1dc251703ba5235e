"""`SetBaumgarte`: what it adds, and that constraints decay as its constants say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs, BuildSimCode, ModelEquations
from symbody.errors import UsageError
from tests.problems.mechanisms import EXAMPLES

T = dynamicsymbols._t
CRANK = EXAMPLES / "slider_crank" / "slider_crank.toml"


@pytest.fixture
def built() -> ModelEquations:
    return BuildEQs(CRANK)


def test_nothing_is_stabilized_unless_asked(built: ModelEquations) -> None:
    before = built.vAccRHS
    assert built.SetBaumgarte() == (0.0, 0.0)
    assert built.SetBaumgarte([3, 4]) == (3.0, 4.0) == built.SetBaumgarte()
    assert built.vAccRHS != before
    built.SetBaumgarte([0, 0])
    assert built.vAccRHS == before


def test_what_is_added_to_the_acceleration_constraints(built: ModelEquations) -> None:
    """2 alpha Psi' + beta^2 Psi, on the other side of the equation; all else stays."""
    gamma, velocity, forcing = built.vAccRHS, built.GetVelCons(), built.vF
    alpha, beta = sp.Rational(5, 2), 4
    built.SetBaumgarte((2.5, 4))
    built.SetBaumgarte((2.5, 4))  # twice is once
    Psi = sp.Matrix([equation.lhs for equation in built.GetPosCons()])
    added = gamma - built.vAccRHS - 2 * alpha * Psi.diff(T) - beta**2 * Psi
    rng = np.random.default_rng(1)
    for _ in range(5):
        point = {s: float(x) for s, x in zip(built.vX, rng.uniform(0.3, 1.3, 6), strict=True)}
        values = {"L1": 0.4, "L2": 1.0}
        numbers = (
            added.subs({s: x for s, x in point.items() if s.has(sp.Derivative)}).subs(point).subs(values)
        )
        # A dozen terms below 50.
        assert [abs(float(value)) < 1e-12 for value in numbers] == [True, True]
    assert built.GetVelCons() == velocity and built.vF == forcing


def test_constraints_decay_as_the_constants_say(built: ModelEquations) -> None:
    """Psi'' + 2 alpha Psi' + beta^2 Psi = 0 from an open loop: with alpha = beta, (1 + beta t) exp(-beta t)."""
    built.SetBaumgarte([5, 5])
    assert list(built.vX)[3:] == list(built.vQ)
    pXdot = BuildSimCode(built, {"Xdot"}, "MapleProc", "Optimize", {"F": 0})
    assert callable(pXdot) and pXdot.__name__ == "pXdot"
    start = sb.assemble(built.equations, {"theta": 0.5, "theta_dot": 0})
    opened = np.array([0.0, 0.0, 0.0, start.q["theta"], start.q["beta"], start.q["s"] + 1e-3])
    solution = solve_ivp(pXdot, (0, 1), opened, method="DOP853", rtol=1e-10, atol=1e-13, t_eval=[0, 0.5, 1])
    gap = sb.compile(built.equations, "constraints").of_state(solution.t, solution.y.T, [0.0])
    expected = np.outer((1 + 5 * solution.t) * np.exp(-5 * solution.t), gap[0])
    # Local errors of 1e-10 of coordinates of order 1, over about a hundred steps.
    assert np.abs(gap - expected).max() < 1e-8


def test_wrong_constants_are_told(built: ModelEquations) -> None:
    wrong: list[Any] = [5, [1], [1, 2, 3], [-1, 1], [1, float("nan")], ["a", 1]]
    for pair in wrong:
        with pytest.raises(UsageError) as caught:
            built.SetBaumgarte(pair)
        assert caught.value.problems[0].code == "dynaflexpro.baumgarte"
    assert built.SetBaumgarte() == (0.0, 0.0)
