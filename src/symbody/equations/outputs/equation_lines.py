"""The equations as people read them: rates, equations of motion, constraints, and names for shared parts."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from symbody.equations.outputs.display import display_sides, latex_sides
from symbody.equations.outputs.printed_equations import LONG
from symbody.equations.outputs.textbook import Textbook
from symbody.expr.canonical import ZERO
from symbody.expr.graph import Graph
from symbody.expr.printing.latex import latex_name, to_display_with_definitions, to_latex_with_definitions
from symbody.expr.printing.latex_rows import WIDTH, latex_equations_page
from symbody.expr.printing.names import greek_name
from symbody.expr.printing.wrapping import wrap_formula
from symbody.expr.rewrite import tree_size
from symbody.model.signals.signal import Signal

_Printer = Callable[[Graph, Sequence[int], int], tuple[list[str], list[tuple[str, str]]]]
_Sides = list[tuple[str, str]]
_NAME: Final = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True, slots=True)
class Section:
    """Equations ``left = right`` under a title, as nodes."""

    title: str
    sides: list[tuple[int, int]]


@dataclass(frozen=True, slots=True)
class WrittenSection:
    """Equations ``left = right`` under a title, as text."""

    title: str
    sides: _Sides

    @property
    def lines(self) -> list[str]:
        """One line an equation."""
        return [f"{left} = {right}" for left, right in self.sides]


def equation_lines(
    textbook: Textbook, latex: bool = False, limit: int = LONG, width: int = 0, greek: bool = False
) -> list[str]:
    """Return the equations of motion, a line an equation or, of text, lines of at most `width` letters.

    Rates of coordinates come first where they are not speeds themselves, constraints last; with them there
    are titles. If one has more than `limit` operations, shared parts are named and defined at the end.
    """
    sections = written_sections(textbook, latex, limit)
    blocks = [_block(section, latex, len(sections) > 1) for section in sections]
    lines = [_with_greek(line) if greek else line for block in blocks for line in block]
    return lines if latex else [row for line in lines for row in wrap_formula(line, width)]


def equation_text(textbook: Textbook, limit: int = LONG, greek: bool = False, width: int = 0) -> str:
    """Return `equation_lines` as one text, on demand with Greek letters for their names."""
    return "\n".join(equation_lines(textbook, False, limit, width, greek))


def _with_greek(line: str) -> str:
    return _NAME.sub(lambda match: greek_name(match[0]), line)


def equation_latex(textbook: Textbook, limit: int = LONG, width: int = WIDTH) -> str:
    r"""Return the equations as one ``aligned`` environment, broken into rows of about `width` letters."""
    sections = written_sections(textbook, True, limit)
    return latex_equations_page([section.sides for section in sections], width)


def written_sections(textbook: Textbook, latex: bool, limit: int) -> list[WrittenSection]:
    """Return all equations as text, the definitions of shared parts under "where" at the end."""
    sections = _sections(textbook)
    graph = textbook.formed.graph
    nodes = [node for section in sections for pair in section.sides for node in pair]
    printer: _Printer = to_latex_with_definitions if latex else to_display_with_definitions
    texts, definitions = printer(graph, nodes, limit)
    pairs = iter(zip(texts[::2], texts[1::2], strict=True))
    written = [WrittenSection(section.title, _take(pairs, len(section.sides))) for section in sections]
    if max((tree_size(graph, node) for node in nodes), default=0) <= limit:
        # Short enough for the arrangement of textbooks.
        sides = latex_sides(textbook) if latex else display_sides(textbook)
        written = [WrittenSection("motion", sides) if part.title == "motion" else part for part in written]
    outputs = [
        _output_sides(signal, latex) for signal in textbook.formed.topology.model.signals if signal.output
    ]
    if outputs:
        written.append(WrittenSection("outputs", outputs))
    held = [_held_sides(signal, latex) for signal in textbook.formed.topology.model.held_signals]
    if held:
        written.append(WrittenSection("samples", held))
    if definitions:
        named = [(latex_name(name) if latex else name, text) for name, text in definitions]
        written.append(WrittenSection("where", named))
    return written


def _output_sides(signal: Signal, latex: bool) -> tuple[str, str]:
    """Return a signal and the name of the output that it stands for."""
    return _words(signal.name, str(signal.output), latex)


def _held_sides(signal: Signal, latex: bool) -> tuple[str, str]:
    """Return a signal that is sampled, what it is at each sample, and how often that is."""
    return _words(signal.name, f"{signal.output or signal.value}, every {signal.sample} s", latex)


def _words(name: str, text: str, latex: bool) -> tuple[str, str]:
    if not latex:
        return name, text
    return latex_name(name), r"\text{" + re.sub(r"([_#%&$^~\{}])", r"\\\1", text) + "}"


def _take(pairs: Iterator[tuple[str, str]], count: int) -> _Sides:
    return [next(pairs) for _ in range(count)]


def _sections(textbook: Textbook) -> list[Section]:
    graph = textbook.formed.graph
    symbols = [graph.symbol(symbol.derivative) for symbol in textbook.formed.q]
    rates = zip(symbols, textbook.readable("qdot").nodes, strict=True)
    sections = [
        Section("rates", [(left, right) for left, right in rates if left != right]),
        Section("motion", list(zip(textbook.inertial_side.nodes, textbook.forcing_side.nodes, strict=True))),
        Section("constraints", [(node, ZERO) for node in textbook.readable("constraints").nodes]),
        Section("signals", textbook.signal_equations),
    ]
    return [section for section in sections if section.sides or section.title == "motion"]


def _block(section: WrittenSection, latex: bool, is_titled: bool) -> list[str]:
    if not is_titled:
        return section.lines
    if latex:
        return [f"% {section.title}", *section.lines]
    return [f"{section.title}:", *(f"  {line}" for line in section.lines)]
