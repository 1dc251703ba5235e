"""`Delay`: the approximation of Pade to its digits, in steps as its fastest pole asks for."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import symbody as sb

ORDERS = range(1, 11)
TIME = 0.1


def delayed(order: int, time: float | str = TIME) -> sb.EquationSet:
    drive = sb.Drive(applied="cos(3*t) - x + F")
    parts = [sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=drive)]
    model = sb.Model(
        "delayed", [*parts, sb.Delay("y", "F", time, order=order)], parameters={"L": TIME}, inputs=["F"]
    )
    return sb.form_equations(model)


def denominator(order: int) -> list[mpmath.mpf]:
    """Coefficients in s*time, highest first: (2n - k)! n! / ((2n)! k! (n - k)!)."""
    fac = mpmath.factorial
    return [
        fac(2 * order - k) * fac(order) / (fac(2 * order) * fac(k) * fac(order - k))
        for k in range(order, -1, -1)
    ]


def fastest(order: int) -> float:
    """The largest pole, 1/s."""
    with mpmath.workdps(40):
        return float(max(map(abs, mpmath.polyroots(denominator(order), maxsteps=200, extraprec=200))) / TIME)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("time", [TIME, "L"])
def test_the_transfer_function_is_that_of_pade(order: int, time: float | str) -> None:
    """Up to frequencies of twice the order: D(-s)/D(s), to 1e-13 of its size of 1.

    A determinant of `order` rows, whose entries are known to 1e-16 each, carries some hundred roundings.
    """
    eqs = delayed(order, time)
    found = sb.linearize(eqs, inputs={"F": 0.0}, outputs=["y"])
    rows = [k for k, name in enumerate(found.state_names) if name.startswith("y_")]
    a, b, c = found.A[np.ix_(rows, rows)], found.B[rows, :], found.C[:, rows]
    powers = denominator(order)
    for frequency in (0.0, 0.3, 1.0, order / 2.0, float(order), 2.0 * order):
        s = 1j * frequency
        answer = (c @ np.linalg.solve(s / TIME * np.eye(order) - a, b) + found.D)[0, 0]
        with mpmath.workdps(40):
            wanted = mpmath.polyval(powers, -mpmath.mpc(s)) / mpmath.polyval(powers, mpmath.mpc(s))
        assert abs(answer - complex(wanted)) <= 1e-13


@pytest.mark.parametrize("order", ORDERS)
def test_no_state_is_larger_than_what_is_delayed(order: int) -> None:
    """A lossless delay stores the input of one delay: squares of states sum up to at most that of the step.

    Coefficients are ratios near the balanced ones, whose scales multiply along the chain: within a half.
    """
    run = sb.simulate(delayed(order), 1.0, inputs={"F": 1.0}, times=np.linspace(0, 1, 401))
    assert np.sqrt((run.s**2).sum(axis=0)).max() <= 1.5


def test_steps_grow_no_faster_than_the_fastest_pole() -> None:
    def steps(order: int) -> int:
        return sb.simulate(delayed(order), 6.0, inputs={"F": "cos(3*t)"}).t.size

    usual = steps(3) / fastest(3)
    for order in range(4, 11):
        assert steps(order) <= 1.2 * usual * fastest(order), order
