"""Equations for values of parameters: rows that are only rounding, and what is kept of them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.equations.solving.negligible_constraints import drop_negligible

# A tilt that no one means: what a direction typed with twelve digits leaves.
TYPED = {"s": 1e-12, "c": 1.0}


def tilted() -> sb.EquationSet:
    """A four-bar in the plane of x and y whose hinges turn about (s, 0, c); its motions along z are all in s."""
    ends = {"P": sb.Frame(at=(-1, 0, 0)), "Q": sb.Frame(at=(1, 0, 0))}
    bodies = [sb.Body(f"B{k}", mass=1, inertia=(1, 1, 1), frames=ends) for k in range(3)]
    places = ["ground", "B0.P", "B0.Q", "B1.P", "B1.Q", "B2.P", "B2.Q", "ground"]
    hinges = [
        sb.Revolute(f"J{k}", places[2 * k], places[2 * k + 1], axis=("s", 0, "c"), coordinate=f"a{k}")
        for k in range(4)
    ]
    return sb.form_equations(sb.Model("tilted", [*bodies, *hinges], parameters=TYPED))


@cache
def four_bar() -> sb.EquationSet:
    return tilted()


def empty_rows(eqs: sb.EquationSet) -> list[bool]:
    return [not row.jacobian for row in eqs.formed.rows]


def test_rows_that_are_rounding_are_empty_and_found_once() -> None:
    eqs = four_bar()
    found = eqs.for_values(TYPED)
    assert not any(empty_rows(eqs))
    assert empty_rows(found).count(False) == 2  # along x and y
    assert eqs.for_values(dict(reversed(TYPED.items()))) is found
    assert eqs.for_values({"s": 0.6, "c": 0.8}) is eqs


@pytest.mark.parametrize("values", [{}, {"s": 1e-12}, TYPED])
def test_a_kept_program_gives_the_same_rows(values: dict[str, float]) -> None:
    eqs = four_bar()
    assert [row.jacobian.keys() for row in eqs.for_values(values).formed.rows] == [
        row.jacobian.keys() for row in drop_negligible(eqs.formed, values).rows
    ]


def test_values_that_empty_the_same_rows_have_the_same_equations() -> None:
    eqs = tilted()
    first = eqs.for_values(TYPED)
    assert all(eqs.for_values({"s": k * 1e-13, "c": 1.0}) is first for k in range(1, 20))


def test_rows_are_looked_at_anew_for_compiled_functions_of_each_set_of_values() -> None:
    eqs = tilted()
    for s, c in [(1e-12, 1.0), (0.6, 0.8), (2e-13, 1.0), (0.8, 0.6), (1e-12, 1.0)]:
        chosen = parameter_set(eqs, {"s": s, "c": c})
        assert empty_rows(chosen.eqs) == empty_rows(eqs.for_values({"s": s, "c": c}))


def test_analyses_form_outputs_of_the_rows_that_count() -> None:
    """A tilt of rounding, in which rows are empty, changes nothing that is seen: it is 1e-12 itself."""
    eqs = tilted()
    exact = {"s": 0, "c": 1}
    found, plane = sb.linearize(eqs), sb.linearize(eqs, parameters=exact)
    assert found.state_names == plane.state_names
    np.testing.assert_allclose(found.A, plane.A, rtol=0, atol=1e-10)
    rest = sb.find_equilibrium(eqs, {"a0": 0.4})
    assert rest.q["a0"] == pytest.approx(
        sb.find_equilibrium(eqs, {"a0": 0.4}, parameters=exact).q["a0"], abs=1e-9
    )
