"""Wrenches of joints: those that the bodies need, summed inward joint by joint."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symbody.equations.dynamics.balance import NO_WRENCH, Wrench
from symbody.equations.kinematics.naming import Names
from symbody.equations.recursive.link_loads import body_loads, link_wrench
from symbody.equations.recursive.links import GROUND, BodyPlacement, LinkWrench
from symbody.equations.recursive.recursion import Recursion
from symbody.equations.recursive.rnea import link_motions
from symbody.equations.recursive.tree import body_inertia
from symbody.expr.expression import Expr
from symbody.spatial.matrix import zero_vector
from symbody.spatial.twist import Twist
from symbody.spatial.vector import components, vector


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
        Their wrenches where they are cut.
    """
    topology, kinematics, tree = recursion.topology, recursion.kinematics, recursion.tree
    motions = link_motions(tree, recursion.gravity, udot)
    needed: dict[str, LinkWrench] = {}
    for body in topology.model.bodies:
        place = tree.bodies[body.name]
        inertia = body_inertia(names, body).to_parent(place.transform)
        if place.link == GROUND:
            needed[body.name] = inertia @ Twist(-recursion.gravity, zero_vector(names.graph))
        else:
            motion = motions[place.link]
            needed[body.name] = inertia.bias_wrench(motion.U, motion.a)
    loads = body_loads(topology, kinematics, tree, recursion.loads)
    for name, (start, end, frame) in _cut_links(recursion, cut).items():
        for body_name, wrench in ((end, cut[name]), (start, -cut[name])):
            if body_name != "ground":
                place = tree.bodies[body_name]
                share = link_wrench(kinematics, place, body_name, frame, wrench.force, wrench.moment)
                loads.append((body_name, share))
    for body_name, load in loads:
        needed[body_name] = needed[body_name] - load
    return _sum_inward(recursion, needed, cut)


def _sum_inward(
    recursion: Recursion, needed: dict[str, LinkWrench], cut: Mapping[str, Wrench]
) -> dict[str, Wrench]:
    """Return the wrenches of branches, summed inward, with those that their joints transmit besides."""
    topology, tree = recursion.topology, recursion.tree
    total = {joint.name: cut.get(joint.name, NO_WRENCH) for joint in topology.joints}
    for branch in reversed(topology.rotation.branches):
        joint = topology.joint(branch.edge.name)
        outward, inward = tree.bodies[branch.child], tree.bodies[branch.parent]
        wrench = on_parent = needed[branch.child]
        if outward.link != inward.link:
            on_parent = tree.links[outward.link].transform.wrench_to_parent(wrench)
        if branch.parent != "ground":
            needed[branch.parent] = needed[branch.parent] + on_parent
        if branch.forward:
            share = _express_at_frame(recursion, outward, branch.child, joint.end.full_name, wrench)
        else:
            share = _express_at_frame(recursion, inward, branch.parent, joint.end.full_name, -on_parent)
        total[joint.name] = total[joint.name] + share
    return total


def _express_at_frame(
    recursion: Recursion, place: BodyPlacement, body: str, frame: str, wrench: LinkWrench
) -> Wrench:
    """Return a wrench about the origin of a link as one about the origin of a frame of a body on it."""
    tree, axes, X = (
        recursion.kinematics.tree,
        recursion.kinematics.tree.orientation_frame(body),
        place.transform,
    )
    arm = X.to_child(X.position) + components(tree, recursion.kinematics.position(body, frame), axes)
    force = X.to_child(wrench.force)
    moment = X.to_child(wrench.moment) - arm.cross(force)
    return Wrench(vector(axes, force), vector(axes, moment))


def _cut_links(recursion: Recursion, cut: Iterable[str]) -> dict[str, tuple[str, str, str]]:
    """Return start body, end body and end frame of joints and constraints that are cut and connect bodies."""
    links = {name: recursion.topology.link(name) for name in cut}
    return {
        name: (link.start.body, link.end.body, link.end.full_name)
        for name, link in links.items()
        if link is not None
    }
