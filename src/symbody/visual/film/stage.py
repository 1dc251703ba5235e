"""`Stage`: a scene made ready to be drawn; `Instant`: what moves, at one time, in ground's axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.visual.film.connector_shapes import coil, cylinder_between, damper, rope_points, side_of
from symbody.visual.film.facets import NOTHING, Facets, Floats, join_facets, unit
from symbody.visual.film.palette import CONNECTORS, body_color, components
from symbody.visual.film.solid_facets import facets_of_solid, line_of_solid, rotation_of
from symbody.visual.scene.scene import Anchor, Connector, Scene, SceneMotion

_SOLID: Final = 0.995  # opacities from here on hide what is behind


@dataclass(frozen=True, slots=True, eq=False)
class Strand:
    """A line in space: points (N, 3) [m], the radius of what it stands for [m], its colour, its body."""

    points: Floats
    radius: float
    color: Floats
    carrier: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Pane:
    """Facets that let through some of what is behind them."""

    facets: Facets
    opacity: float


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A scene made ready to be drawn; all in the axes of the bodies.

    Attributes
    ----------
    scene : Scene
        What is drawn.
    ground, moving : Facets
        What hides all behind it: on the ground, and on the other bodies.
    panes : tuple of Pane
        What does not, one for each solid.
    strands : tuple of Strand
        Lines on bodies.
    shortest : (C,) array
        The least distance that the ends of each connector ever have [m].
    """

    scene: Scene
    ground: Facets
    moving: Facets
    panes: tuple[Pane, ...]
    strands: tuple[Strand, ...]
    shortest: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Instant:
    """What moves, at one time, in ground's axes."""

    moving: Facets
    panes: tuple[Pane, ...]
    strands: tuple[Strand, ...]


@dataclass(frozen=True, slots=True, eq=False)
class BodyPlaces:
    """Where all bodies are, ground first: rotations (B, 3, 3) to ground's axes, positions (B, 3) [m]."""

    rotations: Floats
    positions: Floats

    def place(self, anchor: Anchor) -> Floats:
        """Return where a point of a body is, in ground's axes [m]."""
        return np.asarray(
            self.rotations[anchor.body] @ np.array(anchor.at) + self.positions[anchor.body], dtype=np.float64
        )


def pose_at(motion: SceneMotion, k: int) -> BodyPlaces:
    """Return where the bodies are at a sample of a motion."""
    rotations = np.concatenate([np.eye(3)[np.newaxis], rotation_of(motion.quaternions[k]).reshape(-1, 3, 3)])
    positions = np.concatenate([np.zeros((1, 3)), motion.positions[k].reshape(-1, 3)])
    return BodyPlaces(rotations, positions)


def make_stage(scene: Scene, motion: SceneMotion) -> Stage:
    """Return a scene made ready to be drawn along a motion."""
    pieces: tuple[list[Facets], list[Facets]] = ([], [])
    panes, strands, part = [], [], 0
    for place, body in enumerate(scene.bodies):
        for solid in body.solids:
            color = components(solid.color or body_color(place))
            if solid.kind == "line":
                strands.append(Strand(line_of_solid(solid, scene.meshes), 0.0, color, place))
                continue
            part += 1
            facets = facets_of_solid(solid, scene.meshes).in_color(color, part, place)
            if solid.opacity >= _SOLID:
                pieces[place > 0].append(facets)
            elif solid.opacity > 0.0:
                panes.append(Pane(facets, solid.opacity))
    ground, moving = (join_facets(each) for each in pieces)
    return Stage(scene, ground, moving, tuple(panes), tuple(strands), _shortest(scene, motion))


def stage_at(stage: Stage, pose: BodyPlaces) -> Instant:
    """Return the moving parts at one time, connectors drawn anew."""
    solids, lines = _connectors(stage, pose)
    moving = join_facets([stage.moving.to_ground(pose.rotations, pose.positions), *solids])
    panes = [
        Pane(pane.facets.to_ground(pose.rotations, pose.positions), pane.opacity) for pane in stage.panes
    ]
    strands = [
        Strand(
            each.points @ pose.rotations[each.carrier].T + pose.positions[each.carrier],
            each.radius,
            each.color,
            each.carrier,
        )
        for each in stage.strands
    ]
    return Instant(moving, tuple(panes), (*strands, *lines))


def extent(stage: Stage, poses: Sequence[BodyPlaces]) -> Floats:
    """Return points (N, 3) between which all that is drawn lies, whatever the pose [m]."""
    points = [stage.ground.vertices]
    bodies = range(1, len(stage.scene.bodies))
    corners = {place: _corners(stage, place) for place in bodies}
    anchors = [anchor for each in stage.scene.connectors for anchor in (each.start, each.end)]
    for pose in poses:
        for place in bodies:
            points.append(corners[place] @ pose.rotations[place].T + pose.positions[place])
        points += [pose.place(anchor)[np.newaxis] for anchor in anchors]
    every = np.concatenate(points) if points else np.zeros((0, 3))
    radius = stage.scene.size / 2
    return every if len(every) > 1 else np.array([[-radius] * 3, [radius] * 3])


def _corners(stage: Stage, place: int) -> Floats:
    """Return points of a body that hold the whole of it: those far out in some direction."""
    parts = [stage.moving, *(pane.facets for pane in stage.panes)]
    points = np.concatenate(
        [each.vertices[each.carriers == place] for each in parts]
        + [each.points for each in stage.strands if each.carrier == place]
    )
    if not len(points):
        return np.zeros((1, 3))
    grid = np.array(np.meshgrid(*[[-1.0, -0.5, 0.0, 0.5, 1.0]] * 3)).reshape(3, -1)
    return np.asarray(points[np.unique(np.argmax(points @ grid, axis=0))], dtype=np.float64)


def _shortest(scene: Scene, motion: SceneMotion) -> Floats:
    count = len(motion.times)
    poses = [pose_at(motion, k) for k in np.unique(np.linspace(0, count - 1, min(count, 60)).astype(int))]
    return np.array(
        [
            min(float(np.linalg.norm(pose.place(each.end) - pose.place(each.start))) for pose in poses)
            for each in scene.connectors
        ]
    )


def _connectors(stage: Stage, pose: BodyPlaces) -> tuple[list[Facets], list[Strand]]:
    scene = stage.scene
    solids: list[Facets] = []
    lines: list[Strand] = []
    for place, each in enumerate(scene.connectors):
        color = components(each.color or CONNECTORS[each.kind])
        start, end = pose.place(each.start), pose.place(each.end)
        if each.kind in ("rope", "line"):
            slack = each.length if each.kind == "rope" else 0.0
            lines.append(
                Strand(rope_points(start, end, slack, _gravity_direction(scene)), each.radius, color)
            )
        elif np.linalg.norm(end - start) > 1e-6 * scene.size:
            facets = _connector(each, start, end, float(stage.shortest[place]), scene)
            solids.append(facets.in_color(color, -1 - place, 0))
    return solids, lines


def _connector(each: Connector, start: Floats, end: Floats, shortest: float, scene: Scene) -> Facets:
    if each.kind == "spring":
        reference = np.array(scene.normal if scene.normal is not None else scene.up)
        return coil(start, end, each, side_of(unit(end - start), reference))
    if each.kind in ("damper", "actuator"):
        return damper(start, end, each.radius, shortest)
    return cylinder_between(start, end, each.radius) if each.radius else NOTHING


def _gravity_direction(scene: Scene) -> Floats:
    pull = np.array(scene.gravity if scene.gravity is not None else (0.0, 0.0, 0.0))
    return unit(pull) if np.linalg.norm(pull) > 0.0 else -np.array(scene.up)
