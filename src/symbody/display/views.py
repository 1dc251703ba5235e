"""What each type shows in a notebook; the table at the end is what `symbody.notebook` looks up."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.equilibrium.find_equilibrium import Equilibrium
from symbody.analysis.linear.linearization import Linearization
from symbody.analysis.linear.modes import Mode, Modes, eigenvalue_on_axes
from symbody.analysis.state import State
from symbody.analysis.value_lines import without_rounding
from symbody.display.formulas import show_formula
from symbody.display.html import (
    Markup,
    complex_number,
    notes,
    number,
    page,
    paragraph,
    show_unit,
    symbol,
    table,
)
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.equation_page import equation_operations, equations_page
from symbody.equations.outputs.equation_sections import SHOWN_DIGITS
from symbody.equations.outputs.output_table import OutputTable
from symbody.equations.outputs.units import symbol_units
from symbody.errors import SymbodyError, number_in_words
from symbody.expr.language.formula import Formula
from symbody.model.body import Body
from symbody.model.declarations.declaration import Declared
from symbody.model.element import Element
from symbody.model.joint import Joint
from symbody.model.model import Model
from symbody.notebook import LATEX_VIEWS, VIEWS
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.sweeps.result import Sweep

_MOST_SPEEDS: Final = 4  # of equations that are written out
_MOST_OPERATIONS: Final = 400  # of all sides together
_MOST_STATES: Final = 6  # of a matrix that is written out
_MOST_OUTPUTS: Final = 300  # of a table of them


def _model(model: Model) -> str:
    joints = [
        (joint.name, type(joint).__name__, f"{joint.start} \u2192 {joint.end}", _symbols(joint.coordinates))
        for joint in model.joints
    ]
    others = [
        (element.name, type(element).__name__)
        for element in model.elements
        if not isinstance(element, Body | Joint)
    ]
    units = symbol_units(model)
    parameters = [
        (symbol(name), show_formula(value), show_unit(units.get(name, "")))
        for name, value in model.parameters.items()
    ]
    return page(
        repr(model),
        table(("body", "mass"), ((body.name, show_formula(body.mass)) for body in model.bodies)),
        table(("joint", "kind", "from \u2192 to", "coordinates"), joints),
        table(("element", "kind"), others),
        table(("parameter", "value", "unit"), parameters),
        notes(model.notes),
    )


def _symbols(names: tuple[str, ...]) -> Markup:
    return Markup(", ".join(symbol(name) for name in names))


def _equations(eqs: EquationSet) -> str:
    if _is_short(eqs):
        return page(repr(eqs), Markup(equations_page(eqs.textbook)), notes(eqs.notes))
    rows = [("coordinates", _symbols(eqs.coordinate_names[:12])), ("speeds", _symbols(eqs.speed_names[:12]))]
    hint = (
        "too long to be shown: eqs.text() prints them with names for shared parts, sb.generate_code the code"
    )
    return page(repr(eqs), table(("", ""), rows), paragraph(hint), notes(eqs.notes))


def _is_short(eqs: EquationSet) -> bool:
    if len(eqs.speed_names) > _MOST_SPEEDS:
        return False
    return equation_operations(eqs.textbook) <= _MOST_OPERATIONS


def _equations_latex(eqs: EquationSet) -> str | None:
    return f"$\\displaystyle {eqs.latex(digits=SHOWN_DIGITS)}$" if _is_short(eqs) else None


def _trajectory(run: Trajectory) -> str:
    rows = [
        (symbol(name), show_unit(run.units.get(name, "")), *_course(np.atleast_1d(run[name])))
        for name in (*run.coordinate_names, *run.speed_names)
    ]
    counts = Counter(event.name for event in run.events)
    happened = ", ".join(f"{name} ({count} times)" if count > 1 else name for name, count in counts.items())
    return page(
        repr(run).strip("<>"),
        *([] if run.success else [paragraph(run.status.value)]),
        table(("", "unit", "start", "end", "least", "greatest"), rows),
        paragraph(f"events: {happened}") if happened else Markup(),
        notes(run.notes),
    )


def _course(values: NDArray[np.float64]) -> tuple[str, ...]:
    """Return the first, the last, the least and the greatest of the samples."""
    if not values.size:
        return ("\u2013",) * 4
    return tuple(number(float(value)) for value in (values[0], values[-1], values.min(), values.max()))


def _state(state: State) -> str:
    title = f"{type(state).__name__} of {state.eqs.model.name!r} at t = {number(state.t)} s"
    parts = [table(("", "value", "unit"), _state_rows(state))]
    parts.append(paragraph(f"largest constraint error: {state.residual:.2g}"))
    return page(title, *parts)


def _state_rows(state: State) -> Iterator[tuple[str, str, str]]:
    for values in (state.q, state.u):
        for name, value in values.items():
            unit = state.eqs.units.get(name, "")
            yield symbol(name), number(without_rounding(value, unit)), show_unit(unit)


def _equilibrium(state: Equilibrium) -> str:
    title = f"Equilibrium of {state.eqs.model.name!r}"
    try:
        title += f": {state.verdict}"
    except SymbodyError:  # no linear equations here
        title += ": stability unknown"
    return page(title, table(("", "value", "unit"), _state_rows(state)), notes(state.notes))


def _linearization(linear: Linearization) -> str:
    title = f"Linearization of {linear.at.eqs.model.name!r}: {linear.verdict}"
    parts = [paragraph(Markup(f"states {_symbols(linear.state_names)}"))]
    if 0 < len(linear.state_names) <= _MOST_STATES:
        parts.append(_labelled_matrix("A", linear.A, linear.state_names, linear.state_names))
        if 0 < len(linear.input_names) <= _MOST_STATES:
            parts.append(_labelled_matrix("B", linear.B, linear.state_names, linear.input_names))
    return page(title, _modes(linear.modes), *parts, notes(linear.notes))


def _labelled_matrix(
    letter: str, matrix: NDArray[np.float64], rows: Sequence[str], columns: Sequence[str]
) -> Markup:
    """Return a matrix whose rows, rates of states, and columns have their names."""
    lines = [
        (Markup(f"rate of {symbol(name)}"), *map(_signed_number, row))
        for name, row in zip(rows, matrix, strict=True)
    ]
    return table((letter, *map(symbol, columns)), lines)


def _linearization_latex(linear: Linearization) -> str | None:
    if not 0 < len(linear.state_names) <= _MOST_STATES:
        return None
    names = [letter for letter, matrix in zip("ABCD", linear, strict=True) if matrix.size]
    formulas = (rf"{letter} = {_matrix_latex(getattr(linear, letter))}" for letter in names)
    return "$\\displaystyle " + r",\quad ".join(formulas) + "$"


def _matrix_latex(matrix: NDArray[np.float64]) -> str:
    rows = r" \\ ".join(" & ".join(f"{value:.5g}" for value in row) for row in matrix)
    return rf"\begin{{bmatrix}}{rows}\end{{bmatrix}}"


def _signed_number(value: float) -> str:
    return f"{value:.5g}".replace("-", "\u2212")


def _modes(modes: tuple[Mode, ...]) -> Markup:
    heading = ("eigenvalue [1/s]", "frequency [rad/s]", "damping ratio", "time constant [s]", "largest in")
    return table(heading, (_mode_row(mode) for mode in modes if mode.eigenvalue.imag >= 0.0))


def _mode_row(mode: Mode) -> tuple[str, ...]:
    pair = "\u00b1" if mode.eigenvalue.imag else ""
    eigenvalue = complex_number(eigenvalue_on_axes(mode)).replace(" + ", f" {pair} ")
    leading = max(mode.shape, key=lambda name: abs(mode.shape[name]))
    figures = (mode.frequency, mode.damping_ratio, mode.time_constant)
    return (eigenvalue, *map(number, figures), symbol(leading))


def _all_modes(modes: Modes) -> str:
    return page(number_in_words(len(modes), "mode"), _modes(modes))


def _mode(mode: Mode) -> str:
    shape: Mapping[str, complex] = mode.shape
    rows = [
        (symbol(name), complex_number(complex(value)), number(abs(value))) for name, value in shape.items()
    ]
    title = f"Mode of eigenvalue {complex_number(eigenvalue_on_axes(mode))} 1/s"
    return page(title, _modes((mode,)), table(("state", "shape", "size"), rows))


def _sweep(sweep: Sweep) -> str:
    rows = [
        (symbol(name), show_unit(sweep.units.get(name, "")), number(column.min()), number(column.max()))
        for name, column in sweep.cases.items()
        if len(sweep)
    ]
    verdicts = Counter(status.name for status in sweep.status)
    counts = ", ".join(f"{count} {name}" for name, count in verdicts.items())
    return page(
        repr(sweep), table(("varied", "unit", "from", "to"), rows), paragraph(counts), notes(sweep.notes)
    )


def _outputs(outputs: OutputTable) -> str:
    """Return a table; headings stand at their first output."""
    rows, title = [], ""
    for each in outputs:
        rows.append(
            ("" if each.title == title else each.title, each.name, each.shape_text.replace("x", "\u00d7"),
             show_unit(each.unit), each.meaning)
        )  # fmt: skip
        title = each.title
    heading = ("", "name", "shape", "unit", "meaning")
    return page(number_in_words(len(outputs), "output"), table(heading, rows, _MOST_OUTPUTS))


def _show_declared(element: Declared) -> str:
    """Return the arguments with their values and units."""
    name = f" {element.name}" if isinstance(element, Element) else ""
    rows = list(_rows(element))
    if isinstance(element, Joint):
        rows.insert(0, ("from \u2192 to", f"{element.start} \u2192 {element.end}", ""))
        rows.insert(1, ("coordinates", Markup(", ".join(map(symbol, element.coordinates))), ""))
    return page(f"{type(element).__name__}{name}", table(("", "value", "unit"), rows))


def _rows(element: Declared, before: str = "") -> Iterator[tuple[str, str, str]]:
    """Return a row for each argument, those of parts and of mappings below their names."""
    for word, value in element.given_arguments().items():
        if word in ("name", "start", "end", "coordinate", "coordinates"):
            continue
        unit = _unit(element.fields[word].unit, before)
        for place, entry in _entries(value, f"{before}{word}"):
            if isinstance(entry, Declared):
                yield from _rows(entry, f"{place} ")
            else:
                yield place, _value(entry), unit


def _unit(units: str, before: str) -> str:
    """Return a unit; of "N, N m", of displacements and angles, that of the force or torque it belongs to."""
    both = units.split(", ")
    return show_unit(
        both[-1] if before.startswith("torque") else both[0] if before.startswith("force") else units
    )


def _entries(value: object, place: str) -> Iterator[tuple[str, object]]:
    if isinstance(value, Mapping):
        yield from ((f"{place} {name}", entry) for name, entry in value.items())
    elif isinstance(value, tuple) and any(isinstance(entry, Declared) for entry in value):
        yield from ((f"{place} {k + 1}", entry) for k, entry in enumerate(value))
    else:
        yield place, value


def _value(value: object) -> Markup:
    if isinstance(value, Formula):
        shown = show_formula(value)
        return shown if isinstance(shown, Markup) else Markup(escape(shown))
    if isinstance(value, tuple):
        return Markup(f"({', '.join(map(_value, value))})")
    return Markup(escape(str(value)))


VIEWS.update(
    {
        Model: _model,
        EquationSet: _equations,
        Trajectory: _trajectory,
        State: _state,
        Equilibrium: _equilibrium,
        Linearization: _linearization,
        Mode: _mode,
        Modes: _all_modes,
        Declared: _show_declared,
        Sweep: _sweep,
        OutputTable: _outputs,
    }
)
LATEX_VIEWS.update({EquationSet: _equations_latex, Linearization: _linearization_latex})
