"""Balance: the wrenches of the joints of a tree, from those that the bodies need.

A branch carries what its outer bodies need: forces are balanced along the translation tree, then moments
along the rotation tree, from the leaves inward. The same sums give reactions and, multiplied by the free
motions of the joints, the equations of motion: a body is met once, however many joints lie inward of it.
"""

from __future__ import annotations

from collections.abc import Mapping

from symbody.equations.kinematics.motion import Kinematics
from symbody.graph.spanning_tree import SpanningTree
from symbody.graph.topology import Topology
from symbody.spatial import twist
from symbody.spatial.vector import ZERO, Vector, cross, express_near

# A force in a point and a moment about it, as sums of terms in their own frames.
Wrench = twist.Wrench[Vector]

NO_WRENCH = Wrench(ZERO, ZERO)


def balance_wrenches(
    topology: Topology,
    kinematics: Kinematics,
    needed: Mapping[str, Wrench],
    cut: Mapping[str, Wrench],
) -> dict[str, Wrench]:
    """Return the wrench of every joint on its end body by its start body, at the origin of the end frame.

    Parameters
    ----------
    needed : mapping of body to Wrench
        The sum of the wrenches of joints on each body, about its centre of mass; zero for bodies left out.
    cut : mapping of joint to Wrench
        Wrenches of the joints that are not in the trees.
    """
    forces = {name: wrench.force for name, wrench in cut.items()}
    moments = {name: wrench.moment for name, wrench in cut.items()}
    pushing = {body: wrench.force for body, wrench in needed.items()}
    turning = {body: wrench.moment for body, wrench in needed.items()}
    _balance_branches(topology, kinematics, topology.translation, pushing, forces)
    _subtract_levers(topology, kinematics, forces, turning)
    _balance_branches(topology, kinematics, topology.rotation, turning, moments)
    names = {*forces, *moments}
    return {name: Wrench(forces.get(name, ZERO), moments.get(name, ZERO)) for name in names}


def _balance_branches(
    topology: Topology,
    kinematics: Kinematics,
    tree: SpanningTree,
    needed: Mapping[str, Vector],
    total: dict[str, Vector],
) -> None:
    """Add the wrench part of each branch to `total`, which holds those of the cut joints."""
    remaining = dict(needed)
    for name, carried in total.items():
        joint = topology.link(name)
        if joint is None:
            continue
        remaining[joint.end.body] = remaining.get(joint.end.body, ZERO) - carried
        remaining[joint.start.body] = remaining.get(joint.start.body, ZERO) + carried
    for branch in reversed(tree.branches):
        carried = remaining.get(branch.child, ZERO)
        if carried.is_zero:
            continue
        carried = express_near(kinematics.tree, carried, kinematics.tree.orientation_frame(branch.parent))
        remaining[branch.parent] = remaining.get(branch.parent, ZERO) + carried
        name = branch.edge.name
        total[name] = total.get(name, ZERO) + (carried if branch.forward else -carried)


def _subtract_levers(
    topology: Topology, kinematics: Kinematics, forces: Mapping[str, Vector], needed: dict[str, Vector]
) -> None:
    """Subtract the moments of the joints' forces about the centres of mass from those that bodies need."""
    for name, force in forces.items():
        joint = topology.link(name)
        if joint is None:
            continue
        end = joint.end.full_name
        for body, share in ((joint.end.body, force), (joint.start.body, -force)):
            arm = kinematics.position(body, end)
            lever = cross(kinematics.tree, arm, share)
            if not lever.is_zero:
                needed[body] = needed.get(body, ZERO) - lever
