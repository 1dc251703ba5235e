"""What all shapes of a scene are made from: the model in numbers, and the sizes of what is drawn."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.expr.language.formula import Formula
from symbody.model.constraint import FrameConstraint
from symbody.model.constraints.rolling import Rolling
from symbody.model.contacts.contact import Contact
from symbody.model.contacts.contact_shapes import SHAPE_KINDS
from symbody.model.element import FrameRef
from symbody.model.joint import Joint
from symbody.model.lengths import model_lengths
from symbody.model.loads.forces import Bushing, SpringDamper, TorsionSpring
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.visual.scene.freedoms import JointFreedoms, joint_freedoms
from symbody.visual.scene.numbers import ModelNumbers
from symbody.visual.scene.poses import (
    RigidTransform,
    body_transforms,
    frame_transforms,
    joint_coordinates,
    joint_transform,
)
from symbody.visual.scene.scene import Floats

# Radius of rods: this share of the mechanism's size, or of a usual body's length if that is less.
_ROD: Final = 0.014
_ROD_OF_BODY: Final = 0.045
# At most so many moments of a motion are looked at.
_MOMENTS: Final = 16
# Points nearer than this share of the size are one.
SAME_POINT: Final = 1e-6

Link = Joint | FrameConstraint | SpringDamper | TorsionSpring | Bushing | Contact


@dataclass(frozen=True, slots=True, eq=False)
class SceneBasis:
    """A model in numbers.

    Attributes
    ----------
    frames : mapping of FrameRef to RigidTransform
        Every frame on its body.
    joints : tuple of Joint
        Those of the model and those that stand for bodies without one.
    freedoms : mapping of joint to JointFreedoms
    coordinates : mapping of name to float
        At the start; zero where neither model nor motion has a value.
    doubtful : frozenset of str
        Joints that have such coordinates.
    travel : mapping of name to (lowest, highest)
        Of the coordinates whose motion is known.
    steps : mapping of joint to RigidTransform
        Where its end frame stands in its start frame at the start.
    moments : tuple of mapping of body to RigidTransform
        Where bodies stand in ground's axes, at the start and at some later times if the motion is known;
        loops may be open.
    links : tuple of Link
        What connects two frames, except the joints of bodies that move freely.
    linked, loose : mapping of body to tuple of FrameRef
        Its frames that links connect, and those with a name that none connects.
    lengths : mapping of body to float
        The largest distance between two of its frames [m].
    places : mapping of body to int
        Its place among the bodies of the scene; ground has 0.
    size : float
        Of the mechanism [m].
    rod : float
        Radius of rods [m].
    """

    model: Model
    numbers: ModelNumbers
    frames: Mapping[FrameRef, RigidTransform]
    joints: tuple[Joint, ...]
    freedoms: Mapping[str, JointFreedoms]
    coordinates: Mapping[str, float]
    doubtful: frozenset[str]
    travel: Mapping[str, tuple[float, float]]
    steps: Mapping[str, RigidTransform]
    moments: tuple[Mapping[str, RigidTransform], ...]
    links: tuple[Link, ...]
    linked: Mapping[str, tuple[FrameRef, ...]]
    loose: Mapping[str, tuple[FrameRef, ...]]
    lengths: Mapping[str, float]
    places: Mapping[str, int]
    size: float
    rod: float

    @property
    def bodies(self) -> Mapping[str, RigidTransform]:
        """Where bodies stand at the start."""
        return self.moments[0]

    def frame(self, address: FrameRef) -> RigidTransform:
        """Return where a frame stands in ground's axes at the start."""
        return self.bodies[address.body] @ self.frames[address]

    def distance(self, start: FrameRef, end: FrameRef) -> float:
        """Return the distance of two frames at the start [m]."""
        return float(np.linalg.norm(self.frame(start).at - self.frame(end).at))

    def extent(self, body: str) -> float:
        """Return the largest distance between two frames of a body [m]; of ground 0."""
        return 0.0 if body == GROUND else self.lengths.get(body, 0.0)

    def course(self, start: FrameRef, end: FrameRef) -> Floats:
        """Return the places (N, 3) of a frame's origin in another frame, at the moments [m]."""
        return np.array([
            (bodies[start.body] @ self.frames[start]).inverse().point(
                bodies[end.body].point(self.frames[end].at)
            )
            for bodies in self.moments
        ])  # fmt: skip

    def points(self, body: str) -> list[Floats]:
        """Return the distinct points of a body [m] where something is connected to it, in its axes."""
        points: list[Floats] = []
        for address in self.linked.get(body, ()):
            at = self.frames[address].at
            if all(np.linalg.norm(at - other) > SAME_POINT * self.size for other in points):
                points.append(at)
        return points

    def loose_points(self, body: str) -> list[Floats]:
        """Return the places of a body's frames [m] at which nothing is connected to it, in its axes."""
        return [self.frames[address].at for address in self.loose.get(body, ())]


def scene_basis(
    model: Model, numbers: ModelNumbers, motion: Mapping[str, Floats] | None = None
) -> SceneBasis:
    """Return the model in numbers.

    Parameters
    ----------
    motion : mapping of coordinate to (N,) array, optional
        Values that coordinates take, the first one at the start; by default the model's initial values.
    """
    courses = {name: np.atleast_1d(values) for name, values in (motion or {}).items()}
    courses = {name: values[np.isfinite(values)] for name, values in courses.items()}
    courses = {name: values for name, values in courses.items() if values.size}
    frames = frame_transforms(model, numbers)
    joints = (*model.joints, *model.free_joints)
    freedoms = {joint.name: joint_freedoms(joint, numbers) for joint in joints}
    start: dict[str, Formula | float] = dict(model.initial)
    start |= {name: float(values[0]) for name, values in courses.items()}
    doubtful = frozenset(joint.name for joint in joints if not _is_known(joint, start))
    count = max((values.size for values in courses.values()), default=1)
    steps = [
        _steps(joints, numbers, _values_at(start, courses, place))
        for place in np.linspace(0, count - 1, min(count, _MOMENTS)).astype(int).tolist()
    ]
    unplaced = {body.name: RigidTransform() for body in model.bodies}
    moments = [{**unplaced, **body_transforms(joints, frames, each, doubtful)} for each in steps]
    lengths = _body_lengths(frames)
    size = _size(model, numbers, _points(frames, moments[0]), lengths.values())
    rod = _ROD * size
    usual = [length for length in lengths.values() if length > SAME_POINT * size]
    if usual:
        rod = min(rod, _ROD_OF_BODY * float(np.median(usual)))
    links = _links(model, freedoms)
    linked = _by_body(address for link in links for address in (link.start, link.end))
    attached = {address for addresses in linked.values() for address in addresses}
    return SceneBasis(
        model=model,
        numbers=numbers,
        frames=frames,
        joints=joints,
        freedoms=freedoms,
        coordinates={
            name: value
            for joint in joints
            for name, value in joint_coordinates(joint, numbers, start).items()
        },
        doubtful=doubtful,
        travel={name: (float(values.min()), float(values.max())) for name, values in courses.items()},
        steps=steps[0],
        moments=tuple(moments),
        links=links,
        linked=linked,
        loose=_by_body(address for address in frames if address.frame and address not in attached),
        lengths=lengths,
        places={name: place for place, name in enumerate((GROUND, *(body.name for body in model.bodies)))},
        size=size,
        rod=rod,
    )


def _values_at(
    start: Mapping[str, Formula | float], courses: Mapping[str, Floats], place: int
) -> dict[str, Formula | float]:
    """Return the values of coordinates at one of the times of a motion."""
    later = {name: float(values[min(place, values.size - 1)]) for name, values in courses.items()}
    return {**start, **later}


def _steps(
    joints: Iterable[Joint], numbers: ModelNumbers, values: Mapping[str, Formula | float]
) -> dict[str, RigidTransform]:
    """Return where the end frame of each joint stands in its start frame, at some values of coordinates."""
    return {
        joint.name: joint_transform(joint, numbers, joint_coordinates(joint, numbers, values))
        for joint in joints
    }


def _links(model: Model, freedoms: Mapping[str, JointFreedoms]) -> tuple[Link, ...]:
    """Return the elements that connect two frames, except the joints of bodies that move freely."""
    kinds = (Joint, FrameConstraint, SpringDamper, TorsionSpring, Bushing, Contact)
    return tuple(
        element
        for element in model.elements
        if isinstance(element, kinds)
        and not (isinstance(element, Joint) and freedoms[element.name].translations == 3)
    )


def _is_known(joint: Joint, values: Mapping[str, object]) -> bool:
    """Return whether all coordinates of a joint have values, or are prescribed."""
    return all(name in values or name in joint.motions for name in joint.coordinates)


def _by_body(addresses: Iterable[FrameRef]) -> dict[str, tuple[FrameRef, ...]]:
    """Return the frames of each body, each once, in the order of their first appearance."""
    groups: dict[str, list[FrameRef]] = {}
    for address in dict.fromkeys(addresses):
        groups.setdefault(address.body, []).append(address)
    return {body: tuple(group) for body, group in groups.items()}


def _body_lengths(frames: Mapping[FrameRef, RigidTransform]) -> dict[str, float]:
    """Return for each body the largest distance between two of its frames [m]."""
    points: dict[str, list[Floats]] = {}
    for address, transform in frames.items():
        points.setdefault(address.body, []).append(transform.at)
    return {body: _largest_distance(each) for body, each in points.items()}


def _largest_distance(points: Sequence[Floats]) -> float:
    if len(points) < 2:
        return 0.0
    array = np.array(points)
    return float(np.linalg.norm(array[:, None] - array[None], axis=-1).max())


def _points(frames: Mapping[FrameRef, RigidTransform], bodies: Mapping[str, RigidTransform]) -> Floats:
    """Return the origins (N, 3) of all frames in ground's axes [m]."""
    return np.array([bodies[address.body].point(frame.at) for address, frame in frames.items()])


def _size(model: Model, numbers: ModelNumbers, points: Floats, lengths: Iterable[float]) -> float:
    """Return a length that fits the mechanism [m]: of the box round its frames, else of formulas, else 1."""
    radii = [numbers.number(part.radius) for part in model.constraints if isinstance(part, Rolling)]
    radii += _contact_radii(model, numbers)
    size = max([float(np.ptp(points, axis=0).max()), *lengths, *(2.0 * abs(radius) for radius in radii)])
    if size > 0.0:
        return size
    shapes = [*model.ground_shapes, *(shape for body in model.bodies for shape in body.shapes)]
    formulas = [formula for shape in shapes for _, formula in shape.lengths] or model_lengths(model)
    return max((abs(numbers.number(formula)) for formula in formulas), default=0.0) or 1.0


def _contact_radii(model: Model, numbers: ModelNumbers) -> list[float]:
    """Return half the sizes of all that touches, but of what is given by a formula of the place [m]."""
    return [
        numbers.number(size) * (0.5 if shape.word == "box" else 1.0)
        for part in model.elements
        if isinstance(part, Contact)
        for shape in part.shapes
        if not SHAPE_KINDS[shape.word].reads
        for size in shape.sizes
    ]
