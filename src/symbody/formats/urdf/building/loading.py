"""`load_urdf`: a robot in URDF as a model; and what closes its loops, in words of the model file."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from symbody.arguments import checked_arguments, named_after
from symbody.errors import FormatError, ModelError, Problem, nearest
from symbody.formats.native import read_elements, read_parameters
from symbody.formats.places import Locate, Path, line_locator, relocate
from symbody.formats.reading import parse_toml, read_text
from symbody.formats.schema import check_structure
from symbody.formats.urdf.building.bodies import BodyPlan, rotation
from symbody.formats.urdf.building.conversion import Parts, convert_robot
from symbody.formats.urdf.file.placement import FramePlacement, numeral
from symbody.formats.urdf.file.robot import Robot
from symbody.formats.urdf.file.robot_reading import robot_from_text
from symbody.model.body import GROUND_FRAMES, Body
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.element import Element
from symbody.model.frame import Frame
from symbody.model.frame_index import element_labels
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.model import KINDS, Model
from symbody.model.naming import GROUND

_ROBOT: Final = "robot"


@named_after(1)
@checked_arguments
def load_urdf(
    path: str | os.PathLike[str],
    floating_base: bool = False,
    symbolic: Collection[str] = (),
    gravity: Iterable[Value] = (0, 0, -9.81),
    snap_angles: float = 0,
    loops: str | os.PathLike[str] | None = None,
    limits: Mapping[str, object] | None = None,
) -> Model:
    """Return the model of a robot in a URDF file.

    Links held together by fixed joints are one body, named after the first, with a frame for each link.
    Coordinates are named after the joints; each joint that moves, except those that follow others and those
    that float, has the input ``tau_<joint>``, its effort. What was assumed, made exact or ignored is in
    `Model.notes`. Visuals are shapes of the bodies; collision shapes are left out.

    Parameters
    ----------
    path : str or path
        The file.
    floating_base : bool
        Whether the root link moves freely, with coordinates base_x, base_y, base_z, base_qw .. base_qz and
        speeds base_vx .. base_vz, base_wx .. base_wz along axes of the base; otherwise it is the ground.
    symbolic : collection of str
        Links that stay bodies of their own, whose mass, centre and inertia are the parameters ``<link>_m``,
        ``_cx``, ``_cy``, ``_cz``, ``_Ixx``, ``_Iyy``, ``_Izz``, ``_Ixy``, ``_Ixz``, ``_Iyz`` in axes
        of the link; their values are the file's.
    gravity : (3,) number or formula
        Acceleration of free fall in axes of the ground [m/s^2].
    snap_angles : float
        Angles this near to a multiple of pi/12 are taken as that [rad]; nearer than 2e-11 they always are.
    loops : str or path, optional
        A TOML file of joints, constraints and springs in the syntax of the model file, between links.
    limits : mapping, optional
        Arguments of `Limits` besides low and high, such as ``{"rigid": True}``: all revolute and prismatic
        joints that follow no other have the limits of the file. By default they move beyond them.

    Returns
    -------
    Model
        The robot; what was assumed is in its ``notes``.

    Raises
    ------
    FormatError
        If a file cannot be read, is not XML, or has elements and numbers that do not fit.
    ModelError
        If links and joints form no tree, or the mechanism contradicts itself.
    UsageError
        If an argument names a link that is not there, or the base would float twice.

    Notes
    -----
    The meaning of elements and attributes is that of https://wiki.ros.org/urdf/XML.

    Examples
    --------
    >>> import symbody as sb
    >>> robot = sb.load_urdf("ur5.urdf", floating_base=False)  # doctest: +SKIP
    >>> eqs = sb.form_equations(robot)  # doctest: +SKIP
    """
    text = read_text(path)
    return model_from_urdf(
        text, os.fsdecode(path), floating_base, symbolic, gravity, snap_angles, loops, limits
    )


def model_from_urdf(
    text: str,
    where: str = "robot",
    floating_base: bool = False,
    symbolic: Collection[str] = (),
    gravity: Iterable[Value] = (0, 0, -9.81),
    snap_angles: float = 0,
    loops: str | os.PathLike[str] | None = None,
    limits: Mapping[str, object] | None = None,
) -> Model:
    """Return the model of a URDF text, which messages call `where`; faults as of `load_urdf`."""
    robot = robot_from_text(text, where, snap_angles)
    named = [symbolic] if isinstance(symbolic, str) else list(symbolic)
    parts = convert_robot(robot, floating_base, named, limits)
    extra = NO_LOOPS if loops is None else read_loops(loops, parts)
    elements = [*extra.with_frames(parts.elements), *extra.elements]
    try:
        return Model(
            robot.name,
            elements,
            gravity=gravity,
            parameters={**parts.parameters, **extra.parameters},
            inputs=(*parts.inputs, *extra.inputs),
            initial=extra.initial,
            ground={**parts.ground, **extra.ground_frames},
            notes=parts.notes,
            ground_shapes=parts.ground_shapes,
        )
    except ModelError as error:
        raise ModelError(*_add_lines(error.problems, robot, parts, elements, extra)) from None


def _add_lines(
    problems: Iterable[Problem], robot: Robot, parts: Parts, elements: Sequence[Element], extra: Loops
) -> list[Problem]:
    """Return problems of the model with lines of the robot's file, or of the loops."""
    labels = element_labels(elements)
    added = len(elements) - len(extra.elements)
    bases: dict[str, Path] = {"model": ()}
    for k, label in labels.items():
        bases[label] = extra.paths[k - added] if k >= added and extra.paths else (_ROBOT, label)

    def locate(path: Path) -> str:
        if path and path[0] != _ROBOT:
            return extra.locate(path)
        line = parts.lines.get(str(path[1])) if path else None
        return robot.where if line is None else f"{robot.where}:{line}"

    return relocate(problems, bases, locate)


_ADDRESSES: Final = ("on", "reaction_on", "resolved_in")
_KINDS: Final = tuple(kind for kind in KINDS if kind != "body")


@dataclass(frozen=True, slots=True)
class Loops:
    """What a file adds to a robot.

    Attributes
    ----------
    frames : mapping of body to frames
        Points on links; "ground" is the fixed one.
    paths : tuple of Path
        Where each element stands in the file.
    """

    elements: tuple[Element, ...] = ()
    frames: Mapping[str, Mapping[str, Frame]] = field(default_factory=dict)
    parameters: Mapping[str, Value | None] = field(default_factory=dict)
    inputs: tuple[str, ...] = ()
    initial: Mapping[str, Value] = field(default_factory=dict)
    paths: tuple[Path, ...] = ()
    locate: Locate = lambda path: ""

    @property
    def ground_frames(self) -> Mapping[str, Frame]:
        """Frames fixed on the ground."""
        return self.frames.get(GROUND, {})

    def with_frames(self, elements: Iterable[Element]) -> list[Element]:
        """Return elements of the robot, the bodies with the points on them."""
        return [
            replace(element, frames=FrozenMapping({**element.frames, **self.frames[element.name]}))
            if isinstance(element, Body) and element.name in self.frames
            else element
            for element in elements
        ]


NO_LOOPS: Final = Loops()


def read_loops(path: str | os.PathLike[str], parts: Parts) -> Loops:
    """Return what a file adds to a robot; faults have its lines."""
    where = os.fsdecode(path)
    text = read_text(path)
    data = parse_toml(text, where)
    locate = line_locator(text, where)
    content = check_structure({"name": "loops", **data}, locate)
    problems = [
        Problem("urdf.loops_key", locate((key,)), f"{key!r} is not allowed in a loops file",
                "it is defined by the robot's file and the call", f"delete {key}")
        for key in ("gravity", "layout")
        if key in data
    ]  # fmt: skip
    points = _LoopPoints(parts, locate, problems)
    points.read_bodies(content.get("body", []))
    arguments = Arguments("model")
    frames = content.get("ground", {}).get("frames", {})
    ground: Any = GROUND_FRAMES.from_file(frames, arguments, "ground.frames", "")
    problems += relocate(arguments.problems, {"model": ()}, locate)
    points.frames.setdefault(GROUND, {}).update(ground)
    elements, faults = read_elements(content, _KINDS, locate, "", points.translate_addresses)
    problems += faults
    if problems:
        raise FormatError(*problems)
    return Loops(
        tuple(element for _, element in elements), points.frames, read_parameters(content),
        tuple(content.get("inputs", ())), content.get("initial", {}), tuple(path for path, _ in elements),
        locate,
    )  # fmt: skip


class _LoopPoints:
    """Points on links, and what addresses mean; made for one file."""

    __slots__ = ("_known", "_locate", "_parts", "_problems", "frames")

    def __init__(self, parts: Parts, locate: Locate, problems: list[Problem]) -> None:
        self._parts = parts
        self._locate = locate
        self._problems = problems
        self._known: dict[tuple[str, str], str] = {}
        self.frames: dict[str, dict[str, Frame]] = {}

    def read_bodies(self, entries: Sequence[Mapping[str, Any]]) -> None:
        """Take the frames of links; an entry holds nothing else."""
        for k, entry in enumerate(entries):
            link = entry["name"]
            place = f"{self._locate(('body', k))}, body {link}"
            extra = sorted(set(entry) - {"name", "frames"})
            if link not in self._parts.homes:
                cure = nearest(link, self._parts.homes)
                what = f"there is no link {link!r}"
                self._problems.append(Problem("urdf.unknown_link", place, what, "", cure))
            elif extra:
                what = f"{', '.join(extra)} of a link cannot be given here"
                why = "the robot's file defines it"
                self._problems.append(Problem("urdf.loops_key", place, what, why, "give frames only"))
            else:
                for name, given in entry.get("frames", {}).items():
                    self._add(link, name, given, place)

    def translate_addresses(self, entry: Mapping[str, Any]) -> dict[str, Any]:
        """Return the table of an element with its addresses in words of the model."""
        changed = dict(entry)
        if "between" in entry:
            changed["between"] = [self._address(text) for text in entry["between"]]
        for key in _ADDRESSES:
            if key in entry:
                changed[key] = self._address(entry[key])
        return changed

    def _address(self, text: str) -> str:
        link, _, point = (part.strip() for part in text.partition("."))
        if link not in self._parts.links:
            return text
        own = self._parts.links[link]
        return f"{own.body}.{self._known.get((link, point), point)}" if point else own.full_name

    def _add(self, link: str, name: str, given: Mapping[str, Any], place: str) -> None:
        plan, home = self._parts.homes[link]
        body = self._parts.links[link].body
        frames = self.frames.setdefault(body, {})
        own = name if name not in frames else f"{link} {name}"
        self._known[(link, name)] = own
        if given.get("matrix") is not None and home.turns:
            what = f"a matrix cannot be given on link {link}"
            why = "its body is rotated relative to it"
            fix = "give rotations instead: rotate = [..]"
            self._problems.append(Problem("urdf.loops_matrix", f"{place}, frames.{name}", what, why, fix))
            return
        try:
            frames[own] = Frame(
                at=_on_body(plan, home, given.get("at", (0, 0, 0))),
                rotate=[*rotation(home), *given.get("rotate", ())],
                matrix=given.get("matrix"),
            )
        except ModelError as error:
            self._problems += [replace(p, where=f"{place}, frames.{name}") for p in error.problems]


def _on_body(plan: BodyPlan, home: FramePlacement, at: Sequence[Value]) -> list[str]:
    """Return a point of a link from the centre of mass of its body, as formulas."""
    found = []
    for row, own, c in zip(home.rows, home.at, plan.centre, strict=True):
        terms = [f"({numeral(r)})*({x})" if r != 1 else f"({x})" for r, x in zip(row, at, strict=True) if r]
        terms += [numeral(own)] if own else []
        less = c if isinstance(c, str) else f"({numeral(c)})"
        found.append(" + ".join(terms or ["0"]) + (f" - {less}" if c else ""))
    return found
