"""What joints transmit: the wrenches of the bodies as they are, carried inward joint by joint."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symbody.equations.dynamics.balance import NOTHING, Wrench
from symbody.equations.kinematics.naming import Names
from symbody.equations.recursive.applied import applied_to_body, on_link
from symbody.equations.recursive.forming import body_mass
from symbody.equations.recursive.links import GROUND, Fixed
from symbody.equations.recursive.newton_euler import Carried, link_motions
from symbody.equations.recursive.recursion import Recursion
from symbody.expr.expression import Expr, number
from symbody.vectors.matrix import Triple, apply_matrix, outer, transpose
from symbody.vectors.vector import components, vector


def joint_wrenches(
    recursion: Recursion,
    names: Names,
    udot: Mapping[int, Expr],
    cut: Mapping[str, Wrench],
) -> dict[str, Wrench]:
    """Return the total wrench of every joint on its end body, at the origin of its end frame.

    Parameters
    ----------
    udot : mapping of node to Expr
        u' by the node of u.
    cut : mapping of joint or constraint to Wrench
        What they transmit where they are cut.
    """
    topology, kinematics, tree = recursion.topology, recursion.kinematics, recursion.tree
    motions = link_motions(tree, recursion.gravity, udot)
    needed: dict[str, Carried] = {}
    for part in topology.model.bodies:
        place = tree.bodies[part.name]
        if place.link == GROUND:
            needed[part.name] = _weight(recursion, names, part.name)
            continue
        mass = body_mass(names, part).moved((place.axes,), place.at)
        motion = motions[place.link]
        needed[part.name] = Carried(*mass.bias_wrench(motion.u, motion.a))
    given = applied_to_body(topology, kinematics, tree, recursion.loads)
    for name, (start, end, frame) in _links(recursion, cut).items():
        wrench = cut[name]
        if end != "ground":
            place = tree.bodies[end]
            given.append((end, on_link(kinematics, place, end, frame, wrench.force, wrench.moment)))
        if start != "ground":
            place = tree.bodies[start]
            given.append((start, on_link(kinematics, place, start, frame, -wrench.force, -wrench.moment)))
    for body, own in given:
        needed[body] = needed[body].plus(own.opposite)
    return _carried(recursion, needed, cut)


def _carried(
    recursion: Recursion, needed: dict[str, Carried], cut: Mapping[str, Wrench]
) -> dict[str, Wrench]:
    """Return what branches carry, with what they transmit besides."""
    topology, tree = recursion.topology, recursion.tree
    found = {joint.name: cut.get(joint.name, NOTHING) for joint in topology.joints}
    for branch in reversed(topology.rotation.branches):
        joint = topology.joint(branch.edge.name)
        wrench, place, inward = needed[branch.child], tree.bodies[branch.child], tree.bodies[branch.parent]
        moved = wrench
        if place.link != inward.link:
            moved = wrench.moved(tree.links[place.link])
        if branch.parent != "ground":
            needed[branch.parent] = needed[branch.parent].plus(moved)
        if branch.forward:
            own = _vectors(recursion, place, branch.child, joint.end.frame, wrench)
        else:
            own = _vectors(recursion, inward, branch.parent, joint.end.frame, moved.opposite)
        before = found[joint.name]
        found[joint.name] = Wrench(before.force + own.force, before.moment + own.moment)
    return found


def _vectors(recursion: Recursion, place: Fixed, body: str, frame: str, wrench: Carried) -> Wrench:
    """Return a wrench about the origin of a link as one about the origin of a frame of a body on it."""
    kinematics = recursion.kinematics
    back, home = transpose(place.axes), kinematics.tree.home(body)
    force = apply_matrix(back, wrench.force)
    at = components(kinematics.tree, kinematics.arm(body, frame), home)
    lever = tuple(x + y for x, y in zip(apply_matrix(back, place.at), at, strict=True))
    turned = outer((lever[0], lever[1], lever[2]), force)
    moment = tuple(x - y for x, y in zip(apply_matrix(back, wrench.moment), turned, strict=True))
    return Wrench(vector(home, force), vector(home, (moment[0], moment[1], moment[2])))


def _weight(recursion: Recursion, names: Names, body: str) -> Carried:
    """Return what holds a body that is fixed to ground."""
    place = recursion.tree.bodies[body]
    mass = body_mass(names, recursion.topology.model.body(body)).moved((place.axes,), place.at)
    zero = number(recursion.graph, 0)
    still: Triple = (zero, zero, zero)
    up = (-recursion.gravity[0], -recursion.gravity[1], -recursion.gravity[2])
    return Carried(*mass.wrench(still, up))


def _links(recursion: Recursion, cut: Iterable[str]) -> dict[str, tuple[str, str, str]]:
    """Return start body, end body and end frame of what is cut and connects two bodies."""
    found = {}
    for name in cut:
        link = recursion.topology.link(name)
        if link is not None:
            found[name] = (link.start.body, link.end.body, link.end.frame)
    return found
