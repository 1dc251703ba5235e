"""The growth of analyses is measured for every kind of mechanism, with exponents between sizes."""

from __future__ import annotations

import pytest

from benchmarks import growth_of_analyses
from benchmarks.growth_of_analyses import growth_exponent
from benchmarks.large_mechanisms import LARGE
from benchmarks.timing import Settings


def test_exponents_are_those_of_powers() -> None:
    assert growth_exponent(200, 3.0, 2000, 30.0) == pytest.approx(1.0)
    assert growth_exponent(200, 3.0, 2000, 300.0) == pytest.approx(2.0)


def test_every_kind_is_measured() -> None:
    assert growth_of_analyses.SIZES.keys() == LARGE.keys()
    assert growth_of_analyses.SIZES["chain"][-1] == growth_of_analyses.SIZES["tree"][-1] == 2000


@pytest.mark.exhaustive
def test_figures_of_two_sizes_and_their_exponents() -> None:
    (table,) = growth_of_analyses.tables(Settings(), {"ring": (3, 4)})
    assert [row[0] for row in table.rows] == ["3", "4", "exponent"] and not table.notes
    assert all(len(row) == len(table.columns) and all(row) for row in table.rows)
    assert all(abs(float(cell)) < 30.0 for cell in table.rows[-1][1:])


@pytest.mark.exhaustive
def test_what_takes_too_long_is_said_and_ends_the_table() -> None:
    (table,) = growth_of_analyses.tables(Settings(limit=1e-3), {"tree": (2, 3)})
    assert table.notes == ("2 bodies: > 0.001 s",)
    assert [row[0] for row in table.rows] == ["2"]
