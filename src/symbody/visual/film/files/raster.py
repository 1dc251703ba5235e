"""A drawing as pixels: samples averaged, and strokes and words drawn over them by matplotlib's Agg."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.path import Path
from matplotlib.transforms import Affine2D
from PIL import Image

from symbody.visual.film.drawing import Bytes, Caption, Drawing, Filled, Stroke
from symbody.visual.film.facets import Floats
from symbody.visual.film.palette import components
from symbody.visual.film.text_metrics import text_outline, text_width

POINTS_PER_PIXEL: Final = 0.75  # 96 pixels and 72 points are an inch
DASHES: Final = (4.0, 2.6)  # points


def pixels_of(drawing: Drawing, size: tuple[int, int]) -> Bytes:
    """Return a drawing as pixels (height, width, 3) of a size (width, height)."""
    factor = drawing.samples.shape[1] // size[0]
    image = Image.fromarray(drawing.samples)
    if factor > 1:
        image = image.reduce(factor)
    renderer = RendererAgg(size[0], size[1], 72.0 * size[0] / drawing.size[0])
    context = renderer.new_gc()
    opaque = np.dstack([np.asarray(image), np.full(size[::-1], 255, dtype=np.uint8)])
    renderer.draw_image(context, 0, 0, opaque[::-1])
    context.restore()
    # Points from the upper left corner to pixels from the lower left one.
    scale = size[0] / drawing.size[0]
    place = Affine2D().scale(scale, -scale).translate(0, size[1])
    for mark in drawing.marks:
        if isinstance(mark, Stroke):
            _draw_stroke(renderer, mark, place, scale)
        elif isinstance(mark, Filled):
            _fill(renderer, Path(mark.corners, closed=False), mark.color, place)
        else:
            _draw_words(renderer, mark, place)
    return np.array(renderer.buffer_rgba(), dtype=np.uint8)[:, :, :3]


def path_of_lines(lines: tuple[Floats, ...]) -> Path:
    """Return lines as one path."""
    lengths = np.array([len(line) for line in lines])
    codes = np.full(int(lengths.sum()), Path.LINETO, dtype=np.uint8)
    codes[np.cumsum(lengths) - lengths] = Path.MOVETO
    return Path(np.concatenate(lines), codes)


def path_of_words(words: Caption) -> Path:
    """Return the outlines of letters, in points from the upper left corner of the picture."""
    outline = text_outline(words.text, words.size, words.bold)
    share = {"start": 0.0, "middle": 0.5, "end": 1.0}[words.side]
    shift = share * text_width(words.text, words.size, words.bold)
    place = Affine2D().scale(1, -1).translate(words.at[0] - shift, words.at[1])
    return place.transform_path(outline)


def _draw_stroke(renderer: RendererAgg, stroke: Stroke, place: Affine2D, scale: float) -> None:
    if not stroke.lines:
        return
    context = renderer.new_gc()
    context.set_foreground(tuple(components(stroke.color)), isRGBA=False)
    context.set_alpha(stroke.opacity)
    context.set_linewidth(stroke.width * scale)
    context.set_capstyle("butt" if stroke.dashed else "round")
    context.set_joinstyle("round")
    if stroke.dashed:
        context.set_dashes(0, [scale * each for each in DASHES])
    renderer.draw_path(context, path_of_lines(stroke.lines), place)
    context.restore()


def _fill(renderer: RendererAgg, path: Path, color: str, place: Affine2D) -> None:
    context = renderer.new_gc()
    context.set_linewidth(0.0)
    renderer.draw_path(context, path, place, (*components(color), 1.0))
    context.restore()


def _draw_words(renderer: RendererAgg, words: Caption, place: Affine2D) -> None:
    path = path_of_words(words)
    if words.halo:
        context = renderer.new_gc()
        context.set_foreground(tuple(components(words.halo)), isRGBA=False)
        context.set_linewidth(0.28 * words.size * place.get_matrix()[0, 0])
        context.set_joinstyle("round")
        renderer.draw_path(context, path, place)
        context.restore()
    _fill(renderer, path, words.color, place)
