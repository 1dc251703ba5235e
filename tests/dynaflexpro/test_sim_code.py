"""`BuildSimCode`: the seed's procedure in SciPy's integrator, and as text."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symbody as sb
from symbody.dynaflexpro import BuildEQs, BuildSimCode, ModelEquations
from symbody.errors import UsageError
from tests.problems.mechanisms import EXAMPLES


def built(name: str) -> ModelEquations:
    return BuildEQs(EXAMPLES / name / f"{name}.toml")


def test_the_seeds_script_of_the_top() -> None:
    values = [
        sp.Eq(sp.Symbol(name), value) for name, value in {"L": 1, "m": 1, "A": 2, "C": 1, "G": 9.8}.items()
    ]
    pXdot = BuildSimCode(built("spinning_top"), {"Xdot"}, "MapleProc", "Optimize", values)
    assert callable(pXdot) and pXdot.__name__ == "pXdot"
    solution = solve_ivp(pXdot, (0, 5), [0, 0, 10, 0, np.pi / 2, 0], method="DOP853", rtol=1e-10, atol=1e-12)
    # The printed digits; rtol 1e-10 keeps the error of the angle below 1e-8 rad.
    assert np.degrees(solution.y[4, -1]) == pytest.approx(106.323844, abs=2e-6)


def test_inputs_are_given_or_zero() -> None:
    model = built("spring_mass_damper")
    free = BuildSimCode(model, {"Xdot"})
    driven = BuildSimCode(model, {"Xdot"}, parameters={"F": "sin(t)", "d": 2})
    assert callable(free) and callable(driven)
    assert free(0.0, [0.5, 2.0]) == pytest.approx([-2.25, 0.5], abs=0)
    assert free(0.0, [0.5, 2.0], [3.0]) == pytest.approx([0.75, 0.5], abs=0)
    # 2 rounding errors of numbers below 4.
    assert driven(1.2, [0.5, 2.0]) == pytest.approx([np.sin(1.2) - 3.0, 0.5], abs=1e-15)


def test_source_text_is_that_of_generate_code() -> None:
    model = built("spring_mass_damper")
    text = BuildSimCode(model, {"Xdot"}, "C", "Optimize", {"m": 1, "d": 0.5, "k": 1})
    assert text == sb.generate_code(model.equations, ["xdot"], "c", parameters={})
    text = BuildSimCode(model, {"Xdot"}, "Python", "Optimize", {"m": 1, "d": 0.5, "k": 1})
    assert text == sb.generate_code(model.equations, ["xdot"], "python", parameters={})


def test_wrong_words_are_told_together() -> None:
    model = built("spring_mass_damper")
    with pytest.raises(UsageError) as caught:
        BuildSimCode(model, {"Xdot"}, "Fortran", "Optimise")
    assert [problem.code for problem in caught.value.problems] == [
        "dynaflexpro.language",
        "dynaflexpro.optimize",
    ]
