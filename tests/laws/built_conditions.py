"""From the constraints of a random mechanism to elements of its `Model`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import symbody as sb
from tests.laws.parts import ContactPart, CouplingPart, MotionPart, law_text

Value = float | str
Numbers = Callable[[str, float], Value]


def contact_element(number: Numbers, contact: ContactPart) -> Any:
    """A constraint between frames."""
    name, ends = contact.name, (contact.start, contact.end)
    axes = (contact.axis, contact.second)
    match contact.kind:
        case "distance":
            return sb.Distance(name, *ends, value=_moving(number, f"length_{name}", contact.value))
        case "line":
            return sb.PointOnLine(name, *ends, axis=contact.axis)
        case "plane":
            return sb.PointOnPlane(name, *ends, axis=contact.axis)
        case "surface":
            return sb.PointOnSurface(name, *ends, [law_text(law) for law in contact.surface])
        case "parallel":
            return sb.Parallel(name, *ends, axes=axes)
        case "perpendicular":
            return sb.Perpendicular(name, *ends, axes=axes)
        case "angle":
            return sb.Angle(name, *ends, axes=axes, value=_moving(number, f"angle_{name}", contact.value))
        case "knife":
            return sb.KnifeEdge(name, *ends, axis=contact.second)
    axle = contact.second if contact.kind == "disc" else None
    radius = number(f"radius_{name}", contact.value.mean)
    return sb.Rolling(name, *ends, radius=radius, normal=contact.axis, axis=axle)


def coupling_element(number: Numbers, coupling: CouplingPart) -> Any:
    """A constraint on coordinates."""
    name = coupling.name
    if coupling.kind in ("equation", "rates"):
        factors = [f"*{along}_dot" for along in coupling.along] or [""] * len(coupling.terms)
        texts = [f"{term.text}{factor}" for term, factor in zip(coupling.terms, factors, strict=True)]
        return sb.Constraint(name, f"{' + '.join(texts)} - ({coupling.offset.text})")
    coupled = [term.name for term in coupling.terms]
    first, second = (term.factor for term in coupling.terms[:2])
    offset = _moving(number, f"offset_{name}", coupling.offset)
    match coupling.kind:
        case "gear":
            return sb.Gear(name, coupled, ratio=number(f"ratio_{name}", -second), offset=offset)
        case "rack":
            return sb.RackPinion(name, coupled, radius=number(f"radius_{name}", -second), offset=offset)
        case "belt":
            radii = [number(f"radius{k}_{name}", abs(x)) for k, x in enumerate((first, second))]
            return sb.Belt(name, coupled, radii=radii, crossed=second > 0, offset=offset)
    # Twice the carrier less both shafts.
    return sb.Differential(name, coupled, offset=offset)


def _moving(number: Numbers, name: str, value: MotionPart) -> Value:
    return value.text if value.amplitude else number(name, value.mean)
