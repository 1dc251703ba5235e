"""What closes loops: joints, constraints and springs in words of the model file, between links."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from symbody.errors import FormatError, ModelError, Problem, nearest
from symbody.expr.graph import Constant
from symbody.formats.places import Locate, Path, line_locator, relocate
from symbody.formats.reading import parse_toml, read_text
from symbody.formats.schema import check_structure
from symbody.formats.urdf.building.bodies import BodyPlan, rotation
from symbody.formats.urdf.building.conversion import Parts
from symbody.formats.urdf.file.placement import FramePlacement, numeral
from symbody.model.body import GROUND_FRAMES, Body
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.element import Element
from symbody.model.frame import Frame
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.model import KINDS
from symbody.model.naming import GROUND
from symbody.model.registry import read_element

_ADDRESSES: Final = ("on", "reaction_on", "resolved_in")
_KINDS: Final = tuple(kind for kind in KINDS if kind != "body")


def _nowhere(path: Path) -> str:
    return ""


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
    locate: Locate = _nowhere

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
    elements: list[Element] = []
    paths: list[Path] = []
    for kind in _KINDS:
        for k, entry in enumerate(content.get(kind, [])):
            try:
                elements.append(read_element(kind, points.translate_addresses(entry)))
                paths.append((kind, k))
            except ModelError as error:
                problems += relocate(error.problems, {f"{kind} {entry['name']}": (kind, k)}, locate)
    if problems:
        raise FormatError(*problems)
    parameters = {name: None if v == "" else v for name, v in content.get("parameters", {}).items()}
    return Loops(
        tuple(elements), points.frames, parameters, tuple(content.get("inputs", ())),
        content.get("initial", {}), tuple(paths), locate,
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


def _on_body(plan: BodyPlan | None, home: FramePlacement, at: Sequence[Value]) -> list[str]:
    """Return a point of a link from the centre of mass of its body, as formulas."""
    centre: tuple[Constant | str, ...] = (0, 0, 0) if plan is None else plan.centre
    found = []
    for row, own, c in zip(home.rows, home.at, centre, strict=True):
        terms = [f"({numeral(r)})*({x})" if r != 1 else f"({x})" for r, x in zip(row, at, strict=True) if r]
        terms += [numeral(own)] if own else []
        less = c if isinstance(c, str) else f"({numeral(c)})"
        found.append(" + ".join(terms or ["0"]) + (f" - {less}" if c else ""))
    return found
