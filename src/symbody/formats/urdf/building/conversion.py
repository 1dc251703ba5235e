"""A `Robot` as a `Model`: lumps become bodies, joints keep their names, links become frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType
from typing import Any, Final

from symbody.errors import Problem, UsageError, nearest
from symbody.expr.graph import Constant
from symbody.expr.language.tokens import MAX_NAME, normalize
from symbody.formats.urdf.building.bodies import (
    GROUND_PLAN,
    BodyPlan,
    Lump,
    lump_links,
    plan_body,
    possible,
    symbol_names,
    visual_shape,
)
from symbody.formats.urdf.file.placement import FramePlacement, Numbers, PlacementAngle, exact_angle, numeral
from symbody.formats.urdf.file.robot import Robot, UrdfJoint, UrdfLink
from symbody.formats.urdf.file.structure import outward
from symbody.model.constraint import ConstraintElement
from symbody.model.constraints import Constraint, Gear, RackPinion
from symbody.model.element import Element, FrameRef
from symbody.model.frame import Frame
from symbody.model.joint import Joint
from symbody.model.joints import Free, Planar, Prismatic, Revolute, Weld
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction
from symbody.model.naming import CENTRE, GROUND, RESERVED_SYMBOLS, make_symbol
from symbody.model.shapes import BodyShape

BASE = "base"

_SHOWN = 6


@dataclass(frozen=True, slots=True)
class Parts:
    """What a model is made of.

    Attributes
    ----------
    links : mapping of link to FrameRef
        The frame of each link.
    homes : mapping of link to (BodyPlan, FramePlacement)
        The body each link is part of, and its frame from that of the first link.
    lines : mapping of label to int
        Of the file, for each element, by "body NAME" or "joint NAME".
    """

    elements: tuple[Element, ...]
    ground: Mapping[str, Frame]
    ground_shapes: Sequence[BodyShape]
    parameters: Mapping[str, str]
    inputs: tuple[str, ...]
    notes: tuple[str, ...]
    links: Mapping[str, FrameRef]
    homes: Mapping[str, tuple[BodyPlan, FramePlacement]]
    lines: Mapping[str, int]


def convert_robot(
    robot: Robot,
    floating_base: bool,
    symbolic: Collection[str],
    limits: Mapping[str, object] | None = None,
) -> Parts:
    """Return the parts of the model of a robot; `limits` is the law of limits, None where they do nothing.

    Raises UsageError if `symbolic` names no link, or the base would float twice.
    """
    _check_symbolic(robot, symbolic)
    lumps, joints = lump_links(robot, set(symbolic))
    _check_base(robot, lumps[0], joints, floating_base)
    draft = _Draft(robot, Naming(), floating_base, limits)
    draft.naming.take(*joint_coordinates("floating", BASE), *joint_speeds("floating", BASE))
    draft.place_links(lumps, set(symbolic))
    draft.name_joints(joints)
    elements = [*draft.bodies(), *draft.joints(), *draft.couplings()]
    notes = (*robot.notes, *draft.naming.notes, *draft.notes, *_heavy(robot, lumps, floating_base))
    lines = {f"joint {draft.names[joint.name]}": joint.line for joint in joints}
    lines |= {f"body {plan.name}": robot.links[lump.root].line for lump, plan in draft.plans}
    return Parts(
        tuple(elements),
        draft.frames.get(GROUND, {}),
        draft.shapes.get(GROUND, ()),
        {name: value for _, plan in draft.plans for name, value in plan.values.items()},
        tuple(name for joint in joints for name in draft.inputs(joint)),
        notes,
        draft.links,
        draft.homes,
        lines,
    )


@dataclass(frozen=True, slots=True)
class _Draft:
    """Names and frames while a model is put together."""

    robot: Robot
    naming: Naming
    floats: bool
    limits: Mapping[str, object] | None
    plans: list[tuple[Lump, BodyPlan]] = field(default_factory=list)
    homes: dict[str, tuple[BodyPlan, FramePlacement]] = field(default_factory=dict)
    links: dict[str, FrameRef] = field(default_factory=dict)
    frames: dict[str, dict[str, Frame]] = field(default_factory=dict)
    shapes: dict[str, list[BodyShape]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    symbols: dict[str, str] = field(default_factory=dict)
    moving: list[Moving] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def place_links(self, lumps: Sequence[Lump], symbolic: Collection[str]) -> None:
        """Give every link its body and its frame."""
        names = {name: self.naming.element(name, "_link", "link") for name in self.robot.links}
        for k, lump in enumerate(lumps):
            plan = GROUND_PLAN
            if k or self.floats:
                symbols = [
                    self.naming.symbol(symbol, "parameter") for symbol in symbol_names(names[lump.root])
                ] if lump.root in symbolic else None  # fmt: skip
                plan = plan_body(self.robot, lump, names[lump.root], symbols)
                self.plans.append((lump, plan))
            elif lump.root in symbolic:
                self.notes.append(f"link {lump.root} is in symbolic= without effect: it is the ground")
            for link, place in lump.places.items():
                self.homes[link] = (plan, place)
                self.links[link] = self._stand(plan, names[link], place)
                self._show(plan, self.robot.links[link], place)

    def name_joints(self, joints: Iterable[UrdfJoint]) -> None:
        """Give every joint its names and frames."""
        for joint in joints:
            name = self.naming.element(joint.name, "_joint", "joint")
            self.names[joint.name] = name
            self.symbols[joint.name] = self.naming.symbol(joint.name, "joint") if joint.moves else ""
        for joint in joints:
            self.moving.append(self._movable_joint(joint))

    def inputs(self, joint: UrdfJoint) -> tuple[str, ...]:
        """Return the efforts of a joint: none where it follows another, floats or is fixed."""
        if joint.mimic is not None or joint.kind in ("floating", "fixed"):
            return ()
        return tuple(f"tau_{name}" for name in joint_coordinates(joint.kind, self.symbols[joint.name]))

    def bodies(self) -> list[Element]:
        """Return the bodies with their frames."""
        return [plan.body(self.frames[plan.name], self.shapes.get(plan.name, ())) for _, plan in self.plans]

    def joints(self) -> list[Joint]:
        """Return the joints of the model."""
        found: list[Joint] = []
        if self.floats:
            name = self.naming.element(BASE, "_joint", "the joint")
            found.append(make_free_joint(name, BASE, FrameRef("ground"), self.links[self.robot.root]))
        return found + [moving.element() for moving in self.moving]

    def couplings(self) -> list[Element]:
        """Return what ties the joints that follow others."""
        found: list[Element] = []
        for moving in self.moving:
            if moving.joint.mimic is None or moving.fixed is not None:
                continue
            leader, factor, offset = _leader_law(moving.joint, self.robot.joints)
            name = self.naming.element(f"{moving.joint.name} mimic", "_2", "the coupling")
            pair = (moving.symbol, self.symbols[leader.name])
            found.append(_follow_leader(name, moving.joint, leader, pair, factor, offset))
        return found

    def _movable_joint(self, joint: UrdfJoint) -> Moving:
        turn = normal_turn(joint)
        name = self.names[joint.name]
        plan, place = self.homes[joint.parent]
        start = self._stand(plan, name, place.then(joint.origin).then(turn))
        end = self.links[joint.child]
        if turn.turns:
            own = self.naming.element(f"{joint.name} end", "_frame", "the frame")
            end = self._stand(self.homes[joint.child][0], own, turn)
        fixed = None
        if joint.mimic is not None:
            _, factor, offset = _leader_law(joint, self.robot.joints)
            fixed = None if factor else offset
        limits = self._limits(joint)
        return Moving(joint, name, self.symbols[joint.name], self.inputs(joint), start, end, fixed, limits)

    def _limits(self, joint: UrdfJoint) -> Mapping[str, object] | None:
        """Return the limits of a hinge or slide that moves by itself, if they are asked for."""
        is_limited = joint.kind in ("revolute", "prismatic") and joint.mimic is None
        if self.limits is None or joint.limit is None or not is_limited:
            return None
        ends = {"low": joint.limit.lower, "high": joint.limit.upper}
        return {**self.limits, **{word: numeral(end or 0) for word, end in ends.items()}}

    def _stand(self, plan: BodyPlan, name: str, place: FramePlacement) -> FrameRef:
        self.frames.setdefault(plan.name, {})[name] = plan.frame(place)
        return FrameRef(plan.name, name)

    def _show(self, plan: BodyPlan, link: UrdfLink, place: FramePlacement) -> None:
        shapes = self.shapes.setdefault(plan.name, [])
        for visual in link.visuals:
            shape = visual_shape(self.robot, visual, plan.frame(place.then(visual.origin)))
            if shape is None:
                note = f"line {link.line}: link {link.name}: a visual of impossible size is ignored"
                self.notes.append(note)
            else:
                shapes.append(shape)


def _check_symbolic(robot: Robot, symbolic: Collection[str]) -> None:
    problems = [
        Problem(
            "urdf.unknown_symbolic",
            "symbolic",
            f"the robot has no link {name!r}",
            "",
            nearest(name, robot.links),
        )
        for name in symbolic
        if name not in robot.links
    ]
    if problems:
        raise UsageError(*problems)


def _check_base(robot: Robot, base: Lump, joints: Sequence[UrdfJoint], floats: bool) -> None:
    own = [joint for joint in joints if joint.parent in base.places]
    if floats and not base.mass and len(own) == 1 and own[0].kind == "floating":
        raise UsageError(
            Problem("urdf.floats_twice", f"{robot.where}:{own[0].line}, joint {own[0].name}",
                    f"the root link {robot.root} has no mass, but the file connects {own[0].child} to it by "
                    f"a floating joint",
                    "the file has a floating base already", "remove floating_base=True")
        )  # fmt: skip


def _heavy(robot: Robot, lumps: Sequence[Lump], floats: bool) -> Iterable[str]:
    """Return notes on masses that are impossible, missing or without influence."""
    for lump in lumps if floats else lumps[1:]:
        for name in lump.places:
            link = robot.links[name]
            if not possible(link.inertia):
                yield f"line {link.line}: link {name}: no body can have this inertia; it is used unchanged"
    yield from _weight_notes(robot, lumps, floats)


def _weight_notes(robot: Robot, lumps: Sequence[Lump], floats: bool) -> Iterator[str]:
    base = lumps[0]
    if not floats and base.mass:
        yield f"the base {base.root} is fixed: its mass of {float(base.mass):g} kg has no effect"
    for lump in lumps if floats else lumps[1:]:
        if not lump.mass and not any(lump.inertia):
            yield f"body {lump.root} is massless: no link of it has mass"
    idle = _idle_joints(robot)
    if idle:
        yield f"the joints {_list_names(idle)} move no mass, so nothing resists their forces and torques"


def _idle_joints(robot: Robot) -> list[str]:
    """Return the joints that move whose links, down to the last, have neither mass nor inertia."""
    below = {name: bool(link.mass or any(link.inertia)) for name, link in robot.links.items()}
    joints = outward(robot.joints.values(), robot.root)
    for joint in reversed(joints):
        below[joint.parent] = below[joint.parent] or below[joint.child]
    return [joint.name for joint in joints if joint.moves and not below[joint.child]]


def _list_names(names: Sequence[str]) -> str:
    return ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")


def _leader_law(joint: UrdfJoint, joints: Mapping[str, UrdfJoint]) -> tuple[UrdfJoint, Constant, Constant]:
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


def _follow_leader(
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


_MARKS = str.maketrans({".": "_", '"': "_", "'": "_"})
_DERIVED = ("", "_dot", "_ddot")
_LONGEST = MAX_NAME - 16  # leaves room for what is put before and behind


class Naming:
    """Hands out names of one model."""

    __slots__ = ("_elements", "_symbols", "notes")

    def __init__(self) -> None:
        self._elements = {GROUND, CENTRE}
        self._symbols = set(RESERVED_SYMBOLS)
        self.notes: list[str] = []

    def element(self, name: str, suffix: str, what: str) -> str:
        """Return the name of a body, joint or frame; `suffix` distinguishes it from a namesake."""
        plain = " ".join(normalize(name).translate(_MARKS).split())[:_LONGEST]
        if plain.isdigit() or plain.lower() == GROUND or plain == CENTRE:
            plain = f"{plain}{suffix}" if not plain.isdigit() else f"_{plain}"
        found, number = plain, 1
        while found in self._elements:
            found = f"{plain}{suffix}" + (f"_{number}" if number > 1 else "")
            number += 1
        self._elements.add(found)
        if found != normalize(name):
            self.notes.append(f"{what} {name} is called {found!r} in the model")
        return found

    def symbol(self, name: str, what: str) -> str:
        """Return the name of a coordinate, so that it, its rate and its acceleration are free."""
        plain = make_symbol(name[:_LONGEST])
        found, number = plain, 1
        while not self._symbols.isdisjoint(f"{found}{end}" for end in _DERIVED):
            number += 1
            found = f"{plain}_{number}"
        self._symbols.update(f"{found}{end}" for end in _DERIVED)
        if found != normalize(name):
            self.notes.append(f"{what} {name} has the symbol {found}")
        return found

    def take(self, *symbols: str) -> None:
        """Reserve symbols that must be called so."""
        self._symbols.update(symbols)


_LETTERS: Final = MappingProxyType[Numbers, str]({(1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z"})
# From the z axis to the opposites of the axes.
_OPPOSITES: Final[Mapping[Numbers, tuple[str, PlacementAngle]]] = MappingProxyType(
    {
        (-1, 0, 0): ("y", exact_angle(Fraction(-1, 2))),
        (0, -1, 0): ("x", exact_angle(Fraction(1, 2))),
        (0, 0, -1): ("x", exact_angle(Fraction(1))),
    }
)
_POSITION: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")
_TWIST: Final = ("vx", "vy", "vz", "wx", "wy", "wz")


@dataclass(frozen=True, slots=True)
class Moving:
    """A joint with the names it has in the model.

    Attributes
    ----------
    name : str
        Of the element.
    symbol : str
        Its coordinate, or what the names of its coordinates begin with.
    inputs : tuple of str
        Efforts along its coordinates; none where it follows another or floats.
    fixed : number or None
        The value of a coordinate that never changes.
    limits : mapping or None
        The arguments of its limits.
    """

    joint: UrdfJoint
    name: str
    symbol: str
    inputs: tuple[str, ...]
    start: FrameRef
    end: FrameRef
    fixed: Constant | None = None
    limits: Mapping[str, object] | None = None

    def element(self) -> Joint:
        """Return the joint of the model."""
        return _MAKERS[self.joint.kind](self)


def joint_coordinates(kind: str, symbol: str) -> tuple[str, ...]:
    """Return the coordinates of a joint of the robot."""
    if kind == "floating":
        return tuple(f"{symbol}_{part}" for part in _POSITION)
    if kind == "planar":
        return tuple(f"{symbol}_{k}" for k in (1, 2, 3))
    return () if kind == "fixed" else (symbol,)


def joint_speeds(kind: str, symbol: str) -> tuple[str, ...]:
    """Return the speeds of a joint that are not rates of its coordinates."""
    return tuple(f"{symbol}_{part}" for part in _TWIST) if kind == "floating" else ()


def make_free_joint(name: str, symbol: str, start: FrameRef, end: FrameRef) -> Free:
    """Return a joint without any constraint, with its velocities along axes of its end."""
    return Free(
        name,
        start,
        end,
        coordinates=joint_coordinates("floating", symbol),
        speeds="twist",
        speed_names=joint_speeds("floating", symbol),
    )


def normal_turn(joint: UrdfJoint) -> FramePlacement:
    """Return how the frames of a planar joint are turned so that an axis of theirs is its normal."""
    axis = joint.axis
    if joint.kind != "planar" or axis in _LETTERS:
        return FramePlacement()
    if axis in _OPPOSITES:
        return FramePlacement(turns=(_OPPOSITES[axis],))
    x, y, z = map(float, axis)
    about_z, about_y = (
        PlacementAngle(None, math.atan2(y, x)),
        PlacementAngle(None, math.atan2(math.hypot(x, y), z)),
    )
    return FramePlacement(turns=(("z", about_z), ("y", about_y)))


def _hinge_or_slide(moving: Moving) -> Joint:
    joint, applied = moving.joint, moving.inputs[0] if moving.inputs else 0
    words: dict[str, Any] = {
        "axis": _LETTERS.get(joint.axis) or [numeral(x) for x in joint.axis],
        "coordinate": moving.symbol,
        "motion": None if moving.fixed is None else numeral(moving.fixed),
        "friction": Friction(force=numeral(joint.friction)) if joint.friction else None,
        "limits": moving.limits,
    }
    is_driven = bool(applied or joint.damping)
    drive = Drive(applied=applied, damping=numeral(joint.damping)) if is_driven else None
    if joint.kind == "prismatic":
        return Prismatic(moving.name, moving.start, moving.end, force=drive, **words)
    return Revolute(moving.name, moving.start, moving.end, torque=drive, **words)


def _planar(moving: Moving) -> Joint:
    names = joint_coordinates("planar", moving.symbol)
    drives = {name: Drive(applied=own) for name, own in zip(names, moving.inputs, strict=True)}
    return Planar(
        moving.name,
        moving.start,
        moving.end,
        axis=_LETTERS.get(moving.joint.axis, "z"),
        coordinates=names,
        force={name: drives[name] for name in names[:2]},
        torque={names[2]: drives[names[2]]},
    )


_MAKERS: Final[Mapping[str, Callable[[Moving], Joint]]] = MappingProxyType(
    {
        "revolute": _hinge_or_slide,
        "continuous": _hinge_or_slide,
        "prismatic": _hinge_or_slide,
        "planar": _planar,
        "floating": lambda moving: make_free_joint(moving.name, moving.symbol, moving.start, moving.end),
        "fixed": lambda moving: Weld(moving.name, moving.start, moving.end),
    }
)
