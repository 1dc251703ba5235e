"""Bristles in contacts: the slips and gaps that their states read, and their strengths."""

from __future__ import annotations

from symbody.equations.contacts.contact_geometry import choose, is_less, relative_velocity
from symbody.equations.contacts.pairs import contact_geometry
from symbody.equations.contacts.slip_directions import slip_directions
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.expr.expression import Expr, number
from symbody.model.contacts.contact import BRISTLES_READ, Contact
from symbody.model.loads.friction import Friction
from symbody.model.model import Model


def bristle_values(names: Names, kinematics: Kinematics, model: Model) -> dict[str, Expr]:
    """Return what bristles of contacts read, by name; where nothing can slip along an axis they stay 0.

    Rigid shapes touch while their gap is less than the deflection, which is far above its rounding.
    """
    values: dict[str, Expr] = {}
    zero = number(names.graph, 0)
    for contact in model.elements:
        if not isinstance(contact, Contact) or not contact.bristles:
            continue
        assert contact.friction is not None and contact.friction.deflection is not None
        reach = names.expression(contact.friction.deflection) if contact.is_rigid else zero
        frames = (contact.start.full_name, contact.end.full_name)
        geometry = contact_geometry(names, kinematics, contact)
        for label, touch in zip(contact.bristles, geometry.touches, strict=True):
            gap = touch.gap - reach
            slip = relative_velocity(kinematics, frames, geometry, touch).slip
            moving = {letter: rate for letter, _, rate in slip_directions(kinematics, geometry, slip)}
            read = [choose(is_less(gap, zero), moving.get(letter, zero), zero) for letter in "xy"]
            values |= {f"{label}_{word}": x for word, x in zip(BRISTLES_READ, (*read, gap), strict=True)}
            for letter in {"x", "y"} - moving.keys():
                values |= {f"{label}_{letter}": zero, f"{label}_{letter}_dot": zero}
    return values


def bristle_strengths(names: Names, friction: Friction, where: str) -> tuple[Expr, Expr]:
    """Return the greatest friction along x and y over the force along the normal."""
    first = names.expression(friction.strongest, where)
    return first, first if friction.mu_y is None else names.expression(friction.mu_y, where)


def bristle_force(names: Names, friction: Friction, normal: Expr, label: str, where: str) -> list[Expr]:
    """Return the force on end along x and y."""
    strengths = bristle_strengths(names, friction, where)
    shares = (names.value(f"{label}_share_{letter}") for letter in "xy")
    return [-(strength * normal * share) for strength, share in zip(strengths, shares, strict=True)]
