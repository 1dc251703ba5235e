"""Loads: forces, moments, forces between two points, and generalized forces on joint coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import singledispatch

from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import Expr
from symbody.expr.graph import SymbolKind
from symbody.expr.rewrite import dependence
from symbody.spatial.vector import ZERO, Vector, cross


@dataclass(frozen=True, slots=True)
class PointForce:
    """A force on a body.

    Attributes
    ----------
    frame : str
        A frame of the body.
    position : Vector
        From the frame's origin to the point the force acts in.
    """

    frame: str
    force: Vector
    position: Vector = ZERO


@dataclass(frozen=True, slots=True)
class Moment:
    """A torque on a body, by one of its frames."""

    frame: str
    torque: Vector


@dataclass(frozen=True, slots=True)
class PointToPointForce:
    """Opposite forces on two points along the line between them.

    Attributes
    ----------
    start, end : str
        Frames whose origins are the points.
    position : Vector
        From start to end.
    factor : Expr
        The force on end is `factor` times `position`.
    """

    start: str
    end: str
    position: Vector
    factor: Expr


@dataclass(frozen=True, slots=True)
class GeneralizedForce:
    """A force or torque along a scalar rate, that of a driven joint coordinate.

    Attributes
    ----------
    coordinate : str
        Its name; several coordinates may have one rate, those that rest for instance.
    """

    rate: Expr
    effort: Expr
    coordinate: str


Load = PointForce | Moment | PointToPointForce | GeneralizedForce


@dataclass(frozen=True, slots=True)
class Law:
    """The loads and the energy of one element.

    Attributes
    ----------
    loads : tuple of Load
        On the bodies.
    potential : Expr
        Its energy, as far as it has one [J].
    power : Expr
        Of the loads without potential [W].
    without_potential : tuple of Load or None
        The loads without potential; None: all of `loads`.
    efforts, measures : mapping of name to Expr
        The value of "effort NAME", and of other outputs by their whole names.
    notes : tuple of str
        Choices that the user should know of.
    """

    loads: tuple[Load, ...]
    potential: Expr
    power: Expr
    without_potential: tuple[Load, ...] | None = None
    efforts: Mapping[str, Expr] = field(default_factory=dict)
    measures: Mapping[str, Expr] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@singledispatch
def load_law(element: object, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]) -> Law | None:
    """Return what an element does to the bodies, None if nothing; each file of `loads` registers some."""
    return None


def wrenches(kinematics: Kinematics, load: Load) -> list[tuple[str, Vector, Vector]]:
    """Return (frame, force, torque) for each body on which a load acts, the torque about the frame's origin.

    An effort has none: it is inside its joint.
    """
    if isinstance(load, GeneralizedForce):
        return []
    if isinstance(load, Moment):
        return [(load.frame, ZERO, load.torque)]
    if isinstance(load, PointToPointForce):
        force = load.position * load.factor
        return [(load.end, force, ZERO), (load.start, -force, ZERO)]
    return [(load.frame, load.force, cross(kinematics.tree, load.position, load.force))]


def opposite_forces(
    frames: tuple[str, str], reach: Vector, point: Vector, force: Vector
) -> tuple[PointForce, ...]:
    """Return a force on the second body, and the opposite on the first, in one point.

    Parameters
    ----------
    frames : (str, str)
    reach, point : Vector
        From the origin of the first frame to that of the second, and to the point.
    """
    if force.is_zero:
        return ()
    start, end = frames
    return (PointForce(end, force, point - reach), PointForce(start, -force, point))


def couple(start: str, end: str, torque: Vector) -> tuple[Moment, Moment]:
    """Return a torque on the body end, and the opposite one on start."""
    return (Moment(end, torque), Moment(start, -torque))


def is_constant(x: Expr) -> bool:
    """Return whether an expression holds nothing but parameters."""
    return dependence(x.graph, [x.index])[x.index] <= {SymbolKind.PARAMETER}
