"""A drawing as SVG for print: filled regions, strokes in points, text as text."""

from __future__ import annotations

from functools import lru_cache
from typing import Final
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from symbody.visual.film.drawing import Drawing, Filled, Mark, Stroke
from symbody.visual.film.facets import Floats
from symbody.visual.film.files.raster import DASHES
from symbody.visual.film.surfaces.polylines import join_lines
from symbody.visual.film.surfaces.regions import Region, trace_regions

MILLIMETRES: Final = 25.4 / 72  # of a point
FAMILY: Final = "Helvetica, Arial, 'DejaVu Sans', sans-serif"
# Each region has a rim of its own colour: viewers that smooth borders would let the paper shine through.
_RIM: Final = 0.35


def svg_text(drawing: Drawing, name: str) -> str:
    """Return a drawing as the text of an SVG file whose title is a name."""
    width, height = drawing.size
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_number(width * MILLIMETRES)}mm" '
        f'height="{_number(height * MILLIMETRES)}mm" viewBox="0 0 {_number(width)} {_number(height)}" '
        f'role="img" font-family={quoteattr(FAMILY)}>'
    )
    body = [f"<title>{escape(name)}</title>"]
    if drawing.background != "#ffffff":
        body.append(f'<rect width="100%" height="100%" fill="{drawing.background}"/>')
    per_point = drawing.samples.shape[1] / width
    body.append(f'<g fill-rule="evenodd" stroke-width="{_RIM}" stroke-linejoin="round">')
    body += [_region(each, per_point) for each in trace_regions(drawing.samples, drawing.background)]
    body.append('</g>\n<g stroke-linecap="round" stroke-linejoin="round">')
    body += [_mark(each) for each in drawing.marks]
    return "\n".join([head, *body, "</g>", "</svg>", ""])


def _region(region: Region, per_point: float) -> str:
    data = "".join(_path(ring / per_point, closed=True) for ring in region.rings)
    return f'<path fill="{region.color}" stroke="{region.color}" d="{data}"/>'


def _mark(mark: Mark) -> str:
    if isinstance(mark, Stroke):
        data = "".join(_path(line, closed=False) for line in join_lines(mark.lines))
        more = f' opacity="{_number(mark.opacity)}"' if mark.opacity < 1.0 else ""
        if mark.dashed:
            more += f' stroke-dasharray="{DASHES[0]} {DASHES[1]}" stroke-linecap="butt"'
        return (
            f'<path fill="none" stroke="{mark.color}" stroke-width="{_number(mark.width)}"{more} d="{data}"/>'
        )
    if isinstance(mark, Filled):
        return f'<path fill="{mark.color}" d="{_path(mark.corners, closed=True)}"/>'
    more = "" if mark.side == "start" else f' text-anchor="{mark.side}"'
    more += ' font-weight="bold"' if mark.bold else ""
    if mark.halo:
        more += f' stroke="{mark.halo}" stroke-width="{_number(0.28 * mark.size)}" paint-order="stroke"'
    place = f'x="{_number(mark.at[0])}" y="{_number(mark.at[1])}"'
    return (
        f'<text {place} font-size="{_number(mark.size)}" fill="{mark.color}"{more}>{escape(mark.text)}</text>'
    )


def _path(points: Floats, closed: bool) -> str:
    """Return path data: the first point as it is, the others as steps, in hundredths of a point."""
    places = np.round(np.asarray(points) * 100).astype(np.int64)
    steps = np.diff(places, axis=0)
    steps = steps[(steps != 0).any(axis=1)]
    start = _pair(*places[0].tolist())
    if not len(steps):
        return f"M{start}h0" + ("z" if closed else "")
    return f"M{start}l" + " ".join([_pair(x, y) for x, y in steps.tolist()]) + ("z" if closed else "")


def _pair(x: int, y: int) -> str:
    """Return two numbers of hundredths."""
    second = _hundredths(y)
    return _hundredths(x) + (second if second.startswith("-") else f" {second}")


@lru_cache(maxsize=8192)  # most steps are short
def _hundredths(count: int) -> str:
    return _number(count / 100)


def _number(value: float) -> str:
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    if text in ("-0", ""):
        return "0"
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text
