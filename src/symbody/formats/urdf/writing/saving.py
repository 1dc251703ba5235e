"""`save_urdf`: a model that is a tree of bodies written as URDF."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final
from xml.sax.saxutils import quoteattr

from symbody.arguments import checked_arguments
from symbody.errors import FormatError, Problem
from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.formats.urdf.file.placement import (
    ONE,
    Numbers,
    Rows,
    apply,
    numeral,
    product,
    total,
    transpose,
)
from symbody.formats.writing import write_text
from symbody.model.body import Body
from symbody.model.constraints import Gear, RackPinion
from symbody.model.declarations.arguments import Value
from symbody.model.element import FrameRef
from symbody.model.frame import Frame, rotation_angles
from symbody.model.joint import Joint
from symbody.model.joints import Free, Planar, Prismatic, Revolute, Weld
from symbody.model.model import Model, resolve_parameters
from symbody.model.naming import GROUND
from symbody.model.numbers import as_float, formula_value
from symbody.model.shapes import BodyShape, Box, Cone, Mesh, Sphere
from symbody.model.shapes.shape import hex_color

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
    """Return the URDF text of a model; paths of meshes lead from `folder`; faults as of `save_urdf`."""
    values = Values(resolve_parameters(model, parameters))
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
    if isinstance(shape, Mesh):
        scale = " ".join(values.text(factor) for factor in shape.scale)
        return f'<mesh filename={quoteattr(shape.path_from(folder))} scale="{scale}"/>'
    sizes = [values.text(formula) for _, formula in shape.lengths]
    if isinstance(shape, Box):
        return f'<box size="{" ".join(sizes)}"/>'
    if isinstance(shape, Sphere):
        return f'<sphere radius="{sizes[0]}"/>'
    return f'<{type(shape).__name__.lower()} radius="{sizes[0]}" length="{sizes[1]}"/>'


@dataclass(frozen=True, slots=True)
class UrdfPose:
    """A frame in another, by its rotation matrix."""

    at: Numbers = (0, 0, 0)
    rows: Rows = ONE

    def then(self, inner: UrdfPose) -> UrdfPose:
        """Return the pose of a frame that stands in this one."""
        x, y, z = (total(pair) for pair in zip(self.at, apply(self.rows, inner.at), strict=True))
        return UrdfPose((x, y, z), product(self.rows, inner.rows))

    def inverse(self) -> UrdfPose:
        """Return the pose of the other frame in this one."""
        back = transpose(self.rows)
        x, y, z = apply(back, self.at)
        return UrdfPose((-x, -y, -z), back)

    def origin(self) -> str:
        """Return the element of URDF."""
        yaw, pitch, roll = rotation_angles([[float(x) for x in row] for row in self.rows])
        words = {"xyz": self.at, "rpy": (roll, pitch, yaw)}
        inside = "".join(
            f' {key}="{" ".join(map(numeral, value))}"' for key, value in words.items() if any(value)
        )
        return f"<origin{inside}/>"


def frame_pose(frame: Frame, values: Values) -> UrdfPose:
    """Return where a frame stands on its body."""
    rows = ONE
    for turn in frame.turns():
        rows = product(rows, _rotation_rows([values.number(x) for x in turn.axis], values.number(turn.angle)))
    x, y, z = map(values.number, frame.at)
    return UrdfPose((x, y, z), rows)


def _rotation_rows(axis: Sequence[float], angle: float) -> Rows:
    """Return the rotation matrix about a unit vector (Rodrigues), exact for right angles about main axes."""
    c, s = math.cos(angle), math.sin(angle)
    quarters = round(angle * 2 / math.pi)
    if abs(angle - quarters * math.pi / 2) < 4e-16 * max(1.0, abs(angle)):
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
    x, y, z = axis
    d = 1 - c
    return (
        (c + x * x * d, x * y * d - z * s, x * z * d + y * s),
        (x * y * d + z * s, c + y * y * d, y * z * d - x * s),
        (x * z * d - y * s, y * z * d + x * s, c + z * z * d),
    )


@dataclass(frozen=True, slots=True)
class Values:
    """The values of the parameters of a model."""

    known: Mapping[str, Constant]

    def number(self, formula: Formula) -> float:
        """Return the value of a formula in parameters."""
        value = formula_value(formula, self.known)
        if value is None:
            raise AssertionError(f"{formula} has names that are not parameters")
        return as_float(value)

    def is_known(self, formula: Formula) -> bool:
        """Return whether a formula contains parameters alone."""
        return formula_value(formula, self.known) is not None

    def text(self, formula: Formula) -> str:
        """Return the value of a formula as text."""
        return numeral(self.number(formula))


_KINDS: Final[Mapping[type[Joint], str]] = MappingProxyType(
    {Revolute: "continuous", Prismatic: "prismatic", Weld: "fixed", Planar: "planar", Free: "floating"}
)
_AXES: Final = MappingProxyType({"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"})
# URDF requires limits of a slide; these limit nothing.
_LIMIT: Final = '<limit lower="-1e6" upper="1e6" effort="1e9" velocity="1e6"/>'


@dataclass(frozen=True, slots=True)
class Hung:
    """A joint as URDF describes it.

    Attributes
    ----------
    end : FrameRef
        The frame of the child that is its link's frame.
    details : tuple of str
        What stands in the joint beside its ends and origin.
    """

    name: str
    kind: str
    start: FrameRef
    end: FrameRef
    details: tuple[str, ...]

    @property
    def body(self) -> str:
        """The child."""
        return self.end.body


def hang_joints(model: Model, values: Values) -> tuple[list[Hung], list[Problem]]:
    """Return the joints of a tree, and what URDF has no word for."""
    problems: list[Problem] = []
    mimics = _mimics(model, values, problems)
    written_joints = []
    carried: dict[str, str] = {}
    for joint in (*model.joints, *model.free_joints):
        problems += _joint_problems(joint, values)
        if joint.end.body in carried or joint.end.body == GROUND:
            other = carried.get(joint.end.body)
            what = (
                f"{joint.end.body} is the end of joint {other} too" if other else "its end is on the ground"
            )
            fix = "swap start and end of one joint, or cut the loop"
            problems.append(_refusal(joint.name, what, "URDF describes trees, outward from the ground", fix))
        carried[joint.end.body] = joint.name
        if type(joint) in _KINDS:
            details = tuple(_details(joint, values, mimics.get(joint.name)))
            written_joints.append(Hung(joint.name, _KINDS[type(joint)], joint.start, joint.end, details))
    return written_joints, problems


def unsupported_problems(model: Model) -> list[Problem]:
    """Return a problem for each element that is neither a body, a joint, nor a joint that follows another."""
    return [
        Problem("urdf.cannot_say", f"{element.kind} {element.name}",
                f"URDF cannot describe a {element.kind} like this", "it has links and joints only",
                "use save_model, which writes everything, or remove the element")
        for element in model.elements
        if not isinstance(element, Body | Joint | Gear | RackPinion)
        or (isinstance(element, Gear) and element.backlash is not None)
    ]  # fmt: skip


def _joint_problems(joint: Joint, values: Values) -> Iterator[Problem]:
    if type(joint) not in _KINDS:
        known = ", ".join(kind.__name__ for kind in _KINDS)
        kind = type(joint).__name__
        yield _refusal(joint.name, f"URDF has no joint {kind}", f"it has {known}", "build it from those")
    if isinstance(joint, Free) and (joint.angles != "quaternion" or joint.speeds != "twist"):
        yield _refusal(joint.name, "its coordinates or speeds differ from those of a floating joint",
                       "", 'write angles="quaternion", speeds="twist"')  # fmt: skip
    if joint.motions:
        yield _refusal(
            joint.name, "its motion is prescribed", "URDF cannot describe motions", "remove motion"
        )
    if joint.armature:
        yield _refusal(joint.name, "it has a rotor", "URDF cannot describe its inertia", "remove armature")
    yield from _drive_problems(joint, values)
    if joint.limits:
        why = "its limits do not say what happens there"
        yield _refusal(joint.name, "it has limits", why, "remove limits")
    friction = joint.friction
    if friction is not None and (friction.force is None or friction.is_smooth or friction.static is not None):
        fix = "write friction = { force = .. }"
        yield _refusal(joint.name, "its friction is not a constant force", "", fix)


def _drive_problems(joint: Joint, values: Values) -> Iterator[Problem]:
    for path, _, drive in joint.drives_with_paths():
        applied = drive.applied.names
        if not (drive.applied.constant() == 0 or (len(applied) == 1 and drive.applied.text == applied[0])):
            yield _refusal(joint.name, f"the effort {drive.applied} is a formula",
                           "in URDF every joint has its own input",
                           f"use an input for {path}.applied")  # fmt: skip
        if drive.reads_coordinate or not (isinstance(drive.law, Formula) and drive.law.constant() == 0):
            yield _refusal(
                joint.name, "it has a spring", "URDF cannot describe it", "remove stiffness and law"
            )
        if not values.is_known(drive.damping) or (
            drive.damping.constant() != 0 and len(joint.coordinates) > 1
        ):
            yield _refusal(joint.name, f"the damping {drive.damping} cannot be written",
                           "URDF has numbers, for joints with one coordinate",
                           "remove damping")  # fmt: skip


def _details(joint: Joint, values: Values, mimic: str | None) -> Iterator[str]:
    for axis in joint.directions.values():
        text = _AXES[axis] if isinstance(axis, str) else " ".join(map(values.text, axis))
        yield f'<axis xyz="{text}"/>'
    if isinstance(joint, Planar):
        yield f'<axis xyz="{_AXES[joint.axis]}"/>'
    if isinstance(joint, Prismatic):
        yield _LIMIT
    damping = [drive.damping for drive in joint.drives.values() if drive.damping.constant() != 0]
    words = [f'damping="{values.text(formula)}"' for formula in damping if values.is_known(formula)]
    force = joint.friction.force if joint.friction is not None else None
    if force is not None and values.is_known(force):
        words.append(f'friction="{values.text(force)}"')
    if words:
        yield f"<dynamics {' '.join(words)}/>"
    if mimic is not None:
        yield mimic


def _mimics(model: Model, values: Values, problems: list[Problem]) -> dict[str, str]:
    """Return the <mimic> of each joint that is the first of a coupling."""
    homes = {name: joint.name for joint in model.joints for name in joint.coordinates}
    mimics: dict[str, str] = {}
    for coupling in model.constraints:
        if not isinstance(coupling, Gear | RackPinion):
            continue
        follower, leader = (homes.get(name) for name in coupling.coupled)
        if follower is None or leader is None or follower in mimics or not values.is_known(coupling.offset):
            what = "it cannot be expressed as one joint that follows another"
            why = "a joint follows one other, with constant multiplier and offset"
            fix = "write it so that each joint is the first of one coupling"
            problems.append(Problem("urdf.cannot_say", f"constraint {coupling.name}", what, why, fix))
            continue
        factor, offset = numeral(-values.number(coupling.factors[1])), values.text(coupling.offset)
        mimics[follower] = f'<mimic joint={quoteattr(leader)} multiplier="{factor}" offset="{offset}"/>'
    return mimics


def _refusal(joint: str, what: str, why: str, fix: str) -> Problem:
    return Problem("urdf.cannot_say", f"joint {joint}", what, why, fix)
