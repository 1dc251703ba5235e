"""Layers over each other: ground, earlier positions, the last one, what is transparent, and edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.visual.film.camera import Camera
from symbody.visual.film.drawing import Bytes, Stroke
from symbody.visual.film.facets import Facets, Ints
from symbody.visual.film.palette import color_text, components, edge_color
from symbody.visual.film.stage import Instant, Stage, Strand
from symbody.visual.film.surfaces.layer import Grid, Layer, make_layer
from symbody.visual.film.surfaces.visible_edges import visible_stretches

Depths = NDArray[np.float32]

OUTLINE: Final = 0.9  # points: widths of lines
INNER_EDGE: Final = 0.55
THINNEST: Final = 1.3  # of ropes
_GHOSTLY: Final = 3.0  # times wider are tones of ghosts
_FRONT: Final = np.float32(-np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class Backdrop:
    """What all pictures of one camera have in common: the ground.

    Attributes
    ----------
    camera, grid
        How it is seen.
    paper : str
        The colour behind all.
    tone_width : float
        Of tones on curved surfaces [samples]; 0: they are smooth.
    samples : (H, W, 3) array of bytes
        The ground painted.
    facets, layer
        The ground, and how it is seen.
    """

    camera: Camera
    grid: Grid
    paper: str
    tone_width: float
    samples: Bytes
    facets: Facets
    layer: Layer

    @property
    def sample_length(self) -> float:
        """The distance of two samples [m]."""
        return 1.0 / (self.camera.scale * self.grid.per_point)


def make_backdrop(stage: Stage, camera: Camera, grid: Grid, paper: str, tone_width: float) -> Backdrop:
    """Return the ground of a stage, painted."""
    layer = make_layer(stage.ground, camera, grid, tone_width)
    samples = np.empty((*grid.shape, 3), dtype=np.uint8)
    samples[:] = np.round(255 * components(paper)).astype(np.uint8)
    _paint(samples, layer.buffer.places, layer.colors, 1.0)
    return Backdrop(camera, grid, paper, tone_width, samples, stage.ground, layer)


def paint(backdrop: Backdrop, instants: Sequence[Instant], ghost: float) -> tuple[Bytes, tuple[Stroke, ...]]:
    """Return samples and strokes of a scene at its instants, the last solid, the others as ghosts.

    Parameters
    ----------
    ghost : float
        How opaque the latest ghost is; the first is half as much.
    """
    last = instants[-1]
    top = make_layer(last.moving, backdrop.camera, backdrop.grid, backdrop.tone_width)
    ground = backdrop.layer.buffer.depth
    samples = backdrop.samples.copy()
    strokes: list[Stroke] = []
    solid = np.minimum(ground, top.buffer.depth)
    shown = _in_front(top, ground)
    covered = ground.copy()
    covered.reshape(-1)[top.buffer.places[shown]] = _FRONT
    for k, instant in enumerate(instants[:-1]):
        opacity = ghost * (0.5 + 0.5 * (k + 1) / (len(instants) - 1))
        strokes += _ghost(samples, backdrop, instant, covered, opacity)
    _paint(samples, top.buffer.places[shown], top.colors[shown], 1.0)
    strokes += _edges(backdrop, backdrop.facets, backdrop.layer, solid)
    strokes += _edges(backdrop, last.moving, top, solid)
    strokes += _strands(backdrop, last.strands, solid)
    strokes += _panes(samples, backdrop, last, solid)
    return samples, tuple(strokes)


def _ghost(
    samples: Bytes, backdrop: Backdrop, instant: Instant, covered: Depths, opacity: float
) -> list[Stroke]:
    facets = instant.moving
    layer = make_layer(facets, backdrop.camera, backdrop.grid, _GHOSTLY * backdrop.tone_width)
    shown = _in_front(layer, backdrop.layer.buffer.depth)
    _paint(samples, layer.buffer.places[shown], layer.colors[shown], opacity)
    depth = np.minimum(layer.buffer.depth, covered)
    strength = min(1.0, 1.3 * opacity)
    return [
        *_edges(backdrop, facets, layer, depth, strength),
        *_strands(backdrop, instant.strands, depth, strength),
    ]


def _panes(samples: Bytes, backdrop: Backdrop, instant: Instant, solid: Depths) -> list[Stroke]:
    """Paint what is transparent, the farthest first, and return its edges."""
    strokes = []
    axis = backdrop.camera.axes[2]
    for pane in sorted(instant.panes, key=lambda each: float((each.facets.vertices @ axis).mean())):
        layer = make_layer(pane.facets, backdrop.camera, backdrop.grid, backdrop.tone_width)
        shown = _in_front(layer, solid)
        _paint(samples, layer.buffer.places[shown], layer.colors[shown], pane.opacity)
        # Its own surface hides none of its edges: one sees through it.
        strokes += _edges(backdrop, pane.facets, layer, solid, 0.35 + 0.65 * pane.opacity)
    return strokes


def _in_front(layer: Layer, depth: Depths) -> Ints:
    """Return which of a layer's places are in front of a depth."""
    places = layer.buffer.places
    return np.flatnonzero(layer.buffer.depth.reshape(-1)[places] <= depth.reshape(-1)[places])


def _paint(samples: Bytes, places: Ints, colors: Bytes, opacity: float) -> None:
    flat = samples.reshape(-1, 3)
    if opacity >= 1.0:
        flat[places] = colors
    else:
        mixed = opacity * colors + (1.0 - opacity) * flat[places]
        flat[places] = (mixed + 0.5).astype(np.uint8)


def _edges(
    backdrop: Backdrop, facets: Facets, layer: Layer, depth: Depths, opacity: float = 1.0
) -> list[Stroke]:
    if not len(layer.edges):
        return []
    stretches = visible_stretches(layer.points[layer.edges], depth, backdrop.sample_length)
    lines = stretches.lines
    colors = facets.colors[layer.edge_triangles[lines]]
    kinds = np.concatenate([colors, layer.outlines[lines, np.newaxis]], axis=1)
    groups, place = np.unique(kinds, axis=0, return_inverse=True)
    points = stretches.points / backdrop.grid.per_point
    return [
        Stroke(
            tuple(points[place.reshape(-1) == k]),
            color_text(edge_color(group[:3])),
            OUTLINE if group[3] else INNER_EDGE,
            opacity,
        )
        for k, group in enumerate(groups)
    ]


def _strands(
    backdrop: Backdrop, strands: Sequence[Strand], depth: Depths, opacity: float = 1.0
) -> list[Stroke]:
    strokes = []
    scale = np.array([backdrop.grid.per_point, backdrop.grid.per_point, 1.0])
    for each in strands:
        points = backdrop.camera.project(each.points) * scale
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        stretches = visible_stretches(pieces, depth, backdrop.sample_length)
        width = max(THINNEST, 2 * each.radius * backdrop.camera.scale)
        lines = tuple(stretches.points / backdrop.grid.per_point)
        strokes.append(Stroke(lines, color_text(each.color), width, opacity))
    return [stroke for stroke in strokes if stroke.lines]
