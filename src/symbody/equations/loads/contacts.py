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
from symbody.model.contacts.normal_force import NormalForce
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
    slips = [relative_velocity(kinematics, frames, geometry, touch) for touch in geometry.touches]
    measures = {f"gap {contact.name}": least_gap(geometry.touches)}
    for letter, values in (("x", [s.x for s in slips]), ("y", [s.y for s in slips])):
        measures[f"slip {contact.name} {letter}"] = at_least_gap(geometry.touches, tuple(values))
    zero = number(names.graph, 0)
    if not isinstance(contact.normal, NormalForce):  # rigid: rows and friction laws are its forces
        return Law((), zero, zero, measures=measures)
    left = cross(kinematics.tree, geometry.normal, geometry.forward)
    has_potential = _has_potential(names, contact.normal, where)
    reach = kinematics.position(*frames)
    loads: list[Load] = []
    lossy: list[Load] = []
    total = [zero, zero, zero]
    energy, power = zero, zero
    for touch, velocity in zip(geometry.touches, slips, strict=True):
        along = normal_force(names, contact.normal, touch.gap, velocity.normal, where)
        x, y = zero, zero
        if contact.friction is not None and not contact.friction.is_none:
            x, y = friction_force(names, contact.friction, along.force, velocity, where)
        across = geometry.forward * x + left * y
        elastic = along.elastic if has_potential else zero
        lost = across + geometry.normal * (along.force - elastic)
        loads += opposite_forces(frames, reach, touch.point, across + geometry.normal * along.force)
        lossy += opposite_forces(frames, reach, touch.point, lost)
        energy = energy + (along.energy if has_potential else zero)
        power = power + x * velocity.x + y * velocity.y + (along.force - elastic) * velocity.normal
        total = [old + new for old, new in zip(total, (x, y, along.force), strict=True)]
    for k, letter in enumerate("xyz"):
        measures[f"contact_force {contact.name} {letter}"] = total[k]
    return Law(tuple(loads), energy, power, tuple(lossy), measures=measures)


def _has_potential(names: Names, law: NormalForce, where: str) -> bool:
    """Return whether the elastic part is a function of the gap alone."""
    return law.stiffness is not None and is_constant(names.expression(law.stiffness, where))
