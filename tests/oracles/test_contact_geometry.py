"""Gaps and points of contact against MuJoCo's, in random poses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.contacts.pairs import SIZES, Floats, pose, scene

mujoco: Any = pytest.importorskip("mujoco")

# What MuJoCo calls the shapes, with their sizes: half lengths.
GEOMS = {
    "plane": 'type="plane" size="5 5 1"',
    "sphere": f'type="sphere" size="{SIZES["r"]}"',
    "capsule": f'type="capsule" size="{SIZES["r"]} {SIZES["L"] / 2}"',
    "cylinder": f'type="cylinder" size="{SIZES["r"]} {SIZES["L"] / 2}"',
    "box": 'type="box" size="0.15 0.2 0.25"',
}
PAIRS = [
    ("plane", "sphere"), ("plane", "capsule"), ("plane", "cylinder"), ("plane", "box"), ("sphere", "sphere"),
    ("sphere", "capsule"), ("capsule", "capsule"), ("box", "sphere"), ("box", "capsule"),
]  # fmt: skip
# Its boxes and capsules leave the nearest feature by a margin.
TOLERANCE = 1e-9


def world(words: tuple[str, str]) -> Any:
    """The first body is placed, the second is free: MuJoCo looks for no contact of two that cannot move."""
    first, second = (f"<geom {GEOMS[word]}/>" for word in words)
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body mocap="true">{first}</body><body><freejoint/>{second}</body></worldbody></mujoco>'
    )


def place(data: Any, first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> None:
    data.mocap_pos[0], data.qpos[:3] = first[0], second[0]
    mujoco.mju_mat2Quat(data.mocap_quat[0], np.ascontiguousarray(first[1]).ravel())
    mujoco.mju_mat2Quat(data.qpos[3:], np.ascontiguousarray(second[1]).ravel())


@pytest.mark.parametrize("words", PAIRS, ids=["-".join(pair) for pair in PAIRS])
def test_gap_normal_and_point_are_those_of_mujoco(words: tuple[str, str]) -> None:
    model = scene(words)
    function = sb.compile(
        sb.form_equations(model),
        [
            "gap touch",
            "frame r touch",
            "frame R touch",
            "frame r A.s",
            "frame R A.s",
            "frame r B.s",
            "frame R B.s",
        ],
        quick=True,
    )
    theirs = world(words)
    data = mujoco.MjData(theirs)
    for seed in range(20):
        for asked in (0.05, -0.01):
            q, u = pose(words, 100 + seed, asked)
            gap, r, R, *placements = function(0.0, q, u)
            place(data, (placements[0], placements[1]), (placements[2], placements[3]))
            mujoco.mj_kinematics(theirs, data)
            ends = np.zeros(6)
            if "plane" not in words:
                distance = mujoco.mj_geomDistance(theirs, data, 0, 1, 10.0, ends)
                assert distance == pytest.approx(gap, abs=1e-6), (seed, asked)
            if asked < 0:
                mujoco.mj_collision(theirs, data)
                deepest = min(range(data.ncon), key=lambda k: data.contact[k].dist)
                assert data.contact[deepest].dist == pytest.approx(gap, abs=TOLERANCE), (seed, asked)
                np.testing.assert_allclose(data.contact[deepest].pos, r, atol=TOLERANCE)
                np.testing.assert_allclose(
                    data.contact[deepest].frame[:3],
                    R[:, 2] * (1 - 2 * data.contact[deepest].geom[0]),
                    atol=TOLERANCE,
                )
