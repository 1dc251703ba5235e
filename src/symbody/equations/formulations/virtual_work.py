"""Virtual work: the wrenches that bodies need, times the free motions of the joints that carry them.

``sum over bodies of  dv_j . (m a - F) + dw_j . (I alpha + w x I w - T) = 0``  for every speed u_j, with
partial velocities dv_j, dw_j (Kane & Levinson 1985, section 6.1; Roberson & Schwertassek 1988, chapter 8).
The sum is taken joint by joint: a joint with the free motion dv, dw that carries the force and the moment of
everything outward of it contributes ``dv . force + dw . moment``, so no body is met twice.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from symbody.equations.dynamics.balance import NOTHING, Wrench, balanced
from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.load import Effort, Load
from symbody.equations.dynamics.needs import inertial, without_loads
from symbody.equations.dynamics.projection import Projection, add_rotor
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.variables import Use
from symbody.expr.expression import Expr, number
from symbody.graph.topology import Topology
from symbody.vectors.dyadic import apply, quadratic
from symbody.vectors.vector import NULL, Vector, cross, dot


@dataclass(frozen=True, slots=True)
class VirtualWork:
    """Formulation by virtual work; any trees, any coordinates."""


VIRTUAL_WORK: Final = VirtualWork()


def project(
    topology: Topology,
    kinematics: Kinematics,
    uses: Sequence[Use],
    bodies: Sequence[Inertia],
    loads: Sequence[Load],
    armatures: Mapping[str, Rotor],
) -> Projection:
    """Return the equations of motion in the speeds.

    Parameters
    ----------
    armatures : mapping of coordinate to Rotor
        What turns with the rates of joints.
    """
    speeds, zero = kinematics.speeds, number(kinematics.graph, 0)
    place = {u: j for j, u in enumerate(speeds)}
    mass = [[zero] * len(speeds) for _ in speeds]
    forcing = [zero] * len(speeds)
    free = _free_motions(topology, kinematics, uses)
    for u, j in place.items():
        needed = {
            body.frame: _unit_wrench(kinematics, body, u) for body in bodies if _moves(kinematics, body, u)
        }
        for other, force in _generalized(topology, kinematics, free, needed).items():
            if place[other] >= j:
                mass[j][place[other]] = mass[place[other]][j] = force
    biases = {body.frame: _bias_wrench(kinematics, body) for body in bodies}
    needed = without_loads(topology, kinematics, biases, loads)
    for u, force in _generalized(topology, kinematics, free, needed).items():
        forcing[place[u]] = forcing[place[u]] - force
    for load in loads:
        if isinstance(load, Effort):
            for u, slope in kinematics.slopes(load.rate).items():
                forcing[place[u]] = forcing[place[u]] + slope * load.effort
    for rotor in armatures.values():
        add_rotor(kinematics, rotor, mass, forcing)
    return Projection(tuple(map(tuple, mass)), tuple(forcing))


def kinetic_energy(kinematics: Kinematics, bodies: Sequence[Inertia], armatures: Mapping[str, Rotor]) -> Expr:
    """Return the kinetic energy of the bodies relative to ground, and of rotors along their rates [J]."""
    tree = kinematics.tree
    total = number(tree.graph, 0)
    for body in bodies:
        v = kinematics.velocities[body.frame].value
        w = kinematics.angular_velocities[body.frame].value
        total = total + body.mass * dot(tree, v, v) + quadratic(tree, w, body.tensor, w)
    for rotor in armatures.values():
        total = total + rotor.inertia * rotor.rate**2
    return total / 2


def _free_motions(
    topology: Topology, kinematics: Kinematics, uses: Sequence[Use]
) -> list[tuple[str, int, Vector, Vector]]:
    """Return (joint, speed, dv, dw): how the end of a joint moves relative to its start, seen from there."""
    tree = kinematics.tree
    motions = []
    for use in uses:
        start, end = use.joint.start.frame, use.joint.end.frame
        v, v_start = kinematics.velocities[end], kinematics.velocities[start]
        w, w_start = kinematics.angular_velocities[end], kinematics.angular_velocities[start]
        arm = kinematics.arm(start, end)
        for symbol in use.speeds:
            u = kinematics.graph.symbol(symbol)
            turn = w.partial(u) - w_start.partial(u) if use.in_rotation else NULL
            slide = NULL
            if use.in_translation:
                slide = v.partial(u) - v_start.partial(u) - cross(tree, w_start.partial(u), arm)
            motions.append((use.joint.name, u, slide, turn))
    return motions


def _generalized(
    topology: Topology,
    kinematics: Kinematics,
    free: Iterable[tuple[str, int, Vector, Vector]],
    needed: Mapping[str, Wrench],
) -> dict[int, Expr]:
    """Return the generalized force of each speed that gives the bodies what they need."""
    tree = kinematics.tree
    carried = balanced(topology, kinematics, needed, {})
    found = {}
    for joint, u, slide, turn in free:
        wrench = carried.get(joint, NOTHING)
        force = dot(tree, slide, wrench.force) + dot(tree, turn, wrench.moment)
        if not force.is_zero:
            found[u] = force
    return found


def _moves(kinematics: Kinematics, body: Inertia, u: int) -> bool:
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    return u in v.partials or u in w.partials


def _unit_wrench(kinematics: Kinematics, body: Inertia, u: int) -> Wrench:
    """Return what a body needs for a unit acceleration u' from rest."""
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    return Wrench(v.partial(u) * body.mass, apply(kinematics.tree, body.tensor, w.partial(u)))


def _bias_wrench(kinematics: Kinematics, body: Inertia) -> Wrench:
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    return inertial(kinematics, body, v.bias, w.bias)
