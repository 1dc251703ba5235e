"""`Studio`: a scene, its motion, a camera and all choices; it makes drawings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symbody.errors import Problem, UsageError, nearest
from symbody.visual.film.annotations import (
    FADES,
    corner_marks,
    footprint_marks,
    frame_marks,
    heading_marks,
    legend_marks,
    time_text,
    trace_marks,
    vector_marks,
    vector_scales,
)
from symbody.visual.film.camera import View, fit_camera
from symbody.visual.film.drawing import Drawing, Mark
from symbody.visual.film.facets import Floats
from symbody.visual.film.labels import Box, Offsets, named_points, place_labels
from symbody.visual.film.palette import DARK, LIGHT, Paper, body_color
from symbody.visual.film.stage import BodyPlaces, Stage, extent, make_stage, pose_at, stage_at
from symbody.visual.film.surfaces.layer import Grid
from symbody.visual.film.surfaces.painting import Backdrop, make_backdrop, paint
from symbody.visual.scene.scene import Anchor, Scene, SceneMotion, VectorKind

POINTS_PER_PIXEL: Final = 0.75  # 96 pixels and 72 points are an inch
_MARGIN: Final = 44.0  # points around the mechanism
_SMALL_MARGIN: Final = 0.13  # of the picture, where it is small

_LOOSE: Final = ("free", "cartesian", "rectangular", "planar")  # joints that hold nothing in its place
_HIGH: Final = 12.0  # times its size: what rises and falls less above its ground does so in a level picture
_FAR: Final = 3.0  # times its own extent goes a mechanism that is followed


@dataclass(frozen=True, slots=True)
class Look:
    """What a picture shows.

    Attributes
    ----------
    view : str, (3,) or mapping, optional
        "front", "back", "left", "right", "top", "bottom", "isometric", or the direction from the mechanism to
        the eye in ground's axes. A mapping has "direction" (either of these), "up" (what is drawn upwards),
        "zoom" and "perspective" (True: what is far looks small). By default planar mechanisms are seen
        against the normal of their plane, others isometrically.
    size : (width, height)
        In pixels; 96 are an inch where lengths count.
    traces : tuple of str
        Points whose paths are drawn: ``"body.frame"``, or a body for its centre of mass.
    labels, frames : bool
        Whether joints and bodies are named, and the axes of frames drawn.
    dark : bool
        Whether the picture is dark.
    ghosts : float
        How opaque earlier positions in a picture are, from 0 to 1.
    title : str, optional
        In the upper left corner.
    """

    view: View | None = None
    size: tuple[int, int] = (960, 540)
    traces: tuple[str, ...] = ()
    labels: bool = False
    frames: bool = False
    dark: bool = False
    ghosts: float = 0.35
    title: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Studio:
    """All that pictures of one motion have in common.

    Attributes
    ----------
    stage, motion, look, paper, backdrop
        What is drawn, when, and how.
    track : SceneMotion
        The same motion at other times, along which there are footprints.
    size : float
        By which arrows and footprints are drawn: that of the scene, or more where the picture shows more [m].
    scales : mapping
        Metres for a newton and a newton metre.
    trace_times : (M,) array
        When traced points are where they are [s].
    traces : tuple of (M, 3) arrays
        Their places [m].
    trace_colors : tuple of str
        Those of their bodies.
    decimals : int
        Of printed times.
    followed : (3,) array, optional
        Of a mechanism that goes far, which the camera follows: where its centre of mass begins [m].
    level : (3,) array, optional
        Upwards, where a camera that follows stays level, so that what bounces does so above its ground.
    """

    stage: Stage
    motion: SceneMotion
    track: SceneMotion
    look: Look
    paper: Paper
    backdrop: Backdrop
    size: float
    scales: dict[VectorKind, float]
    trace_times: Floats
    traces: tuple[Floats, ...]
    trace_colors: tuple[str, ...]
    decimals: int
    followed: Floats | None
    level: Floats | None

    def draw(
        self, samples: Sequence[int], until: float | None = None, before: Offsets | None = None
    ) -> tuple[Drawing, Offsets]:
        """Return the picture of samples of the motion, the last solid, and where its names stand.

        Parameters
        ----------
        until : float, optional
            When traces end [s]; by default with the motion.
        before : mapping, optional
            Where names stood in the picture before.
        """
        poses = [pose_at(self.motion, k) for k in samples]
        instants = [stage_at(self.stage, pose) for pose in poses]
        backdrop = self.backdrop_at(poses[-1])
        painted, strokes = paint(backdrop, instants, self.look.ghosts)
        camera, scene, size = backdrop.camera, self.stage.scene, _points(self.look)
        last = len(self.trace_times)
        if until is not None:
            last = int(np.searchsorted(self.trace_times, until, side="right"))
        marks: list[Mark] = [*strokes, *trace_marks(camera, self.traces, self.trace_colors, last)]
        latest = float(self.motion.times[samples[-1]])
        share = 1.0 if until is None else FADES  # a picture shows where all of its times have come from
        marks += footprint_marks(camera, self.track, latest, self.size, self.paper, share)
        if self.look.frames:
            marks += frame_marks(scene, camera, poses[-1])
        for k, pose in zip(samples, poses, strict=True):
            marks += vector_marks(camera, pose, self.motion.vectors, k, self.scales, self.size)
        offsets: Offsets = {}
        if self.look.labels:
            named = named_points(scene, poses[-1])
            corners = _corners(size, len(self.scales))
            names, offsets = place_labels(named, camera, painted, size, self.paper, corners, before)
            marks += names
        marks += corner_marks(scene, camera, size, self.paper)
        marks += legend_marks(camera, size, self.paper, self.scales, self.motion.vectors)
        stamp = time_text([float(self.motion.times[k]) for k in samples], self.decimals)
        marks += heading_marks(size, self.paper, self.look.title, stamp)
        return Drawing(size, self.paper.background, painted, tuple(marks)), offsets

    def backdrop_at(self, pose: BodyPlaces) -> Backdrop:
        """Return the ground as the camera sees it that goes along with the mechanism, if it does."""
        before = self.backdrop
        if self.followed is None:
            return before
        gone = centre_of(self.stage.scene, pose) - self.followed
        if self.level is not None:
            gone -= (gone @ self.level) * self.level
        camera = replace(before.camera, center=before.camera.center + gone)
        return make_backdrop(self.stage, camera, before.grid, before.paper, before.tone_width)


def _corners(size: tuple[float, float], scales: int) -> tuple[Box, ...]:
    """Return where axes and scale bar, gravity, and time with legend stand: no names there."""
    width, height = size
    return (
        (0.0, height - 58.0, 150.0, height),
        (width - 60.0, 0.0, width, 44.0),
        (width - 130.0, height - 28.0 - 16.0 * scales, width, height),
    )


def make_studio(
    scene: Scene,
    motion: SceneMotion,
    look: Look,
    per_pixel: float,
    tone_width: float = 0.0,
    track: SceneMotion | None = None,
    *,
    follows: bool = False,
) -> Studio:
    """Return the studio that makes pictures of a motion.

    Parameters
    ----------
    per_pixel : float
        How many samples a pixel has, in width and in height.
    tone_width : float
        Of tones on curved surfaces [samples]; 0: they are smooth, which files of regions cannot say.
    track : SceneMotion, optional
        The same motion at other times, for traces and footprints.
    follows : bool
        Whether the camera follows what goes far; a picture of several times shows all of them.

    Raises
    ------
    UsageError
        If there is no such view, or a traced point is unknown.
    """
    track = motion if track is None else track
    traces = tuple(_trace(scene, track, name) for name in look.traces)
    stage = make_stage(scene, motion)
    size = _points(look)
    chosen = np.unique(np.linspace(0, len(motion.times) - 1, min(len(motion.times), 120)).astype(int))
    poses = [pose_at(motion, k) for k in chosen]
    carried, start = carried_extent(stage, poses)
    followed = start if follows else None
    reach = np.concatenate([extent(stage, poses), *traces]) if followed is None else carried
    margin = min(_MARGIN, _SMALL_MARGIN * min(size))
    camera = fit_camera(scene, look.view, reach[np.isfinite(reach).all(axis=1)], size, margin)
    width = round(per_pixel * look.size[0])
    grid = Grid((round(per_pixel * look.size[1]), width), width / size[0])
    paper = DARK if look.dark else LIGHT
    backdrop = make_backdrop(stage, camera, grid, paper.background, tone_width)
    arrow_size = max(scene.size, 0.5 * _diagonal(reach))
    scales = vector_scales(motion, arrow_size)
    bodies = [body.name for body in scene.bodies]
    colors = tuple(body_color(bodies.index(name.split(".")[0])) for name in look.traces)
    decimals = _decimals(motion.times)
    return Studio(
        stage,
        motion,
        track,
        look,
        paper,
        backdrop,
        arrow_size,
        scales,
        track.times,
        traces,
        colors,
        decimals,
        followed,
        level_direction(stage, poses),
    )


def _points(look: Look) -> tuple[float, float]:
    return POINTS_PER_PIXEL * look.size[0], POINTS_PER_PIXEL * look.size[1]


def _decimals(times: Floats) -> int:
    """Return the number of decimals that distinguishes times: two at least."""
    steps = np.diff(np.unique(times))
    return 2 if not len(steps) or steps.min() >= 0.01 else min(6, int(np.ceil(-np.log10(steps.min()))))


def _trace(scene: Scene, track: SceneMotion, name: str) -> Floats:
    """Return the way of a point (N, 3) of a body [m]."""
    points: dict[str, Anchor] = {}
    for place, body in enumerate(scene.bodies):
        points[body.name] = Anchor(place, (0.0, 0.0, 0.0))
        points |= {f"{body.name}.{frame.name}": Anchor(place, frame.at) for frame in body.frames}
    if name not in points:
        raise UsageError(
            Problem("film.trace", "traces", f"there is no point {name!r}", fix=nearest(name, points))
        )
    return np.array([pose_at(track, k).place(points[name]) for k in range(len(track.times))])


def centre_of(scene: Scene, pose: BodyPlaces) -> Floats:
    """Return the centre of mass (3,) of all bodies [m]; without masses the mean of their places."""
    masses = np.array([body.mass for body in scene.bodies[1:]])
    places = pose.positions[1:]
    if not len(places):
        return np.zeros(3)
    weights = masses / masses.sum() if masses.sum() > 0.0 else np.full(len(places), 1.0 / len(places))
    return np.asarray(weights @ places, dtype=np.float64)


def carried_extent(stage: Stage, poses: Sequence[BodyPlaces]) -> tuple[Floats, Floats | None]:
    """Return points (N, 3) around the mechanism, relative to the point that the camera follows.

    Returns
    -------
    points : (N, 3) array
        As if the centre of mass stayed where it is at first [m].
    start : (3,) array or None
        Where it is at first; None if the mechanism does not go far: then it is not followed.
    """
    first = centre_of(stage.scene, poses[0])
    level = level_direction(stage, poses)
    ground = len(stage.ground.vertices)
    moved, carried = [], []
    for pose in poses:
        points = extent(stage, [pose])[ground:]
        moved.append(points)
        gone = centre_of(stage.scene, pose) - first
        carried.append(points - gone if level is None else points - gone + (gone @ level) * level)
    ways, own = np.concatenate(moved), np.concatenate(carried)
    goes_far = not _is_tied(stage.scene) and _diagonal(ways) > _FAR * _diagonal(own) > 0.0
    return own, first if goes_far else None


def level_direction(stage: Stage, poses: Sequence[BodyPlaces]) -> Floats | None:
    """Return upwards where the ground is seen and the mechanism does not rise or fall far, else None."""
    scene = stage.scene
    if scene.gravity is None or not scene.bodies[0].solids:
        return None
    up = np.array(scene.up)
    heights = [float(up @ centre_of(scene, pose)) for pose in poses]
    own = extent(stage, poses[:1])[len(stage.ground.vertices) :]
    return up if max(heights) - min(heights) < _HIGH * _diagonal(own) else None


def _is_tied(scene: Scene) -> bool:
    """Return whether a joint, such as a guide that shows the way, holds the mechanism on the ground."""
    return any(0 in (joint.start.body, joint.end.body) and joint.type not in _LOOSE for joint in scene.joints)


def _diagonal(points: Floats) -> float:
    good = points[np.isfinite(points).all(axis=1)]
    return float(np.linalg.norm(np.ptp(good, axis=0))) if len(good) else 0.0
