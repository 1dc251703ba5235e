"""Joints and bodies as they stand on each other, before any axes are chosen.

Bodies that are welded together are one group, whose first body gives the axes and the origin.
"""

from __future__ import annotations

from dataclasses import dataclass

from symbody.equations.kinematics.frame_placement import frame_of, joint_ends, reverse_steps
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole, axis_rotations, joint_steps
from symbody.equations.recursive.constants import axes_with_z
from symbody.equations.recursive.links import LinkTransform
from symbody.expr.expression import Expr
from symbody.graph.spanning_tree import TreeBranch
from symbody.graph.topology import Topology
from symbody.model.element import FrameRef
from symbody.spatial.euler_parameters import EulerParameters
from symbody.spatial.matrix import Matrix3, Vector3, identity, zero_vector
from symbody.spatial.rotation import AxisRotation, Rotation, compose_steps, rotation_matrix
from symbody.spatial.transform import Transform


@dataclass(frozen=True, slots=True)
class TreeJoint:
    """A joint that moves, between two groups.

    Attributes
    ----------
    steps : tuple of AxisRotation or EulerParameters
        From the near frame, on the parent, to the far frame.
    near : Transform
        The near frame in the parent's group.
    far : Transform
        The far frame in its own group, which is its body.
    z : Matrix3 or None
        Axes whose third is the one it turns about, in both frames; None: it has not one constant axis.
    """

    role: JointRole
    branch: TreeBranch
    parent: str
    steps: tuple[AxisRotation | EulerParameters, ...]
    near: LinkTransform
    far: LinkTransform
    z: Matrix3[Expr] | None

    @property
    def rotation(self) -> str:
        """The axes it turns about: "none", "z" or "any"."""
        return "none" if not self.steps else "any" if self.z is None else "z"

    @property
    def has_displacements(self) -> bool:
        """Whether the far frame's origin moves relative to the near frame."""
        return bool(self.role.joint.translation_coordinates)


def joints_and_groups(
    topology: Topology, names: Names, roles: dict[str, JointRole], align: bool
) -> tuple[list[TreeJoint], dict[str, tuple[str, LinkTransform]]]:
    """Return all moving joints outward from ground, and for each body its group and its transform therein."""
    graph = names.graph
    here = Transform((identity(graph),), zero_vector(graph))
    groups: dict[str, tuple[str, LinkTransform]] = {"ground": ("ground", here)}
    joints = []
    for branch in topology.rotation.branches:
        role = roles[branch.edge.name]
        joint = role.joint
        start, end = joint_ends(joint, branch)
        group, parent = groups[branch.parent]
        near, far = parent.then(_frame(topology, names, start)), _frame(topology, names, end)
        steps = joint_steps(names, joint)
        rotation = compose_steps(steps if branch.forward else reverse_steps(steps))
        if not joint.coordinates:
            shift = Vector3(names.triple(joint.shift(), f"joint {joint.name}"))
            between = _transform(names, rotation, shift)
            groups[branch.child] = (group, near.then(between).then(far.inverse))
            continue
        moving = tuple(step for step in rotation.turns if isinstance(step, AxisRotation | EulerParameters))
        only = moving[0] if len(moving) == 1 and align else None
        z = axes_with_z(graph, only.axis) if isinstance(only, AxisRotation) else None
        joints.append(TreeJoint(role, branch, group, moving, near, far, z))
        groups[branch.child] = (branch.child, here)
    return joints, groups


def _frame(topology: Topology, names: Names, address: FrameRef) -> LinkTransform:
    """Return where a frame stands on its body."""
    frame = frame_of(topology.model, address)
    rotation = compose_steps(axis_rotations(names, frame.turns(), address.full_name))
    return _transform(names, rotation, Vector3(names.triple(frame.at, address.full_name)))


def _transform(names: Names, rotation: Rotation, position: Vector3[Expr]) -> LinkTransform:
    return Transform((rotation_matrix(names.graph, rotation),), position)
