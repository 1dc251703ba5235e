"""Links of a URDF file: mass, centre, inertia, and the shapes that are seen or touched."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from symbody.expr.graph import Constant
from symbody.formats.urdf.file.attributes import Attributes
from symbody.formats.urdf.file.robot import Shape, UrdfLink
from symbody.formats.urdf.file.xml_tree import XmlNode

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
