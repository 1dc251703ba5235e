"""Rigid contacts: the rows of their gaps, and friction across the normal, which reads their multipliers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symbody.equations.contacts.bristles import bristle_strengths
from symbody.equations.contacts.contact_geometry import relative_velocity
from symbody.equations.contacts.pairs import contact_geometry
from symbody.equations.contacts.slip_directions import slip_directions
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.loads.friction import FrictionLaw, SlipDirection, slip_share
from symbody.expr.expression import Expr, sqrt
from symbody.expr.opcodes import SIGN
from symbody.model.contacts.contact import Contact
from symbody.spatial.vector import cross


def gap_rows(names: Names, kinematics: Kinematics, contact: Contact) -> Iterator[ConstraintEquation]:
    """Return a row for each point in which the shapes touch; its multiplier pushes them apart."""
    frames = (contact.start.full_name, contact.end.full_name)
    geometry = contact_geometry(names, kinematics, contact)
    restitution = names.expression(contact.restitution, f"contact {contact.name}")
    for touch in geometry.touches:
        rate = relative_velocity(kinematics, frames, geometry, touch).normal
        lever = touch.point - kinematics.position(*frames)
        yield ConstraintEquation(
            name="",
            element=contact.name,
            value=touch.gap,
            jacobian=kinematics.speed_partials(rate),
            drift=kinematics.at_zero_speeds(rate),
            gamma=-kinematics.bias(rate),
            force=geometry.normal,
            moment=cross(kinematics.tree, lever, geometry.normal),
            sense=1,
            restitution=None if restitution.is_zero else restitution,
        )


def contact_friction(names: Names, kinematics: Kinematics, contact: Contact) -> Iterator[FrictionLaw]:
    """Return the friction of a rigid contact: a law for each direction in which a point may slip."""
    friction, where = contact.friction, f"contact {contact.name}"
    if not contact.is_rigid or friction is None or friction.is_none:
        return
    frames = (contact.start.full_name, contact.end.full_name)
    geometry = contact_geometry(names, kinematics, contact)
    strength = names.expression(friction.mu, where)
    limit = strength if friction.mu_static is None else names.expression(friction.mu_static, where)
    smooth = None if friction.v0 is None else names.expression(friction.v0, where)
    for k, touch in enumerate(geometry.touches, start=1):
        velocity = relative_velocity(kinematics, frames, geometry, touch)
        directions = list(slip_directions(kinematics, geometry, velocity.slip))
        rates = [rate for _, _, rate in directions]
        element = f"{contact.name} friction" if len(geometry.touches) == 1 else f"{contact.name} friction {k}"
        reach, multiplier = kinematics.position(*frames), f"lambda_{contact.name}_{k}"
        for letter, direction, rate in directions:
            if contact.bristles:
                strength = limit = bristle_strengths(names, friction, where)["xy".index(letter)]
                slip = names.value(f"{contact.bristles[k - 1]}_share_{letter}")
            else:
                slip = _slip(rate, rates, smooth)
            yield FrictionLaw(
                name=f"{element} {letter}",
                element=element,
                friction=friction,
                joint=None,
                rate=rate,
                slip=rate * 0 if strength.is_zero else slip,
                strength=strength,
                limit=limit,
                radius=None,
                reads_reaction=True,
                switches=not friction.is_smooth,
                touch=SlipDirection(contact.name, frames, reach, touch.point, direction, multiplier),
            )


def _slip(rate: Expr, rates: Sequence[Expr], smooth: Expr | None) -> Expr:
    """Return a component of the slip over its magnitude, or over a smooth function of it."""
    if smooth is not None:
        return rate / sqrt(sum((x * x for x in rates), smooth * smooth))
    return rate.apply(SIGN) if len(rates) == 1 else slip_share(rate, *rates)
