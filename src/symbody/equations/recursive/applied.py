"""What loads do to links."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.equations.dynamics.load import Load, wrenches
from symbody.equations.dynamics.needs import frame_owners
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.recursive.links import GROUND, Fixed, Tree
from symbody.equations.recursive.newton_euler import Carried
from symbody.equations.recursive.pseudo_inertia import added
from symbody.graph.topology import Topology
from symbody.vectors.matrix import Triple, apply_matrix, outer
from symbody.vectors.vector import Vector, components


def applied_wrenches(
    topology: Topology, kinematics: Kinematics, tree: Tree, loads: Iterable[Load]
) -> dict[int, Carried]:
    """Return the sum of what loads give each link that they act on, about its origin in its axes."""
    found: dict[int, Carried] = {}
    for body, own in applied_to_body(topology, kinematics, tree, loads):
        link = tree.bodies[body].link
        if link != GROUND:
            found[link] = found[link].plus(own) if link in found else own
    return found


def applied_to_body(
    topology: Topology, kinematics: Kinematics, tree: Tree, loads: Iterable[Load]
) -> list[tuple[str, Carried]]:
    """Return (body, wrench about its link's origin in its axes) for all that loads give; not ground."""
    owners = frame_owners(topology)
    return [
        (owners[frame], on_link(kinematics, tree.bodies[owners[frame]], owners[frame], frame, force, torque))
        for load in loads
        for frame, force, torque in wrenches(kinematics, load)
        if owners[frame] != "ground"
    ]


def on_link(
    kinematics: Kinematics, place: Fixed, body: str, frame: str, force: Vector, torque: Vector
) -> Carried:
    """Return a wrench that acts in the origin of a body's frame, about the origin of the body's link."""
    home = kinematics.tree.home(body)

    def here(a: Vector) -> Triple:
        return apply_matrix(place.axes, components(kinematics.tree, a, home))

    f = here(force)
    lever = added(place.at, here(kinematics.arm(body, frame)))
    return Carried(f, added(here(torque), outer(lever, f)))
