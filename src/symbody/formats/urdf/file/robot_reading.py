"""A URDF file to a `Robot`: its whole content, and all its faults with their lines."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

from symbody.errors import FormatError, ModelError, Problem, UsageError, nearest
from symbody.expr.graph import Constant
from symbody.formats.reading import read_text
from symbody.formats.urdf.file.placement import Numbers
from symbody.formats.urdf.file.robot import Limit, Mimic, Robot, Shape, UrdfJoint, UrdfLink
from symbody.formats.urdf.file.structure import find_root, tree_problems
from symbody.formats.urdf.file.xml_tree import EXACT, Attributes, XmlNode, parse_xml

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
    """Return the content of a URDF text, which messages call `where`; faults as of `read_urdf`."""
    if not (math.isfinite(snap_angles) and 0 <= snap_angles <= _SNAP_LIMIT):
        raise UsageError(
            Problem("urdf.snap_angles", "snap_angles", f"{snap_angles} rad is not a tolerance for angles",
                    "multiples of pi/12 are 0.26 rad apart", f"give a number from 0 to {_SNAP_LIMIT}")
        )  # fmt: skip
    read = Attributes(where, snap_angles)
    root = parse_xml(text, where)
    if root.tag != "robot":
        what = f"the file is not URDF: it begins with <{root.tag}>"
        known = {"sdf": "this is SDF", "mujoco": "this is MuJoCo's format", "COLLADA": "this is a mesh"}
        why = known.get(root.tag, "")
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


Color = tuple[Constant, ...]

_ENTRIES: Final = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_KINDS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "box": ("size",),
        "cylinder": ("radius", "length"),
        "capsule": ("radius", "length"),
        "sphere": ("radius",),
    }
)


def read_link(read: Attributes, node: XmlNode, colors: Mapping[str, Color]) -> UrdfLink:
    """Return a link; `colors` are those of the robot's materials."""
    name = read.name(node, "")
    label = f"link {name}"
    visuals = tuple(shape for part in node.all("visual") for shape in _shapes(read, part, label, colors))
    collisions = tuple(shape for part in node.all("collision") for shape in _shapes(read, part, label, {}))
    inertial = read.only(node, "inertial", label)
    if inertial is None:
        return UrdfLink(name, node.line, visuals=visuals, collisions=collisions)
    mass = read.only(inertial, "mass", label, needed=True)
    tensor = read.only(inertial, "inertia", label, needed=True)
    value = 0 if mass is None else read.number(mass, "value", label)
    if value < 0 and mass is not None:
        read.refuse("negative_mass", mass, label, f"the mass is {float(value):g} kg", "a sign is wrong",
                    "give a positive mass, or 0 for a massless link")  # fmt: skip
    entries: tuple[Constant, ...] = (0,) * 6
    if tensor is not None:
        entries = tuple(read.number(tensor, entry, label) for entry in _ENTRIES)
    return UrdfLink(
        name, node.line, value, read.origin(inertial, label), entries, True, visuals, collisions
    )  # fmt: skip


def read_colors(read: Attributes, robot: XmlNode) -> dict[str, Color]:
    """Return the colours of the materials that have one, by name."""
    colors: dict[str, Color] = {}
    for material in (node for node in robot.walk() if node.tag == "material"):
        color = material.all("color")
        name = material.attributes.get("name", "")
        if color and name:
            colors.setdefault(name, read.numbers(color[0], "rgba", f"material {name}", (0, 0, 0, 1)))
    return colors


def _shapes(read: Attributes, node: XmlNode, label: str, colors: Mapping[str, Color]) -> list[Shape]:
    """Return the shape of a visual or collision, or none if its kind is unknown."""
    geometry = node.all("geometry")
    if not geometry or not geometry[0].children:
        read.remark(node, f"{label}: <{node.tag}> without geometry is ignored")
        return []
    form = geometry[0].children[0]
    origin = read.origin(node, label)
    material = node.all("material")
    color = colors.get(material[0].attributes.get("name", "")) if material else None
    name = node.attributes.get("name", "")
    if form.tag == "mesh":
        mesh = read.name(form, label, "filename")
        return [Shape(name, origin, "mesh", read.numbers(form, "scale", label, (1, 1, 1)), mesh, color)]
    if form.tag not in _KINDS:
        read.remark(form, f"{label}: the shape <{form.tag}> is not known and ignored")
        return []
    sizes: tuple[Constant, ...] = ()
    for word in _KINDS[form.tag]:
        sizes += read.triple(form, word, label) if word == "size" else (read.number(form, word, label),)
    return [Shape(name, origin, form.tag, sizes, "", color)]


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
