"""Joints and bodies as they stand on each other, before any axes are chosen.

Bodies that are welded together are one group, whose first body gives the axes and the origin.
"""

from __future__ import annotations

from dataclasses import dataclass

from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import Use, joint_steps, turns_of
from symbody.equations.recursive.constants import onto_axis
from symbody.equations.recursive.pseudo_inertia import added
from symbody.expr.expression import number
from symbody.graph.spanning_tree import Branch
from symbody.graph.topology import Topology
from symbody.model.element import Address
from symbody.model.frame import Frame
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, identity, opposite, product, transpose
from symbody.vectors.rotation import EulerParameters, Turn, rotation_matrix, rotation_of


@dataclass(frozen=True, slots=True)
class Pose:
    """Axes and origin of one frame in another: components to components, and a position."""

    axes: Matrix
    at: Triple

    def then(self, other: Pose) -> Pose:
        """Return the pose of a frame that stands in this one."""
        return Pose(product(self.axes, other.axes), added(self.at, apply_matrix(self.axes, other.at)))

    @property
    def inverse(self) -> Pose:
        """The pose of the other in the one."""
        back = transpose(self.axes)
        return Pose(back, opposite(apply_matrix(back, self.at)))


@dataclass(frozen=True, slots=True)
class Hinge:
    """A joint that moves, between two groups.

    Attributes
    ----------
    steps : tuple of Turn or EulerParameters
        From the near frame, on the parent, to the far frame.
    near : Pose
        Of the near frame in the parent's group.
    far : Pose
        Of the far frame in its own group, which is its body.
    z : Matrix or None
        Its third column is the axis it turns about, in both frames; None: it has not one constant axis.
    """

    use: Use
    branch: Branch
    parent: str
    steps: tuple[Turn | EulerParameters, ...]
    near: Pose
    far: Pose
    z: Matrix | None

    @property
    def turning(self) -> str:
        """About what it turns: "none", "z" or "any"."""
        return "none" if not self.steps else "any" if self.z is None else "z"

    @property
    def sliding(self) -> bool:
        """Whether the far frame's origin moves relative to the near frame."""
        return bool(self.use.joint.translation_coordinates)


def hinges_and_groups(
    topology: Topology, names: Names, uses: dict[str, Use], align: bool
) -> tuple[list[Hinge], dict[str, tuple[str, Pose]]]:
    """Return all moving joints outward from ground, and for each body its group and its pose therein."""
    still = Pose(identity(names.graph), _origin(names))
    groups: dict[str, tuple[str, Pose]] = {"ground": ("ground", still)}
    hinges = []
    for branch in topology.rotation.branches:
        use = uses[branch.edge.name]
        joint = use.joint
        ends = (joint.start, joint.end) if branch.forward else (joint.end, joint.start)
        group, pose = groups[branch.parent]
        near, far = pose.then(_pose(topology, names, ends[0])), _pose(topology, names, ends[1])
        steps = joint_steps(names, joint)
        if not branch.forward:
            steps = tuple(step.inverse for step in reversed(steps))
        steps = tuple(s for s in rotation_of(steps).turns if isinstance(s, Turn | EulerParameters))
        if not joint.coordinates:
            shift = names.triple(joint.shift(), f"joint {joint.name}")
            between = Pose(rotation_matrix(names.graph, rotation_of(steps)), shift)
            groups[branch.child] = (group, near.then(between).then(far.inverse))
            continue
        only = steps[0] if len(steps) == 1 and align else None
        z = onto_axis(names.graph, only.axis) if isinstance(only, Turn) else None
        hinges.append(Hinge(use, branch, group, steps, near, far, z))
        groups[branch.child] = (branch.child, still)
    return hinges, groups


def _pose(topology: Topology, names: Names, address: Address) -> Pose:
    """Return where a frame stands on its body."""
    frame, graph = Frame(), names.graph
    if address.point:
        model = topology.model
        frames = model.ground if address.body == "ground" else model.body(address.body).frames
        frame = frames[address.point]
    turns = turns_of(names, frame.turns(), address.frame)
    return Pose(rotation_matrix(graph, rotation_of(turns)), names.triple(frame.at, address.frame))


def _origin(names: Names) -> Triple:
    zero = number(names.graph, 0)
    return (zero, zero, zero)
