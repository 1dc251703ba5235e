"""The equations of a mechanism in tabs: what stands in books, and what computes it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, Final

from symbody.analysis.linear.linearize import linearize
from symbody.builder.task_failure import Report
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
from symbody.equations.outputs.display import equation_sides
from symbody.equations.outputs.joint_outputs import reaction_axes, reaction_wrench
from symbody.errors import SymbodyError
from symbody.expr.canonical import ZERO
from symbody.expr.rewrite import tree_sizes
from symbody.expr.sympy.closed_form import readable
from symbody.formats.native import to_data
from symbody.simulation.programs.generate_code import generate_code
from symbody.spatial.vector import components

Answer = dict[str, Any]

_ORDER: Final = (
    "Equations", "Mass matrix", "Forcing", "Constraints", "Kinematic equations", "Reactions", "Linearization",
    "Energies",
)  # fmt: skip
# The order of writing: what is long comes last, so that something is there soon.
_QUICK_FIRST: Final = (
    "Forcing", "Kinematic equations", "Constraints", "Energies", "Mass matrix", "Equations", "Linearization",
    "Reactions",
)  # fmt: skip
_MOST_REACTIONS: Final = 12  # joints whose reactions are written
_PARTS: Final = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z")


def equation_tabs(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return the equations of motion, tab by tab.

    Raises
    ------
    TaskFailure, SymbodyError
        If options or model do not allow it.
    """
    options = read_options(EquationOptions, payload["options"])
    model = complete_model(payload["data"], payload["folder"])
    chosen = formulation_types().get(options.formulation)
    eqs = form_equations(model, chosen() if chosen else None)
    formed = eqs.formed
    report("formulas", None)
    written: dict[str, Answer] = {}
    makers = _makers(eqs)
    for name in _QUICK_FIRST:
        report(f"writing: {name.lower()}", None)
        written[name] = _tab(eqs, name, makers[name])
        report(f"writing: {name.lower()}", None, {**written[name], "place": _ORDER.index(name)})
    tabs = [written[name] for name in _ORDER]
    report("sources of terms", None)
    if tabs[0]["blocks"] and _is_short(eqs):
        tabs[0]["blocks"] = [_with_sources(eqs, to_data(model), payload["folder"])]
    return {
        "tabs": tabs,
        "notes": list(eqs.notes),
        "formulation": type(formed.formulation).__name__,
        "speeds": list(eqs.speed_names),
        "coordinates": list(eqs.coordinate_names),
        "multipliers": list(eqs.multiplier_names),
    }


def _makers(eqs: EquationSet) -> dict[str, Callable[[], list[FormulaBlock]]]:
    """Return what writes each tab."""
    return {
        "Equations": partial(_motion, eqs),
        "Mass matrix": partial(_matrices, eqs, ("mass_matrix", "M", "Mass matrix")),
        "Forcing": partial(_matrices, eqs, ("forcing", "F", "Forcing")),
        "Constraints": partial(_constraints, eqs),
        "Kinematic equations": partial(_rates, eqs),
        "Reactions": partial(_reactions, eqs),
        "Linearization": partial(_linear, eqs),
        "Energies": partial(_energies, eqs),
    }


def _tab(eqs: EquationSet, name: str, make: Callable[[], list[FormulaBlock]]) -> Answer:
    try:
        blocks = [_render(eqs, block) for block in make()]
        return {"name": name, "blocks": blocks, "note": "" if blocks else _NOTHING.get(name, "")}
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
        "Constraints": "There are none: every joint is in the trees.",
        "Kinematic equations": "The speeds are the rates of the coordinates.",
        "Reactions": "There are no joints.",
    }
)


def _render(eqs: EquationSet, block: FormulaBlock) -> Answer:
    return render_block(eqs.formed.graph, block, partial(_c_code, eqs, block.output))


def _c_code(eqs: EquationSet, output: str) -> str:
    """Return C that computes an output, "" where there is none."""
    if not output:
        return ""
    try:
        return generate_code(eqs, output)
    except SymbodyError:
        return ""


def _motion(eqs: EquationSet) -> list[FormulaBlock]:
    return [_motion_block(eqs, ())]


def _motion_block(eqs: EquationSet, spans: tuple[Mapping[int, str], ...]) -> FormulaBlock:
    sides = equation_sides(eqs.textbook) if _is_short(eqs) else _plain_sides(eqs)
    left, right = tuple(a for a, _ in sides), tuple(b for _, b in sides)
    return FormulaBlock("Equations of motion", right, left, output="xdot", spans=spans)


def _plain_sides(eqs: EquationSet) -> list[tuple[int, int]]:
    return list(zip(eqs.textbook.inertial_side.nodes, eqs.textbook.forcing_side.nodes, strict=True))


def _is_short(eqs: EquationSet) -> bool:
    """Return whether the equations are written as in textbooks: what moves on the left."""
    nodes = [node for pair in _plain_sides(eqs) for node in pair]
    return max(tree_sizes(eqs.formed.graph, nodes), default=0) <= LONG


def _with_sources(eqs: EquationSet, data: Mapping[str, Any], folder: str) -> Answer:
    """Return the equations of motion, each term with the elements it comes from."""
    sources = term_sources(eqs, data, folder)
    marks = {term: f"t{k}" for k, term in enumerate(sources)}
    rows = range(len(eqs.speed_names))
    spans = tuple({node: marks[i, node] for i, node in sources if i == row} for row in rows)
    block = _motion_block(eqs, spans if sources else ())
    shown = _render(eqs, block)
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
    zero = eqs.textbook.readable("constraints").nodes
    blocks = []
    if zero:
        # Read as "expression = 0": the constraint itself is the left side.
        blocks.append(
            FormulaBlock("Constraints on positions", (ZERO,) * len(zero), tuple(zero), output="constraints")
        )
    rates = eqs.textbook.readable("velocity_constraints").nodes
    blocks.append(
        FormulaBlock(
            "Constraints on velocities", (ZERO,) * len(rates), tuple(rates), output="velocity_constraints"
        )
    )
    return [*blocks, *_matrices(eqs, ("jacobian", "J", "Jacobian of the constraints by the speeds"))]


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
    matrices = [("A", "A", "A: derivatives of the states' rates by the states")]
    if eqs.input_names:
        matrices.append(("B", "B", "B: derivatives of the states' rates by the inputs"))
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
