"""What constraints beside the joints demand, in NumPy: rows on the relative motion of two frames, and wrenches."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tests.laws.parts import ContactPart, CouplingPart
from tests.laws.rotations import Array, unit


def contact_rows(contact: ContactPart, r: Array, axes: Array) -> Array:
    """(k, 6) rows on angular velocity and rate of the shift of end relative to start, in start axes.

    Parameters
    ----------
    r, axes
        Position of end's origin and axes of end, in start axes.
    """
    first, second = unit(contact.axis), axes @ unit(contact.second)
    match contact.kind:
        case "distance":
            return _pushes(r / np.linalg.norm(r))
        case "line":
            return _pushes(*across(first))
        case "plane":
            return _pushes(first)
        case "surface":
            return _pushes(*(_gradient(contact, k, r) for k in range(len(contact.surface))))
        case "parallel":
            return _turns(*(np.cross(second, normal) for normal in across(first)))
        case "perpendicular" | "angle":
            return _turns(np.cross(second, first))
        case "knife":
            return _pushes(second)
    arm = contact_arm(contact, axes)
    return np.array([[*np.cross(arm, e), *e] for e in np.eye(3)])


def row_values(contact: ContactPart, t: float) -> Array:
    """What the rows have to be: moving lengths and angles."""
    rate = contact.value.rate(t) if contact.kind in ("distance", "angle") else 0.0
    # The angle is kept by its cosine, whose rate along the rows is that of a . b.
    rate = -np.sin(contact.value.at(t)) * rate if contact.kind == "angle" else rate
    return np.full(row_count(contact), rate)


def row_count(contact: ContactPart) -> int:
    """How many rows a contact has."""
    if contact.kind in ("line", "parallel"):
        return 2
    if contact.kind == "surface":
        return len(contact.surface)
    return 3 if contact.rolls else 1


def contact_arm(contact: ContactPart, axes: Array) -> Array:
    """From the centre of a rolling sphere or disc to the point of contact, in start axes."""
    normal = unit(contact.axis)
    if contact.kind == "disc":
        axle = axes @ unit(contact.second)
        normal = normal - (normal @ axle) * axle
        normal = normal / np.linalg.norm(normal)
    found: Array = -contact.value.mean * normal
    return found


def heading(contact: ContactPart, axes: Array) -> Array:
    """Forward, left and up in the point of contact of a disc, as columns in start axes."""
    normal = unit(contact.axis)
    forward = np.cross(axes @ unit(contact.second), normal)
    forward = forward / np.linalg.norm(forward)
    return np.column_stack([forward, np.cross(normal, forward), normal])


def slopes(coupling: CouplingPart, known: Mapping[str, float]) -> dict[str, float]:
    """The factor of each coordinate's rate in the row; times the multiplier it is the effort along it."""
    if coupling.along:
        listed = zip(coupling.along, (term.value(known) for term in coupling.terms), strict=True)
    else:
        listed = zip(
            (term.name for term in coupling.terms), (t.slope(known) for t in coupling.terms), strict=True
        )
    found: dict[str, float] = {}
    for name, slope in listed:
        found[name] = found.get(name, 0.0) + slope
    return found


def across(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to an axis and to each other."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first = first / np.linalg.norm(first)
    return first, np.cross(axis, first)


def _gradient(contact: ContactPart, k: int, r: Array) -> Array:
    found = np.zeros(3)
    for term in contact.surface[k]:
        if term.name:
            found["xyz".index(term.name)] += term.slope(dict(zip("xyz", r, strict=True)))
    return found


def _pushes(*directions: Array) -> Array:
    return np.array([[0.0, 0.0, 0.0, *direction] for direction in directions])


def _turns(*directions: Array) -> Array:
    return np.array([[*direction, 0.0, 0.0, 0.0] for direction in directions])
