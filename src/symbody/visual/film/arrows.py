"""Arrows in the plane of a picture, as strokes and filled heads."""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.visual.film.drawing import Filled, Mark, Stroke
from symbody.visual.film.facets import Floats

_HEAD: Final = 4.6  # lengths of a head, in widths of its line
_SLENDER: Final = 0.38  # half the width of a head, in lengths


def arrow(start: Floats, end: Floats, color: str, width: float, heads: int = 1) -> tuple[Mark, ...]:
    """Return an arrow [pt]; of what is shorter than its head, the head alone in that length."""
    along = end - start
    length = float(np.hypot(*along))
    if length < 0.5:
        return ()
    unit = along / length
    head = min(_HEAD * width, length / heads)
    across = _SLENDER * head * np.array([-unit[1], unit[0]])
    marks: list[Mark] = []
    shaft = end - unit * (0.8 * head + (heads - 1) * 0.75 * head)
    if length > head:
        marks.append(Stroke((np.stack([start, shaft]),), color, width))
    for k in range(heads):
        tip = end - k * 0.75 * head * unit
        base = tip - head * unit
        marks.append(Filled(np.stack([tip, base + across, base + 0.2 * head * unit, base - across]), color))
    return tuple(marks)
