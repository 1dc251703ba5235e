"""A document as Markdown with formulas between dollars, and as a notebook of such cells."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable
from importlib import import_module
from typing import Any
from urllib.parse import quote

from symbody.errors import EnvironmentFault, Problem
from symbody.expr.language.formula import Formula
from symbody.report import document as parts
from symbody.report.latex_document import (
    equation_formulas,
    formula_cell,
    governing_formulas,
    matrix_formulas,
    name_formula,
    plain_number,
    unit_formula,
)
from symbody.report.template import fill_template

Place = Callable[[parts.Figure], str]


def markdown_document(document: parts.ReportContent, folder: str) -> str:
    """Return Markdown that reads its pictures from a folder."""
    return fill_template("# {{ title }}\n\n{{ body }}", markdown_pieces(document, folder), "page")


def markdown_pieces(document: parts.ReportContent, folder: str) -> dict[str, str]:
    """Return what templates may contain: title, body, and each section."""
    sections = {
        part.key: section_text(part, lambda figure: f"{quote(folder)}/{figure.name}.svg")
        for part in document.sections
    }
    return {"title": _words(document.title), "body": "\n".join(sections.values()), **sections}


def section_text(section: parts.ReportSection, place: Place) -> str:
    """Return a section; `place` says where a picture is."""
    blocks = "\n".join(filter(None, (_block(block, place) for block in section.blocks)))
    return f"## {_words(section.title)}\n\n{blocks}"


def notebook_document(document: parts.ReportContent) -> str:
    """Return a notebook of Markdown cells, a section each, with its pictures in them.

    Raises
    ------
    EnvironmentFault
        If nbformat is not installed.
    """
    try:
        nb: Any = import_module("nbformat.v4")
    except ImportError:
        fix = "pip install nbformat, or write .html, .md or .tex"
        raise EnvironmentFault(
            Problem(
                "report.no_nbformat", "", "notebooks are written by nbformat, which is not installed", fix=fix
            )
        ) from None
    cells = [nb.new_markdown_cell(f"# {_words(document.title)}", id="title")]
    for section in document.sections:
        cell = nb.new_markdown_cell(
            section_text(section, lambda figure: f"attachment:{figure.name}.png"), id=section.key
        )
        pictures = [block for block in section.blocks if isinstance(block, parts.Figure)]
        if pictures:
            cell["attachments"] = {
                f"{figure.name}.png": {"image/png": b64encode(figure.draw("png")).decode()}
                for figure in pictures
            }
        cells.append(cell)
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    text: str = nb.writes(nb.new_notebook(cells=cells, metadata=kernel))
    return f"{text}\n"


def _block(block: parts.Block, place: Place) -> str:
    if isinstance(block, parts.Paragraph):
        return f"{_words(block.text)}\n"
    if isinstance(block, parts.Notes):
        return "".join(
            f"- {''.join(map(_cell, parts.split_names(text, block.names)))}\n" for text in block.texts
        )
    if isinstance(block, parts.TextTable):
        return _grid(block)
    if isinstance(block, parts.Figure):
        return f"![{_words(block.caption)}]({place(block)})\n"
    if isinstance(block, parts.MatrixRow):
        return "\n".join(_block(matrix, place) for matrix in block.matrices)
    if isinstance(block, parts.GoverningEquations):
        formula, words = governing_formulas(block)
        return f"The equations of motion are\n\n$$\n{formula}\n$$\n\n{words}\n"
    if isinstance(block, parts.Matrix):
        shown, where = matrix_formulas(block)
        return "".join(f"$$\n{text}\n$$\n" for text in (shown, where) if text)
    return f"$$\n{equation_formulas(block)}\n$$\n"


def _grid(block: parts.TextTable) -> str:
    if not block.rows:
        return ""
    lines = [block.heading, ("---",) * len(block.heading), *(tuple(map(_cell, row)) for row in block.rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _cell(cell: parts.Cell) -> str:
    if isinstance(cell, parts.Name):
        return f"${name_formula(cell.text)}$"
    if isinstance(cell, parts.NameList):
        return ", ".join(f"${name_formula(text)}$" for text in cell.texts)
    if isinstance(cell, parts.Unit):
        return unit_formula(cell.text).replace("|", r"\|")
    if isinstance(cell, parts.FormulaList):
        return f"({', '.join(_words(x) if isinstance(x, str) else _formula_cell(x) for x in cell.entries)})"
    if isinstance(cell, Formula):
        return _formula_cell(cell)
    return _words(cell) if isinstance(cell, str) else plain_number(cell)


def _formula_cell(formula: Formula) -> str:
    return formula_cell(formula).replace("|", r"\vert ")


def _words(text: str) -> str:
    """Return plain text with the characters that Markdown reads otherwise; HTML in it is text."""
    for mark in "\\`*_[]|#$":
        text = text.replace(mark, f"\\{mark}")
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
