"""`Scene`: a mechanism as shapes on bodies, and `SceneMotion`: where the bodies are over time.

Everything that draws reads these two and nothing else: the page, the notebook, film, still pictures. Both
are plain data with a JSON form (`docs/scene.md`). Lengths are in metres. A quaternion has its scalar first
and takes components in the axes of the part to components in the axes of what carries it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Point = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

SolidKind = Literal["box", "cylinder", "cone", "sphere", "capsule", "mesh", "line"]
ConnectorKind = Literal["spring", "damper", "rope", "actuator", "line"]
VectorKind = Literal["force", "torque"]


@dataclass(frozen=True, slots=True)
class SceneFrame:
    """A named set of axes fixed on a body.

    Attributes
    ----------
    name : str
        Without the body's: ``"tip"``; the body's own is ``"CoM"``.
    at : Point
        Origin in the body's axes, from the centre of mass [m].
    quaternion : Quaternion
        From the frame's axes to the body's.
    """

    name: str
    at: Point
    quaternion: Quaternion


@dataclass(frozen=True, slots=True)
class Solid:
    """A shape that is fixed on a body.

    Attributes
    ----------
    element : str
        The body, joint or constraint that it shows; what a tooltip names.
    kind : str
        "box", "cylinder" and "cone" along z, "sphere", "capsule" along z, "mesh" or "line".
    size : tuple of float
        box: edges along x, y, z; cylinder, cone, capsule: radius and length (of a capsule without its caps);
        sphere: radius; mesh: factors along x, y, z; line: nothing [m]. All but meshes and lines are centred
        on `at`, a cone half way up its axis.
    at, quaternion
        The shape's axes in the body's.
    mesh : int, optional
        Which of the scene's meshes: of a line its vertices in order.
    color : str
        ``"#rrggbb"``, or "" for the colour of the body.
    opacity : float
        From 0 to 1.
    """

    element: str
    kind: SolidKind
    size: tuple[float, ...]
    at: Point = (0.0, 0.0, 0.0)
    quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
    mesh: int | None = None
    color: str = ""
    opacity: float = 1.0


@dataclass(frozen=True, slots=True)
class SceneBody:
    """A body with its frames and shapes; the first of a scene is the ground."""

    name: str
    frames: tuple[SceneFrame, ...]
    solids: tuple[Solid, ...]
    mass: float = 0.0


@dataclass(frozen=True, slots=True)
class Anchor:
    """A point fixed on a body: its place among the bodies of the scene, and where on it [m]."""

    body: int
    at: Point


@dataclass(frozen=True, slots=True)
class Connector:
    """What is stretched between two points, drawn anew at every instant.

    Attributes
    ----------
    element : str
        What it shows.
    kind : str
        "spring" (a coil), "damper" (a cylinder with a rod), "rope", "actuator" or "line".
    start, end : Anchor
        Where it ends.
    radius : float
        Of the coil or the cylinder [m].
    length : float
        Of a rope: its length, longer than the distance where it hangs; of a spring its free length [m].
    coils : int
        Turns of a spring.
    color : str
        ``"#rrggbb"``, or "" for the usual one of its kind.
    """

    element: str
    kind: ConnectorKind
    start: Anchor
    end: Anchor
    radius: float
    length: float = 0.0
    coils: int = 0
    color: str = ""


@dataclass(frozen=True, slots=True)
class SceneJoint:
    """A joint by its two frames, to be named and picked.

    Attributes
    ----------
    name, type : str
        ``"elbow"``, ``"revolute"``.
    start, end : Anchor
        The origins of its frames.
    """

    name: str
    type: str
    start: Anchor
    end: Anchor


@dataclass(frozen=True, slots=True, eq=False)
class SceneMesh:
    """Vertices (M, 3) [m] and triangles (K, 3), counter-clockwise from outside; lines have none."""

    vertices: Floats
    triangles: NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Scene:
    """A mechanism as shapes.

    Attributes
    ----------
    name : str
        Of the model.
    size : float
        A length that fits the mechanism [m]: sizes of arrows, axes and labels follow from it.
    up : Point
        The direction that is drawn upwards, a unit vector in ground's axes.
    normal : Point, optional
        Of the plane of a planar mechanism: pictures look against it.
    gravity : Point, optional
        Its acceleration [m/s^2], if there is any.
    bodies : tuple of SceneBody
        Ground first.
    connectors, joints, meshes
        What else there is; solids refer to meshes by their place.
    notes : tuple of str
        Assumptions, and elements that could not be drawn as the model describes them.
    """

    name: str
    size: float
    up: Point
    normal: Point | None
    gravity: Point | None
    bodies: tuple[SceneBody, ...]
    connectors: tuple[Connector, ...] = ()
    joints: tuple[SceneJoint, ...] = ()
    meshes: tuple[SceneMesh, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class MotionCurve:
    """An output over time: its name, its unit, "" where unknown, and its values (N,)."""

    name: str
    unit: str
    values: Floats


@dataclass(frozen=True, slots=True, eq=False)
class MotionVector:
    """A force or a torque over time, drawn as an arrow.

    Attributes
    ----------
    name : str
        Such as ``"reaction elbow"``.
    kind : str
        "force" [N] or "torque" [N m].
    anchor : Anchor
        Where it acts, or the body that it acts on.
    values : (N, 3) array
        Components in ground's axes.
    places : (N, 3) array, optional
        Where it acts in ground's axes, if that moves on its body, as points of contact do [m].
    prints : bool
        Whether it leaves footprints there: of a contact with the ground.
    """

    name: str
    kind: VectorKind
    anchor: Anchor
    values: Floats
    places: Floats | None = None
    prints: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class SceneMotion:
    """Where the bodies of a scene are at some times.

    Attributes
    ----------
    times : (N,) array
        Ascending [s]; at least one.
    positions : (N, B, 3) array
        Centres of mass of all bodies but the ground, in the scene's order, in ground's axes [m].
    quaternions : (N, B, 4) array
        From each body's axes to ground's; of one sign along the motion, so that they can be interpolated.
    curves, vectors
        What else is shown over the same times.
    events : tuple of (name, t)
        What happened.
    """

    times: Floats
    positions: Floats
    quaternions: Floats
    curves: tuple[MotionCurve, ...] = ()
    vectors: tuple[MotionVector, ...] = ()
    events: tuple[tuple[str, float], ...] = ()
