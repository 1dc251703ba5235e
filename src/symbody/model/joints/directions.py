"""Axes that joints take beside the plain one: letters with a cyclic order, perpendicular pairs, the pitch."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from types import MappingProxyType
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.door import ZERO, Door, Value
from symbody.model.joint import Joint
from symbody.model.numbers import as_float, value_of
from symbody.model.turn import LETTERS, Axis, axis_from
from symbody.model.uses import Triple

Axes = Iterable[str | Iterable[Value]]

# Axes typed with 9 digits pass.
_PERPENDICULAR: Final = 1e-8
_BENDS: Final = MappingProxyType({"x": "z", "y": "x", "z": "y"})


def letter_from(joint: Joint, door: Door, value: object, path: str) -> str:
    """Return an axis that must be a letter, because others follow it in cyclic order."""
    if isinstance(value, str) and value in LETTERS:
        return value
    door.refuse(
        "model.axis_letter",
        path,
        f"{value!r} is not an axis of the start frame",
        "the coordinates are along or about the other two axes",
        'write "x", "y" or "z"; for another direction turn the frames that are joined',
    )
    return "z"


def in_plane(normal: str, first: Formula, second: Formula) -> Triple:
    """Return components along the two axes that follow the normal in cyclic order."""
    return {"x": (ZERO, first, second), "y": (second, ZERO, first), "z": (first, second, ZERO)}[normal]


def bend_axis(axis: str) -> str:
    """Return the axis that a shaft along `axis` is bent about at azimuth 0: the second in cyclic order."""
    return _BENDS[axis]


def pitch_from(joint: Joint, door: Door, value: object, path: str) -> Formula:
    """Return the displacement in a full turn [m]."""
    return door.formula(value, path)


def perpendicular_axes(joint: Joint, door: Door, value: object, path: str) -> tuple[Axis, Axis]:
    """Return two axes; those that are numbers are refused unless they are perpendicular."""
    items = door.items(value, path)
    if len(items) != 2:
        door.refuse(
            "model.wrong_number",
            path,
            f"{len(items)} axes instead of two",
            "",
            'write two perpendicular axes, such as ["x", "y"]',
        )
        return ("x", "y")
    first, second = (axis_from(door, item, f"{path}[{k}]") for k, item in enumerate(items))
    values = _numbers(first), _numbers(second)
    if values[0] is not None and values[1] is not None:
        skew = not_perpendicular(values[0], values[1])
        if skew:
            door.refuse("model.skew_axes", path, *skew)
    return first, second


def not_perpendicular(first: Sequence[float], second: Sequence[float]) -> tuple[str, str, str] | None:
    """Return what, why and fix for two axes that are not perpendicular; None if they are, or one is zero."""
    lengths = math.hypot(*first) * math.hypot(*second)
    if lengths == 0:
        return None
    cosine = sum(a * b for a, b in zip(first, second, strict=True)) / lengths
    if not math.isfinite(cosine) or abs(cosine) <= _PERPENDICULAR:
        return None
    angle = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
    return (
        f"the angle between the axes is {angle:.6g} deg",
        "this joint needs perpendicular axes",
        'make it 90 deg, for instance with ["x", "y"]; digits that are typed must be good to nine places',
    )


def _numbers(axis: Axis) -> list[float] | None:
    """Return the components of an axis, or None where one has no value without parameters."""
    components = LETTERS[axis] if isinstance(axis, str) else axis
    values = [value_of(component) for component in components]
    known = [as_float(value) for value in values if value is not None]
    return known if len(known) == 3 else None
