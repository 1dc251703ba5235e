"""A document as LaTeX, for pdflatex with amsmath; pictures are PDF files beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from symbody.display.formulas import graph_of_formula
from symbody.errors import ExpressionError
from symbody.expr.language.formula import Formula
from symbody.expr.printing.latex import latex_name, to_latex, to_latex_with_definitions
from symbody.expr.printing.latex_rows import WIDTH, latex_equations_page
from symbody.report import document as parts
from symbody.report.template import fill_template

_PAGE_WIDTH: Final = 64  # letters of a row of the page below
_PACKAGES: Final = r"""\usepackage[T1]{fontenc}
\usepackage[utf8]{inputenc}
\usepackage{amsmath,amssymb,graphicx,longtable}
\allowdisplaybreaks
\setcounter{MaxMatrixCols}{60}
"""
_PAGE: Final = r"""\documentclass[11pt,a4paper]{article}
{{ packages }}\usepackage[margin=2.2cm]{geometry}
\setlength{\parindent}{0pt}
\setlength{\parskip}{0.6em}
\title{{{ title }}}
\date{}
\begin{document}
\maketitle
{{ body }}\end{document}
"""
_NEW_ROW: Final = " \\\\\n"
_ESCAPES: Final = {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "\u2192": r"$\to$",
    "\u00b7": r"$\cdot$",
    "\u2212": "$-$", "\u00b1": r"$\pm$", "<": r"\textless{}", ">": r"\textgreater{}", "|": r"\textbar{}",
    '"': "''", **{c: rf"\{c}" for c in "{}$&#%_"},
}  # fmt: skip


def latex_document(document: parts.ReportContent, folder: str) -> str:
    """Return LaTeX that reads its pictures from a folder."""
    return fill_template(_PAGE, latex_pieces(document, folder), "page")


def latex_pieces(document: parts.ReportContent, folder: str) -> dict[str, str]:
    """Return what templates may contain: title, packages, body, and each section."""
    sections = {part.key: _section(part, folder) for part in document.sections}
    return {
        "title": latex_words(document.title),
        "packages": _PACKAGES,
        "body": "".join(sections.values()),
        **sections,
    }


def latex_words(text: str) -> str:
    """Return plain text with the characters that LaTeX reads otherwise, and no others than Latin ones."""
    return "".join(_ESCAPES.get(c, c if ord(c) < 0x180 else "?") for c in text)


def _section(section: parts.ReportSection, folder: str) -> str:
    blocks = "".join(_block(block, folder) for block in section.blocks)
    return f"\\section{{{latex_words(section.title)}}}\n{blocks}"


def _block(block: parts.Block, folder: str) -> str:
    if isinstance(block, parts.Paragraph):
        return f"{latex_words(block.text)}\n\n"
    if isinstance(block, parts.Notes):
        items = "".join(
            f"\\item {''.join(map(_cell, parts.split_names(text, block.names)))}\n" for text in block.texts
        )
        return f"\\begin{{itemize}}\n{items}\\end{{itemize}}\n" if items else ""
    if isinstance(block, parts.TextTable):
        return _grid(block)
    if isinstance(block, parts.Figure):
        picture = f"\\includegraphics[width=0.9\\textwidth]{{{folder}/{block.name}.pdf}}"
        caption = f"\\caption{{{latex_words(block.caption)}}}"
        return f"\\begin{{figure}}[h]\n\\centering\n{picture}\n{caption}\n\\end{{figure}}\n"
    if isinstance(block, parts.GoverningEquations):
        formula, words = governing_formulas(block)
        return (
            f"The equations of motion are\n\\begin{{equation*}}\n{formula}\n\\end{{equation*}}\n{words}\n\n"
        )
    if isinstance(block, parts.Matrix | parts.MatrixRow):
        return _matrices(block.matrices if isinstance(block, parts.MatrixRow) else (block,))
    return _equations(block)


def _grid(block: parts.TextTable) -> str:
    if not block.rows:
        return ""
    width = 1 / len(block.heading)
    columns = f"p{{\\dimexpr {width:.4f}\\textwidth-2\\tabcolsep\\relax}}" * len(block.heading)
    top = " & ".join(f"\\textbf{{{latex_words(word)}}}" for word in block.heading)
    lines = "".join(" & ".join(map(_cell, row)) + " \\\\\n" for row in block.rows)
    return f"\\begin{{longtable}}{{{columns}}}\n{top} \\\\\n\\hline\n\\endhead\n{lines}\\end{{longtable}}\n"


def _cell(cell: parts.Cell) -> str:
    if isinstance(cell, parts.Name):
        return f"${name_formula(cell.text)}$"
    if isinstance(cell, parts.NameList):
        return ", ".join(f"${name_formula(text)}$" for text in cell.texts)
    if isinstance(cell, parts.Unit):
        return unit_formula(cell.text)
    if isinstance(cell, parts.FormulaList):
        return f"({', '.join(map(formula_cell, cell.entries))})"
    if isinstance(cell, Formula):
        return formula_cell(cell)
    return latex_words(cell) if isinstance(cell, str) else f"${plain_number(cell)}$"


def formula_cell(cell: Formula | str) -> str:
    """Return a formula between dollars, and text as it is."""
    if isinstance(cell, str):
        return latex_words(cell)
    if cell.is_number:
        return f"${cell.text}$"
    try:
        return f"${to_latex(*graph_of_formula(cell))}$"
    except ExpressionError:  # a division by zero, or longer than anybody reads
        return latex_words(cell.text)


def governing_formulas(block: parts.GoverningEquations) -> tuple[str, str]:
    """Return the equations of motion as matrices, and a sentence with the names in their vectors."""
    bold = r"\boldsymbol"
    formula = rf"{bold}{{M}} \, \dot{{{bold}{{u}}}} = {bold}{{F}}"
    lists = [("speeds", "u", block.speeds)]
    if block.has_constraints:
        formula += rf" + {bold}{{J}}^{{\mathrm{{T}}}} {bold}{{\lambda}}, \qquad "
        formula += rf"{bold}{{J}} \, \dot{{{bold}{{u}}}} = {bold}{{\gamma}}"
        lists.append(("multipliers", r"\lambda", block.multipliers))
    words = [
        f"the {word} ${bold}{{{letter}}}$"
        + (f" = ({', '.join(f'${name_formula(name)}$' for name in names)})" if names else "")
        for word, letter, names in lists
    ]
    return formula, f"with {' and '.join(words)}."


def plain_number(value: float) -> str:
    """Return a number, and a dash where there is none or it is infinite."""
    return f"{value:.6g}" if math.isfinite(value) else "--"


def name_formula(name: str) -> str:
    """Return a name of the model as LaTeX, rates with dots."""
    for ending, dot in (("_ddot", r"\ddot"), ("_dot", r"\dot")):
        if name.endswith(ending) and name != ending:
            return rf"{dot}{{{latex_name(name.removesuffix(ending))}}}"
    return latex_name(name)


def unit_formula(unit: str) -> str:
    """Return a unit with raised powers."""
    first, *others = unit.split("^")
    return latex_words(first) + "".join(f"$^{{{part[:1]}}}${latex_words(part[1:])}" for part in others)


def equation_formulas(block: parts.EquationBlock, width: int = WIDTH) -> str:
    """Return equations with their definitions as one ``aligned`` environment."""
    texts, named = to_latex_with_definitions(
        block.graph, block.nodes, parts.LONG, block.numerals, block.leading
    )
    sides = list(zip(texts[::2], texts[1::2], strict=True))
    for k, remark in block.remarks.items():
        sides[k] = sides[k][0], rf"{sides[k][1]} \quad \text{{({latex_words(remark)})}}"
    blocks = [sides]
    if named:
        blocks.append([(latex_name(name), text) for name, text in named])
    signs = {k: relation.latex for k, relation in block.relations.items()}
    return latex_equations_page(blocks, width, [signs])


def matrix_formulas(block: parts.Matrix, width: int = WIDTH) -> tuple[str, str]:
    """Return a matrix, and the definitions that its entries read as an ``aligned`` environment."""
    texts, named = to_latex_with_definitions(block.graph, block.nodes, parts.LONG, block.numerals)
    columns = block.shape[1]
    rows = (" & ".join(texts[start : start + columns]) for start in range(0, len(texts), columns))
    entries = r" \\ ".join(rows)
    shown = rf"\boldsymbol{{{latex_name(block.symbol)}}} = \begin{{bmatrix}}{entries}\end{{bmatrix}}"
    where = [[(latex_name(name), text) for name, text in named]]
    return shown, latex_equations_page(where, width) if named else ""


def _equations(block: parts.EquationBlock) -> str:
    return _number_equations(equation_formulas(block, _PAGE_WIDTH))


def _number_equations(aligned: str) -> str:
    """Return equations with a number each, which may continue on the next page; definitions have none."""
    inner = aligned.removeprefix("\\begin{aligned}\n").removesuffix("\n\\end{aligned}")
    equations, gap, definitions = inner.partition(" \\\\[1ex]\n")
    rows = (f"{row} \\notag" if row.startswith(r"&\q") else row for row in equations.split(_NEW_ROW))
    named = (f"{row} \\notag" for row in definitions.split(_NEW_ROW) if row)
    return f"\\begin{{align}}\n{_NEW_ROW.join(rows)}{gap}{_NEW_ROW.join(named)}\n\\end{{align}}\n"


def _break_pages(aligned: str) -> str:
    """Return equations that may go on on the next page."""
    inner = aligned.removeprefix(r"\begin{aligned}").removesuffix(r"\end{aligned}")
    return f"\\begin{{align*}}{inner}\\end{{align*}}\n"


def _matrices(matrices: Sequence[parts.Matrix]) -> str:
    """Return matrices beside each other where there is room, each as wide as the page at most."""
    formulas = [matrix_formulas(matrix, _PAGE_WIDTH) for matrix in matrices]
    width = r"\ifdim\width>\textwidth\textwidth\else\width\fi"
    boxes = (rf"\resizebox{{{width}}}{{!}}{{$\displaystyle {matrix}$}}" for matrix, _ in formulas)
    where = "".join(_break_pages(text) for _, text in formulas if text)
    row = " \\quad\n".join(boxes)  # lines are broken between them
    return f"\\begin{{center}}\n{row}\n\\end{{center}}\n{where}"
