"""The middle of a report: kinematics, constraints, dynamics, the equations, the reactions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.equation_page import DIGITS_NOTE
from symbody.equations.outputs.equation_sections import (
    EquationSection,
    constraint_sections,
    equation_sections,
    has_rounded,
)
from symbody.errors import SymbodyError
from symbody.expr.graph import Graph
from symbody.expr.opcodes import SADDLE
from symbody.expr.rewrite import operation_count, tree_sizes
from symbody.expr.sequences.sequence import Roots
from symbody.report.document import (
    LONG,
    MOST_OPERATIONS,
    Block,
    Cell,
    EquationBlock,
    GoverningEquations,
    Matrix,
    MatrixRow,
    Name,
    Paragraph,
    ReportSection,
    TextTable,
)
from symbody.report.setting import Setting

# Bodies whose kinematics are written out, and speeds of matrices that are.
_MOST_BODIES: Final = 8
_MOST_SPEEDS: Final = 12
# Outputs of frames, and how they are written.
_LETTERS: Final = {"r": "r", "v": "v", "w": "omega"}


def kinematics_section(setting: Setting) -> ReportSection:
    """Return the rates of coordinates, and places and velocities of the bodies' frames in the ground."""
    return ReportSection("kinematics", "Kinematics", tuple(_kinematics(setting)))


def _kinematics(setting: Setting) -> Iterator[Block]:
    eqs, numerals = setting.eqs, setting.numerals
    graph, formed = eqs.formed.graph, eqs.formed
    rates = [graph.symbol(symbol.derivative) for symbol in formed.q]
    sides = [(a, b) for a, b in zip(rates, eqs.textbook.readable("qdot").nodes, strict=True) if a != b]
    if sides:
        yield Paragraph("Rates of the coordinates as functions of the speeds:")
        yield from _equations(setting, EquationSection("rates", tuple(sides)))
    bodies = eqs.model.bodies
    if len(bodies) > _MOST_BODIES:
        yield Paragraph(
            f"Positions of the {len(bodies)} bodies are not written out; each is an output, such as "
            f'"frame r {bodies[0].name} ground ground".'
        )
        return
    yield Paragraph(
        "Origin [m], velocity [m/s] and angular velocity [rad/s] of each body relative to ground, in ground "
        "axes:"
    )
    for body in bodies:
        outputs = {letter: f"frame {kind} {body.name} ground ground" for kind, letter in _LETTERS.items()}
        nodes = {letter: eqs.textbook.readable(name).nodes for letter, name in outputs.items()}
        if any(_is_long(graph, entries) for entries in nodes.values()):
            yield Paragraph(f"The formulas of {body.name} are too long to print.")
        else:
            yield MatrixRow(
                tuple(
                    Matrix(f"{x}_{body.name}", graph, (3, 1), tuple(entries), numerals)
                    for x, entries in nodes.items()
                )
            )


def constraints_section(setting: Setting) -> ReportSection:
    """Return the constraints of each joint, on positions and on velocities."""
    return ReportSection("constraints", "Constraints", tuple(_constraints(setting)))


def _constraints(setting: Setting) -> Iterator[Block]:
    formed = setting.eqs.formed
    if not formed.rows:
        yield Paragraph("No constraints: the coordinates of the trees are independent.")
        return
    rows: list[tuple[Cell, ...]] = [
        (row.element, "positions" if row.is_holonomic else "velocities", Name(row.name))
        for row in formed.rows
    ]
    yield TextTable(("joint or element", "constraint on", "multiplier"), tuple(rows))
    for section in constraint_sections(setting.eqs.textbook):
        if section.sides:
            yield Paragraph(f"{section.title.heading}:")
            yield from _equations(setting, section)


def dynamics_section(setting: Setting) -> ReportSection:
    """Return M, F, J and gamma."""
    eqs = setting.eqs
    blocks: list[Block] = []
    if eqs.speed_names:
        blocks.append(_governing_equations(eqs))
    else:
        blocks.append(Paragraph("There are no speeds: nothing can move, or all motions are prescribed."))
    blocks += _matrices(setting) if eqs.speed_names else ()
    return ReportSection("dynamics", "Mass matrix, forcing, Jacobian", blocks)


def _governing_equations(eqs: EquationSet) -> GoverningEquations:
    speeds, multipliers = eqs.speed_names, eqs.multiplier_names
    short = max(len(speeds), len(multipliers)) <= _MOST_SPEEDS
    return GoverningEquations(speeds if short else (), multipliers if short else (), bool(multipliers))


def _matrices(setting: Setting) -> Iterator[Block]:
    eqs = setting.eqs
    graph = eqs.formed.graph
    names = {"M": "mass_matrix", "F": "forcing"}
    if eqs.multiplier_names:
        names |= {"J": "jacobian", "gamma": "gamma"}
    for letter, name in names.items():
        if len(eqs.speed_names) > _MOST_SPEEDS or _is_big(graph, eqs.roots(name).nodes):
            yield Paragraph(
                f"{letter} ({name}) is too large to print; generate_code(eqs, {name!r}) writes it."
            )
            continue
        roots: Roots = eqs.textbook.display(name)
        rows, columns = (*roots.shape, 1)[:2]
        yield Matrix(letter, graph, (rows, columns), tuple(roots.nodes), setting.numerals)


def equations_section(setting: Setting) -> ReportSection:
    """Return all equations, as people write them: as many as there are unknowns."""
    eqs = setting.eqs
    if len(eqs.speed_names) > _MOST_SPEEDS or _is_big(
        eqs.formed.graph, (*eqs.roots("mass_matrix").nodes, *eqs.roots("forcing").nodes)
    ):
        text = "too large for the report; eqs.text() prints them, sb.generate_code writes them"
        return ReportSection("equations", "Equations of motion", (Paragraph(text),))
    blocks: list[Block] = []
    for section in equation_sections(eqs.textbook, LONG):
        if section.key != "motion":
            blocks.append(Paragraph(f"{section.title.heading}:"))
        if section.note:
            blocks.append(Paragraph(f"{section.note[:1].upper()}{section.note[1:]}."))
        if section.sides:
            blocks += _equations(setting, section)
        if section.words:
            blocks.append(TextTable(("signal", "is"), section.words))
    return ReportSection("equations", "Equations of motion", blocks)


def reactions_section(setting: Setting) -> ReportSection:
    """Return force and moment that each joint transmits, where they are short."""
    return ReportSection("reactions", "Reactions", tuple(_reactions(setting)))


def _reactions(setting: Setting) -> Iterator[Block]:
    eqs, numerals = setting.eqs, setting.numerals
    yield Paragraph(
        "Force [N] and moment [N\u00b7m] on the end body by the start body, at the joint and in the axes "
        "that reaction outputs use, by multipliers and accelerations."
    )
    if eqs.undetermined_reactions:
        yield Paragraph(
            f"Redundant constraints leave undetermined: {', '.join(eqs.undetermined_reactions)}; their "
            f"values are those of the minimum-norm solution."
        )
    graph, long = eqs.formed.graph, []
    for joint in eqs.formed.topology.joints if len(eqs.speed_names) <= _MOST_SPEEDS else ():
        try:
            sides = eqs.textbook.reaction_sides(joint.name)
        except SymbodyError:
            long.append(joint.name)
            continue
        if any(_is_long(graph, roots.nodes) for roots in sides):
            long.append(joint.name)
        else:
            letters = (f"F_{joint.name}", f"M_{joint.name}")
            pairs = zip(letters, sides, strict=True)
            yield MatrixRow(
                tuple(Matrix(x, graph, (3, 1), tuple(roots.nodes), numerals) for x, roots in pairs)
            )
    if long or len(eqs.speed_names) > _MOST_SPEEDS:
        which = ", ".join(long) if long else "all joints"
        yield Paragraph(f"Too long to print, available as outputs by name: {which}.")


def with_digits_note(setting: Setting, parts: Sequence[ReportSection]) -> tuple[ReportSection, ...]:
    """Return sections, the first with rounded numbers headed by a sentence that says so."""
    for k, part in enumerate(parts):
        matrices = [m for block in part.blocks if isinstance(block, MatrixRow) for m in block.matrices]
        shown = [*matrices, *(block for block in part.blocks if isinstance(block, EquationBlock | Matrix))]
        nodes = [node for block in shown for node in block.nodes]
        if has_rounded(setting.eqs.textbook, nodes, setting.numerals):
            said = Paragraph(DIGITS_NOTE.format(setting.digits))
            return (*parts[:k], replace(part, blocks=(said, *part.blocks)), *parts[k + 1 :])
    return tuple(parts)


def _equations(setting: Setting, section: EquationSection) -> Iterator[Block]:
    """Yield equations, or a sentence in place of those that nobody reads."""
    graph = setting.eqs.formed.graph
    if _is_big(graph, section.nodes):
        yield Paragraph("Too large to print.")
    else:
        yield EquationBlock(
            graph, section.sides, setting.numerals, section.leading, section.remarks, section.relations
        )


def _is_big(graph: Graph, nodes: Sequence[int]) -> bool:
    return operation_count(graph, list(nodes)) > MOST_OPERATIONS or _has_solution(graph, nodes)


def _is_long(graph: Graph, nodes: Sequence[int]) -> bool:
    return _has_solution(graph, nodes) or max(tree_sizes(graph, nodes), default=0) > LONG


def _has_solution(graph: Graph, nodes: Sequence[int]) -> bool:
    """Return whether a formula reads accelerations or multipliers that are solved for: no formula itself."""
    return any(graph.ops[node] == SADDLE for node in graph.reachable(nodes))
