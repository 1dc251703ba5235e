"""Contacts as loads: what their laws make of where shapes touch."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.contacts.contact_geometry import (
    at_least_gap,
    least_gap,
    relative_velocity,
)
from symbody.equations.contacts.contact_laws import friction_force, normal_force
from symbody.equations.contacts.pairs import contact_geometry
from symbody.equations.dynamics.load import Law, Load, is_constant, load_law, opposite_forces
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import number
from symbody.model.contacts.contact import Contact
from symbody.spatial.vector import cross


@load_law.register(Contact)
def _contact_law(contact: Contact, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]) -> Law:
    """Return the law of a contact: opposite forces in each of its points, the middle of the overlap.

    There the power of the force along the normal is its product with the rate of the gap, which all points on
    the normal have in common.
    """
    where = f"contact {contact.name}"
    frames = (contact.start.full_name, contact.end.full_name)
    geometry = contact_geometry(names, kinematics, contact)
    left = cross(kinematics.tree, geometry.normal, geometry.forward)
    has_potential = _has_potential(names, contact, where)
    zero = number(names.graph, 0)
    loads: list[Load] = []
    lossy: list[Load] = []
    slips, total = [], [zero, zero, zero]
    energy, power = zero, zero
    for touch in geometry.touches:
        velocity = relative_velocity(kinematics, frames, geometry, touch)
        along = normal_force(names, contact.normal, touch.gap, velocity.normal, where)
        x, y = zero, zero
        if contact.friction is not None and not contact.friction.is_none:
            x, y = friction_force(names, contact.friction, along.force, velocity, where)
        across = geometry.forward * x + left * y
        elastic = along.elastic if has_potential else zero
        reach = kinematics.position(*frames)
        lost = across + geometry.normal * (along.force - elastic)
        loads += opposite_forces(frames, reach, touch.point, across + geometry.normal * along.force)
        lossy += opposite_forces(frames, reach, touch.point, lost)
        energy = energy + (along.energy if has_potential else zero)
        power = power + x * velocity.x + y * velocity.y + (along.force - elastic) * velocity.normal
        total = [old + new for old, new in zip(total, (x, y, along.force), strict=True)]
        slips.append(velocity)
    measures = {f"gap {contact.name}": least_gap(geometry.touches)}
    for k, letter in enumerate("xyz"):
        measures[f"contact_force {contact.name} {letter}"] = total[k]
    for letter, values in (("x", [s.x for s in slips]), ("y", [s.y for s in slips])):
        measures[f"slip {contact.name} {letter}"] = at_least_gap(geometry.touches, tuple(values))
    return Law(tuple(loads), energy, power, tuple(lossy), measures=measures)


def _has_potential(names: Names, contact: Contact, where: str) -> bool:
    """Return whether the elastic part is a function of the gap alone."""
    law = contact.normal
    return law.stiffness is not None and is_constant(names.expression(law.stiffness, where))
