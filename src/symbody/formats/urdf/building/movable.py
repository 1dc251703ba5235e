"""Joints of the model from joints of the robot: coordinates, axes, inputs, damping, friction."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType
from typing import Final

from symbody.expr.graph import Constant
from symbody.formats.urdf.file.placement import FramePlacement, Numbers, PlacementAngle, exact_angle, numeral
from symbody.formats.urdf.file.robot import UrdfJoint
from symbody.model.element import FrameRef
from symbody.model.joint import Joint
from symbody.model.joints import Free, Planar, Prismatic, Revolute, Weld
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction

_LETTERS: Final = MappingProxyType[Numbers, str]({(1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z"})
# From the z axis to the opposites of the axes.
_OPPOSITES: Final[Mapping[Numbers, tuple[str, PlacementAngle]]] = MappingProxyType(
    {
        (-1, 0, 0): ("y", exact_angle(Fraction(-1, 2))),
        (0, -1, 0): ("x", exact_angle(Fraction(1, 2))),
        (0, 0, -1): ("x", exact_angle(Fraction(1))),
    }
)
_POSITION: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")
_TWIST: Final = ("vx", "vy", "vz", "wx", "wy", "wz")


@dataclass(frozen=True, slots=True)
class Moving:
    """A joint with the names it has in the model.

    Attributes
    ----------
    name : str
        Of the element.
    symbol : str
        Its coordinate, or what the names of its coordinates begin with.
    inputs : tuple of str
        Efforts along its coordinates; none where it follows another or floats.
    fixed : number or None
        The value of a coordinate that never changes.
    """

    joint: UrdfJoint
    name: str
    symbol: str
    inputs: tuple[str, ...]
    start: FrameRef
    end: FrameRef
    fixed: Constant | None = None

    def element(self) -> Joint:
        """Return the joint of the model."""
        return _MAKERS[self.joint.kind](self)


def joint_coordinates(kind: str, symbol: str) -> tuple[str, ...]:
    """Return the coordinates of a joint of the robot."""
    if kind == "floating":
        return tuple(f"{symbol}_{part}" for part in _POSITION)
    if kind == "planar":
        return tuple(f"{symbol}_{k}" for k in (1, 2, 3))
    return () if kind == "fixed" else (symbol,)


def joint_speeds(kind: str, symbol: str) -> tuple[str, ...]:
    """Return the speeds of a joint that are not rates of its coordinates."""
    return tuple(f"{symbol}_{part}" for part in _TWIST) if kind == "floating" else ()


def make_free_joint(name: str, symbol: str, start: FrameRef, end: FrameRef) -> Free:
    """Return a joint without any constraint, with its velocities along axes of its end."""
    return Free(
        name,
        start,
        end,
        coordinates=joint_coordinates("floating", symbol),
        speeds="twist",
        speed_names=joint_speeds("floating", symbol),
    )


def normal_turn(joint: UrdfJoint) -> FramePlacement:
    """Return how the frames of a planar joint are turned so that an axis of theirs is its normal."""
    axis = joint.axis
    if joint.kind != "planar" or axis in _LETTERS:
        return FramePlacement()
    if axis in _OPPOSITES:
        return FramePlacement(turns=(_OPPOSITES[axis],))
    x, y, z = map(float, axis)
    about_z, about_y = (
        PlacementAngle(None, math.atan2(y, x)),
        PlacementAngle(None, math.atan2(math.hypot(x, y), z)),
    )
    return FramePlacement(turns=(("z", about_z), ("y", about_y)))


def _revolute(moving: Moving) -> Joint:
    return Revolute(
        moving.name,
        moving.start,
        moving.end,
        axis=_axis(moving.joint),
        coordinate=moving.symbol,
        torque=_drive(moving),
        motion=_motion(moving),
        friction=_friction(moving.joint),
    )


def _prismatic(moving: Moving) -> Joint:
    return Prismatic(
        moving.name,
        moving.start,
        moving.end,
        axis=_axis(moving.joint),
        coordinate=moving.symbol,
        force=_drive(moving),
        motion=_motion(moving),
        friction=_friction(moving.joint),
    )


def _planar(moving: Moving) -> Joint:
    names = joint_coordinates("planar", moving.symbol)
    drives = {name: Drive(applied=own) for name, own in zip(names, moving.inputs, strict=True)}
    return Planar(
        moving.name,
        moving.start,
        moving.end,
        axis=_LETTERS.get(moving.joint.axis, "z"),
        coordinates=names,
        force={name: drives[name] for name in names[:2]},
        torque={names[2]: drives[names[2]]},
    )


def _floating_joint(moving: Moving) -> Joint:
    return make_free_joint(moving.name, moving.symbol, moving.start, moving.end)


def _weld(moving: Moving) -> Joint:
    return Weld(moving.name, moving.start, moving.end)


_MAKERS: Final[Mapping[str, Callable[[Moving], Joint]]] = MappingProxyType(
    {
        "revolute": _revolute,
        "continuous": _revolute,
        "prismatic": _prismatic,
        "planar": _planar,
        "floating": _floating_joint,
        "fixed": _weld,
    }
)


def _axis(joint: UrdfJoint) -> str | list[str]:
    return _LETTERS.get(joint.axis) or [numeral(x) for x in joint.axis]


def _drive(moving: Moving) -> Drive | None:
    applied = moving.inputs[0] if moving.inputs else 0
    if not applied and not moving.joint.damping:
        return None
    return Drive(applied=applied, damping=numeral(moving.joint.damping))


def _friction(joint: UrdfJoint) -> Friction | None:
    return Friction(force=numeral(joint.friction)) if joint.friction else None


def _motion(moving: Moving) -> str | None:
    return None if moving.fixed is None else numeral(moving.fixed)
