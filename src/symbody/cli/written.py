"""What ``symbody equations`` prints: rates, equations of motion, constraints, and names for shared parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.display import display_equations, latex_equations
from symbody.expr.canonical import ZERO
from symbody.expr.graph import Graph
from symbody.expr.printing.latex import to_display_with_definitions, to_latex_with_definitions
from symbody.expr.rewrite import tree_size

# Operations of one equation that somebody will read without names for its parts.
LONG: Final = 400

_Printer = Callable[[Graph, Sequence[int], int], tuple[list[str], list[tuple[str, str]]]]
_Lines = list[tuple[int, int]]


@dataclass(frozen=True, slots=True)
class _Section:
    """Equations ``left = right`` under a title."""

    title: str
    sides: _Lines


def equation_lines(eqs: EquationSet, latex: bool = False, limit: int = LONG) -> list[str]:
    """Return the equations of motion, a line an equation.

    Rates of coordinates come first where they are not speeds themselves, constraints last; with them there
    are titles. If one has more than `limit` operations, shared parts are named and defined at the end.
    """
    sections = _sections(eqs)
    graph = eqs.formed.graph
    sizes = [tree_size(graph, node) for section in sections for pair in section.sides for node in pair]
    printer: _Printer = to_latex_with_definitions if latex else to_display_with_definitions
    nodes = [node for section in sections for pair in section.sides for node in pair]
    texts, named = printer(graph, nodes, limit)
    lines = [f"{left} = {right}" for left, right in zip(texts[::2], texts[1::2], strict=True)]
    motion = len(eqs.speed_names)
    if max(sizes, default=0) <= limit:  # short enough for the arrangement of textbooks
        before = len(sections[0].sides) if sections[0].title == "rates" else 0
        lines[before : before + motion] = latex_equations(eqs) if latex else display_equations(eqs)
    if len(sections) == 1 and not named:
        return lines
    return _add_title(sections, lines, [f"{name} = {text}" for name, text in named], latex)


def _sections(eqs: EquationSet) -> list[_Section]:
    graph = eqs.formed.graph
    symbols = [graph.symbol(symbol.derivative) for symbol in eqs.formed.q]
    rates = zip(symbols, eqs.textbook.readable("qdot").nodes, strict=True)
    found = [
        _Section("rates", [(left, right) for left, right in rates if left != right]),
        _Section(
            "motion",
            list(zip(eqs.textbook.inertial_side.nodes, eqs.textbook.forcing_side.nodes, strict=True)),
        ),
        _Section("constraints", [(node, ZERO) for node in eqs.textbook.readable("constraints").nodes]),
    ]
    return [section for section in found if section.sides or section.title == "motion"]


def _add_title(
    sections: Sequence[_Section], lines: Sequence[str], named: Sequence[str], latex: bool
) -> list[str]:
    result: list[str] = []
    start = 0
    for section in sections:
        stop = start + len(section.sides)
        result += _block(section.title, lines[start:stop], latex)
        start = stop
    return result + (_block("where", named, latex) if named else [])


def _block(title: str, lines: Sequence[str], latex: bool) -> list[str]:
    return [f"% {title}", *lines] if latex else [f"{title}:", *(f"  {line}" for line in lines)]
