"""Curves in formulas for people: a name and an argument, with the numbers, slopes and checks of the pieces."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import PchipInterpolator
from sympy.physics.mechanics import dynamicsymbols

import symbody as sb
from symbody.builder.tasks.equations import all_tabs
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.outputs import textbook
from symbody.equations.outputs.curve_names import CurveFunction, curve_functions, name_curves
from symbody.expr.graph import Graph
from symbody.expr.sympy.closed_form import readable
from symbody.expr.written_function import write_out
from symbody.formats.native import to_data
from tests.formulations import UNLIMITED, name_of

LENGTHS, FORCES = [0.2, 0.3, 0.4, 0.5, 0.6], [3000, 1200, 0, -900, -2500]
Kind = Literal["linear", "pchip"]
VALUES = {"m_w": 40, "m_b": 300, "k_t": 2e5, "d": 1500, "g": 9.81}
STATE = (0.0, [0.02, 0.37], [0.1, -0.2])


def quarter_car(kind: Kind = "pchip", name: str = "SPRING", **changes: float) -> sb.Model:
    wheel, body = sb.Body("Wheel", mass="m_w"), sb.Body("Chassis", mass="m_b")
    tyre = sb.Drive(stiffness="k_t")
    spring = sb.SpringDamper(
        name, wheel, body, law=sb.Curve(LENGTHS, FORCES, kind=kind, outside="slope"), damping="d"
    )
    parts = [
        sb.Prismatic("axle", "ground", wheel, axis="z", coordinate="z_w", force=tyre),
        sb.Prismatic("slide", "ground", body, axis="z", coordinate="z_b"),
        spring,
    ]
    return sb.Model("quarter car", parts, (0, 0, "-g"), {**VALUES, **changes})


@pytest.mark.parametrize("formulation", [None, *UNLIMITED], ids=name_of)
@pytest.mark.parametrize("kind", ["linear", "pchip"])
def test_a_curve_of_a_quarter_car_is_printed_by_name(formulation: Formulation | None, kind: Kind) -> None:
    eqs = sb.form_equations(quarter_car(kind), formulation=formulation)
    text, latex = eqs.text(), eqs.latex()
    assert text.count("law_SPRING(sqrt((z_w - z_b)^2))") == 2 and "if(" not in text and len(text) < 600
    assert r"\operatorname{law\_SPRING}" in latex and "cases" not in latex
    assert not eqs.forcing.atoms(sp.Piecewise) and "law_SPRING" in str(eqs.forcing)
    assert "law_SPRING" in (eqs._repr_latex_() or "").replace("\\_", "_")
    slopes, forces = sb.compile(eqs, ["udot", "effort SPRING"])(*STATE)
    law = float(
        np.interp(0.35, LENGTHS, FORCES) if kind == "linear" else PchipInterpolator(LENGTHS, FORCES)(0.35)
    )
    assert forces == pytest.approx(law + 1500 * 0.3)
    assert slopes[1] == pytest.approx(forces / 300 - 9.81)


@pytest.mark.parametrize("kind", ["linear", "pchip"])
def test_the_formula_has_the_numbers_and_slopes_of_the_curve(kind: Kind) -> None:
    eqs = sb.form_equations(quarter_car(kind))
    z_w, z_b = dynamicsymbols("z_w z_b")
    rates = {z_w.diff(): 0.1, z_b.diff(): -0.2}
    constants = {sp.Symbol(name): value for name, value in VALUES.items()}
    forcing = eqs.forcing.subs(rates).subs(constants)
    computed = sb.compile(eqs, "forcing")(*STATE)
    by_sympy = sp.lambdify((z_w, z_b), forcing, "numpy")(0.02, 0.37)
    assert by_sympy[:, 0] == pytest.approx(computed)
    assert [float(x) for x in forcing.subs({z_w: 0.02, z_b: 0.37}).evalf()] == pytest.approx(
        computed.tolist()
    )
    # SymPy's formula is an output like any other, and its slope is that of the pieces.
    assert sb.compile(eqs, eqs.forcing[1])(*STATE) == pytest.approx(computed[1])
    slope = sp.lambdify((z_w, z_b), forcing[1].diff(z_b), "numpy")(0.02, 0.37)
    step = 1e-5
    ahead, behind = (sb.compile(eqs, "forcing")(0.0, [0.02, 0.37 + h], STATE[2])[1] for h in (step, -step))
    assert slope == pytest.approx((ahead - behind) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("kind", ["linear", "pchip"])
def test_a_function_of_a_curve_takes_numbers_and_arrays(kind: Kind) -> None:
    (law,) = curve_functions(quarter_car(kind))
    x = np.linspace(0.2, 0.6, 41)
    expected = np.interp(x, LENGTHS, FORCES) if kind == "linear" else PchipInterpolator(LENGTHS, FORCES)(x)
    assert law(x) == pytest.approx(expected) and [law(float(value)) for value in x] == pytest.approx(expected)
    assert np.isnan(law(np.nan)) and law(0.7) == pytest.approx(-2500 + 0.1 * law.derivative(0)(0.6))


def test_names_of_laws_are_words_that_nothing_else_has() -> None:
    assert [law.name for law in curve_functions(quarter_car(name="front left"))] == ["law_front_left"]
    assert [law.name for law in curve_functions(quarter_car(name="S", law_S=1.0))] == ["law_S_"]
    drives = {"x": sb.Drive(law=sb.Curve([0, 1], [0, 1])), "y": sb.Drive(law=sb.Curve([0, 1], [1, 0]))}
    table = sb.Planar(
        "table",
        "ground",
        sb.Body("A", mass=1, inertia=(1, 1, 1)),
        coordinates=("x", "y", "phi"),
        force=drives,
    )
    assert [law.name for law in curve_functions(sb.Model("m", [table]))] == ["law_table_x", "law_table_y"]


def test_the_curve_of_a_drive_is_named() -> None:
    drive = sb.Drive(law=sb.Curve([-1, 0, 1], [2, 0, -1]))
    block = sb.Prismatic("P", sb.Body("A", mass="m"), "ground", axis="x", coordinate="s", force=drive)
    eqs = sb.form_equations(sb.Model("m", [block], parameters={"m": 1.0}))
    assert eqs.text() == "m s'' - law_P(s) = 0"


def test_a_curve_shown_as_another_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    def exchange(graph: Graph, nodes: Sequence[int], functions: Sequence[CurveFunction]) -> list[int]:
        """Name the curve, and let the name mean its slope."""
        named = name_curves(graph, nodes, functions)
        for place, law in enumerate(functions):
            if law in graph.functions:
                graph.functions[place] = replace(law, pieces=law.derivative(0).pieces)
        return named

    eqs = sb.form_equations(quarter_car())
    monkeypatch.setattr(textbook, "name_curves", exchange)
    with pytest.raises(sb.SymbodyError, match="differ from the functions that are computed"):
        eqs.text()


def test_names_are_written_out_again_as_the_nodes_they_stand_for() -> None:
    formed = sb.form_equations(quarter_car()).formed
    nodes = [entry.index for entry in formed.dynamics.forcing]
    named = name_curves(formed.graph, nodes, curve_functions(formed.topology.model))
    assert named != nodes and write_out(formed.graph, named) == nodes
    assert readable(formed.graph, named) != readable(formed.graph, nodes)


def test_the_builder_shows_the_name_and_its_code_the_pieces() -> None:
    payload = {"data": to_data(quarter_car()), "folder": "", "options": {}}
    tabs = {tab["name"]: json.dumps(tab) for tab in all_tabs(payload)}
    for name in ("Equations", "Forcing"):
        assert "law_SPRING" in tabs[name] and "begin{cases}" not in tabs[name]
    assert "-10285.714285714288" in tabs["Forcing"]


def test_the_reaction_of_a_guide_shows_the_name() -> None:
    """A spring across its guide: the guide bears a part of the curve's force."""
    block = sb.Body("A", mass=1, frames={"end": sb.Frame(at=(0, 0.3, 0))})
    guide = sb.Prismatic("P", "ground", block, axis="z", coordinate="s")
    spring = sb.SpringDamper("S", "ground", "A.end", law=sb.Curve(LENGTHS, FORCES))
    model = sb.Model("m", [guide, spring])
    payload = {"data": to_data(model), "folder": "", "options": {}}
    tabs = {tab["name"]: json.dumps(tab) for tab in all_tabs(payload)}
    assert "law_S" in tabs["Reactions"] and "begin{cases}" not in tabs["Reactions"]
    force = sb.form_equations(model).reaction("P").force
    assert "law_S" in str(force) and not force.atoms(sp.Piecewise)
