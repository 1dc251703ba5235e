"""Joints that follow others: what ``<mimic>`` means in the model."""

from __future__ import annotations

from collections.abc import Mapping

from symbody.expr.graph import Constant
from symbody.formats.urdf.file.placement import numeral
from symbody.formats.urdf.file.robot import UrdfJoint
from symbody.model.constraint import ConstraintElement
from symbody.model.constraints import Constraint, Gear, RackPinion


def leader_law(joint: UrdfJoint, joints: Mapping[str, UrdfJoint]) -> tuple[UrdfJoint, Constant, Constant]:
    """Return (leader, k, o) with ``q = k leader + o``, where the leader follows no other joint.

    In a chain ``q = k1 p + o1``, ``p = k2 r + o2`` gives ``q = k1 k2 r + k1 o2 + o1``.
    """
    factor: Constant = 1
    offset: Constant = 0
    while joint.mimic is not None:
        offset += factor * joint.mimic.offset
        factor *= joint.mimic.multiplier
        joint = joints[joint.mimic.leader]
    return joint, factor, offset


def follow_leader(
    name: str,
    joint: UrdfJoint,
    leader: UrdfJoint,
    symbols: tuple[str, str],
    factor: Constant,
    offset: Constant,
) -> ConstraintElement:
    """Return what ties a joint to its leader; `symbols` are their coordinates."""
    slides, led_slides = joint.kind == "prismatic", leader.kind == "prismatic"
    if not slides and not led_slides:
        return Gear(name, symbols, ratio=numeral(factor), offset=numeral(offset))
    if slides and not led_slides:
        return RackPinion(name, symbols, radius=numeral(factor), offset=numeral(offset))
    own, other = symbols
    return Constraint(name, f"{own} - ({numeral(factor)})*{other} - ({numeral(offset)})")
