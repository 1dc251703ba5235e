"""The trees of `trees.py` for programs that compute with numbers: Pinocchio, and MuJoCo by its file format."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tests.oracles.comparison import Floats
from tests.oracles.trees import Joint, Place, Tree, random_tree

KINDS = ("weld", "revolute", "prismatic", "spherical")


def plain_tree(seed: int, most: int = 8) -> Tree:
    """A tree under gravity alone, with the angular velocity along axes of the end as all these programs have it."""
    tree = random_tree(seed, most, KINDS, bare=True)
    joints = tuple(
        replace(joint, speeds="end") if joint.kind == "spherical" else joint for joint in tree.joints
    )
    return replace(tree, joints=joints)


def rotation(axis: str, angle: float) -> Floats:
    """The matrix of a turn about a coordinate axis."""
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = math.cos(angle)
    R[j, i], R[i, j] = math.sin(angle), -math.sin(angle)
    return R


def placed(place: Place) -> tuple[Floats, Floats]:
    """Rotation matrix and origin of a frame on its body."""
    R = np.eye(3)
    for axis, angle in place.turns:
        R = R @ rotation(axis, float(angle))
    return R, np.array(place.at, float)


def attached(joint: Joint) -> tuple[Floats, Floats]:
    """The body relative to its parent while the coordinates are zero."""
    (R, r), (Q, s) = placed(joint.start), placed(joint.end)
    return R @ Q.T, r - R @ Q.T @ s


def orientation(joint: Joint, angles: list[float]) -> Floats:
    """The end of a spherical joint relative to its start."""
    R = np.eye(3)
    for axis, angle in zip(joint.sequence, angles, strict=True):
        R = R @ rotation(axis, angle)
    return R


def tensor(tree: Tree, body: int) -> Floats:
    """The inertia tensor about the centre of mass."""
    part = tree.bodies[body]
    xy, xz, yz = map(float, part.products)
    xx, yy, zz = map(float, part.moments)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def values_of(tree: Tree, joint: int, values: Mapping[str, float], names: tuple[str, ...]) -> list[float]:
    """The values of one joint, of those in the order of its coordinates."""
    return [
        values[name]
        for name, own in zip(names, tree.coordinates, strict=True)
        if own.startswith(f"q{joint}_")
    ]


def unit(joint: Joint) -> Floats:
    axis = np.array(joint.axis, float)
    scaled: Floats = axis / np.linalg.norm(axis)
    return scaled


def by_pinocchio(pin: Any, tree: Tree, q: Mapping[str, float], u: Mapping[str, float]) -> Floats:
    """Accelerations in the order of `tree.speeds`, by the articulated-body algorithm of Pinocchio."""
    model = pin.Model()
    model.gravity.linear = np.array(tree.gravity, float)
    homes = {-1: (0, pin.SE3.Identity())}  # the joint a body moves with, and where the body is in its frame
    own: dict[int, int] = {}
    for k, joint in enumerate(tree.joints):
        carrier, home = homes[joint.parent]
        start, end = home * pin.SE3(*placed(joint.start)), pin.SE3(*placed(joint.end)).inverse()
        if joint.kind == "weld":
            homes[k] = (carrier, start * end)
        else:
            kinds = {
                "revolute": pin.JointModelRevoluteUnaligned,
                "prismatic": pin.JointModelPrismaticUnaligned,
            }
            moves = kinds[joint.kind](unit(joint)) if joint.kind in kinds else pin.JointModelSpherical()
            own[k] = model.addJoint(carrier, moves, start, f"J{k}")
            homes[k] = (own[k], end)
        inertia = pin.Inertia(float(tree.bodies[k].mass), np.zeros(3), tensor(tree, k))
        model.appendBodyToJoint(homes[k][0], inertia, homes[k][1])
    x, v = pin.neutral(model), np.zeros(model.nv)
    for k, number in own.items():
        here, moving = values_of(tree, k, q, tree.coordinates), values_of(tree, k, u, tree.speeds)
        place = model.joints[number]
        if tree.joints[k].kind == "spherical":
            here = pin.Quaternion(orientation(tree.joints[k], here)).coeffs()
        x[place.idx_q : place.idx_q + place.nq] = here
        v[place.idx_v : place.idx_v + place.nv] = moving
    found = pin.aba(model, model.createData(), x, v, np.zeros(model.nv))
    listed = [found[model.joints[number].idx_v :][: model.joints[number].nv] for number in own.values()]
    return np.concatenate(listed)


def quaternion(R: Floats) -> Floats:
    """Scalar first, of the largest of four ways to find it [Shepperd 1978]."""
    t = np.trace(R)
    k = int(np.argmax([t, *np.diag(R)])) - 1
    if k < 0:
        found = np.array([1 + t, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        found = np.zeros(4)
        found[0], found[1 + k] = R[j, i] - R[i, j], 1 + 2 * R[k, k] - t
        found[1 + i], found[1 + j] = R[i, k] + R[k, i], R[j, k] + R[k, j]
    unit_length: Floats = found / np.linalg.norm(found)
    return unit_length


def _numbers(values: Any) -> str:
    return " ".join(repr(float(x)) for x in values)


def mujoco_text(tree: Tree) -> str:
    """The tree in MuJoCo's file format; products of inertia are not written, MuJoCo would diagonalize them."""

    def body(k: int) -> str:
        joint = tree.joints[k]
        (R, r), (Q, s) = attached(joint), placed(joint.end)
        kinds = {"revolute": "hinge", "prismatic": "slide", "spherical": "ball"}
        axis = f' axis="{_numbers(Q @ unit(joint))}"' if joint.kind in ("revolute", "prismatic") else ""
        moves = (
            f'<joint name="J{k}" type="{kinds[joint.kind]}" pos="{_numbers(s)}"{axis}/>'
            if joint.kind in kinds
            else ""
        )
        moments = _numbers(tree.bodies[k].moments)
        mass = f'<inertial pos="0 0 0" mass="{float(tree.bodies[k].mass)!r}" diaginertia="{moments}"/>'
        below = "".join(body(i) for i, other in enumerate(tree.joints) if other.parent == k)
        return f'<body pos="{_numbers(r)}" quat="{_numbers(quaternion(R))}">{moves}{mass}{below}</body>'

    roots = "".join(body(k) for k, joint in enumerate(tree.joints) if joint.parent < 0)
    return (
        f'<mujoco><compiler angle="radian" inertiafromgeom="false"/><option gravity="{_numbers(tree.gravity)}"/>'
        f"<worldbody>{roots}</worldbody></mujoco>"
    )


def by_mujoco(mujoco: Any, tree: Tree, q: Mapping[str, float], u: Mapping[str, float]) -> Floats:
    """Accelerations in the order of `tree.speeds`, by MuJoCo."""
    model = mujoco.MjModel.from_xml_string(mujoco_text(tree))
    data = mujoco.MjData(model)
    ranges: list[tuple[Floats, slice]] = []
    for k, joint in enumerate(tree.joints):
        if joint.kind == "weld":
            continue
        here = values_of(tree, k, q, tree.coordinates)
        moving = np.array(values_of(tree, k, u, tree.speeds))
        number = model.joint(f"J{k}").id
        first, at = model.jnt_qposadr[number], model.jnt_dofadr[number]
        turn = np.eye(len(moving))
        if joint.kind == "spherical":  # along axes of the body, not of its joint's frame
            turn = placed(joint.end)[0]
            data.qpos[first : first + 4] = quaternion(turn @ orientation(joint, here) @ turn.T)
        else:
            data.qpos[first] = here[0]
        data.qvel[at : at + len(moving)] = turn @ moving
        ranges.append((turn, slice(at, at + len(moving))))
    mujoco.mj_forward(model, data)
    return np.concatenate([turn.T @ data.qacc[place] for turn, place in ranges])
