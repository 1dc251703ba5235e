"""Equations as text and LaTeX: what is printed, how it is broken into rows, and when it is only counted."""

from __future__ import annotations

import re

import pytest

import symbody as sb
from symbody.equations.outputs.equation_lines import written_sections
from symbody.expr.printing.latex_rows import break_latex, latex_equations_page, letters
from tests.display.test_views import oscillator


def chain(count: int) -> sb.Model:
    links = [
        sb.Body(f"Link{k}", mass=f"m{k}", inertia=(0, 0, 1), frames={"end": sb.Frame(at=("l", 0, 0))})
        for k in range(count)
    ]
    pins = [
        sb.Revolute(
            f"pin{k}", "ground" if k == 0 else f"Link{k - 1}.end", f"Link{k}", coordinate=f"theta{k + 1}"
        )
        for k in range(count)
    ]
    values = {"l": 1.0, **{f"m{k}": 1.0 for k in range(count)}}
    return sb.Model("chain", [*links, *pins], parameters=values)


def test_printed_equations_are_those_of_textbooks() -> None:
    eqs = sb.form_equations(oscillator())
    assert str(eqs) == eqs.text() == "m x'' + d x' + k x = F"
    assert repr(eqs) == "EquationSet of 'oscillator': 1 coordinate, 1 speed, 0 constraints"
    assert repr(eqs.textbook) == "Textbook of 'oscillator': the formulas of its equations"


def test_latex_is_one_environment_with_aligned_signs() -> None:
    eqs = sb.form_equations(oscillator())
    latex = eqs.latex()
    assert latex == "\\begin{aligned}\nm \\, \\ddot{x} + d \\, \\dot{x} + k \\, x &= F\n\\end{aligned}"
    assert latex in (eqs._repr_latex_() or "")


def test_greek_letters_on_demand() -> None:
    eqs = sb.form_equations(chain(2))
    assert "θ1''" in eqs.text(greek=True) and "theta" not in eqs.text(greek=True)
    assert "theta1''" in eqs.text()


def test_many_speeds_are_counted_and_written_on_demand() -> None:
    eqs = sb.form_equations(chain(9))
    assert str(eqs).startswith("EquationSet of 'chain': 9 coordinates") and "\n" not in str(eqs)
    lines = eqs.text(limit=50).splitlines()
    assert lines[0] == "motion:" and "where:" in lines


def unbroken(rows: list[str]) -> str:
    """The formula that was broken into rows, with brackets that stretch again."""
    return re.sub(r"\\Big([lr])", lambda m: r"\left" if m[1] == "l" else r"\right", " ".join(rows))


@pytest.mark.parametrize("width", [20, 35, 80, 10_000])
@pytest.mark.parametrize("count", [1, 2, 4])
def test_rows_are_short_balanced_and_lose_nothing(width: int, count: int) -> None:
    (motion,) = written_sections(sb.form_equations(chain(count)).textbook, True, 400)
    for side in (side for pair in motion.sides for side in pair):
        rows = break_latex(side, width)
        assert unbroken(rows).split() == side.split()
        for row in rows:
            assert row.count(r"\left(") == row.count(r"\right)")
            assert row.count("{") == row.count("}")
            # Only a product, which nothing breaks, is longer than a row.
            assert letters(row) <= width or not re.search(r" [+-] (?!.*\\right)", row[3:]), row


def test_a_side_that_is_too_long_is_broken_inside_its_brackets() -> None:
    inner = " + ".join(f"x_{{{k}}}" for k in range(30))
    rows = break_latex(rf"a \, \left({inner}\right) + b", 20)
    assert len(rows) > 2 and r"\Bigl(" in rows[0] and r"\Bigr)" in rows[-1]
    page = latex_equations_page([[(rows[0], "0"), ("c", inner)], [("d", "e")]], 20)
    assert (
        page.count(r"\\[1ex]") == 1
        and page.startswith("\\begin{aligned}")
        and page.endswith("\\end{aligned}")
    )
