"""Contacts as loads: what their laws make of where shapes touch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from symbody.equations.contacts.contact_geometry import (
    ContactGeometry,
    RelativeVelocity,
    at_least_gap,
    least_gap,
    relative_velocity,
)
from symbody.equations.contacts.contact_laws import friction_force, normal_force
from symbody.equations.contacts.pairs import contact_geometry
from symbody.equations.dynamics.load import Law, Load, PointForce, is_constant, load_law
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import Expr, number
from symbody.model.contacts.contact import Contact
from symbody.spatial.vector import ZERO, Vector, components, cross, dot, vector


class TouchForce(NamedTuple):
    """What acts on end in one point of contact.

    Attributes
    ----------
    normal, elastic : Expr
        Along the normal, and the part of it with a potential [N].
    friction : Vector
        Across the normal.
    energy, power : Expr
        The potential, and the power of all that has none.
    """

    normal: Expr
    elastic: Expr
    friction: Vector
    energy: Expr
    power: Expr


@load_law.register(Contact)
def _contact_law(contact: Contact, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]) -> Law:
    """Return the law of a contact: opposite forces in each of its points, the middle of the overlap.

    There the power of the force along the normal is its product with the rate of the gap, which all points on
    the normal have in common.
    """
    frames = (contact.start.full_name, contact.end.full_name)
    geometry = contact_geometry(names, kinematics, contact)
    loads: list[Load] = []
    without_potential: list[Load] = []
    energy = power = number(names.graph, 0)
    total, velocities = ZERO, []
    for touch in geometry.touches:
        velocity = relative_velocity(kinematics, frames, geometry, touch)
        acting = _touch_force(contact, names, kinematics, geometry, touch.gap, velocity)
        force = acting.friction + geometry.normal * acting.normal
        loads += _opposite_forces(kinematics, frames, touch.point, force)
        rest = acting.friction + geometry.normal * (acting.normal - acting.elastic)
        without_potential += _opposite_forces(kinematics, frames, touch.point, rest)
        energy, power, total = energy + acting.energy, power + acting.power, total + force
        velocities.append(velocity)
    measures = _measures(contact.name, kinematics, geometry, total, velocities)
    return Law(tuple(loads), energy, power, tuple(without_potential), measures=measures)


def _touch_force(
    contact: Contact,
    names: Names,
    kinematics: Kinematics,
    geometry: ContactGeometry,
    gap: Expr,
    velocity: RelativeVelocity,
) -> TouchForce:
    where, tree = f"contact {contact.name}", kinematics.tree
    along = normal_force(names, contact.normal, gap, velocity.normal, where)
    has_potential = contact.normal.stiffness is not None and is_constant(
        names.expression(contact.normal.stiffness, where)
    )
    zero = number(names.graph, 0)
    elastic, energy = (along.elastic, along.energy) if has_potential else (zero, zero)
    friction = ZERO
    if contact.friction is not None and not contact.friction.is_none:
        slip: Sequence[Expr] = components(tree, velocity.slip, geometry.home)
        axes = [geometry.forward, cross(tree, geometry.normal, geometry.forward)]
        if contact.friction.mu_y is not None:
            slip = [dot(tree, axis, velocity.slip) for axis in axes]
        shares = friction_force(names, contact.friction, along.force, slip, where)
        if contact.friction.mu_y is not None:
            friction = axes[0] * shares[0] + axes[1] * shares[1]
        else:
            friction = vector(geometry.home, (shares[0], shares[1], shares[2]))
    power = (along.force - elastic) * velocity.normal + dot(tree, friction, velocity.slip)
    return TouchForce(along.force, elastic, friction, energy, power)


def _measures(
    name: str,
    kinematics: Kinematics,
    geometry: ContactGeometry,
    force: Vector,
    velocities: Sequence[RelativeVelocity],
) -> dict[str, Expr]:
    """Return the outputs: the least gap, the slip there, and the force on end in the axes of the contact."""
    tree = kinematics.tree
    left = cross(tree, geometry.normal, geometry.forward)
    measures = {f"gap {name}": least_gap(geometry.touches)}
    for letter, axis in (("x", geometry.forward), ("y", left), ("z", geometry.normal)):
        measures[f"contact_force {name} {letter}"] = dot(tree, axis, force)
        if letter != "z":
            slips = tuple(dot(tree, axis, velocity.slip) for velocity in velocities)
            measures[f"slip {name} {letter}"] = at_least_gap(geometry.touches, slips)
    return measures


def _opposite_forces(
    kinematics: Kinematics, frames: tuple[str, str], point: Vector, force: Vector
) -> tuple[Load, ...]:
    """Return a force on end, and the opposite on start, in a point given from start's origin."""
    if force.is_zero:
        return ()
    start, end = frames
    return (
        PointForce(end, force, point - kinematics.position(start, end)),
        PointForce(start, -force, point),
    )
