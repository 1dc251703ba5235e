"""What is stretched between points: springs, dampers, actuators, ropes, rods; and springs that turn."""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.expr.language.formula import Formula
from symbody.model.constraints.points import Distance
from symbody.model.element import FrameRef
from symbody.model.joint import Joint
from symbody.model.loads.curve import Law
from symbody.model.loads.forces import Bushing, Drive, SpringDamper, TorsionSpring
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import (
    RUBBER,
    SPRING_COLOR,
    STEEL,
    FixedShape,
    ball,
    fixed_shape,
    frame_along,
    mesh_shape,
    shift_frame,
)
from symbody.visual.scene.poses import RigidTransform
from symbody.visual.scene.scene import Anchor, Connector, ConnectorKind, Floats
from symbody.visual.scene.shapes.meshes import spiral, tube

# Sizes in radii of rods.
_COIL, _DAMPER, _ROPE, _ROD = 2.4, 1.3, 0.35, 0.6
# Springs and dampers beside a guide are so far from its middle.
_ASIDE: Final = 3.4
# Springs of sliding joints without a free length of their own have this share of the mechanism's size.
_COIL_LENGTH: Final = 0.45
# Turns of a spring: as many as this times its radius fits into its length, between the two limits.
_TURN_LENGTH, _FEWEST, _MOST = 1.1, 5, 14


def anchor(basis: SceneBasis, address: FrameRef) -> Anchor:
    """Return the origin of a frame as an anchor."""
    return anchor_at(basis, address.body, basis.frames[address])


def anchor_at(basis: SceneBasis, body: str, where: RigidTransform) -> Anchor:
    """Return the origin of a frame on a body as an anchor."""
    return Anchor(basis.places[body], where.place)


def spring_damper_connectors(basis: SceneBasis, element: SpringDamper) -> list[Connector]:
    """Return the spring, the damper and the actuator of an element between two points."""
    distance = basis.distance(element.start, element.end)
    length = abs(basis.numbers.number(element.free, distance)) or distance
    ends = (anchor(basis, element.start), anchor(basis, element.end))
    return [
        _connector(basis, element.name, kind, ends, length)
        for kind in _kinds(element.stiffness, element.damping, element.applied, element.law)
    ]


def drive_connectors(basis: SceneBasis, joint: Joint) -> list[Connector]:
    """Return springs and dampers along the translations of a joint, from a point of start to end."""
    freedoms = basis.freedoms[joint.name]
    if freedoms.translations > 2 or freedoms.slides_in != "start":
        return []
    slides = dict(zip(joint.translation_coordinates, freedoms.slides, strict=False))
    connectors = []
    for name, drive in joint.force.items():
        kinds = _kinds(drive.stiffness, drive.damping, Formula.from_value(0), drive.law)
        if name in slides and kinds:
            where, length = _foot(basis, joint, drive, slides[name], name)
            for kind, aside in zip(kinds, _aside(basis, joint, slides[name], len(kinds)), strict=True):
                start = RigidTransform(where.at + basis.frames[joint.start].axes @ aside, where.axes)
                end = basis.frames[joint.end]
                end = RigidTransform(end.point(aside), end.axes)
                ends = (
                    anchor_at(basis, joint.start.body, start),
                    anchor_at(basis, joint.end.body, end),
                )
                connectors.append(_connector(basis, joint.name, kind, ends, length))
    return connectors


def _aside(basis: SceneBasis, joint: Joint, slide: Floats, count: int) -> list[Floats]:
    """Return where springs and dampers along a guide stand, across it: on both sides where there are two.

    What turns about the guide, or is alone, is on it.
    """
    if count < 2 or basis.freedoms[joint.name].rotations:
        return [np.zeros(3)] * count
    axes = basis.frame(joint.start).axes
    gravity = basis.numbers.vector(basis.model.gravity)
    up = axes.T @ (-gravity if np.any(gravity) else np.array([0.0, 1.0, 0.0]))
    across = up - (up @ slide) * slide
    if np.linalg.norm(across) < 1e-3 * np.linalg.norm(up):
        across = np.eye(3)[int(np.argmin(np.abs(slide)))]
        across = across - (across @ slide) * slide
    step = _ASIDE * basis.rod * across / np.linalg.norm(across)
    return [(1.0 - 2.0 * k / (count - 1)) * step for k in range(count)]


def distance_connectors(basis: SceneBasis, element: Distance) -> list[Connector]:
    """Return the rope or the rod that keeps two points at a distance."""
    length = abs(basis.numbers.number(element.value))
    kind: ConnectorKind = "rope" if element.rope else "line"
    radius = (_ROPE if element.rope else _ROD) * basis.rod
    ends = (anchor(basis, element.start), anchor(basis, element.end))
    return [Connector(element.name, kind, *ends, radius, length)]


def distance_shapes(basis: SceneBasis, element: Distance) -> list[FixedShape]:
    """Return the balls that a rod is held by, or the knots of a rope."""
    radius = (0.8 if element.rope else 1.2) * basis.rod
    return [
        ball(address.body, element.name, basis.frames[address].at, radius, STEEL)
        for address in (element.start, element.end)
    ]


def torsion_shapes(basis: SceneBasis, element: TorsionSpring) -> list[FixedShape]:
    """Return the spiral of a spring that turns."""
    frame = basis.frames[element.start]
    where = frame_along(frame.at, frame.axes @ basis.numbers.axis(element.axis))
    return [_spiral(basis, element.start.body, element.name, where)]


def drive_shapes(basis: SceneBasis, joint: Joint) -> list[FixedShape]:
    """Return the spirals and the motors of what acts about a joint's axes, and the feet of its springs."""
    freedoms = basis.freedoms[joint.name]
    shapes: list[FixedShape] = []
    if not (joint.torque or joint.force or joint.motion):
        return shapes
    frame = basis.frames[joint.start]
    driven = {name: drive for name, drive in joint.torque.items() if name in joint.angle_coordinates}
    if freedoms.rotations == 1 and freedoms.translations == 0:
        where = frame_along(frame.at, frame.axes @ freedoms.axes[0])
        if any(
            _kinds(drive.stiffness, Formula.from_value(0), Formula.from_value(0), drive.law)
            for drive in driven.values()
        ):
            shapes.append(_spiral(basis, joint.start.body, joint.name, where))
        if joint.motion or any(drive.applied.constant() != 0 for drive in driven.values()):
            motor = shift_frame(where, z=-4.2 * basis.rod)
            size = (2.3 * basis.rod, 3.4 * basis.rod)
            shapes.append(fixed_shape(joint.start.body, joint.name, "cylinder", size, motor, STEEL))
    return shapes + _feet(basis, joint)


def bushing_shapes(basis: SceneBasis, element: Bushing) -> list[FixedShape]:
    """Return the rubber between two frames."""
    start, end = basis.frames[element.start], basis.frames[element.end]
    z = start.axes[:, 2]
    size = (3.0 * basis.rod, 4.0 * basis.rod)
    core = (1.4 * basis.rod, 6.0 * basis.rod)
    return [
        fixed_shape(
            element.start.body, element.name, "cylinder", size, frame_along(start.at, z), RUBBER, 0.6
        ),
        fixed_shape(element.end.body, element.name, "cylinder", core, frame_along(end.at, end.axes[:, 2])),
    ]


def _kinds(stiffness: Formula, damping: Formula, applied: Formula, law: Law) -> list[ConnectorKind]:
    """Return the kind of connector that draws a law; a formula is a spring if nothing else is there."""
    kinds: list[ConnectorKind] = []
    if stiffness.constant() != 0:
        kinds.append("spring")
    if damping.constant() != 0:
        kinds.append("damper")
    is_law = not isinstance(law, Formula) or law.constant() != 0
    if is_law and not kinds:
        kinds.append("spring")
    if applied.constant() != 0:
        kinds.append("actuator")
    return kinds


def _connector(
    basis: SceneBasis, name: str, kind: ConnectorKind, ends: tuple[Anchor, Anchor], length: float
) -> Connector:
    if kind == "spring":
        radius = _COIL * basis.rod
        coils = int(np.clip(length / (_TURN_LENGTH * radius), _FEWEST, _MOST))
        return Connector(name, kind, *ends, radius, length, coils, SPRING_COLOR)
    return Connector(name, kind, *ends, _DAMPER * basis.rod, 0.0)


def _foot(
    basis: SceneBasis, joint: Joint, drive: Drive, slide: Floats, coordinate: str
) -> tuple[RigidTransform, float]:
    """Return where on start a spring along a joint begins, and its free length.

    It begins in the frame if its free length is given as that of the coordinate, else before it.
    """
    frame = basis.frames[joint.start]
    free = basis.numbers.number(drive.free)
    usual = _COIL_LENGTH * basis.size
    if abs(free) > 0.2 * usual and drive.stiffness.constant() != 0:
        return RigidTransform(frame.at, frame.axes), abs(free)
    low = min(basis.coordinates[coordinate], basis.travel.get(coordinate, (np.inf, np.inf))[0])
    length = max(usual, 1.4 * (free - low))
    return RigidTransform(frame.point((free - length) * slide), frame.axes), length


def _feet(basis: SceneBasis, joint: Joint) -> list[FixedShape]:
    """Return a small wall where springs along a joint are fixed on start, away from its frame."""
    shapes = []
    freedoms = basis.freedoms[joint.name]
    for connector in drive_connectors(basis, joint)[:1]:
        at = np.array(connector.start.at)
        direction = basis.frames[joint.start].axes @ freedoms.slides[0]
        frame = basis.frames[joint.start].at
        at = frame + (at - frame) @ direction * direction
        if np.linalg.norm(at - basis.frames[joint.start].at) > basis.rod:
            wide = 12.0 if len(drive_connectors(basis, joint)) > 1 else 7.0
            edges = (wide * basis.rod, wide * basis.rod, basis.rod)
            where = shift_frame(frame_along(at, direction), z=-0.5 * basis.rod)
            shapes.append(fixed_shape(joint.start.body, joint.name, "box", edges, where, STEEL))
    return shapes


def _spiral(basis: SceneBasis, body: str, name: str, where: RigidTransform) -> FixedShape:
    line = spiral(1.6 * basis.rod, 4.6 * basis.rod, 3.5)
    raised = shift_frame(where, z=2.2 * basis.rod)
    return mesh_shape(body, name, tube(line, 0.3 * basis.rod, sides=6), raised, SPRING_COLOR)
