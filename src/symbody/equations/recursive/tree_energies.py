"""Kinetic and potential energy by recursion."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.equations.dynamics.inertia import Rotor
from symbody.equations.recursive.links import GROUND, KinematicTree, LinkInertia, LinkTwist
from symbody.expr.expression import Expr
from symbody.spatial.matrix import Vector3
from symbody.spatial.twist import Twist


def kinetic_energy(tree: KinematicTree, rotors: Iterable[Rotor], zero: Expr) -> Expr:
    """Return the kinetic energy of all links and rotors, ``sum of v . I v / 2`` [J]."""
    still = Twist(Vector3((zero, zero, zero)), Vector3((zero, zero, zero)))
    velocities: list[LinkTwist] = []
    total = zero
    for link in tree.links:
        parent = still if link.parent == GROUND else velocities[link.parent]
        v = link.transform.twist_to_child(parent) + link.motion.velocity
        velocities.append(v)
        momentum = link.inertia @ v
        total = total + v.linear.dot(momentum.force) + v.angular.dot(momentum.moment)
    for rotor in rotors:
        total = total + rotor.inertia * rotor.rate**2
    return total / 2


def potential_energy(tree: KinematicTree, on_ground: LinkInertia, gravity: Vector3[Expr]) -> Expr:
    """Return the potential energy of gravity, zero at ground's origin [J].

    Parameters
    ----------
    on_ground : RigidInertia
        Of the bodies fixed to ground.
    """
    moments = [(link.inertia.first, link.inertia.mass) for link in tree.links]
    first = on_ground.first
    for k, link in reversed(list(enumerate(tree.links))):
        h, mass = moments[k]
        h = link.transform.to_parent(h) + link.transform.position * mass
        if link.parent == GROUND:
            first = first + h
        else:
            before, other = moments[link.parent]
            moments[link.parent] = (before + h, other + mass)
    return -first.dot(gravity)
