"""Loops: a joint more between two bodies of an assembled tree, with its end frame where the pose has it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.laws.drafts import Draft, Rejection
from tests.laws.draws import PLANE
from tests.laws.joint_laws import rotation, shift
from tests.laws.motion import all_freedoms, body_places, demands, frame_place, freedom_scales
from tests.laws.parts import FramePart, JointPart, Mechanism
from tests.laws.rotations import Array, euler_zyx

TRIES = 8  # before another body is hung on, which gives freedom
MOST_BODIES = 7
# Relative singular values of what loops demand: above the first a row counts, below the second it depends on
# others; a pose in between is near a singular one, where every formulation loses digits.
COUNTS, DEPENDS = 2e-2, 1e-9
FLAT = ("revolute",) * 6 + ("prismatic", "prismatic", "pin_slot", "rectangular")
SPATIAL = (
    ("spherical", "planar") * 3 + ("revolute",) * 2 + ("prismatic", "weld")
    + ("bearing", "telescoping", "gimbal", "cartesian", "cylindrical", "universal", "constant_velocity") * 2
    + ("screw", "pin_slot", "rectangular")
)  # fmt: skip
IDLE_ROWS = 3  # those of a planar loop that hold identically


def add_loops(draft: Draft, number: int) -> Mechanism:
    """Close loops, each of which removes freedom; its rows are independent but for those of a plane."""
    rank, redundant = 0, 0
    for _ in range(number):
        rank, idle = _close(draft, rank)
        redundant += idle
    return replace(draft.finished(), loops=number, redundant=redundant)


def _close(draft: Draft, rank: int) -> tuple[int, int]:
    """Close one loop and return the rank of all, and how many of its rows are redundant."""
    reasons: list[str] = []
    while True:
        found = _try_to_close(draft, rank, reasons)
        if found is not None:
            return found
        if len(draft.bodies) >= MOST_BODIES:
            raise Rejection(max(set(reasons), key=reasons.count))
        draft.add_body("revolute" if draft.normal else "spherical")


def _try_to_close(draft: Draft, rank: int, reasons: list[str]) -> tuple[int, int] | None:
    bodies = ["ground", *(body.name for body in draft.bodies if body.name not in draft.placed)]
    for _ in range(TRIES):
        draft.joints.append(_closing_joint(draft, *draft.draws.rng.sample(bodies, 2)))
        mechanism = draft.finished()
        found, left, rows = loop_rank(mechanism)
        idle = IDLE_ROWS if draft.normal else 0
        driven = any(j.motions for j in draft.joints)
        if found == rank + rows - idle and found > rank and left >= (0 if driven else 1):
            return found, idle
        reasons.append("near a singular pose" if found < 0 else "too few freedoms")
        draft.drop(draft.joints.pop())
    return None


def loop_rank(mechanism: Mechanism) -> tuple[int, int, int]:
    """Rank of what all closing joints demand, independent speeds left, and rows of the last joint.

    The rank is -1 where it is in doubt.
    """
    last = mechanism.joints[-1]
    own = 6 - len(last.names) + (last.sequence == "quaternion") + len(last.motions)
    rank, left = demanded_rank(mechanism)
    return rank, left, own


def demanded_rank(mechanism: Mechanism) -> tuple[int, int]:
    """Rank of all that is demanded, and independent speeds left; -1 and 0 where the rank is in doubt."""
    places = body_places(mechanism)
    motion = all_freedoms(mechanism, places)
    rows = demands(mechanism, places, motion).rows * freedom_scales(mechanism, motion)
    open_columns = [k for k in range(motion.size) if k not in motion.known]
    singular = np.linalg.svd(rows[:, open_columns], compute_uv=False)
    relative = singular / max(singular.max(initial=0.0), 1.0)  # rows are unit vectors times arms of order 1
    if ((relative < COUNTS) & (relative > DEPENDS)).any():
        return -1, 0
    rank = int((relative >= COUNTS).sum())
    return rank, len(open_columns) - rank


def _closing_joint(draft: Draft, a: str, b: str) -> JointPart:
    """A joint from a new frame on one body to the frame on the other that closes it at the pose."""
    kind = draft.draws.rng.choice(FLAT if draft.normal else SPATIAL)
    start = draft.frame(a)
    joint = draft.joint(kind, start, "", closing=True)
    mechanism = draft.finished()
    places = body_places(mechanism)
    r, axes = frame_place(mechanism, places, start)
    r, axes = r + axes @ shift(joint), axes @ rotation(joint)
    r_b, axes_b = places[b]
    end = draft.put(b, _placed_frame(draft, axes_b.T @ (r - r_b), axes_b.T @ axes))
    return replace(joint, end=end)


def _placed_frame(draft: Draft, at: Array, axes: Array) -> FramePart:
    if not draft.normal:
        angles = euler_zyx(axes)
        turns = tuple(zip("zyx", angles, strict=True))
        return FramePart((float(at[0]), float(at[1]), float(at[2])), turns, by_matrix=draft.draws.chance(0.3))
    first, second = PLANE[draft.normal]
    flat = [0.0, 0.0, 0.0]
    flat[first], flat[second] = float(at[first]), float(at[second])
    angle = float(np.arctan2(axes[second, first], axes[first, first]))
    return FramePart((flat[0], flat[1], flat[2]), ((draft.normal, angle),))
