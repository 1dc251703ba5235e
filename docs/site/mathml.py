"""Formulas as MathML, which browsers draw without scripts, fonts or a network."""

from __future__ import annotations

import re
from html import escape
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

_LOW = re.compile(r"\\left\(((?:(?!\\left|\\right|\\frac|\\sqrt|\\begin|\^).)*)\\right\)")


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _display(writer: Any, node: nodes.math_block) -> None:
    writer.body.append(f'<div class="math" tabindex="0">{_mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def _mathml(latex: str, display: str) -> str:
    # the converter knows align* but not aligned, and no distances between rows
    rows = latex.replace("{aligned}", "{align*}").replace("\\\\[1ex]", "\\\\")
    body = convert(_with_plain_brackets(rows), display=display)
    body = body.replace("<mover>", '<mover accent="true">')  # dots of full size
    for dots in ("&#x000A8;", "&#x002D9;"):
        body = body.replace(f"<mo>{dots}</mo>", f'<mo stretchy="false">{dots}</mo>')
    for side in ("left", "right"):  # Firefox reads the attribute, Chromium this style alone
        aligned = f'columnalign="{side}"'
        body = body.replace(aligned, f'{aligned} style="text-align: -webkit-{side}"')
    return body.replace("<math ", f'<math aria-label="{escape(latex, quote=True)}" ', 1)


def _with_plain_brackets(latex: str) -> str:
    """Return LaTeX whose brackets grow only around what is higher than a line."""
    while (plain := _LOW.sub(r"(\1)", latex)) != latex:
        latex = plain
    return latex


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the writers of formulas with Sphinx."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_display, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
