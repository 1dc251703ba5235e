"""Names beside what they name: each where it covers neither another name nor, if possible, a body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from symbody.visual.film.camera import Camera
from symbody.visual.film.drawing import Bytes, Caption, Mark, Stroke
from symbody.visual.film.facets import Floats
from symbody.visual.film.palette import Paper, components
from symbody.visual.film.stage import BodyPlaces
from symbody.visual.film.text_metrics import text_width
from symbody.visual.scene.scene import Scene

SIZE: Final = 8.5
Box = tuple[float, float, float, float]  # left, top, right, bottom [pt]
Offsets = dict[str, tuple[float, float]]  # of names placed before

_DISTANCES: Final = (9.0, 16.0, 26.0, 40.0)
_LINE_FROM: Final = 16.0  # names this far away have a line to what they name
_STEPS: Final = 8
_FAR: Final = 0.02  # cost of a point of distance, in shares of the name that cover a body
_MOVE: Final = 0.6  # cost of another place than before: names that jump in a film are hard to read


def named_points(scene: Scene, pose: BodyPlaces) -> dict[str, Floats]:
    """Return where joints and bodies are [m], by the words that name them; a free joint has no place."""
    points = {joint.name: pose.place(joint.end) for joint in scene.joints if joint.type != "free"}
    for place, body in enumerate(scene.bodies[1:], start=1):
        points.setdefault(body.name, pose.positions[place])
    return points


def place_labels(
    names: Mapping[str, Floats],
    camera: Camera,
    samples: Bytes,
    size: tuple[float, float],
    paper: Paper,
    taken: Sequence[Box] = (),
    before: Mapping[str, tuple[float, float]] | None = None,
) -> tuple[list[Mark], Offsets]:
    """Return the marks of names at points (3,) [m], and where each is beside its point.

    Parameters
    ----------
    taken : sequence of boxes
        Where no name may be.
    before : mapping, optional
        Where names were in the picture before.
    """
    covered = _cover_mask(samples, paper)
    per_point = samples.shape[1] / size[0]
    boxes = list(taken)
    marks: list[Mark] = []
    offsets: Offsets = {}
    for name, point in names.items():
        at = camera.project(point)[:2]
        half = (0.5 * text_width(name, SIZE) + 1.5, 0.5 * SIZE + 1.5)
        old = (before or {}).get(name)
        best: tuple[float, tuple[float, float], Box] | None = None
        for offset in _offsets(half, old):
            box = _box(at, offset, half)
            if not _fits(box, size) or any(_overlap(box, each) for each in boxes):
                continue
            cost = _share(covered, box, per_point) + _FAR * float(np.hypot(*offset))
            cost += _MOVE * (old is not None and offset != old)
            if best is None or cost < best[0]:
                best = (cost, offset, box)
        if best is not None:
            offsets[name] = best[1]
            boxes.append(best[2])
            marks += _label(name, at, best[1], half, paper)
    return marks, offsets


def _offsets(half: tuple[float, float], old: tuple[float, float] | None) -> list[tuple[float, float]]:
    """Return where the middle of a name may be, from the point that it names [pt]."""
    places = [] if old is None else [old]
    for distance in _DISTANCES:
        for k in range(_STEPS):
            x, y = np.cos(2 * np.pi * (k - 1) / _STEPS), np.sin(2 * np.pi * (k - 1) / _STEPS)
            places.append((float(x * (distance + half[0] * abs(x))), float(y * (distance + 0.3 * half[1]))))
    return places


def _label(
    name: str, at: Floats, offset: tuple[float, float], half: tuple[float, float], paper: Paper
) -> list[Mark]:
    x, y = float(at[0]) + offset[0], float(at[1]) + offset[1]
    words = Caption((x, y + 0.35 * SIZE), name, SIZE, paper.ink, "middle", halo=paper.background)
    # The nearest point of the name, from which the line starts.
    near = np.clip(at, (x - half[0], y - half[1]), (x + half[0], y + half[1]))
    if np.hypot(*(near - at)) < _LINE_FROM:
        return [words]
    return [Stroke((np.stack([np.asarray(at), near]),), paper.faint, 0.6), words]


def _box(at: Floats, offset: tuple[float, float], half: tuple[float, float]) -> Box:
    x, y = float(at[0]) + offset[0], float(at[1]) + offset[1]
    return x - half[0], y - half[1], x + half[0], y + half[1]


def _fits(box: Box, size: tuple[float, float]) -> bool:
    return box[0] >= 2.0 and box[1] >= 2.0 and box[2] <= size[0] - 2.0 and box[3] <= size[1] - 2.0


def _overlap(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _cover_mask(samples: Bytes, paper: Paper) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Return at every fourth sample whether a body is there."""
    nothing = np.round(255 * components(paper.background)).astype(np.uint8)
    covered: np.ndarray[tuple[int, int], np.dtype[np.bool_]] = (samples[::4, ::4] != nothing).any(axis=2)
    return covered


def _share(covered: np.ndarray[tuple[int, int], np.dtype[np.bool_]], box: Box, per_point: float) -> float:
    left, top, right, bottom = (int(each * per_point / 4) for each in box)
    part = covered[top : bottom + 1, left : right + 1]
    return float(part.mean()) if part.size else 0.0
