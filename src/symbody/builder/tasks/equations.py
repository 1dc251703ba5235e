"""The equations of a mechanism in tabs: what stands in books, and what computes it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, Final

from symbody.analysis.linear.linearize import linearize
from symbody.builder.page_problems import page_problem
from symbody.builder.task_failure import Report, TaskFailure
from symbody.builder.tasks.formula_blocks import (
    LONG,
    FormulaBlock,
    Label,
    entry_label,
    number_block,
    render_block,
)
from symbody.builder.tasks.options import EquationOptions, read_options
from symbody.builder.tasks.reading import complete_model
from symbody.builder.tasks.term_sources import term_sources
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.equations.formulations.registry import formulation_types
from symbody.equations.outputs.curve_names import curve_functions, name_curves
from symbody.equations.outputs.equation_page import DIGITS_NOTE
from symbody.equations.outputs.equation_sections import (
    SHOWN_DIGITS,
    EquationSection,
    constraint_sections,
    equation_sections,
    motion_section,
    numerals_of,
)
from symbody.equations.outputs.joint_outputs import reaction_axes, reaction_wrench
from symbody.errors import Problem, SymbodyError
from symbody.expr.canonical import ZERO
from symbody.expr.rewrite import tree_sizes
from symbody.expr.sympy.closed_form import readable
from symbody.formats.native import to_data
from symbody.simulation.programs.generate_code import generate_code
from symbody.spatial.vector import components

Answer = dict[str, Any]

TABS: Final = (
    "Equations", "Mass matrix", "Forcing", "Constraints", "Kinematic equations", "Reactions", "Linearization",
    "Energies",
)  # fmt: skip
_MOST_REACTIONS: Final = 12  # joints whose reactions are written
# What generated code of a section computes.
_CODE: Final[Mapping[str, str]] = MappingProxyType(
    {"rates": "qdot", "motion": "xdot", "positions": "constraints", "velocities": "velocity_constraints"}
)
_PARTS: Final = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z")


@dataclass(frozen=True, slots=True)
class _Derived:
    """The equations of this process, and what they were formed from."""

    eqs: EquationSet
    data: Mapping[str, Any]
    folder: str


_DERIVED: Final[list[_Derived]] = []


def derive_equations(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return the equations of motion and what belongs to them; other tabs are written on demand.

    Raises
    ------
    TaskFailure, SymbodyError
        If options or model do not allow it.
    """
    eqs = _form(payload)
    _DERIVED[:] = [_Derived(eqs, to_data(eqs.model), payload["folder"])]
    report("writing the equations of motion", None)
    return {
        "tabs": [_tab(eqs, TABS[0])],
        "names": list(TABS),
        "notes": list(eqs.notes),
        "formulation": type(eqs.formed.formulation).__name__,
        "speeds": list(eqs.speed_names),
        "coordinates": list(eqs.coordinate_names),
        "multipliers": list(eqs.multiplier_names),
    }


def equation_tab(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return a tab of the equations that this process has derived; the first with the sources of its terms.

    Raises
    ------
    TaskFailure
        If there is no such tab.
    """
    name = payload["name"]
    if not _DERIVED or name not in TABS:
        problem = Problem("builder.no_tab", str(name)[:40], "this tab of equations does not exist",
                          fix="derive the equations again")  # fmt: skip
        raise TaskFailure([page_problem(problem, {})])
    derived = _DERIVED[0]
    tab = _tab(derived.eqs, name)
    if name == TABS[0] and tab["blocks"] and _is_short(derived.eqs):
        motion, *others = tab["blocks"]
        tab["blocks"] = [{**motion, **_with_sources(derived)}, *others]
    return tab


def all_tabs(payload: Mapping[str, Any]) -> list[Answer]:
    """Return all tabs of the equations of a model."""
    eqs = _form(payload)
    return [_tab(eqs, name) for name in TABS]


def _form(payload: Mapping[str, Any]) -> EquationSet:
    options = read_options(EquationOptions, payload["options"])
    model = complete_model(payload["data"], payload["folder"])
    chosen = formulation_types().get(options.formulation)
    return form_equations(model, chosen() if chosen else None)


def _makers(eqs: EquationSet) -> dict[str, Callable[[], list[FormulaBlock]]]:
    """Return what writes each tab."""
    return {
        "Equations": partial(_equations, eqs),
        "Mass matrix": partial(_matrices, eqs, ("mass_matrix", "M", "Mass matrix")),
        "Forcing": partial(_matrices, eqs, ("forcing", "F", "Forcing")),
        "Constraints": partial(_constraints, eqs),
        "Kinematic equations": partial(_rates, eqs),
        "Reactions": partial(_reactions, eqs),
        "Linearization": partial(_linear, eqs),
        "Energies": partial(_energies, eqs),
    }


def _tab(eqs: EquationSet, name: str) -> Answer:
    try:
        blocks = [_render(eqs, block) for block in _makers(eqs)[name]()]
        said = any("data-full=" in (block["mathml"] or "") for block in blocks)
        digits = DIGITS_NOTE.format(SHOWN_DIGITS) if said else ""
        return {"name": name, "blocks": blocks, "note": digits if blocks else _NOTHING.get(name, "")}
    except SymbodyError as error:  # too long to be written out, or not there for this mechanism
        blocks = _numbers(eqs) if name == "Linearization" else []
        return {"name": name, "blocks": blocks, "note": "" if blocks else str(error.problems[0].what)}


def _numbers(eqs: EquationSet) -> list[Answer]:
    """Return the linear equations at the start in numbers, where loops leave no formulas."""
    try:
        linear = linearize(eqs)
    except SymbodyError:
        return []
    states, inputs = list(linear.state_names), list(linear.input_names)
    blocks = [number_block(f"A at the start, by {', '.join(states)}", "A", linear.A.tolist())]
    if inputs:
        blocks.append(number_block(f"B at the start, by {', '.join(inputs)}", "B", linear.B.tolist()))
    return blocks


_NOTHING: Final[Mapping[str, str]] = MappingProxyType(
    {
        "Equations": "No equations of motion: there are no speeds, because all motions are prescribed or "
        "nothing can move.",
        "Constraints": "No constraints: every joint is in the trees.",
        "Kinematic equations": "The speeds are the rates of the coordinates.",
        "Reactions": "There are no joints.",
    }
)


def _render(eqs: EquationSet, block: FormulaBlock) -> Answer:
    block = replace(block, numerals=numerals_of(eqs.formed.topology.model, SHOWN_DIGITS))
    return render_block(eqs.formed.graph, block, partial(_c_code, eqs, block.output))


def _c_code(eqs: EquationSet, output: str) -> str:
    """Return C that computes an output, "" where there is none."""
    if not output:
        return ""
    try:
        return generate_code(eqs, output)
    except SymbodyError:
        return ""


def _equations(eqs: EquationSet) -> list[FormulaBlock]:
    """Return all equations that belong to the motion, section by section."""
    sections = equation_sections(eqs.textbook, LONG)
    return [_section_block(section) for section in sections if section.sides]


def _section_block(section: EquationSection, spans: tuple[Mapping[int, str], ...] = ()) -> FormulaBlock:
    left, right = (tuple(pair[k] for pair in section.sides) for k in (0, 1))
    return FormulaBlock(
        section.title.heading, right, left, output=_CODE.get(section.key, ""), spans=spans,
        leading=section.leading, remarks=section.remarks, relations=section.relations,
    )  # fmt: skip


def _is_short(eqs: EquationSet) -> bool:
    """Return whether the equations are written as in textbooks: what moves on the left."""
    sides = motion_section(eqs.textbook, LONG).nodes
    return max(tree_sizes(eqs.formed.graph, sides), default=0) <= LONG


def _with_sources(derived: _Derived) -> Answer:
    """Return the equations of motion, each term with the elements it comes from."""
    eqs = derived.eqs
    sources = term_sources(eqs, derived.data, derived.folder)
    marks = {term: f"t{k}" for k, term in enumerate(sources)}
    rows = range(len(eqs.speed_names))
    spans = tuple({node: marks[i, node] for i, node in sources if i == row} for row in rows)
    shown = _render(eqs, _section_block(motion_section(eqs.textbook, LONG), spans if sources else ()))
    listed = [{"span": marks[term], "elements": names} for term, names in sources.items()]
    return {**shown, "sources": listed}


def _matrices(eqs: EquationSet, *outputs: tuple[str, str, str]) -> list[FormulaBlock]:
    """Return outputs as matrices; vectors are columns."""
    blocks = []
    for output, symbol, title in outputs:
        roots = eqs.textbook.readable(output)
        rows, columns = (*roots.shape, 1)[:2]
        if not roots.nodes:
            continue
        labels = tuple(
            entry_label(symbol, i + 1, j + 1) if len(roots.shape) == 2 else entry_label(symbol, i + 1)
            for i in range(rows)
            for j in range(columns)
        )
        name = Label(f"<mi>{symbol}</mi>", symbol, symbol)
        blocks.append(FormulaBlock(title, tuple(roots.nodes), labels, rows, columns, name, output))
    return blocks


def _constraints(eqs: EquationSet) -> list[FormulaBlock]:
    if not eqs.multiplier_names:
        return []
    blocks = [
        _section_block(section)
        for section in constraint_sections(eqs.textbook)
        if section.key == "positions" and section.sides
    ]
    rates = eqs.textbook.readable("velocity_constraints").nodes
    blocks.append(
        FormulaBlock(
            "Constraints and their rates, on velocities",
            (ZERO,) * len(rates),
            tuple(rates),
            output="velocity_constraints",
        )
    )
    return [
        *blocks,
        *_matrices(eqs, ("jacobian", "J", "Jacobian of the constraints with respect to the speeds")),
    ]


def _rates(eqs: EquationSet) -> list[FormulaBlock]:
    graph = eqs.formed.graph
    symbols = [graph.symbol(symbol.derivative) for symbol in eqs.formed.q]
    pairs = [
        (left, right)
        for left, right in zip(symbols, eqs.textbook.readable("qdot").nodes, strict=True)
        if left != right
    ]
    if not pairs:
        return []
    title = "Rates of the coordinates"
    return [FormulaBlock(title, tuple(b for _, b in pairs), tuple(a for a, _ in pairs), output="qdot")]


def _reactions(eqs: EquationSet) -> list[FormulaBlock]:
    formed = eqs.textbook.formed
    joints = formed.topology.model.joints[:_MOST_REACTIONS]
    return [FormulaBlock(*_reaction(eqs, joint.name), output=f"reaction {joint.name}") for joint in joints]


def _reaction(eqs: EquationSet, joint: str) -> tuple[str, tuple[int, ...], tuple[Label | int, ...]]:
    """Return title, entries and names of a reaction in u' and the multipliers; entries of 0 stay."""
    formed = eqs.textbook.formed
    wrench = reaction_wrench(formed, joint, "", "")
    axes = reaction_axes(formed, joint)
    tree = formed.kinematics.tree
    entries = [*components(tree, wrench.force, axes), *components(tree, wrench.moment, axes)]
    curves = curve_functions(formed.topology.model)
    nodes = readable(formed.graph, name_curves(formed.graph, [entry.index for entry in entries], curves))
    labels = tuple(
        Label(f"<msub><mi>{part[0]}</mi><mi>{part[2]}</mi></msub>", part, f"{part[0]}{part[2]}")
        for part in _PARTS
    )
    return f"Joint {joint}, on its end, in the axes of its start", tuple(nodes), labels


def _linear(eqs: EquationSet) -> list[FormulaBlock]:
    matrices = [("A", "A", "A: derivatives of the state rates with respect to the states")]
    if eqs.input_names:
        matrices.append(("B", "B", "B: derivatives of the state rates with respect to the inputs"))
    return _matrices(eqs, *matrices)


def _energies(eqs: EquationSet) -> list[FormulaBlock]:
    return list(_energy_blocks(eqs))


def _energy_blocks(eqs: EquationSet) -> Iterator[FormulaBlock]:
    for output, symbol, title in (
        ("kinetic_energy", "T", "Kinetic energy"),
        ("potential_energy", "V", "Potential energy"),
    ):
        label = Label(f"<mi>{symbol}</mi>", symbol, symbol)
        yield FormulaBlock(title, tuple(eqs.textbook.readable(output).nodes), (label,), output=output)
