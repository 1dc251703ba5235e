"""Joints of a model as those of URDF; all that URDF lacks is refused by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final
from xml.sax.saxutils import quoteattr

from symbody.errors import Problem
from symbody.expr.language.formula import Formula
from symbody.formats.urdf.file.placement import numeral
from symbody.formats.urdf.writing.values import Values
from symbody.model.body import Body
from symbody.model.constraints import Gear, RackPinion
from symbody.model.constraints.couplings import JointCoupling
from symbody.model.element import FrameRef
from symbody.model.joint import Joint
from symbody.model.joints import Free, Planar, Prismatic, Revolute, Weld
from symbody.model.model import Model
from symbody.model.naming import GROUND

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
    friction = joint.friction
    if friction is not None and (friction.force is None or friction.is_smooth or friction.static is not None):
        fix = "write friction = { force = .. }"
        yield _refusal(joint.name, "its friction is not a constant force", "", fix)


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
        mimics[follower] = _mimic(coupling, leader, values)
    return mimics


def _mimic(coupling: JointCoupling, leader: str, values: Values) -> str:
    factor, offset = -values.number(coupling.factors[1]), values.number(coupling.offset)
    return f'<mimic joint={quoteattr(leader)} multiplier="{numeral(factor)}" offset="{numeral(offset)}"/>'


def _refusal(joint: str, what: str, why: str, fix: str) -> Problem:
    return Problem("urdf.cannot_say", f"joint {joint}", what, why, fix)
