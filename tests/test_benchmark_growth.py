"""The growth of a chain is measured in all columns, and what is too slow is left out by name."""

from __future__ import annotations

import pytest

from benchmarks import growth
from benchmarks.timing import Settings


def ratio(cell: str) -> float:
    return float(cell.partition("(")[2].rstrip("x)"))


@pytest.mark.exhaustive
def test_figures_of_one_size_stand_in_every_column(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(growth, "peer_seconds", lambda links, limit: 3.0)
    (table,) = growth.tables(Settings(rounds=1), [2])
    ((links, *cells),) = table.rows
    assert links == "2" and len(cells) + 1 == len(table.columns) and all(cells)


@pytest.mark.exhaustive
def test_figures_of_two_sizes_with_their_ratios(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(growth, "peer_seconds", lambda links, limit: 3.0 if links == 2 else None)
    (table,) = growth.tables(Settings(rounds=1), [2, 8])
    assert [row[0] for row in table.rows] == ["2", "8"]
    assert all(len(row) == len(table.columns) for row in table.rows)
    at = table.columns.index("per body")
    assert ratio(table.rows[0][at]) == 1.0 and ratio(table.rows[1][at]) > 0
    assert "x)" in table.rows[0][-1] and not table.rows[1][-1]
    assert any("SymPy" in note for note in table.notes)


@pytest.mark.exhaustive
def test_a_chain_that_takes_too_long_ends_the_table() -> None:
    (table,) = growth.tables(Settings(limit=1e-3, rounds=1), [2, 3])
    assert not table.rows
    assert "2 bodies: not done within 0.001 s" in table.notes


@pytest.mark.exhaustive
def test_the_peer_is_timed_for_the_same_chain() -> None:
    found = growth.peer_seconds(2, 60.0)
    assert found is not None and 0.0 < found < 60.0
