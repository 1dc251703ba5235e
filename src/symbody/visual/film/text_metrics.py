"""How wide text is, in the one typeface of all pictures."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

_FAMILY: Final = "DejaVu Sans"  # comes with matplotlib; wider than those that browsers take, so that all fit


def font(bold: bool) -> FontProperties:
    """Return the typeface."""
    return FontProperties(family=_FAMILY, weight="bold" if bold else "normal")


@lru_cache(maxsize=512)
def text_outline(text: str, size: float, bold: bool) -> TextPath:
    """Return the outlines of letters [pt], upwards from the start of the baseline; dollars are dollars."""
    return TextPath((0, 0), text.replace("$", r"\$"), size=size, prop=font(bold), usetex=False)


@lru_cache(maxsize=2048)
def text_width(text: str, size: float, bold: bool = False) -> float:
    """Return the width of a line of text [pt]."""
    if not text.strip():
        return 0.3 * size * len(text)
    # control points of letters lie on their outermost places, or a hair beyond
    return float(text_outline(text, size, bold).vertices[:, 0].max())
