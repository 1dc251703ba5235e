"""A random mechanism near its pose: the values of all joints where its bodies stand elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.laws.joint_laws import freedoms, letters, rates, rotation, shift
from tests.laws.motion import Places, frame_place
from tests.laws.parts import JointPart, Mechanism
from tests.laws.rotations import Array, quaternion

Twists = dict[str, tuple[Array, Array]]
# Newton's method squares the distance: from a thousandth of the unit three steps end at rounding.
_STEPS = 4


def moved(mechanism: Mechanism, places: Places) -> Mechanism:
    """The mechanism with the values of its joints, closing ones among them, that bodies near the pose have.

    Where loops are open by a little the values of a closing joint are those of least squares.
    """
    joints = tuple(_moved_joint(mechanism, places, joint) for joint in mechanism.joints)
    placed = {body: places[body] for body in mechanism.placed}
    return replace(mechanism, joints=joints, placed=placed)


def _moved_joint(mechanism: Mechanism, places: Places, joint: JointPart) -> JointPart:
    (r_s, a_s), (r_e, a_e) = (frame_place(mechanism, places, address) for address in (joint.start, joint.end))
    r, axes = a_s.T @ (r_e - r_s), a_s.T @ a_e
    scale = np.array([1.0] * 3 + [1.0 / mechanism.units.length] * 3)
    for _ in range(_STEPS if joint.names else 0):
        missing = np.concatenate([_turn(axes @ rotation(joint).T), r - shift(joint)])
        basis = np.vstack(freedoms(joint)) * scale[:, None]
        own = np.linalg.lstsq(basis, missing * scale, rcond=None)[0]
        changes = rates(joint, own)
        values = {
            name: x + changes.get(f"{name}_dot", 0.0)
            for name, x in zip(joint.names, joint.values, strict=True)
        }
        if joint.sequence == "quaternion":
            names = [name for name, word in zip(joint.names, letters(joint), strict=True) if word == "o"]
            values |= dict(zip(names, quaternion(axes).tolist(), strict=True))
        joint = replace(joint, values=tuple(float(x) for x in values.values()))
    return joint


def _turn(matrix: Array) -> Array:
    """The vector of a small rotation, to its second order."""
    skew = 0.5 * (matrix - matrix.T)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
