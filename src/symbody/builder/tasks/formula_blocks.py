"""Blocks of formulas as the page shows them: MathML, LaTeX, SymPy and C beside each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from symbody.errors import SymbodyError
from symbody.expr.graph import Graph
from symbody.expr.printing.equation_layout import entry_names, equations_html, matrix_html
from symbody.expr.printing.latex import to_latex_with_definitions
from symbody.expr.printing.mathml import to_mathml_with_definitions
from symbody.expr.printing.mathml_tables import terms_of
from symbody.expr.printing.numerals import ALL_DIGITS, Numerals
from symbody.expr.printing.relation import Relation
from symbody.expr.rewrite import operation_count, tree_sizes
from symbody.expr.sympy.sympy_bridge import to_sympy

Block = dict[str, Any]

LONG: Final = 400  # operations of a formula above which shared parts get names
_MOST_OPERATIONS: Final = 20_000  # of a block that is written at all; C is written of any
_MOST_CHARACTERS: Final = 400_000  # of MathML that a browser lays out in a moment
_MOST_SYMPY: Final = 20_000  # operations written out
_WIDEST: Final = 60  # characters of LaTeX in a row of a matrix that is drawn as one


@dataclass(frozen=True, slots=True)
class Label:
    """The left side of an equation that is a name: of an entry of a matrix, or of a vector."""

    mathml: str
    latex: str
    text: str


@dataclass(frozen=True, slots=True)
class FormulaBlock:
    """Formulas under one title.

    Attributes
    ----------
    nodes : tuple of int
        Right sides.
    labels : tuple of Label or int
        Left sides: names, or nodes of the graph.
    rows, columns : int
        Of a matrix, whose entries the nodes are, row by row; 0 of other formulas.
    name : Label, optional
        Of the matrix.
    output : str
        What generated C computes; "" where there is nothing of that name.
    spans : tuple of mapping of node to str
        Of each equation, the terms that bear marks.
    numerals : Numerals
        How many digits numbers have on the screen; copies have all.
    leading : mapping of node to node
        The acceleration that comes first in a left side.
    remarks : mapping of int to str
        What is said behind an equation, by its place.
    relations : mapping of int to Relation
        What stands between sides where that is no equality, by their place.
    """

    title: str
    nodes: tuple[int, ...]
    labels: tuple[Label | int, ...]
    rows: int = 0
    columns: int = 0
    name: Label | None = None
    output: str = ""
    spans: tuple[Mapping[int, str], ...] = ()
    numerals: Numerals = ALL_DIGITS
    leading: Mapping[int, int] = field(default_factory=dict)
    remarks: Mapping[int, str] = field(default_factory=dict)
    relations: Mapping[int, Relation] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _BlockTexts:
    """The nodes of a block as text, and the names of shared parts."""

    texts: dict[int, str]
    named: list[tuple[str, str]]


def entry_label(symbol: str, *indices: int) -> Label:
    """Return the name of an entry of a matrix or a vector, counted from 1."""
    digits = "".join(map(str, indices)) if all(k < 10 for k in indices) else ",".join(map(str, indices))
    return Label(
        f"<msub><mi>{symbol}</mi><mn>{digits}</mn></msub>",
        f"{symbol}_{{{digits}}}",
        f"{symbol}[{', '.join(str(k - 1) for k in indices)}]",
    )


def number_block(title: str, symbol: str, rows: Sequence[Sequence[float]]) -> Block:
    """Return a matrix of numbers as the page shows it."""
    texts = [[f"{value:.5g}" for value in row] for row in rows]
    cells = [[f"<mn>{text}</mn>".replace("-", "\u2212") for text in row] for row in texts]
    body = " \\\\\n".join(" & ".join(row) for row in texts)
    listed = ", ".join("[" + ", ".join(repr(float(value)) for value in row) + "]" for row in rows)
    latex = f"{symbol} = \\begin{{bmatrix}}\n{body}\n\\end{{bmatrix}}"
    return {
        "title": title,
        "mathml": matrix_html(f"<mi>{symbol}</mi>", cells, entry_names(symbol, len(cells), len(cells[0])))
        if cells
        else "",
        "latex": latex,
        "sympy": f"{symbol} = Matrix([{listed}])",
        "c": "",
        "characters": len(latex),
        "empty": not rows,
    }


def render_block(graph: Graph, block: FormulaBlock, write_c: Callable[[], str]) -> Block:
    """Return a block as the page shows it; what is too long has its number of characters only.

    C, which takes longest, is written of what can be shown at all.

    Raises
    ------
    ExpressionError
        If something of it has no formula.
    """
    nodes = [*block.nodes, *(label for label in block.labels if isinstance(label, int))]
    result: Block = {"title": block.title, "mathml": None, "latex": None, "sympy": None, "c": "",
                     "characters": 0, "empty": not block.nodes}  # fmt: skip
    if not nodes:
        return {**result, "c": write_c()}
    operations = operation_count(graph, nodes)
    if operations > _MOST_OPERATIONS:
        c_code = write_c()
        characters = max(len(c_code), operations)
        return {**result, "c": c_code, "operations": operations, "characters": characters}
    latex = _latex(graph, block, nodes)
    mathml = _mathml(graph, block, nodes, latex)
    return {
        **result,
        "operations": operations,
        "mathml": mathml if len(mathml) <= _MOST_CHARACTERS else None,
        "latex": latex,
        "sympy": _sympy(graph, block, nodes),
        "c": write_c(),
        "characters": len(latex),
    }


def _latex(graph: Graph, block: FormulaBlock, nodes: Sequence[int]) -> str:
    texts, named = to_latex_with_definitions(graph, nodes, LONG, leading=block.leading)
    written = _BlockTexts(dict(zip(nodes, texts, strict=True)), named)
    if _is_drawn(block, written):
        assert block.name is not None
        rows = [" & ".join(row) for row in _matrix_rows(block, written)]
        body = " \\\\\n".join(rows)
        text = f"{block.name.latex} = \\begin{{bmatrix}}\n{body}\n\\end{{bmatrix}}"
        sides: list[tuple[str, str]] = []
    else:
        sides = [(_side(label, written, "latex"), right) for label, right in _pairs(block, written)]
        text = ""
    sides += named
    signs = [block.relations.get(k, Relation.EQUAL).latex for k in range(len(sides))]
    pieces = (f"{left} &{sign} {right}" for sign, (left, right) in zip(signs, sides, strict=True))
    lines = " \\\\\n".join(pieces)
    aligned = f"\\begin{{aligned}}\n{lines}\n\\end{{aligned}}" if sides else ""
    return "\n\n".join(part for part in (text, aligned) if part)


def _mathml(graph: Graph, block: FormulaBlock, nodes: Sequence[int], latex: str) -> str:
    if len(latex) > _MOST_CHARACTERS:
        return " " * (_MOST_CHARACTERS + 1)
    texts, named = to_mathml_with_definitions(graph, nodes, LONG, block.numerals, block.leading)
    written = _BlockTexts(dict(zip(nodes, texts, strict=True)), named)
    if block.name is not None:
        names = entry_names(block.name.latex, block.rows, block.columns)
        return matrix_html(block.name.mathml, _matrix_rows(block, written), names) + equations_html(named)
    sides = [(_side(label, written, "mathml"), right) for label, right in _pairs(block, written)]
    if block.spans and not named:
        sides = [
            (_with_spans(graph, block, spans, left), _with_spans(graph, block, spans, right))
            for spans, (left, right) in zip(block.spans, sides, strict=True)
        ]
    remarks = [block.remarks.get(k, "") for k in range(len(sides))]
    return equations_html([*sides, *named], remarks, block.relations)


def _sympy(graph: Graph, block: FormulaBlock, nodes: Sequence[int]) -> str | None:
    """Return the block as text that SymPy writes, None where it would be written out too long."""
    if sum(tree_sizes(graph, nodes)) > _MOST_SYMPY:
        return None
    try:
        written = dict(zip(nodes, map(str, to_sympy(graph, nodes)), strict=True))
    except SymbodyError:  # SymPy could not tell two symbols apart
        return None
    if block.rows:
        assert block.name is not None
        rows = [block.nodes[k * block.columns : (k + 1) * block.columns] for k in range(block.rows)]
        listed = ", ".join("[" + ", ".join(written[node] for node in row) + "]" for row in rows)
        return f"{block.name.text} = Matrix([{listed}])"
    lines = []
    for k, (label, node) in enumerate(zip(block.labels, block.nodes, strict=True)):
        if isinstance(label, int):
            relation = block.relations.get(k, Relation.EQUAL)
            lines.append(f"{relation.sympy}({written[label]}, {written[node]})")
        else:
            lines.append(f"{label.text} = {written[node]}")
    return "\n".join(lines)


def _is_drawn(block: FormulaBlock, written: _BlockTexts) -> bool:
    """Return whether a matrix is drawn as one: whether its rows fit a column of text."""
    if not block.rows:
        return False
    return all(sum(map(len, row)) <= _WIDEST * 2 for row in _matrix_rows(block, written))


def _matrix_rows(block: FormulaBlock, written: _BlockTexts) -> list[list[str]]:
    texts = [written.texts[node] for node in block.nodes]
    return [texts[k * block.columns : (k + 1) * block.columns] for k in range(block.rows)]


def _pairs(block: FormulaBlock, written: _BlockTexts) -> list[tuple[Label | int, str]]:
    """Return left and right sides; of a matrix those entries that are not zero."""
    pairs = zip(block.labels, block.nodes, strict=True)
    return [(label, written.texts[node]) for label, node in pairs if node != 0 or not block.rows]


def _side(label: Label | int, written: _BlockTexts, kind: str) -> str:
    return written.texts[label] if isinstance(label, int) else str(getattr(label, kind))


def _with_spans(graph: Graph, block: FormulaBlock, spans: Mapping[int, str], formula: str) -> str:
    """Return a formula whose terms bear the spans they are known under.

    Parameters
    ----------
    spans : mapping of node to str
        Terms that may stand in it.
    formula : str
        MathML of a sum.
    """
    texts, _ = to_mathml_with_definitions(graph, list(spans), LONG, block.numerals)
    marks = {_strip_sign(text): span for text, span in zip(texts, spans.values(), strict=True)}
    parts = []
    for elements in terms_of(list(ElementTree.fromstring(f"<mrow>{formula}</mrow>"))):
        signs, unsigned = _split_sign(elements)
        span = marks.get("".join(map(_text, unsigned)))
        inner = "".join(map(_text, unsigned))
        parts.append("".join(map(_text, signs)))
        parts.append(inner if span is None else f'<mrow data-span="{span}">{inner}</mrow>')
    return "".join(parts)


def _strip_sign(formula: str) -> str:
    _, unsigned = _split_sign(list(ElementTree.fromstring(f"<mrow>{formula}</mrow>")))
    return "".join(map(_text, unsigned))


def _split_sign(elements: list[Element]) -> tuple[list[Element], list[Element]]:
    is_sign = bool(elements) and elements[0].tag == "mo" and elements[0].text in ("+", "\u2212")
    return (elements[:1], elements[1:]) if is_sign else ([], elements)


def _text(element: Element) -> str:
    return ElementTree.tostring(element, encoding="unicode")
