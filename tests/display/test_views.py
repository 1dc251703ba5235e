"""What results show in notebooks: well-formed, escaped, short, with formulas as MathML."""

from __future__ import annotations

import subprocess
import sys
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

import symbody as sb
from symbody.display.formulas import show_formula
from symbody.display.html import MOST_ROWS, complex_number, number, show_unit, table
from symbody.expr.language.formula import Formula

MATH = "{http://www.w3.org/1998/Math/MathML}"
HOSTILE = "<script>alert(1)</script> & Co"


def oscillator(**options: Any) -> sb.Model:
    mass = sb.Body(options.pop("body", "Mass"), mass="m")
    drive = sb.Drive(applied="F", stiffness="k", damping="d")
    slider = sb.Prismatic("slider", "ground", mass, axis="x", coordinate="x", force=drive)
    values = {"m": 2.0, "k": "4*m", "d": 0.5, **options.pop("parameters", {})}
    return sb.Model(options.pop("name", "oscillator"), [slider], inputs=["F"], parameters=values, **options)


def shown(value: Any) -> Element:
    text = value._repr_html_()
    assert isinstance(text, str)
    return ElementTree.fromstring(text)


def cells(root: Element) -> list[list[str]]:
    return [["".join(cell.itertext()) for cell in row] for row in root.iter("tr")]


def test_a_model_shows_its_parts_and_units() -> None:
    rows = cells(shown(oscillator()))
    assert ["Mass", "m"] in rows
    assert ["slider", "Prismatic", "ground → Mass", "x"] in rows
    assert ["m", "2.0", "kg"] in rows and ["d", "0.5", "N·s/m"] in rows
    assert any(row[0] == "k" and row[2] == "N/m" for row in rows)


def test_equations_are_shown_as_mathml() -> None:
    root = shown(sb.form_equations(oscillator()))
    (row,) = (each for each in root.iter("div") if each.get("class") == "sb-equation")
    assert len(list(row.iter(f"{MATH}math"))) == 4  # three terms, and what is on the right
    text = "".join(row.itertext()).replace("\u2062", "")
    assert text == "mx¨+dx˙+kx=F"


def test_equations_that_are_too_long_are_counted() -> None:
    bodies = [
        sb.Body(f"Link {k}", mass=1, inertia=(0, 0, 1), frames={"end": sb.Frame(at=(1, 0, 0))})
        for k in range(6)
    ]
    pins = [
        sb.Revolute(
            f"pin {k}", "ground" if k == 0 else f"Link {k - 1}.end", f"Link {k}", coordinate=f"phi_{k}"
        )
        for k in range(6)
    ]
    root = shown(sb.form_equations(sb.Model("chain", [*bodies, *pins])))
    text = "".join(root.itertext())
    assert "6 speeds" in text and "too long" in text
    assert all(element.get("display") is None for element in root.iter(f"{MATH}math"))


def test_a_motion_shows_its_course_and_events() -> None:
    event = sb.Event("x", name=HOSTILE[:20])
    run = sb.simulate(sb.form_equations(oscillator()), 5.0, {"x": 1.0}, events=event)
    root = shown(run)
    rows = {row[0]: row[1:] for row in cells(root)}
    assert rows["x"][:2] == ["m", "1"]
    assert float(rows["x"][2].replace("−", "-")) == pytest.approx(run["x"][-1], rel=1e-4)
    assert any(row.startswith("x˙") for row in rows)
    assert f"{HOSTILE[:20]} ({len(run.events)} times)" in "".join(root.itertext())


def test_states_modes_and_sweeps() -> None:
    eqs = sb.form_equations(oscillator())
    state, rest = sb.assemble(eqs, {"x": 0.25}), sb.find_equilibrium(eqs)
    assert ["x", "0.25", "m"] in cells(shown(state))
    assert "stable" in "".join(shown(rest).itertext())
    linear = rest.linearization
    root = shown(linear)
    assert len([row for row in cells(root) if "±" in row[0]]) == 1  # a pair is one row
    assert "A=" in "".join(root.itertext())
    assert "damping ratio" in "".join(shown(linear.modes[0]).itertext())
    sweep = sb.sweep(eqs, 1.0, {"m": [1.0, 2.0, 4.0]})
    assert ["m", "kg", "1", "4"] in cells(shown(sweep))
    assert "3 SUCCESS" in "".join(shown(sweep).itertext())


def test_names_are_text_whatever_they_contain() -> None:
    model = oscillator(name=HOSTILE, body=HOSTILE.replace(".", ""))
    eqs = sb.form_equations(model)
    for value in (model, eqs, sb.simulate(eqs, 0.1), sb.assemble(eqs), sb.find_equilibrium(eqs)):
        assert "<script" not in value._repr_html_()
        assert HOSTILE in "".join(shown(value).itertext())


def test_long_tables_are_cut() -> None:
    rows = ElementTree.fromstring(table(("a",), ([str(k)] for k in range(MOST_ROWS + 5))))
    assert cells(rows)[-1] == ["… and 5 more"]
    assert len(cells(rows)) == MOST_ROWS + 2
    assert table(("a",), []) == ""


def test_numbers_units_and_formulas() -> None:
    assert number(float("nan")) == "–" and number(1.0 / 3.0) == "0.333333"
    assert complex_number(-0.25 + 2.0j) == "−0.25 + 2 i" and complex_number(complex(-1.0)) == "−1"
    assert show_unit("kg m^2/s^3") == "kg·m²/s³" and show_unit("N m, N") == "N·m, N" and show_unit("") == ""
    assert show_formula(None) == "–" and show_formula(Formula.from_value("9.81")) == "9.81"
    assert "<mfrac>" in show_formula(Formula.from_value("pi*x_dot/l"))
    assert show_formula(Formula.from_value("1/(x - x)")) == "1/(x - x)"


def test_nothing_of_it_is_loaded_before_it_is_shown() -> None:
    script = (
        "import sys, symbody as sb; m = sb.Model('m', []); loaded = set(sys.modules);"
        "print('symbody.display.views' in loaded, 'IPython' in loaded, '<b>' in m._repr_html_())"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert (done.stdout, done.stderr) == ("False False True\n", "")


def test_every_case_of_a_motion_without_samples() -> None:
    run = sb.simulate(sb.form_equations(oscillator()), 0.1)
    empty = sb.Trajectory(
        np.zeros(0), np.zeros((1, 0)), np.zeros((1, 0)), run.coordinate_names, run.speed_names, run.status,
        run.statistics,
    )  # fmt: skip
    assert ["x", "", "–", "–", "–", "–"] in cells(shown(empty))
