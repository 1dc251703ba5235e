"""`Drawing`: a finished picture as data: filled samples below, strokes, filled shapes and words above."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from symbody.visual.film.facets import Floats

Bytes = NDArray[np.uint8]
Side = Literal["start", "middle", "end"]


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """Lines of one colour.

    Attributes
    ----------
    lines : tuple of (N, 2) arrays
        Points of each [pt].
    color : str
        ``"#rrggbb"``.
    width : float
        In points.
    opacity : float
        From 0 to 1.
    dashed : bool
        Whether they are broken.
    """

    lines: tuple[Floats, ...]
    color: str
    width: float
    opacity: float = 1.0
    dashed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Filled:
    """A filled polygon: corners (N, 2) [pt] and ``"#rrggbb"``."""

    corners: Floats
    color: str


@dataclass(frozen=True, slots=True)
class Caption:
    """A line of text.

    Attributes
    ----------
    at : (x, y)
        Start, middle or end of its baseline [pt].
    text : str
        As it is printed.
    size : float
        Of the type [pt].
    color : str
        ``"#rrggbb"``.
    side : str
        What of it is at `at`.
    bold : bool
        Whether it is heavy.
    halo : str
        The colour of a rim that keeps it readable over lines, "" for none.
    """

    at: tuple[float, float]
    text: str
    size: float
    color: str
    side: Side = "start"
    bold: bool = False
    halo: str = ""


Mark = Stroke | Filled | Caption


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """A finished picture.

    Attributes
    ----------
    size : (width, height)
        In points of 1/72 inch.
    background : str
        ``"#rrggbb"``.
    samples : (H, W, 3) array of bytes
        Colours of surfaces, without edges, row by row from the top.
    marks : tuple of Stroke, Filled and Caption
        What lies above, from the lowest to the uppermost.
    """

    size: tuple[float, float]
    background: str
    samples: Bytes
    marks: tuple[Mark, ...]
