"""What acts on bodies placed by hand: weights, forces and torques."""

from __future__ import annotations

from collections.abc import Mapping

from symbody.equations.by_hand.frames import Chain, convert_vector, position_of
from symbody.equations.by_hand.mechanism import MechanismByHand, PlacedBody, PlacedForce, PlacedLoad
from symbody.equations.dynamics.load import Load, Moment, PointForce
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.loads.loads import Loads
from symbody.expr.expression import Expr, number
from symbody.spatial.vector import cross, dot


def loads_by_hand(mechanism: MechanismByHand, kinematics: Kinematics, names: Mapping[Chain, str]) -> Loads:
    """Return the loads of a mechanism; weights have the only potential energy."""
    tree, graph = kinematics.tree, kinematics.graph
    weights: list[Load] = []
    potential = power = number(graph, 0)
    if mechanism.gravity is not None:
        gravity = convert_vector(names, mechanism.gravity)
        for body in mechanism.bodies:
            weight = gravity * body.mass
            weights.append(PointForce(body.name, weight))
            potential = potential - dot(tree, kinematics.position("ground", body.name), weight)
    others: list[Load] = []
    for load in mechanism.loads:
        for on, sign in ((load.on, 1), (load.reaction_on, -1)):
            if on is not None:
                found, spent = _load_on_body(kinematics, names, load, on, sign)
                others.append(found)
                power = power + spent
    return Loads((*weights, *others), potential, power, {}, tuple(others))


def _load_on_body(
    kinematics: Kinematics, names: Mapping[Chain, str], load: PlacedLoad, body: PlacedBody, sign: int
) -> tuple[Load, Expr]:
    """Return what a load does to one body, and its power there."""
    tree = kinematics.tree
    acting = convert_vector(names, load.vector) * sign
    w = kinematics.angular_velocities[body.name].value
    if not isinstance(load, PlacedForce):
        return Moment(body.name, acting), dot(tree, acting, w)
    arm = position_of(kinematics, names, body, load.point)
    v = kinematics.velocities[body.name].value + cross(tree, w, arm)
    return PointForce(body.name, acting, arm), dot(tree, acting, v)
