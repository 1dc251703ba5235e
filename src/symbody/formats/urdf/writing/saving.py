"""`save_urdf`: a model that is a tree of bodies written as URDF."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from xml.sax.saxutils import quoteattr

from symbody.arguments import checked_arguments
from symbody.errors import FormatError
from symbody.formats.urdf.writing.poses import UrdfPose, frame_pose
from symbody.formats.urdf.writing.tree_joints import Hung, hang_joints, unsupported_problems
from symbody.formats.urdf.writing.values import Values
from symbody.formats.writing import write_text
from symbody.model.body import Body
from symbody.model.declarations.arguments import Value
from symbody.model.element import FrameRef
from symbody.model.model import Model
from symbody.model.shapes import BodyShape, Box, Cone, Mesh, Sphere
from symbody.model.shapes.colors import hex_color

_GROUND = "world"


@checked_arguments
def save_urdf(
    model: Model,
    path: str | os.PathLike[str],
    parameters: Mapping[str, Value] = MappingProxyType({}),
) -> None:
    """Write a model to a URDF file.

    The ground becomes the link ``world``; each frame of a body becomes a link fixed on it. URDF names
    coordinates after joints and has no element for gravity, which its readers choose. Shapes become visuals,
    cones excepted, which URDF does not have.

    Parameters
    ----------
    model : Model
        A tree of joints.
    path : str or path
        The file, as ``"robot.urdf"``.
    parameters : mapping of name to number or formula
        Take the place of the model's values.

    Raises
    ------
    FormatError
        If the mechanism is not a tree, has parts that URDF lacks, all named, or the file cannot be written.
    ModelError
        If parameters have no value.

    Examples
    --------
    >>> import tempfile, pathlib, symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "cart.urdf")
    ...     sb.save_urdf(sb.Model("cart", [rail]), path)
    ...     "prismatic" in path.read_text()
    True
    """
    folder = os.path.dirname(os.path.abspath(os.fsdecode(path)))
    write_text(path, model_to_urdf(model, parameters, folder))


def model_to_urdf(
    model: Model, parameters: Mapping[str, Value] = MappingProxyType({}), folder: str = ""
) -> str:
    """Return the URDF text of a model; paths of meshes lead from `folder`.

    Raises
    ------
    FormatError, ModelError
        See `save_urdf`.
    """
    values = Values.from_model(model, parameters)
    joints, problems = hang_joints(model, values)
    problems += unsupported_problems(model)
    if problems:
        raise FormatError(*problems)
    homes = {joint.body: joint.end for joint in joints}
    links = _Links(model, values, homes)
    lines = ['<?xml version="1.0"?>', f"<robot name={quoteattr(model.name)}>"]
    lines += links.lines(folder)
    for joint in joints:
        lines += _joint_lines(links, joint)
    return "\n".join([*lines, "</robot>", ""])


class _Links:
    """Where the link of each body is, and what it is called; made for one text."""

    __slots__ = ("_homes", "_model", "_values", "names")

    def __init__(self, model: Model, values: Values, homes: Mapping[str, FrameRef]) -> None:
        self._model = model
        self._values = values
        self._homes = homes
        taken = {body.name for body in model.bodies}
        self.names = {body: body for body in taken}
        self.names["ground"] = _free_name(_GROUND, taken)

    def place(self, address: FrameRef) -> UrdfPose:
        """Return a frame of a body from the frame of its link."""
        home = self._own(self._homes[address.body]) if address.body in self._homes else UrdfPose()
        return home.inverse().then(self._own(address))

    def lines(self, folder: str) -> Iterator[str]:
        """Return the lines of all links, and of the joints that fix frames on them."""
        world = f"  <link name={quoteattr(self.names['ground'])}"
        shown = [
            line for shape in self._model.ground_shapes for line in self._visual("ground", shape, folder)
        ]
        yield from [f"{world}>", *shown, "  </link>"] if shown else [f"{world}/>"]
        for body in self._model.bodies:
            yield from self._body_lines(body, folder)
        taken = {*self.names.values()}
        frames = [("ground", name) for name in self._model.ground]
        frames += [(body.name, name) for body in self._model.bodies for name in body.frames]
        for body_name, name in frames:
            if name == body_name:  # the link's own frame, as a file that was read has it
                continue
            link = _free_name(name, taken)
            taken.add(link)
            yield f"  <link name={quoteattr(link)}/>"
            pose = self.place(FrameRef(body_name, name))
            yield f'  <joint name={quoteattr(f"{link} fixed")} type="fixed">'
            yield f"    <parent link={quoteattr(self.names[body_name])}/>"
            yield f"    <child link={quoteattr(link)}/>"
            yield f"    {pose.origin()}"
            yield "  </joint>"

    def _own(self, address: FrameRef) -> UrdfPose:
        """Return a frame from the centre of mass of its body."""
        if not address.frame:
            return UrdfPose()
        ground = address.body == "ground"
        frames = self._model.ground if ground else self._model.body(address.body).frames
        return frame_pose(frames[address.frame], self._values)

    def _visual(self, body: str, shape: BodyShape, folder: str) -> Iterator[str]:
        return _visual_lines(shape, self.place(FrameRef(body)), self._values, folder)

    def _body_lines(self, body: Body, folder: str) -> Iterator[str]:
        centre = self.place(FrameRef(body.name))
        mass = self._values.text(body.mass)
        xx, yy, zz = map(self._values.text, body.inertia)
        xy, xz, yz = map(self._values.text, body.products)
        yield f"  <link name={quoteattr(body.name)}>"
        yield "    <inertial>"
        yield f"      {centre.origin()}"
        yield f'      <mass value="{mass}"/>'
        yield f'      <inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>'
        yield "    </inertial>"
        for shape in body.shapes:
            yield from self._visual(body.name, shape, folder)
        yield "  </link>"


def _joint_lines(links: _Links, joint: Hung) -> Iterator[str]:
    yield f'  <joint name={quoteattr(joint.name)} type="{joint.kind}">'
    yield f"    <parent link={quoteattr(links.names[joint.start.body])}/>"
    yield f"    <child link={quoteattr(joint.body)}/>"
    yield f"    {links.place(joint.start).origin()}"
    yield from (f"    {line}" for line in joint.details)
    yield "  </joint>"


def _free_name(name: str, taken: set[str]) -> str:
    found, number = name, 1
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    return found


def _visual_lines(shape: BodyShape, centre: UrdfPose, values: Values, folder: str) -> Iterator[str]:
    """Return the element of a shape; none of a cone, which URDF has no word for.

    Parameters
    ----------
    centre : UrdfPose
        Of the body's centre of mass, from the frame of its link.
    folder : str
        Where the file stands: paths of meshes lead from there.
    """
    if isinstance(shape, Cone):
        return
    yield "    <visual>"
    yield f"      {centre.then(frame_pose(shape.frame, values)).origin()}"
    yield f"      <geometry>{_geometry(shape, values, folder)}</geometry>"
    opacity = values.text(shape.opacity)
    if shape.color or opacity != "1":
        color = hex_color(shape.color) or "#b4b4b4"
        shares = [f"{int(color[k : k + 2], 16) / 255:.6g}" for k in (1, 3, 5)]
        rgba = " ".join([*shares, opacity])
        yield f'      <material name="{color} {opacity}"><color rgba="{rgba}"/></material>'
    yield "    </visual>"


def _geometry(shape: BodyShape, values: Values, folder: str) -> str:
    """Return the form of a shape."""
    if isinstance(shape, Mesh):
        scale = " ".join(values.text(factor) for factor in shape.scale)
        return f'<mesh filename={quoteattr(shape.path_from(folder))} scale="{scale}"/>'
    sizes = [values.text(formula) for _, formula in shape.lengths]
    if isinstance(shape, Box):
        return f'<box size="{" ".join(sizes)}"/>'
    if isinstance(shape, Sphere):
        return f'<sphere radius="{sizes[0]}"/>'
    return f'<{type(shape).__name__.lower()} radius="{sizes[0]}" length="{sizes[1]}"/>'
