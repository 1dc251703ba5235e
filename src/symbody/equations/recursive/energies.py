"""Kinetic and potential energy by recursion."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.equations.dynamics.inertia import Rotor
from symbody.equations.recursive.links import GROUND, Tree
from symbody.equations.recursive.pseudo_inertia import PseudoInertia, added, scaled
from symbody.equations.recursive.turned import to_child, to_parent
from symbody.expr.expression import Expr
from symbody.vectors.matrix import Triple, inner, outer


def kinetic_energy(tree: Tree, rotors: Iterable[Rotor], zero: Expr) -> Expr:
    """Return the kinetic energy of all links and rotors [J]."""
    still = (zero, zero, zero)
    velocities: list[tuple[Triple, Triple]] = []
    total = zero
    for link in tree.links:
        w, v = (still, still) if link.parent == GROUND else velocities[link.parent]
        v = added(to_child(link.steps, added(v, outer(w, link.arm))), link.motion.v)
        w = added(to_child(link.steps, w), link.motion.w)
        velocities.append((w, v))
        momentum, spin = link.inertia.wrench(w, v)
        total = total + inner(v, momentum) + inner(w, spin)
    for rotor in rotors:
        total = total + rotor.inertia * rotor.rate**2
    return total / 2


def potential_energy(tree: Tree, on_ground: PseudoInertia, gravity: Triple) -> Expr:
    """Return the potential energy of gravity, zero at ground's origin [J].

    Parameters
    ----------
    on_ground : PseudoInertia
        What ground carries.
    """
    moments = [(link.inertia.first, link.inertia.mass) for link in tree.links]
    first = on_ground.first
    for k in reversed(range(len(tree.links))):
        link = tree.links[k]
        h, mass = moments[k]
        h = added(to_parent(link.steps, h), scaled(link.arm, mass))
        if link.parent == GROUND:
            first = added(first, h)
        else:
            before, other = moments[link.parent]
            moments[link.parent] = (added(before, h), other + mass)
    return -inner(gravity, first)
