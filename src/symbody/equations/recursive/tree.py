"""The kinematic tree of a mechanism: axes chosen, motions of joints formed, masses added to their links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symbody.equations.kinematics.frame_steps import RotationStep, TranslationStep
from symbody.equations.kinematics.mechanism_names import joint_speeds
from symbody.equations.kinematics.motion import Kinematics, form_kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole, quasi_vector
from symbody.equations.recursive.link_axes import LinkAxes, choose_axes
from symbody.equations.recursive.links import (
    GROUND,
    BodyPlacement,
    JointMotion,
    KinematicTree,
    LinkInertia,
    LinkTransform,
    LinkTwist,
    MotionSubspaceColumn,
    TreeLink,
)
from symbody.equations.recursive.tree_joints import TreeJoint, joints_and_groups
from symbody.expr.graph import Graph
from symbody.graph.topology import Topology
from symbody.model.body import Body
from symbody.spatial.euler_parameters import EulerParameters
from symbody.spatial.inertia import RigidInertia, central_inertia, massless
from symbody.spatial.matrix import SymmetricTensor, Triple, Vector3, identity, zero_vector
from symbody.spatial.rotation import AxisRotation
from symbody.spatial.transform import Transform
from symbody.spatial.twist import Twist
from symbody.spatial.vector import Vector, components, vector

# The two frames of a joint's own kinematics, in which the near frame takes the place of ground.
_NEAR, _FAR = "ground", "far"


def form_tree(
    topology: Topology,
    names: Names,
    rates: Mapping[int, int],
    roles: Sequence[JointRole],
    *,
    align: bool = True,
) -> KinematicTree:
    """Return the links of a mechanism whose rotation tree is its translation tree.

    Parameters
    ----------
    rates : mapping of node to node
        q' in terms of u.
    align : bool
        Whether axes are put along joints and common normals; else they are those of the joints' frames.
    """
    graph = names.graph
    joints, groups = joints_and_groups(topology, names, {role.joint.name: role for role in roles}, align)
    following: dict[str, list[TreeJoint]] = {}
    for joint in joints:
        following.setdefault(joint.parent, []).append(joint)
    numbers = {"ground": GROUND}
    axes: dict[str, LinkTransform] = {"ground": Transform((identity(graph),), zero_vector(graph))}
    links = []
    for joint in joints:
        group, parent = joint.branch.child, axes[joint.parent]
        chosen = choose_axes(joint, parent, following.get(group, ()))
        links.append(_link(names, rates, joint, chosen, numbers[joint.parent], parent))
        numbers[group], axes[group] = len(links) - 1, chosen.transform
    bodies = {
        body: BodyPlacement(numbers[group], axes[group].inverse.then(transform))
        for body, (group, transform) in groups.items()
    }
    tree = KinematicTree(tuple(links), bodies)
    return _with_inertias(names, topology.model.bodies, tree)


def body_inertia(names: Names, body: Body) -> LinkInertia:
    """Return the mass distribution of a body about its center of mass, in its axes."""
    where = f"body {body.name}"
    moments, products = names.triple(body.inertia, where), names.triple(body.products, where)
    return central_inertia(SymmetricTensor(*moments, *products), names.expression(body.mass, where))


def ground_inertia(names: Names, bodies: Sequence[Body], tree: KinematicTree) -> LinkInertia:
    """Return the mass distribution of the bodies that are fixed to ground."""
    total = massless(names.graph)
    for body in bodies:
        place = tree.bodies[body.name]
        if place.link == GROUND:
            total = total + body_inertia(names, body).to_parent(place.transform)
    return total


def base_tree(graph: Graph, tree: KinematicTree) -> tuple[KinematicTree, LinkInertia]:
    """Return the tree with base parameters only, the rest added to parents, and the inertia of ground."""
    total = [link.inertia for link in tree.links]
    ground = massless(graph)
    for k, link in reversed(list(enumerate(tree.links))):
        total[k], share = base_parameters(total[k], link.motion.rotation, link.motion.has_displacements)
        share = share.to_parent(link.transform)
        if link.parent == GROUND:
            ground = ground + share
        else:
            total[link.parent] = total[link.parent] + share
    links = tuple(replace(link, inertia=inertia) for link, inertia in zip(tree.links, total, strict=True))
    return replace(tree, links=links), ground


def base_parameters(
    inertia: LinkInertia, rotation: str, has_displacements: bool
) -> tuple[LinkInertia, LinkInertia]:
    """Return the inertia that stays with a link, and that which its parent can carry as well.

    A mass on the axis of a hinge z moves alike with both bodies; so does one in the center of a spherical
    joint. A link that only slides turns with its parent. [Gautier & Khalil 1990]

    Parameters
    ----------
    rotation : str
        "none", "z" or "any": the axes the link turns about relative to its parent.
    has_displacements : bool
        Whether its origin moves relative to the parent.
    """
    k, h, m = inertia
    zero = m * 0
    none, still = SymmetricTensor(*[zero] * 6), Vector3((zero, zero, zero))
    if rotation == "none":
        second, kept = k, none
    elif rotation == "z":
        second, kept = none._replace(zz=k.zz), k._replace(zz=zero)
    else:
        second, kept = none, k
    if has_displacements:
        return RigidInertia(kept, h, m), RigidInertia(second, still, zero)
    if rotation == "none":
        return RigidInertia(none, still, zero), inertia
    along = Vector3((zero, zero, h[2])) if rotation == "z" else still
    across = Vector3((h[0], h[1], zero)) if rotation == "z" else h
    return RigidInertia(kept, across, zero), RigidInertia(second, along, m)


def _with_inertias(names: Names, bodies: Sequence[Body], tree: KinematicTree) -> KinematicTree:
    """Return the tree with the inertia of each body added to the link it stands on."""
    total = [link.inertia for link in tree.links]
    for body in bodies:
        place = tree.bodies[body.name]
        if place.link != GROUND:
            total[place.link] = total[place.link] + body_inertia(names, body).to_parent(place.transform)
    links = tuple(replace(link, inertia=inertia) for link, inertia in zip(tree.links, total, strict=True))
    return replace(tree, links=links)


def _link(
    names: Names,
    rates: Mapping[int, int],
    joint: TreeJoint,
    chosen: LinkAxes,
    parent_number: int,
    parent: LinkTransform,
) -> TreeLink:
    """Return the link behind a joint, still without mass."""
    near = parent.inverse.then(joint.near)
    law = Transform((near.matrix @ chosen.law,), near.position)
    kinematics = _joint_kinematics(names, rates, joint, chosen)
    x, y, z = components(kinematics.tree, kinematics.position(_NEAR, _FAR), _NEAR)
    return TreeLink(
        joint=joint.role.joint.name,
        parent=parent_number,
        transform=Transform(chosen.steps, law.point_to_parent(Vector3((x, y, z + chosen.shift)))),
        motion=_joint_motion(kinematics, joint),
        inertia=massless(names.graph),
    )


def _joint_kinematics(
    names: Names, rates: Mapping[int, int], tree_joint: TreeJoint, chosen: LinkAxes
) -> Kinematics:
    """Return the kinematics of one joint alone, from near to far frame, in the axes of its law."""
    joint, forward = tree_joint.role.joint, tree_joint.branch.forward
    frames = {"start": _NEAR, "end": _FAR} if forward else {"start": _FAR, "end": _NEAR}
    sign, back = 1 if forward else -1, chosen.law.T

    def in_law_axes(frame: str, parts: Triple) -> Vector:
        return vector(frames[frame], back @ parts) * sign

    steps: tuple[AxisRotation | EulerParameters, ...] = tree_joint.steps
    if tree_joint.rotation == "z":
        z = identity(names.graph)[2]
        steps = tuple(AxisRotation(z, step.angle) for step in steps if isinstance(step, AxisRotation))
    rotation_speeds, translation_speeds = joint.rotation_speeds, joint.translation_speeds
    w, v = None, None
    if rotation_speeds is not None:
        w = in_law_axes(rotation_speeds.resolved_in, quasi_vector(names, rotation_speeds))
    shift = in_law_axes(joint.shift_in, names.triple(joint.shift(), f"joint {joint.name}"))
    if translation_speeds is not None:
        seen = in_law_axes(translation_speeds.resolved_in, quasi_vector(names, translation_speeds))
        v = (frames["start"], seen)
    return form_kinematics(
        names.graph,
        [RotationStep(_FAR, _NEAR, steps, w)],
        [TranslationStep(_FAR, _NEAR, _FAR, shift, v)],
        rates,
        joint_speeds(names, rates, tree_joint.role),
    )


def _joint_motion(kinematics: Kinematics, joint: TreeJoint) -> JointMotion:
    """Return the free motions of a joint, S: the partial velocities of the far frame in its own axes."""
    tree, w, v = kinematics.tree, kinematics.angular_velocities[_FAR], kinematics.velocities[_FAR]
    axes = tree.orientation_frame(_FAR)

    def twist(linear: Vector, angular: Vector) -> LinkTwist:
        return Twist(components(tree, linear, axes), components(tree, angular, axes))

    return JointMotion(
        columns=tuple(MotionSubspaceColumn(u, twist(v.partial(u), w.partial(u))) for u in kinematics.speeds),
        velocity=twist(v.value, w.value),
        bias=twist(v.bias, w.bias),
        rotation=joint.rotation,
        has_displacements=joint.has_displacements,
    )
