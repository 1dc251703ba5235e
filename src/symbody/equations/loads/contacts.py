"""Contacts as loads: what their laws make of where shapes touch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from symbody.equations.contacts.bristles import bristle_force
from symbody.equations.contacts.contact_geometry import (
    ContactGeometry,
    RelativeVelocity,
    at_least_gap,
    choose,
    is_less,
    least_gap,
    relative_velocity,
)
from symbody.equations.contacts.contact_laws import friction_force, normal_force
from symbody.equations.contacts.pairs import contact_geometry
from symbody.equations.dynamics.load import Law, Load, is_constant, load_law, opposite_forces
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import Expr, number
from symbody.model.contacts.contact import Contact
from symbody.model.contacts.normal_force import NormalForce
from symbody.spatial.matrix import Triple
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
    if not isinstance(contact.normal, NormalForce):  # rigid: rows and friction laws are its forces
        velocities = [relative_velocity(kinematics, frames, geometry, touch) for touch in geometry.touches]
        still = number(names.graph, 0)
        measures = _measures(contact.name, kinematics, geometry, velocities)
        for letter, place in zip(
            "xyz", zip(*_places(kinematics, frames[0], geometry), strict=True), strict=True
        ):
            measures[f"touch {contact.name} {letter}"] = at_least_gap(geometry.touches, place)
            measures |= {f"touch {contact.name} {k} {letter}": each for k, each in enumerate(place, start=1)}
        return Law((), still, still, measures=measures)
    loads: list[Load] = []
    without_potential: list[Load] = []
    energy = power = number(names.graph, 0)
    reach, total, velocities, pressing = kinematics.position(*frames), ZERO, [], []
    for k, touch in enumerate(geometry.touches):
        velocity = relative_velocity(kinematics, frames, geometry, touch)
        bristle = contact.bristles[k] if contact.bristles else ""
        acting = _touch_force(
            contact, contact.normal, names, kinematics, geometry, touch.gap, velocity, bristle
        )
        force = acting.friction + geometry.normal * acting.normal
        loads += opposite_forces(frames, reach, touch.point, force)
        rest = acting.friction + geometry.normal * (acting.normal - acting.elastic)
        without_potential += opposite_forces(frames, reach, touch.point, rest)
        energy, power, total = energy + acting.energy, power + acting.power, total + force
        velocities.append(velocity)
        pressing.append(acting.normal)
    measures = _measures(contact.name, kinematics, geometry, velocities)
    for letter, axis in zip("xyz", geometry.axes(kinematics), strict=True):
        measures[f"contact_force {contact.name} {letter}"] = dot(kinematics.tree, axis, total)
    places = _places(kinematics, frames[0], geometry)
    for letter, place in zip("xyz", zip(*places, strict=True), strict=True):
        least = at_least_gap(geometry.touches, place)
        measures[f"contact_point {contact.name} {letter}"] = centre_of_pressure(pressing, place, least)
    return Law(tuple(loads), energy, power, tuple(without_potential), measures=measures)


def centre_of_pressure(pressing: Sequence[Expr], places: Sequence[Expr], otherwise: Expr) -> Expr:
    """Return the mean of some places by the forces along the normal there; another where there are none.

    Parameters
    ----------
    pressing : sequence of Expr
        The forces, not negative [N].
    places : sequence of Expr
        A component of each place [m].
    """
    if len(places) == 1:
        return places[0]
    total = moment = number(otherwise.graph, 0)
    for force, place in zip(pressing, places, strict=True):
        total, moment = total + force, moment + force * place
    presses = is_less(number(otherwise.graph, 0), total)
    return choose(presses, moment / choose(presses, total, number(otherwise.graph, 1)), otherwise)


def _places(kinematics: Kinematics, start: str, geometry: ContactGeometry) -> list[Triple]:
    """Return the points of contact from start's origin, in its axes."""
    return [components(kinematics.tree, touch.point, start) for touch in geometry.touches]


def _touch_force(
    contact: Contact,
    law: NormalForce,
    names: Names,
    kinematics: Kinematics,
    geometry: ContactGeometry,
    gap: Expr,
    velocity: RelativeVelocity,
    bristle: str,
) -> TouchForce:
    where, tree = f"contact {contact.name}", kinematics.tree
    along = normal_force(names, law, gap, velocity.normal, where)
    has_potential = law.stiffness is not None and is_constant(names.expression(law.stiffness, where))
    zero = number(names.graph, 0)
    elastic, energy = (along.elastic, along.energy) if has_potential else (zero, zero)
    friction = ZERO
    if contact.friction is not None and not contact.friction.is_none:
        slip: Sequence[Expr] = components(tree, velocity.slip, geometry.home)
        axes = [geometry.forward, cross(tree, geometry.normal, geometry.forward)]
        has_axes = bool(bristle) or contact.friction.mu_y is not None
        if has_axes:
            slip = [dot(tree, axis, velocity.slip) for axis in axes]
        shares = (
            bristle_force(names, contact.friction, along.force, bristle, where)
            if bristle
            else friction_force(names, contact.friction, along.force, slip, where)
        )
        if has_axes:
            friction = axes[0] * shares[0] + axes[1] * shares[1]
        else:
            friction = vector(geometry.home, (shares[0], shares[1], shares[2]))
    power = (along.force - elastic) * velocity.normal + dot(tree, friction, velocity.slip)
    return TouchForce(along.force, elastic, friction, energy, power)


def _measures(
    name: str,
    kinematics: Kinematics,
    geometry: ContactGeometry,
    velocities: Sequence[RelativeVelocity],
) -> dict[str, Expr]:
    """Return the outputs that need no law: the least gap, and the slip there."""
    measures = {f"gap {name}": least_gap(geometry.touches)}
    for letter, axis in zip("xy", geometry.axes(kinematics), strict=False):
        slips = tuple(dot(kinematics.tree, axis, velocity.slip) for velocity in velocities)
        measures[f"slip {name} {letter}"] = at_least_gap(geometry.touches, slips)
    return measures
