"""The sections of equations as text and as LaTeX, with names for shared parts."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from symbody.equations.outputs.equation_sections import EquationSection, equation_sections, numerals_of
from symbody.equations.outputs.printed_equations import LONG
from symbody.equations.outputs.textbook import Textbook
from symbody.expr.printing.latex import latex_name, to_display_with_definitions, to_latex_with_definitions
from symbody.expr.printing.latex_rows import WIDTH, latex_equations_page
from symbody.expr.printing.names import greek_name
from symbody.expr.printing.wrapping import wrap_formula

_Writer = Callable[..., tuple[list[str], list[tuple[str, str]]]]
_Sides = list[tuple[str, str]]
_NAME: Final = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True, slots=True)
class WrittenSection:
    """Equations ``left = right`` under a title, as text; `signs` are those that are not ``=``."""

    title: str
    sides: _Sides
    note: str = ""
    signs: Mapping[int, str] = field(default_factory=dict)

    @property
    def lines(self) -> list[str]:
        """One line an equation."""
        signs = self.signs
        rows = [f"{left} {signs.get(k, '=')} {right}" for k, (left, right) in enumerate(self.sides)]
        return rows or [self.note]


def equation_lines(
    textbook: Textbook,
    latex: bool = False,
    limit: int = LONG,
    width: int = 0,
    greek: bool = False,
    digits: int | None = None,
) -> list[str]:
    """Return the equations, a line an equation or, of text, lines of at most `width` letters.

    With more than the equations of motion there are titles. If one has more than `limit` operations, shared
    parts are named and defined at the end.
    """
    sections = written_sections(textbook, latex, limit, digits)
    blocks = [_block(section, latex, len(sections) > 1) for section in sections]
    lines = [line for block in blocks for line in block]
    if greek:
        lines = [_NAME.sub(lambda match: greek_name(match[0]), line) for line in lines]
    return lines if latex else [row for line in lines for row in wrap_formula(line, width)]


def equation_text(
    textbook: Textbook, limit: int = LONG, greek: bool = False, width: int = 0, digits: int | None = None
) -> str:
    """Return `equation_lines` as one text, on demand with Greek letters for their names."""
    return "\n".join(equation_lines(textbook, False, limit, width, greek, digits))


def equation_latex(
    textbook: Textbook, limit: int = LONG, width: int = WIDTH, digits: int | None = None
) -> str:
    r"""Return the equations as one ``aligned`` environment, broken into rows of about `width` letters."""
    sections = written_sections(textbook, True, limit, digits)
    blocks = [section.sides or [(_latex_words(section.note), "")] for section in sections]
    return latex_equations_page(blocks, width, [section.signs for section in sections])


def written_sections(
    textbook: Textbook, latex: bool, limit: int, digits: int | None = None
) -> list[WrittenSection]:
    """Return all equations as text, the definitions of shared parts under "where" at the end."""
    sections = equation_sections(textbook, limit)
    nodes = [node for section in sections for node in section.nodes]
    leading = {root: own for section in sections for root, own in section.leading.items()}
    write: _Writer = to_latex_with_definitions if latex else to_display_with_definitions
    numerals = numerals_of(textbook.formed.topology.model, digits)
    texts, definitions = write(textbook.formed.graph, nodes, limit, numerals, leading)
    pairs = iter(zip(texts[::2], texts[1::2], strict=True))
    written = [_write(section, pairs, latex) for section in sections]
    if definitions:
        named = [(latex_name(name) if latex else name, text) for name, text in definitions]
        written.append(WrittenSection("where", named))
    return written


def _write(section: EquationSection, pairs: Iterator[tuple[str, str]], latex: bool) -> WrittenSection:
    sides = [next(pairs) for _ in section.sides]
    for k, remark in section.remarks.items():
        left, right = sides[k]
        sides[k] = left, rf"{right} \quad {_latex_words(f'({remark})')}" if latex else f"{right} ({remark})"
    for name, text in section.words:
        sides.append((latex_name(name), _latex_words(text)) if latex else (name, text))
    signs = {k: each.latex if latex else each.value for k, each in section.relations.items()}
    return WrittenSection(section.title.word, sides, section.note, signs)


def _latex_words(text: str) -> str:
    return r"\text{" + re.sub(r"([_#%&$^~\{}])", r"\\\1", text) + "}"


def _block(section: WrittenSection, latex: bool, is_titled: bool) -> list[str]:
    if not is_titled:
        return section.lines
    if latex:
        return [f"% {section.title}", *section.lines]
    return [f"{section.title}:", *(f"  {line}" for line in section.lines)]
