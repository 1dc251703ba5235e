"""From the parts of a random mechanism to its `Model`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import symbody as sb
from tests.laws.built_conditions import contact_element, coupling_element
from tests.laws.joint_laws import translations
from tests.laws.parts import (
    BodyPart,
    DrivePart,
    FramePart,
    JointPart,
    LoadPart,
    Mechanism,
    SpringPart,
    law_text,
)

Value = float | str
_CLASSES = {
    "weld": sb.Weld, "revolute": sb.Revolute, "prismatic": sb.Prismatic, "screw": sb.Screw,
    "cylindrical": sb.Cylindrical, "universal": sb.Universal, "constant_velocity": sb.ConstantVelocity,
    "pin_slot": sb.PinSlot, "planar": sb.Planar, "rectangular": sb.Rectangular, "cartesian": sb.Cartesian,
    "spherical": sb.Spherical, "gimbal": sb.Gimbal, "bearing": sb.Bearing, "telescoping": sb.Telescoping,
    "free": sb.Free,
}  # fmt: skip
_WITHOUT_AXIS = ("weld", "universal", "pin_slot", "cartesian", "spherical", "gimbal", "free")


@dataclass(slots=True)
class _Numbers:
    """Numbers that become parameters where the mechanism is symbolic."""

    symbolic: bool
    parameters: dict[str, float] = field(default_factory=dict)

    def __call__(self, name: str, value: float) -> Value:
        if not self.symbolic or value == 0:
            return value
        self.parameters[name] = value
        return name


def build_model(mechanism: Mechanism) -> sb.Model:
    """The model of a mechanism."""
    number = _Numbers(mechanism.symbolic)
    elements: list[Any] = [_body(number, body) for body in mechanism.bodies]
    elements += [_joint(number, joint) for joint in mechanism.joints]
    elements += [_spring(number, spring) for spring in mechanism.springs]
    elements += [_load(load) for load in mechanism.loads]
    elements += [contact_element(number, contact) for contact in mechanism.contacts]
    elements += [coupling_element(number, coupling) for coupling in mechanism.couplings]
    gravity = [number(f"g{axis}", value) for axis, value in zip("xyz", mechanism.gravity, strict=True)]
    ground = {name: _frame(number, f"ground_{name}", frame) for name, frame in mechanism.ground.items()}
    return sb.Model(
        f"random {mechanism.seed}",
        elements,
        gravity=gravity,
        parameters=number.parameters,
        inputs=tuple(mechanism.inputs),
        ground=ground,
    )


def _body(number: _Numbers, body: BodyPart) -> sb.Body:
    i = body.tensor
    # Equal moments are one parameter, so that symmetric bodies are seen to be symmetric.
    distinct = {i[k, k]: f"I{'xyz'[k]}_{body.name}" for k in (2, 1, 0)}
    return sb.Body(
        body.name,
        mass=number(f"m_{body.name}", body.mass),
        inertia=[number(distinct[i[k, k]], float(i[k, k])) for k in range(3)],
        products=[
            number(f"I{w}_{body.name}", float(i["xyz".index(w[0]), "xyz".index(w[1])]))
            for w in ("xy", "xz", "yz")
        ],
        frames={name: _frame(number, f"{body.name}_{name}", frame) for name, frame in body.frames.items()},
    )


def _frame(number: _Numbers, name: str, frame: FramePart) -> sb.Frame:
    at = [number(f"{name}_{axis}", value) for axis, value in zip("xyz", frame.at, strict=True)]
    if frame.by_matrix:
        return sb.Frame(at=at, matrix=frame.matrix.tolist())
    return sb.Frame(at=at, rotate=frame.turns)


def _drive(number: _Numbers, name: str, drive: DrivePart) -> sb.Drive:
    return sb.Drive(
        applied=law_text(drive.applied),
        stiffness=number(f"k_{name}", drive.stiffness),
        damping=number(f"d_{name}", drive.damping),
        free=number(f"free_{name}", drive.free),
    )


def _joint(number: _Numbers, joint: JointPart) -> Any:
    words: dict[str, Any] = {}
    if joint.kind not in _WITHOUT_AXIS:
        words["axis"] = joint.axis
    if joint.kind in ("universal", "pin_slot"):
        words["axes"] = (joint.axis, joint.second)
    words |= {"pitch": number(f"pitch_{joint.name}", joint.pitch)} if joint.kind == "screw" else {}
    words |= {"angles": joint.sequence} if joint.sequence else {}
    if joint.kind in ("spherical", "free"):
        words["speeds"] = joint.speeds
        words["speed_names"] = joint.speed_names or None
    if joint.named and joint.names:
        words |= {"coordinate": joint.names[0]} if len(joint.names) == 1 else {"coordinates": joint.names}
    drives = {name: _drive(number, name, drive) for name, drive in joint.drives.items()}
    motions = {name: motion.text for name, motion in joint.motions.items()}
    if len(joint.names) == 1:
        word = "force" if joint.kind == "prismatic" else "torque"
        for name in joint.names:
            words |= {word: drives[name]} if name in drives else {}
            words |= {"motion": motions[name]} if name in motions else {}
        if joint.armature:
            words["armature"] = number(f"rotor_{joint.name}", joint.armature)
    else:
        places = translations(joint)
        words |= _keyed("force", {name: drive for name, drive in drives.items() if name in places})
        words |= _keyed("torque", {name: drive for name, drive in drives.items() if name not in places})
        words |= _keyed("motion", motions)
    if joint.motions:
        words["as_constraint"] = joint.as_constraint
    return _CLASSES[joint.kind](joint.name, joint.start, joint.end, **words)


def _keyed(word: str, table: dict[str, Any]) -> dict[str, Any]:
    return {word: table} if table else {}


def _spring(number: _Numbers, spring: SpringPart) -> sb.SpringDamper:
    return sb.SpringDamper(
        spring.name,
        spring.start,
        spring.end,
        stiffness=number(f"k_{spring.name}", spring.stiffness),
        damping=number(f"d_{spring.name}", spring.damping),
        free=number(f"free_{spring.name}", spring.free),
        applied=law_text(spring.applied),
    )


def _load(load: LoadPart) -> sb.Force | sb.Torque:
    make = sb.Force if load.is_force else sb.Torque
    return make(
        load.name,
        load.on,
        [law_text(law) for law in load.vector],
        resolved_in=load.resolved_in,
        reaction_on=load.reaction_on,
    )
