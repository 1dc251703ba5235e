"""Steps from frame to frame, from a model and its trees."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from symbody.equations.kinematics.frame_steps import RotationStep, TranslationStep
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole, axis_rotations, joint_steps, quasi_vector
from symbody.graph.spanning_tree import TreeBranch
from symbody.graph.topology import Topology
from symbody.model.element import FrameRef
from symbody.model.frame import Frame
from symbody.model.joint import Joint
from symbody.model.model import Model
from symbody.spatial.euler_parameters import EulerParameters
from symbody.spatial.rotation import AxisRotation
from symbody.spatial.vector import Vector, vector

Steps = tuple[AxisRotation | EulerParameters, ...]


def predicted_frame(joint: str) -> str:
    """Return the name of the frame in which a cut joint's end frame must stand."""
    return f"{joint}|predicted"


def rotation_steps(topology: Topology, names: Names, roles: Sequence[JointRole]) -> Iterator[RotationStep]:
    """Return how all frames are turned, outward from ground along the rotation tree."""
    model = topology.model
    yield from _rotations_of_fixed_frames(names, "ground", model.ground.items())
    for branch in topology.rotation.branches:
        yield from _rotations_of_branch(topology, names, branch)
        body = model.body(branch.child)
        yield from _rotations_of_fixed_frames(names, body.name, body.frames.items())
    for role in roles:
        if role.has_angles and role.joint.name not in topology.rotation_branches:
            steps = joint_steps(names, role.joint)
            yield RotationStep(predicted_frame(role.joint.name), role.joint.start.full_name, steps)


def translation_steps(topology: Topology, names: Names) -> Iterator[TranslationStep]:
    """Return where all origins stand, outward from ground along the translation tree."""
    model = topology.model
    yield from _translations_of_fixed_frames(names, "ground", model.ground.items())
    for branch in topology.translation.branches:
        yield from _translations_of_branch(topology, names, branch)
        body = model.body(branch.child)
        yield from _translations_of_fixed_frames(names, body.name, body.frames.items())


def joint_shift(names: Names, joint: Joint) -> Vector:
    """Return the position of a joint's end frame from its start frame, in the joint's coordinates."""
    home = joint.end.full_name if joint.shift_in == "end" else joint.start.full_name
    return vector(home, names.triple(joint.shift(), f"joint {joint.name}"))


def _rotations_of_fixed_frames(
    names: Names, body: str, frames: Iterable[tuple[str, Frame]]
) -> Iterator[RotationStep]:
    for name, frame in frames:
        yield RotationStep(
            f"{body}.{name}", body, axis_rotations(names, frame.turns(), f"frame {body}.{name}")
        )


def _translations_of_fixed_frames(
    names: Names, body: str, frames: Iterable[tuple[str, Frame]]
) -> Iterator[TranslationStep]:
    for name, frame in frames:
        at = names.triple(frame.at, f"frame {body}.{name}")
        yield TranslationStep(f"{body}.{name}", body, body, vector(body, at))


def _rotations_of_branch(topology: Topology, names: Names, branch: TreeBranch) -> Iterator[RotationStep]:
    """Return the steps from the near frame of a joint to its far frame and to the body there.

    A joint walked against its direction has its rotation reversed.
    """
    joint = topology.joint(branch.edge.name)
    near, far = joint_ends(joint, branch)
    steps = joint_steps(names, joint)
    other = _far_frame(joint)
    frames = (
        {"start": near.full_name, "end": other} if branch.forward else {"start": other, "end": near.full_name}
    )
    quasi = joint.rotation_speeds
    w = None if quasi is None else vector(frames[quasi.resolved_in], quasi_vector(names, quasi))
    if branch.forward:
        yield RotationStep(other, near.full_name, steps, w)
    else:
        yield RotationStep(other, near.full_name, reverse_steps(steps), None if w is None else -w)
    turns = reverse_steps(axis_rotations(names, frame_of(topology.model, far).turns(), far.full_name))
    yield RotationStep(far.body, other, turns)


def _translations_of_branch(
    topology: Topology, names: Names, branch: TreeBranch
) -> Iterator[TranslationStep]:
    joint = topology.joint(branch.edge.name)
    near, far = joint_ends(joint, branch)
    sign = 1 if branch.forward else -1
    shift = joint_shift(names, joint) * sign
    quasi = joint.translation_speeds
    other = _far_frame(joint)
    start, end = joint.start.full_name, joint.end.full_name
    if quasi is None:
        yield TranslationStep(other, near.full_name, far.body, shift)
    else:
        home = start if quasi.resolved_in == "start" else end
        slide = vector(home, quasi_vector(names, quasi)) * sign
        yield TranslationStep(other, near.full_name, far.body, shift, (start, slide))
    at = names.triple(frame_of(topology.model, far).at, far.full_name)
    yield TranslationStep(far.body, other, far.body, -vector(far.body, at))


def joint_ends(joint: Joint, branch: TreeBranch) -> tuple[FrameRef, FrameRef]:
    """Return the near end of a joint, on the parent of its branch, and the far end."""
    return (joint.start, joint.end) if branch.forward else (joint.end, joint.start)


def _far_frame(joint: Joint) -> str:
    return f"{joint.name}|far"


def frame_of(model: Model, address: FrameRef) -> Frame:
    """Return a frame of a body or of ground; without a name, that of the body itself."""
    if not address.frame:
        return Frame()
    frames = model.ground if address.body == "ground" else model.body(address.body).frames
    return frames[address.frame]


def reverse_steps(steps: Steps) -> Steps:
    """Return the rotation back."""
    return tuple(step.inverse for step in reversed(steps))
