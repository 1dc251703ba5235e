"""Equations for values of parameters: rows that are only rounding, and what is kept of them."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

import symbody as sb
from symbody.equations.solving.noise import noise_program, without_noise

TURNED = Path(__file__).parents[1] / "corpus" / "rows_rounding.toml"
VALUES = {"L1": 0.3, "L2": 0.8, "L3": 0.6}


@cache
def four_bar() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(TURNED))


def empty_rows(eqs: sb.EquationSet) -> list[bool]:
    return [not row.slopes for row in eqs.formed.rows]


def test_rows_that_are_rounding_are_empty_and_found_once() -> None:
    eqs = four_bar()
    found = eqs.for_values(VALUES)
    # a planar loop: two of the five or six rows of its cut joint count
    assert empty_rows(found).count(False) == 2
    assert not any(empty_rows(eqs))
    assert eqs.for_values(dict(reversed(VALUES.items()))) is found
    assert eqs.for_values(VALUES | {"L1": 0.25}) is not found


@pytest.mark.parametrize("values", [{}, {"L1": 0.3}, VALUES])
def test_a_kept_program_gives_the_same_rows(values: dict[str, float]) -> None:
    formed = four_bar().formed
    kept = without_noise(formed, values, noise_program(formed))
    assert [row.slopes.keys() for row in kept.rows] == [
        row.slopes.keys() for row in without_noise(formed, values).rows
    ]


def test_only_the_last_values_are_kept() -> None:
    eqs = sb.form_equations(sb.load_model(TURNED))
    first = eqs.for_values(VALUES)
    for k in range(20):
        eqs.for_values(VALUES | {"L1": 0.2 + 0.001 * k})
    assert len(eqs._for_values) <= 8
    renewed = eqs.for_values(VALUES)
    assert renewed is not first
    assert empty_rows(renewed) == empty_rows(first)
