"""Small pieces of HTML: headings, tables, notes; text is escaped unless its type is HTML."""

from __future__ import annotations

import math
import re
from base64 import b64encode
from collections.abc import Iterable, Sequence
from functools import cache
from html import escape
from importlib.resources import files
from typing import Final

from symbody.expr.printing.mathml import mathml_name
from symbody.expr.printing.mathml_tables import math_element

MOST_ROWS: Final = 12  # of a table
_ALIGNED: Final = "text-align:left;padding:0 1em 0 0"
_FONT_FACE: Final = re.compile(r"@font-face \{[^}]*\}\n")
_PRODUCT: Final = re.compile(r"(?<=[^\s,]) (?=\S)")  # of units: "N m"
_SUPERSCRIPTS: Final = str.maketrans(
    "0123456789", "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"
)


class Markup(str):
    """Text that is HTML."""

    __slots__ = ()


def page(title: str, *parts: Markup) -> str:
    """Return a heading and what stands under it."""
    content = "".join(parts)
    style = f"<style>{maths_style('<mover' in content)}</style>" if "<math" in content else ""
    return f'<div class="symbody">{style}<b>{escape(title)}</b>{content}</div>'


@cache
def maths_style(with_font: bool) -> str:
    """Return the style sheet of equations.

    Parameters
    ----------
    with_font : bool
        Whether the font for mathematics stands in it, with its licence some 42 kB: dots need it.
    """
    folder = files("symbody.display")
    style = folder.joinpath("maths.css").read_text("utf-8")
    if not with_font:
        return _FONT_FACE.sub("", style)
    font = b64encode(folder.joinpath("maths.woff2").read_bytes()).decode("ascii")
    licence = escape(folder.joinpath("maths_font_license.txt").read_text("utf-8").strip(), quote=False)
    return f"/*\n{licence}\n*/\n" + style.replace("./maths.woff2", f"data:font/woff2;base64,{font}")


def paragraph(text: str) -> Markup:
    """Return text as a paragraph."""
    return Markup(f"<div>{_cell(text)}</div>")


def table(heading: Sequence[str], rows: Iterable[Sequence[str]], most: int = MOST_ROWS) -> Markup:
    """Return a table; rows beyond the `most` are counted only, a table without rows is nothing."""
    shown = list(rows)
    if not shown:
        return Markup()
    top = "".join(f'<th style="{_ALIGNED}">{_cell(word)}</th>' for word in heading)
    body = "".join(_line(row) for row in shown[:most])
    if len(shown) > most:
        more = f"\u2026 and {len(shown) - most} more"
        body += f'<tr><td colspan="{len(heading)}" style="{_ALIGNED}">{more}</td></tr>'
    return Markup(f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>")


def notes(texts: Sequence[str]) -> Markup:
    """Return notes as a list."""
    items = "".join(f"<li>{escape(text)}</li>" for text in texts[:MOST_ROWS])
    return Markup(f"<ul>{items}</ul>" if items else "")


def symbol(name: str) -> Markup:
    """Return a name of the model as a formula: dots for ``_dot``, indices, Greek letters."""
    for ending, order in (("_ddot", 2), ("_dot", 1)):
        if name.endswith(ending) and name != ending:
            return Markup(math_element(mathml_name(name.removesuffix(ending), order)))
    return Markup(math_element(mathml_name(name)))


def number(value: float) -> str:
    """Return a number to six digits."""
    return f"{value + 0.0:.6g}" if math.isfinite(value) else "\u2013"  # no minus before 0


def complex_number(value: complex) -> str:
    """Return a complex number to five digits."""
    if value.imag == 0.0:
        return f"{value.real:.5g}".replace("-", "\u2212")
    sign = "+" if value.imag > 0.0 else "\u2212"
    return f"{value.real:.5g} {sign} {abs(value.imag):.5g} i".replace("-", "\u2212")


def show_unit(unit: str) -> str:
    """Return a unit as it is printed: kg·m² for "kg m^2"."""
    first, *others = _PRODUCT.sub("\u00b7", unit).split("^")
    return first + "".join(part[:1].translate(_SUPERSCRIPTS) + part[1:] for part in others)


def _line(row: Sequence[str]) -> str:
    cells = "".join(f'<td style="{_ALIGNED}">{_cell(cell)}</td>' for cell in row)
    return f"<tr>{cells}</tr>"


def _cell(text: str) -> str:
    return text if isinstance(text, Markup) else escape(text)
