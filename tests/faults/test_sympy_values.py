"""SymPy symbols and expressions, fractions and NumPy numbers stand wherever text and numbers do."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

import symbody as sb
from tests.display.test_views import oscillator

L, m, t = sp.Symbol("L"), sp.Symbol("m"), sp.Symbol("t")


def test_elements_take_expressions() -> None:
    assert sb.Body("B", mass=2 * m + sp.Rational(1, 3)) == sb.Body("B", mass="1/3 + 2*m")
    assert sb.Frame(at=(L / 2, sp.pi / 4, -L)) == sb.Frame(at=("L/2", "pi/4", "-L"))
    exact = sb.Body("B", mass=Fraction(1, 3), inertia=(np.float64(1), np.int32(2), np.float32(0.5)))
    assert exact == sb.Body("B", mass="1/3", inertia=("1.0", "2", "0.5"))


def test_what_is_no_real_expression_is_refused_with_its_place() -> None:
    with pytest.raises(sb.ModelError, match="body B, mass"):
        sb.Body("B", mass=sp.I * m)
    with pytest.raises(sb.ModelError, match="body B, mass"):
        sb.Body("B", mass=sp.zoo)


def test_functions_take_symbols_for_names_and_expressions_for_text() -> None:
    eqs = sb.form_equations(oscillator())
    (x,), (speed,) = eqs.coordinates, eqs.speeds
    run = sb.simulate(
        eqs, 1.0, {x: sp.Rational(1, 4), speed: sp.pi / 10}, parameters={m: sp.Rational(3, 2)},
        inputs={"F": sp.sin(2 * t)},
    )  # fmt: skip
    same = sb.simulate(
        eqs, 1.0, {"x": 0.25, "x_dot": "pi/10"}, parameters={"m": 1.5}, inputs={"F": "sin(2*t)"}
    )
    np.testing.assert_array_equal(run["x"], same["x"])
    np.testing.assert_array_equal(run[m * speed**2 / 2], run["m*x_dot^2/2"])
    assert list(run.outputs(x, speed)) == ["x", "x_dot"]
    assert repr(sb.compile(eqs, [x, 2 * speed])) == repr(sb.compile(eqs, ["x", "2*x_dot"]))
    assert sb.plot(run, x, speed).get_lines()


def test_faults_name_the_function_that_was_called() -> None:
    eqs = sb.form_equations(oscillator())
    with pytest.raises(sb.UsageError, match="simulate, argument initial"):
        sb.simulate(eqs, 1.0, {3: 0.5})  # type: ignore[dict-item]
