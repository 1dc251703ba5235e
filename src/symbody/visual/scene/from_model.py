"""`make_scene`: the shapes of a mechanism from its model alone, before any equation is formed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from symbody.arguments import checked_arguments
from symbody.model.constraints.points import (
    Distance,
    PointOnCurve,
    PointOnLine,
    PointOnPlane,
    PointOnSurface,
)
from symbody.model.constraints.rolling import KnifeEdge, Rolling
from symbody.model.declarations.arguments import Value
from symbody.model.element import FrameRef
from symbody.model.joint import Joint
from symbody.model.loads.forces import Bushing, SpringDamper, TorsionSpring
from symbody.model.model import Model
from symbody.model.naming import CENTRE, GROUND
from symbody.visual.scene.basis import SceneBasis, scene_basis
from symbody.visual.scene.fixed_shape import GROUND_COLOR, FixedShape
from symbody.visual.scene.numbers import ModelNumbers, model_numbers
from symbody.visual.scene.poses import as_point
from symbody.visual.scene.scene import (
    Connector,
    Scene,
    SceneBody,
    SceneFrame,
    SceneJoint,
    SceneMesh,
    Solid,
)
from symbody.visual.scene.shapes.body_shapes import body_shapes
from symbody.visual.scene.shapes.connectors import (
    anchor,
    bushing_shapes,
    distance_connectors,
    distance_shapes,
    drive_connectors,
    drive_shapes,
    spring_damper_connectors,
    torsion_shapes,
)
from symbody.visual.scene.shapes.contact_solids import contact_solids
from symbody.visual.scene.shapes.gears import gear_shapes
from symbody.visual.scene.shapes.ground_shapes import ground_shapes
from symbody.visual.scene.shapes.joint_shapes import joint_shapes
from symbody.visual.scene.shapes.patches import (
    curve_shapes,
    floor_shapes,
    line_shapes,
    plane_shapes,
    surface_shapes,
)
from symbody.visual.scene.shapes.user_shapes import user_shapes
from symbody.visual.scene.shapes.wheels import knife_shapes, rolling_shapes
from symbody.visual.scene.view import facing_normal, gravity_of, plane_normal, up_direction

_NOTHING: Mapping[str, float] = MappingProxyType({})


@checked_arguments
def make_scene(
    model: Model,
    parameters: Mapping[str, Value] = _NOTHING,
    motion: Mapping[str, ArrayLike] = _NOTHING,
) -> Scene:
    """Return a mechanism as shapes.

    Bodies without shapes of their own get some: rods between what is connected to them, solids of their
    inertia. Joints are drawn by their axes and freedoms.

    Parameters
    ----------
    parameters : mapping of name to number or formula
        Take the place of the model's values. What has no value is drawn as if it were 1, with a note.
    motion : mapping of coordinate to (N,) array
        Values that coordinates take, the first of them at the start: guides are as long as what moves on
        them needs. Without them the model's initial values stand for the start.

    Raises
    ------
    ModelError
        If names are not parameters, values not formulas, or formulas depend on each other in a circle.
    """
    courses = {name: np.asarray(values, dtype=np.float64) for name, values in motion.items()}
    return draw_scene(scene_basis(model, model_numbers(model, parameters), courses))


def draw_scene(basis: SceneBasis) -> Scene:
    """Return the mechanism of a basis as shapes."""
    model = basis.model
    gravity, normal = gravity_of(basis), plane_normal(basis)
    up = up_direction(gravity, normal)
    given, remarks = user_shapes(basis)
    solids, meshes = _with_meshes([*_shapes(basis, given), *ground_shapes(basis, up, normal)])
    return Scene(
        name=model.name,
        size=float(basis.size),
        up=as_point(up),
        normal=None if normal is None else as_point(facing_normal(normal, up)),
        gravity=None if gravity is None else as_point(gravity),
        bodies=_bodies(basis, solids),
        connectors=tuple(_connectors(basis)),
        joints=tuple(
            SceneJoint(joint.name, _type_of(joint), anchor(basis, joint.start), anchor(basis, joint.end))
            for joint in model.joints
        ),
        meshes=meshes,
        notes=(*_notes(basis.numbers), *remarks),
    )


def _notes(numbers: ModelNumbers) -> tuple[str, ...]:
    """Return the notes on assumed parameters."""
    if not numbers.assumed:
        return ()
    verb = "has" if len(numbers.assumed) == 1 else "have"
    return (f"{', '.join(numbers.assumed)} {verb} no value: the picture uses 1",)


def _shapes(basis: SceneBasis, given: Mapping[str, list[FixedShape]]) -> list[FixedShape]:
    """Return all solids, those of bodies first; bodies that roll or touch have no other shape than rods.

    Parameters
    ----------
    given : mapping of body to its shapes
        Where the model has some, which take the place of the usual ones.
    """
    rollers = [element for element in basis.model.constraints if isinstance(element, Rolling)]
    wheels = [*gear_shapes(basis), *(shape for each in rollers for shape in rolling_shapes(basis, each))]
    wheels += contact_solids(basis)
    wheels = [shape for shape in wheels if shape.body == GROUND or shape.body not in given]
    names = {shape.body for shape in wheels}
    shapes = [*given.get(GROUND, ()), *floor_shapes(basis, given)]
    for body in basis.model.bodies:
        shapes += given.get(body.name) or body_shapes(basis, body, body.name in names)
    detailed = {name for name, own in given.items() if any(shape.mesh is not None for shape in own)}
    for joint in basis.model.joints:
        if {joint.start.body, joint.end.body} <= detailed:
            continue  # meshes show themselves how they are joined
        shapes += [*joint_shapes(basis, joint), *drive_shapes(basis, joint)]
    for element in basis.model.elements:
        make = _SHAPES.get(type(element))
        shapes += [] if make is None else make(basis, element)
    return [*shapes, *wheels]


def _connectors(basis: SceneBasis) -> list[Connector]:
    """Return all that is stretched between points."""
    connectors: list[Connector] = []
    for element in basis.model.elements:
        if isinstance(element, SpringDamper):
            connectors += spring_damper_connectors(basis, element)
        elif isinstance(element, Distance):
            connectors += distance_connectors(basis, element)
        elif isinstance(element, Joint):
            connectors += drive_connectors(basis, element)
    return connectors


def _with_meshes(shapes: Iterable[FixedShape]) -> tuple[dict[str, list[Solid]], tuple[SceneMesh, ...]]:
    """Return the solids of each body, with the places of their meshes, and the meshes, each once."""
    solids: dict[str, list[Solid]] = {}
    meshes: list[SceneMesh] = []
    places: dict[int, int] = {}
    for shape in shapes:
        solid = shape.solid
        if shape.mesh is not None:
            place = places.setdefault(id(shape.mesh), len(meshes))
            if place == len(meshes):
                meshes.append(shape.mesh)
            solid = replace(solid, mesh=place)
        if shape.body == GROUND and not solid.color:
            solid = replace(solid, color=GROUND_COLOR)
        solids.setdefault(shape.body, []).append(solid)
    return solids, tuple(meshes)


def _bodies(basis: SceneBasis, solids: Mapping[str, list[Solid]]) -> tuple[SceneBody, ...]:
    """Return ground and bodies with their frames."""
    frames: dict[str, list[SceneFrame]] = {}
    for address, transform in basis.frames.items():
        if address != FrameRef(GROUND):
            frame = SceneFrame(address.frame or CENTRE, transform.place, transform.quaternion)
            frames.setdefault(address.body, []).append(frame)
    masses = {body.name: basis.numbers.number(body.mass) for body in basis.model.bodies}
    return tuple(
        SceneBody(name, tuple(frames.get(name, ())), tuple(solids.get(name, ())), masses.get(name, 0.0))
        for name in (GROUND, *masses)
    )


def _type_of(joint: Joint) -> str:
    """Return the type of a joint in a model file."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in type(joint).__name__).lstrip("_")


# Shapes of elements other than joints.
_SHAPES: Final[Mapping[type, Callable[..., list[FixedShape]]]] = MappingProxyType(
    {
        Bushing: bushing_shapes,
        Distance: distance_shapes,
        KnifeEdge: knife_shapes,
        PointOnCurve: curve_shapes,
        PointOnLine: line_shapes,
        PointOnPlane: plane_shapes,
        PointOnSurface: surface_shapes,
        TorsionSpring: torsion_shapes,
    }
)
