"""Joints of a URDF file."""

from __future__ import annotations

from typing import Final

from symbody.errors import nearest
from symbody.expr.graph import Constant
from symbody.formats.urdf.file.attributes import EXACT, Attributes
from symbody.formats.urdf.file.placement import Numbers
from symbody.formats.urdf.file.robot import Limit, Mimic, UrdfJoint
from symbody.formats.urdf.file.xml_tree import XmlNode

KINDS: Final = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
SINGLE: Final = ("revolute", "continuous", "prismatic")
_HAVE_AXIS: Final = (*SINGLE, "planar")


def read_joint(read: Attributes, node: XmlNode) -> UrdfJoint:
    """Return a joint."""
    name = read.name(node, "")
    label = f"joint {name}"
    kind = read.name(node, label, "type")
    if kind and kind not in KINDS:
        read.refuse("joint_type", node, label, f"there is no joint type {kind!r}", "", nearest(kind, KINDS))
    ends = {}
    for tag in ("parent", "child"):
        end = read.only(node, tag, label, needed=True)
        ends[tag] = "" if end is None else read.name(end, label, "link")
    dynamics = read.only(node, "dynamics", label)
    values: dict[str, Constant] = {"damping": 0, "friction": 0}
    if dynamics is not None:
        values = {word: _coefficient(read, dynamics, word, label) for word in values}
        if kind not in SINGLE and any(values.values()):
            read.remark(dynamics, f"{label}: damping and friction of a {kind} joint are ignored")
    axis = _axis(read, node, label, kind)
    return UrdfJoint(
        name, node.line, kind, ends["parent"], ends["child"], read.origin(node, label), axis,
        values["damping"], values["friction"], _limit(read, node, label, kind),
        _mimic(read, node, label, kind),
    )  # fmt: skip


def _axis(read: Attributes, node: XmlNode, label: str, kind: str) -> Numbers:
    element = read.only(node, "axis", label)
    if kind not in _HAVE_AXIS:
        return (1, 0, 0)
    if element is None or "xyz" not in element.attributes:
        read.default("a joint without <axis> has 1 0 0")
        return (1, 0, 0)
    faults = len(read.problems)
    axis = read.triple(element, "xyz", label)
    if len(read.problems) > faults:
        return (1, 0, 0)
    length = sum(float(x) ** 2 for x in axis) ** 0.5
    if length == 0:
        read.refuse("zero_axis", element, label, "the axis has length zero", "all its components are 0",
                    'give a direction, for instance <axis xyz="0 0 1"/>')  # fmt: skip
        return (1, 0, 0)
    main = max(range(3), key=lambda k: abs(float(axis[k])))
    off = sum(float(x) ** 2 for k, x in enumerate(axis) if k != main) ** 0.5 / length
    if 0 < off <= read.snap:
        if off > EXACT:
            read.remark(
                element,
                f"{label}: the axis is rounded to the coordinate axis, from which it differs by {off:.2g} "
                f"rad",
            )
        axis = _axis_vector(main, axis[main])
    if sum(bool(x) for x in axis) == 1:
        if abs(length - 1) > 1e-9:
            read.remark(element, f"{label}: the axis of length {length:g} is normalized")
        return _axis_vector(main, axis[main])
    return axis


def _axis_vector(k: int, sign: Constant) -> Numbers:
    x, y, z = ((1 if sign > 0 else -1) if i == k else 0 for i in range(3))
    return (x, y, z)


def _coefficient(read: Attributes, node: XmlNode, word: str, label: str) -> Constant:
    value = read.number(node, word, label, 0)
    if value < 0:
        read.refuse("negative", node, label, f"the {word} is {float(value):g}",
                    "it would drive the joint instead of resisting it",
                    "give 0 or a positive number")  # fmt: skip
        return 0
    return value


def _limit(read: Attributes, node: XmlNode, label: str, kind: str) -> Limit | None:
    found = read.only(node, "limit", label)
    if found is None:
        if kind in ("revolute", "prismatic"):
            read.default("a revolute or prismatic joint has no <limit>")
        return None
    lower, upper, effort, velocity = (
        read.optional_number(found, word, label) for word in ("lower", "upper", "effort", "velocity")
    )
    if lower is not None and upper is not None and lower > upper:
        read.remark(
            found, f"{label}: the lower limit {float(lower):g} is above the upper one {float(upper):g}"
        )
    return Limit(lower, upper, effort, velocity)


def _mimic(read: Attributes, node: XmlNode, label: str, kind: str) -> Mimic | None:
    found = read.only(node, "mimic", label)
    if found is None:
        return None
    leader = read.name(found, label, "joint")
    mimic = Mimic(leader, read.number(found, "multiplier", label, 1), read.number(found, "offset", label, 0))
    if kind not in SINGLE:
        read.remark(found, f"{label}: <mimic> of a {kind} joint is ignored")
        return None
    return mimic
