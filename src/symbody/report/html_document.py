"""A document as one HTML file: no script, no request; light, dark and printed."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from typing import Final

from symbody.display.formulas import show_formula
from symbody.display.html import Markup, maths_style, number, show_unit, symbol
from symbody.expr.graph import Graph
from symbody.expr.language.formula import Formula
from symbody.expr.printing.equation_layout import entry_names, equations_html, matrix_html
from symbody.expr.printing.mathml import mathml_name, to_mathml_with_definitions
from symbody.expr.printing.mathml_tables import math_element
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import tree_sizes
from symbody.report import document as parts
from symbody.report.template import fill_template

# Only what stands in the file itself is shown.
_POLICY: Final = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; font-src data:"
_STYLE: Final = """
:root { color-scheme: light dark;
  --ink: #1c2430; --paper: #ffffff; --line: #c9d1dc; --link: #1f5f99; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e8ee; --paper: #14181f; --line: #3a4452; --link: #8fbfea; }
}
body { margin: 0 auto; padding: 1.5rem; max-width: 60rem; color: var(--ink); background: var(--paper);
  font: 16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 1.8rem; } h2 { margin-top: 2.2rem; border-bottom: 1px solid var(--line); }
nav ol { columns: 2; } a { color: var(--link); }
.row { display: flex; flex-wrap: wrap; gap: 0 2rem; }
.row > * { max-width: 100%; overflow-x: auto; }
.row > :has(.sb-equation) { flex: 1 1 100%; }
.wide { overflow-x: auto; padding: 0.3rem 0; }
table.grid { border-collapse: collapse; margin: 0.8rem 0; font-size: 0.95em; }
table.grid th, table.grid td { border-bottom: 1px solid var(--line); padding: 0.25rem 1.2rem 0.25rem 0;
  text-align: left; vertical-align: top; }
math { font-size: 1.05em; }
body { counter-reset: equation; }
.sb-equation { position: relative; padding-right: 3.5em; }
details .sb-equation { padding-right: 0; }
.sb-equation::after { counter-increment: equation; content: "(" counter(equation) ")";
  position: absolute; right: 0; top: 0.3em; text-indent: 0; opacity: 0.75; }
details .sb-equation::after { content: none; counter-increment: none; }
figure { margin: 1rem 0; }
figure img { max-width: 100%; height: auto; background: #ffffff; border-radius: 4px; }
figcaption { font-size: 0.9em; } summary { cursor: pointer; color: var(--link); }
@media print {
  :root { --ink: #000000; --paper: #ffffff; --line: #999999; --link: #000000; }
  body { max-width: none; padding: 0; } .wide { overflow: visible; }
  figure, table.grid { break-inside: avoid; }
}
"""
_PAGE: Final = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{{ policy }}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ title }}</title>
<style>{{ style }}</style>
</head>
<body>
<main>
<h1>{{ title }}</h1>
{{ contents }}{{ body }}</main>
</body>
</html>
"""


def html_document(document: parts.ReportContent) -> str:
    """Return a page."""
    return fill_template(_PAGE, html_pieces(document), "page")


def html_pieces(document: parts.ReportContent) -> dict[str, str]:
    """Return what templates of pages may contain: title, style, policy, contents, body, and each section."""
    sections = {part.key: _section(part) for part in document.sections}
    entries = "".join(
        f'<li><a href="#{part.key}">{escape(part.title)}</a></li>' for part in document.sections
    )
    return {
        "title": escape(document.title),
        "style": maths_style(with_font=True) + _STYLE,
        "policy": _POLICY,
        "contents": f'<nav aria-label="Contents"><ol>{entries}</ol></nav>\n',
        "body": "".join(sections.values()),
        **sections,
    }


def _section(section: parts.ReportSection) -> str:
    blocks = "".join(map(_block, section.blocks))
    return f'<section id="{section.key}">\n<h2>{escape(section.title)}</h2>\n{blocks}</section>\n'


def _block(block: parts.Block) -> str:
    if isinstance(block, parts.Paragraph):
        return f"<p>{escape(block.text)}</p>\n"
    if isinstance(block, parts.Notes):
        return _items(block)
    if isinstance(block, parts.TextTable):
        return _grid(block)
    if isinstance(block, parts.Figure):
        content = b64encode(block.draw("svg")).decode()
        words = escape(block.caption)
        picture = f'<img src="data:image/svg+xml;base64,{content}" alt="{words}">'
        return f"<figure>{picture}<figcaption>{words}</figcaption></figure>\n"
    if isinstance(block, parts.GoverningEquations):
        return _governing_equations(block)
    if isinstance(block, parts.MatrixRow):
        return f'<div class="row">{"".join(map(_matrix, block.matrices))}</div>\n'
    return _matrix(block) if isinstance(block, parts.Matrix) else _equations(block)


def _items(block: parts.Notes) -> str:
    items = (f"<li>{''.join(map(_cell, parts.split_names(text, block.names)))}</li>" for text in block.texts)
    return f"<ul>{''.join(items)}</ul>\n" if block.texts else ""


def _grid(block: parts.TextTable) -> str:
    if not block.rows:
        return ""
    top = "".join(f'<th scope="col">{escape(word)}</th>' for word in block.heading)
    lines = ("".join(f"<td>{_cell(cell)}</td>" for cell in row) for row in block.rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return _scroll(f'<table class="grid"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>')


def _scroll(content: str) -> str:
    """Return what may be wider than the page, to be scrolled by mouse and keys."""
    return f'<div class="wide" tabindex="0">{content}</div>\n'


def _cell(cell: parts.Cell) -> str:
    if isinstance(cell, parts.Name):
        return symbol(cell.text)
    if isinstance(cell, parts.NameList):
        return ", ".join(map(symbol, cell.texts))
    if isinstance(cell, parts.Unit):
        return escape(show_unit(cell.text))
    if isinstance(cell, parts.FormulaList):
        return f"({', '.join(map(_formula_cell, cell.entries))})"
    return _formula_cell(cell) if isinstance(cell, str | Formula) else _negative(number(cell))


def _formula_cell(cell: str | Formula) -> str:
    if isinstance(cell, str):
        return escape(cell)
    shown = show_formula(cell)
    return shown if isinstance(shown, Markup) else escape(_negative(shown))


def _negative(text: str) -> str:
    """Return a number with a minus instead of a hyphen."""
    return text.replace("-", "\u2212")


def _governing_equations(block: parts.GoverningEquations) -> str:
    mass, force, speed = (_bold(mathml_name(name, order)) for name, order in (("M", 0), ("F", 0), ("u", 1)))
    content = f"{mass}{speed}<mo>=</mo>{force}"
    lists = [("speeds", "u", block.speeds)]
    if block.has_constraints:
        jacobian, gamma, multipliers = (_bold(mathml_name(name)) for name in ("J", "gamma", "lambda"))
        content += f'<mo>+</mo><msup>{jacobian}<mi mathvariant="normal">T</mi></msup>{multipliers}'
        content += f'<mo>,</mo><mspace width="2em"/>{jacobian}{speed}<mo>=</mo>{gamma}'
        lists.append(("multipliers", "lambda", block.multipliers))
    words = [
        f"the {word} {math_element(_bold(mathml_name(letter)))}"
        + (f" = ({', '.join(map(symbol, names))})" if names else "")
        for word, letter, names in lists
    ]
    return f"<p>The equations of motion are</p>\n{_formula(content)}<p>with {' and '.join(words)}.</p>\n"


def _bold(content: str) -> str:
    return f'<mrow style="font-weight:bold">{content}</mrow>'


def _equations(block: parts.EquationBlock) -> str:
    texts, named = to_mathml_with_definitions(
        block.graph, block.nodes, parts.LONG, block.numerals, block.leading
    )
    remarks = [block.remarks.get(k, "") for k in range(len(block.sides))]
    shown = equations_html(zip(texts[::2], texts[1::2], strict=True), remarks, block.relations)
    return _with_definitions(_with_source(shown, block.graph, block.nodes), named)


def _matrix(block: parts.Matrix) -> str:
    texts, named = to_mathml_with_definitions(block.graph, block.nodes, parts.LONG, block.numerals)
    columns = block.shape[1]
    starts = range(0, len(texts), columns)
    rows = [texts[start : start + columns] for start in starts]
    shown = matrix_html(_bold(mathml_name(block.symbol)), rows, entry_names(block.symbol, *block.shape))
    return _with_definitions(_with_source(shown, block.graph, block.nodes), named)


def _with_source(shown: str, graph: Graph, nodes: Sequence[int]) -> str:
    """Return formulas with the text that symbody reads back, one a line; long ones have none."""
    if max(tree_sizes(graph, nodes), default=0) > parts.LONG:
        return shown
    text = escape("\n".join(to_text(graph, node) for node in nodes))
    return f'<div data-formula="{text}">{shown}</div>'


def _formula(content: str) -> str:
    """Return a formula in a block."""
    return _scroll(math_element(content, block=True))


def _with_definitions(shown: str, named: list[tuple[str, str]]) -> str:
    """Return formulas with the names of shared parts, which are folded."""
    if not named:
        return shown
    where = equations_html((mathml_name(name), text) for name, text in named)
    return f"{shown}<details><summary>{len(named)} named shared parts</summary>{where}</details>\n"
