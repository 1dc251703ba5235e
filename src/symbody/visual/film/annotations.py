"""What is drawn over bodies: frames, traces, forces and their scale, axes, scale bar, gravity, time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Final

import numpy as np

from symbody.visual.film.camera import Camera
from symbody.visual.film.drawing import Caption, Filled, Mark, Stroke
from symbody.visual.film.facets import Floats
from symbody.visual.film.palette import AXES, CONTACT, FORCE, TORQUE, Paper, blend
from symbody.visual.film.solid_facets import rotation_of
from symbody.visual.film.stage import BodyPlaces
from symbody.visual.film.text_metrics import text_width
from symbody.visual.scene.scene import MotionVector, Scene, SceneMotion, VectorKind

Size = tuple[float, float]

SMALL: Final = 8.5  # points: sizes of type
TITLE: Final = 11.0
MARGIN: Final = 14.0  # points from the rims
_AXIS: Final = 24.0  # points: lengths of arrows in the corners
_FRAME: Final = 0.075  # of the scene's size: lengths of axes of frames
_USUAL: Final = 0.25  # of the scene's size: forces as large as they are for all but a tenth of the time
_LONGEST: Final = 0.5  # of the scene's size: longer arrows are cut off, such as those of impacts
_SHARE: Final = 0.9  # of the time in which a force acts it is no larger than what sets the scale
_NOTHING: Final = 1e-9  # of the largest magnitude
_DOT: Final = 2.2  # points: the radius of a point of contact
_PRINT: Final = 1.5  # points: of a footprint
# Of the scene's size: points of contact that are nearer to the last footprint make no other.
_SPACING: Final = 0.025
FADES: Final = 0.4  # of the motion's length, until a footprint has gone in a film
_SHORT: Final = 0.12  # shares of an axis below this are seen as a point

_HEAD: Final = 4.6  # lengths of a head, in widths of its line
_SLENDER: Final = 0.38  # half the width of a head, in lengths


def frame_marks(scene: Scene, camera: Camera, pose: BodyPlaces) -> list[Mark]:
    """Return the axes of all frames of bodies."""
    marks: list[Mark] = []
    for place, body in enumerate(scene.bodies):
        for frame in body.frames:
            at = pose.positions[place] + pose.rotations[place] @ np.array(frame.at)
            axes = pose.rotations[place] @ rotation_of(frame.quaternion)
            ends = camera.project(np.stack([at, *(at + _FRAME * scene.size * axes.T)]))[:, :2]
            for k, color in enumerate(AXES):
                marks += arrow(ends[0], ends[1 + k], color, 1.1)
    return marks


def trace_marks(camera: Camera, paths: Sequence[Floats], colors: Sequence[str], last: int) -> list[Mark]:
    """Return the first samples of the ways of points (N, 3) in ground's axes."""
    return [
        Stroke((camera.project(path[:last])[:, :2],), color, 1.2)
        for path, color in zip(paths, colors, strict=True)
        if min(last, len(path)) > 1
    ]


def vector_scales(motion: SceneMotion, size: float) -> dict[VectorKind, float]:
    """Return the metres that are drawn for a newton and for a newton metre.

    The largest force that something bears for all but a tenth of the time in which it acts sets the scale:
    the peak of an impact would make all else too short to be seen.
    """
    scales: dict[VectorKind, float] = {}
    for vector in motion.vectors:
        usual = _usual_magnitude(vector.values, motion.times)
        if np.isfinite(usual) and usual > 0.0:
            scales[vector.kind] = min(scales.get(vector.kind, np.inf), _USUAL * size / usual)
    return scales


def _usual_magnitude(values: Floats, times: Floats) -> float:
    sizes = np.linalg.norm(values, axis=1)
    spans = np.diff(times, prepend=times[0])
    spans[:-1] += spans[1:]
    acts = (sizes > _NOTHING * sizes.max()) & (spans > 0.0)
    if not acts.any():
        return float(sizes.max())
    order = np.argsort(sizes[acts])
    passed = np.cumsum(spans[acts][order])
    return float(sizes[acts][order][np.searchsorted(passed, _SHARE * passed[-1])])


def vector_marks(
    camera: Camera,
    pose: BodyPlaces,
    vectors: Sequence[MotionVector],
    k: int,
    scales: Mapping[VectorKind, float],
    size: float,
) -> list[Mark]:
    """Return the arrows of forces and torques at a sample; those of torques have two heads.

    Contacts that do not touch have none; the points of those that do are dots.
    """
    marks: list[Mark] = []
    for vector in vectors:
        if vector.kind not in scales or not np.isfinite(vector.values[k]).all():
            continue
        at = pose.place(vector.anchor) if vector.places is None else vector.places[k]
        along = scales[vector.kind] * vector.values[k]
        length = float(np.linalg.norm(along))
        if vector.places is not None and length == 0.0:
            continue
        ends = camera.project(np.stack([at, at + along * min(1.0, _LONGEST * size / max(length, 1e-300))]))
        is_force = vector.kind == "force"
        color = color_of(vector)
        marks += arrow(ends[0, :2], ends[1, :2], color, 1.8, 1 if is_force else 2)
        if vector.places is not None:
            marks.append(_dot(ends[0, :2], _DOT, color))
    return marks


def color_of(vector: MotionVector) -> str:
    """Return the colour of an arrow."""
    if vector.kind == "torque":
        return TORQUE
    return CONTACT if vector.name.startswith("contact ") else FORCE


def footprint_marks(
    camera: Camera, motion: SceneMotion, time: float, size: float, paper: Paper, share: float
) -> list[Mark]:
    """Return where contacts have touched up to a time: dots, the fainter the older they are.

    Parameters
    ----------
    share : float
        Of the motion's length, after which they have gone.
    """
    lasts = share * float(motion.times[-1] - motion.times[0])
    marks: list[Mark] = []
    for vector in motion.vectors:
        if not vector.prints or vector.places is None:
            continue
        for k in _prints(vector, size):
            age = (time - float(motion.times[k])) / lasts if lasts > 0.0 else 0.0
            if 0.0 <= age < 1.0:
                at = camera.project(vector.places[k][np.newaxis])[0, :2]
                marks.append(_dot(at, _PRINT * (1.0 - 0.5 * age), blend(CONTACT, paper.background, age)))
    return marks


def _prints(vector: MotionVector, size: float) -> list[int]:
    """Return at which samples a contact makes a new print: where it begins to touch, and each so far."""
    assert vector.places is not None
    touches = np.linalg.norm(vector.values, axis=1) > 0.0
    found: list[int] = []
    for k in np.flatnonzero(touches):
        goes_on = bool(found) and k > 0 and bool(touches[k - 1])
        if not goes_on or np.linalg.norm(vector.places[k] - vector.places[found[-1]]) > _SPACING * size:
            found.append(int(k))
    return found


def _dot(at: Floats, radius: float, color: str) -> Mark:
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    return Filled(at + radius * np.column_stack([np.cos(angles), np.sin(angles)]), color)


def legend_marks(
    camera: Camera,
    size: Size,
    paper: Paper,
    scales: Mapping[VectorKind, float],
    vectors: Sequence[MotionVector],
) -> list[Mark]:
    """Return how long forces and torques are drawn, above the lower right corner."""
    marks: list[Mark] = []
    for row, (kind, scale) in enumerate(sorted(scales.items())):
        value = round_number(70.0 / (scale * camera.scale))
        length = value * scale * camera.scale
        y = size[1] - MARGIN - 2.0 - 1.9 * SMALL * (row + 1)
        text = with_unit(value, "N" if kind == "force" else "N m")
        x = size[0] - MARGIN - text_width(text, SMALL) - 6.0
        heads = 1 if kind == "force" else 2
        color = next(color_of(vector) for vector in vectors if vector.kind == kind)
        marks += arrow(np.array([x - length, y]), np.array([x, y]), color, 1.8, heads)
        marks.append(Caption((x + 6.0, y + 0.35 * SMALL), text, SMALL, paper.ink))
    return marks


def corner_marks(scene: Scene, camera: Camera, size: Size, paper: Paper) -> list[Mark]:
    """Return the axes of ground, a scale bar beside them, and the direction of gravity."""
    origin = np.array([MARGIN + _AXIS, size[1] - MARGIN - _AXIS])
    directions = camera.axes[:2] @ np.diag([1.0, 1.0, 1.0])
    shown = [k for k in range(3) if np.hypot(*directions[:, k]) > _SHORT]
    low = min([0.0, *(float(directions[0, k]) for k in shown)])
    below = min([0.0, *(float(directions[1, k]) for k in shown)])
    origin = np.array([MARGIN - low * (_AXIS + 8.0), size[1] - MARGIN + below * (_AXIS + 8.0)])
    marks: list[Mark] = []
    for k in shown:
        along = np.array([directions[0, k], -directions[1, k]])
        marks += arrow(origin, origin + _AXIS * along, AXES[k], 1.2)
        x, y = origin + (_AXIS + 6.0) * along
        marks.append(Caption((float(x), float(y) + 0.35 * SMALL), "xyz"[k], SMALL, AXES[k], "middle"))
    if not camera.distance:
        right = max([0.0, *(float(directions[0, k]) for k in shown)])
        marks += _scale_bar(
            camera, (float(origin[0]) + right * (_AXIS + 8.0) + 18.0, size[1] - MARGIN), paper
        )
    return marks + _gravity(scene, camera, size, paper)


def heading_marks(size: Size, paper: Paper, title: str | None, stamp: str) -> list[Mark]:
    """Return the title in the upper left corner and the time in the lower right one."""
    marks: list[Mark] = []
    if title:
        marks.append(Caption((MARGIN, MARGIN + 0.75 * TITLE), title, TITLE, paper.ink, bold=True))
    if stamp:
        marks.append(Caption((size[0] - MARGIN, size[1] - MARGIN), stamp, SMALL + 0.5, paper.ink, "end"))
    return marks


def round_number(value: float) -> float:
    """Return the largest number of 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(each * power for each in (1.0, 2.0, 5.0) if each * power <= value * (1 + 1e-12)))


def with_unit(value: float, unit: str) -> str:
    """Return a quantity in the unit's multiple that needs the fewest digits.

    >>> with_unit(0.05, "m"), with_unit(2000.0, "N"), with_unit(0.5, "m")
    ('50 mm', '2 kN', '0.5 m')
    """
    for limit, prefix in ((1e6, "M"), (1e3, "k"), (0.1, ""), (1e-4, "m"), (0.0, "µ")):
        if value >= limit * (1 - 1e-9):
            factor = {"M": 1e-6, "k": 1e-3, "": 1.0, "m": 1e3, "µ": 1e6}[prefix]
            return f"{value * factor:.4g} {prefix}{unit}"
    return f"{value:.4g} {unit}"


def time_text(times: Sequence[float], decimals: int) -> str:
    """Return times as they are printed: all, or the first, the second and the last of many."""
    texts = [f"{t:.{decimals}f}".replace("-0." + "0" * decimals, "0." + "0" * decimals) for t in times]
    if len(texts) > 6:
        texts = [*texts[:2], "…", texts[-1]]
    return f"t = {', '.join(texts)} s"


def _scale_bar(camera: Camera, at: tuple[float, float], paper: Paper) -> list[Mark]:
    length = round_number(90.0 / camera.scale)
    x, y = at
    end = x + length * camera.scale
    ticks = tuple(np.array([[each, y - 3.0], [each, y]]) for each in (x, end))
    bar = Stroke((np.array([[x, y], [end, y]]), *ticks), paper.ink, 1.0)
    return [bar, Caption(((x + end) / 2, y - 4.5), with_unit(length, "m"), SMALL, paper.ink, "middle")]


def _gravity(scene: Scene, camera: Camera, size: Size, paper: Paper) -> list[Mark]:
    if scene.gravity is None or not np.linalg.norm(scene.gravity) > 0.0:
        return []
    pull = np.array(scene.gravity) / np.linalg.norm(scene.gravity)
    seen = camera.axes[:2] @ pull * np.array([1.0, -1.0])
    if np.hypot(*seen) < _SHORT:
        return []
    middle = np.array([size[0] - MARGIN - 0.6 * _AXIS, MARGIN + 0.6 * _AXIS])
    start, end = middle - 0.5 * _AXIS * seen, middle + 0.5 * _AXIS * seen
    x, y = middle + 9.0 * np.array([-abs(seen[1]), abs(seen[0])])
    letter = Caption((float(x), float(y) + 0.3 * SMALL), "g", SMALL, paper.faint, "middle")
    return [*chain(arrow(start, end, paper.faint, 1.3)), letter]


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
