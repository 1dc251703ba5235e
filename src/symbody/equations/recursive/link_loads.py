"""Loads as wrenches on links."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.equations.dynamics.inertial_wrenches import frame_owners
from symbody.equations.dynamics.load import Load, wrenches
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.recursive.links import GROUND, BodyPlacement, KinematicTree, LinkWrench
from symbody.graph.topology import Topology
from symbody.spatial.transform import Transform
from symbody.spatial.twist import Wrench
from symbody.spatial.vector import Vector, components


def link_loads(
    topology: Topology, kinematics: Kinematics, tree: KinematicTree, loads: Iterable[Load]
) -> dict[int, LinkWrench]:
    """Return the sum of the loads on each link that has some, about its origin in its axes."""
    total: dict[int, LinkWrench] = {}
    for body, wrench in body_loads(topology, kinematics, tree, loads):
        link = tree.bodies[body].link
        if link != GROUND:
            total[link] = total[link] + wrench if link in total else wrench
    return total


def body_loads(
    topology: Topology, kinematics: Kinematics, tree: KinematicTree, loads: Iterable[Load]
) -> list[tuple[str, LinkWrench]]:
    """Return (body, wrench about its link's origin in its axes) for all loads on bodies; not on ground."""
    owners = frame_owners(topology)
    return [
        (
            owners[frame],
            link_wrench(kinematics, tree.bodies[owners[frame]], owners[frame], frame, force, torque),
        )
        for load in loads
        for frame, force, torque in wrenches(kinematics, load)
        if owners[frame] != "ground"
    ]


def link_wrench(
    kinematics: Kinematics, place: BodyPlacement, body: str, frame: str, force: Vector, torque: Vector
) -> LinkWrench:
    """Return a wrench in the origin of a body's frame as one about the origin of the body's link."""
    tree, axes = kinematics.tree, kinematics.tree.orientation_frame(body)
    arm = components(tree, kinematics.position(body, frame), axes)
    X = Transform(place.transform.steps, place.transform.point_to_parent(arm))
    return X.wrench_to_parent(Wrench(components(tree, force, axes), components(tree, torque, axes)))
