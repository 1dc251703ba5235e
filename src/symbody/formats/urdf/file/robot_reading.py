"""A URDF file to a `Robot`: its whole content, and all its faults with their lines."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterable
from types import MappingProxyType
from typing import Final

from symbody.errors import FormatError, ModelError, Problem, UsageError
from symbody.formats.reading import read_text
from symbody.formats.urdf.file.attributes import Attributes
from symbody.formats.urdf.file.joints import read_joint
from symbody.formats.urdf.file.links import read_colors, read_link
from symbody.formats.urdf.file.robot import Robot
from symbody.formats.urdf.file.structure import find_root, tree_problems
from symbody.formats.urdf.file.xml_tree import XmlNode, parse_xml

_READ: Final = ("link", "joint", "material")
_IGNORED: Final = MappingProxyType(
    {
        "transmission": "has no effect on the motion of the joints",
        "gazebo": "is for another simulator",
        "sensor": "has no effect on the motion",
    }
)
_SNAP_LIMIT: Final = 0.1


def read_urdf(path: str | os.PathLike[str], snap_angles: float = 0) -> Robot:
    """Return the content of a URDF file, shapes and limits included.

    Raises
    ------
    FormatError
        If the file cannot be read, is not XML, or has elements and numbers that do not fit.
    ModelError
        If its links and joints form no tree. Both list all problems, with their lines.
    """
    return robot_from_text(read_text(path), os.fsdecode(path), snap_angles)


def robot_from_text(text: str, where: str = "robot", snap_angles: float = 0) -> Robot:
    """Return the content of a URDF text; messages call it `where`.

    Raises
    ------
    FormatError, ModelError
        See `read_urdf`.
    """
    if not (math.isfinite(snap_angles) and 0 <= snap_angles <= _SNAP_LIMIT):
        raise UsageError(
            Problem("urdf.snap_angles", "snap_angles", f"{snap_angles} rad is not a tolerance for angles",
                    "multiples of pi/12 are 0.26 rad apart", f"give a number from 0 to {_SNAP_LIMIT}")
        )  # fmt: skip
    read = Attributes(where, snap_angles)
    root = parse_xml(text, where)
    if root.tag != "robot":
        what = f"the file is not URDF: it begins with <{root.tag}>"
        why = _other_format(root.tag)
        fix = 'give a file that begins with <robot name="..">'
        raise FormatError(Problem("urdf.not_a_robot", f"{where}:{root.line}", what, why, fix))
    _refuse_templates(read, root)
    name = read.name(root, "")
    colors = read_colors(read, root)
    links = [read_link(read, node, colors) for node in root.all("link")]
    joints = [read_joint(read, node) for node in root.all("joint")]
    if not links:
        read.refuse("no_links", root, "", "the robot has no <link>", "", 'add <link name=".."/>')
    if read.problems:
        raise FormatError(*read.problems)
    problems = tree_problems(where, links, joints)
    if problems:
        raise ModelError(*problems)
    return Robot(
        name,
        where,
        find_root(links, joints),
        MappingProxyType({link.name: link for link in links}),
        MappingProxyType({joint.name: joint for joint in joints}),
        (*read.notes(), *_ignored_notes(root)),
    )


def _other_format(tag: str) -> str:
    known = {"sdf": "this is SDF", "mujoco": "this is MuJoCo's format", "COLLADA": "this is a mesh"}
    return known.get(tag, "")


def _refuse_templates(read: Attributes, root: XmlNode) -> None:
    """Refuse macros of xacro: links and joints would be missing."""
    for node in root.children:
        if node.tag.startswith("xacro:"):
            read.refuse("template", node, "", f"<{node.tag}> is an instruction of xacro",
                        "the file is a template: its macros are not expanded",
                        "run xacro first: xacro robot.xacro > robot.urdf")  # fmt: skip
            return


def _ignored_notes(root: XmlNode) -> Iterable[str]:
    """Return a note for each kind of element that is not read."""
    first: dict[str, int] = {}
    count: Counter[str] = Counter()
    for node in root.children:
        if node.tag not in _READ:
            first.setdefault(node.tag, node.line)
            count[node.tag] += 1
    for tag, line in first.items():
        reason = _IGNORED.get(tag, "is not part of URDF")
        yield f"line {line}: <{tag}> {reason} and is ignored" + (
            f" ({count[tag]} times)" if count[tag] > 1 else ""
        )
