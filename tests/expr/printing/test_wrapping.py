"""Lines of formulas broken into rows."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import symbody as sb
from symbody.expr.printing.wrapping import text_width, wrap_formula


def test_a_row_ends_before_the_outermost_sign_that_fills_it() -> None:
    line = "  m x'' + k (long_name_a + long_name_b - long_name_c) x + g L cos(theta) = F"
    assert wrap_formula(line, 60) == [
        "  m x'' + k (long_name_a + long_name_b - long_name_c) x",
        "      + g L cos(theta) = F",
    ]
    assert wrap_formula(line, 0) == wrap_formula(line, 200) == [line]


def test_the_right_side_is_not_left_alone() -> None:
    assert wrap_formula("first_term x + second_term y + third z = 0", 40) == [
        "first_term x + second_term y",
        "    + third z = 0",
    ]


def test_products_and_names_without_a_sign_break_at_blanks_or_not_at_all() -> None:
    assert wrap_formula(" ".join(["factor"] * 5), 20) == [
        "factor factor factor",
        "    factor factor",
    ]
    assert wrap_formula("x" * 50, 20) == ["x" * 50]


EXAMPLES = Path(__file__).parents[3] / "examples"
WORDS = st.lists(
    st.sampled_from(["+", "-", "=", "a", "(bc", "d)", "long_name_of_a_joint'", "1e-05"]), max_size=60
)


@given(WORDS, st.integers(0, 90))
def test_rows_are_the_line(words: list[str], width: int) -> None:
    line = " ".join(["x", *words])
    rows = wrap_formula(line, width)
    assert " ".join(row.strip() for row in rows) == line
    for row in rows:
        assert not width or len(row) <= width or " " not in row.strip() or width < 40


def test_equations_fit_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    whole = eqs.text(width=0)
    assert max(map(len, whole.splitlines())) > 100
    for columns, width in (("80", 80), ("40", 80), ("95", 95), ("300", 100)):
        monkeypatch.setenv("COLUMNS", columns)
        assert text_width() == width
        assert max(map(len, str(eqs).splitlines())) <= width
        assert str(eqs).split() == whole.split()
