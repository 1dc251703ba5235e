"""The wrench that accelerates each body, and the part of it left to the joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symbody.equations.dynamics.balance import Wrench
from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.load import Load, wrenches
from symbody.equations.kinematics.motion import Kinematics
from symbody.graph.topology import Topology
from symbody.spatial.dyadic import gyroscopic, times_vector
from symbody.spatial.vector import Vector, cross


def inertial_wrench(kinematics: Kinematics, body: Inertia, a: Vector, alpha: Vector) -> Wrench:
    """Return ``m a`` and ``I alpha + w x I w`` of a body, about its centre of mass."""
    tree = kinematics.tree
    w = kinematics.angular_velocities[body.frame].value
    return Wrench(a * body.mass, times_vector(tree, body.tensor, alpha) + gyroscopic(tree, w, body.tensor))


def subtract_loads(
    topology: Topology, kinematics: Kinematics, needed: Mapping[str, Wrench], loads: Iterable[Load]
) -> dict[str, Wrench]:
    """Return the wrench of the joints on each body: all that it needs, less the loads."""
    owners = frame_owners(topology)
    result = dict(needed)
    for load in loads:
        for frame, force, torque in wrenches(kinematics, load):
            owner = owners[frame]
            if owner in result:
                moment = torque + cross(kinematics.tree, kinematics.position(owner, frame), force)
                result[owner] = Wrench(result[owner].force - force, result[owner].moment - moment)
    return result


def frame_owners(topology: Topology) -> dict[str, str]:
    """Return the body, or ground, that each frame of the model is fixed on."""
    owners = {"ground": "ground"} | {f"ground.{name}": "ground" for name in topology.model.ground}
    for body in topology.model.bodies:
        owners[body.name] = body.name
        owners |= {f"{body.name}.{name}": body.name for name in body.frames}
    return owners
