"""What acts on a random mechanism: drives, springs, forces and torques, and what counts its freedoms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.laws.drafts import independent_speeds
from tests.laws.draws import Draws
from tests.laws.joint_laws import translations
from tests.laws.loops import loop_rank
from tests.laws.motion import body_places, frame_place
from tests.laws.parts import JointPart, LoadPart, Mechanism, SpringPart

Readable = list[tuple[str, float]]


def add_loads(mechanism: Mechanism, draws: Draws) -> Mechanism:
    """The mechanism with loads and with its freedoms counted."""
    inputs = {f"F{k}": draws.number() for k in range(draws.rng.choice([0, 1, 1, 2]))}
    readable = _readable(mechanism, inputs)
    joints = tuple(_with_drives(joint, draws, readable) for joint in mechanism.joints)
    places = body_places(mechanism)
    rank = loop_rank(mechanism)[0] if mechanism.loops else 0
    found = replace(mechanism, joints=joints, inputs=inputs)
    addresses = [f"{body.name}.{name}" for body in found.bodies for name in body.frames]
    addresses += [body.name for body in found.bodies] + [
        "ground",
        *(f"ground.{name}" for name in found.ground),
    ]
    springs, loads = [], []
    for k in range(draws.rng.choice([0, 1, 1, 2])):
        spring = _spring(found, draws, f"S{k}", addresses, readable)
        if spring is not None:
            springs.append(spring)
    for k in range(draws.rng.choice([0, 1, 1, 2])):
        loads.append(_load(found, draws, f"L{k}", addresses, readable))
    found = replace(found, springs=tuple(springs), loads=tuple(loads))
    return replace(found, freedoms=independent_speeds(found, rank, places))


def _readable(mechanism: Mechanism, inputs: dict[str, float]) -> Readable:
    """Names that laws may read, with their units; coordinates of joints with one, rates included."""
    units = mechanism.units
    found: Readable = [("t", units.time), *((name, 1.0) for name in inputs)]
    for joint in mechanism.joints:
        if len(joint.names) == 1 and joint.named:
            unit = units.length if joint.kind == "prismatic" else 1.0
            found += [(joint.names[0], unit), (f"{joint.names[0]}_dot", unit / units.time)]
    return found


def _with_drives(joint: JointPart, draws: Draws, readable: Readable) -> JointPart:
    units = draws.units
    drives = {}
    if joint.named and joint.sequence != "quaternion" and draws.chance(0.15 if joint.closing else 0.4):
        lengths = translations(joint)
        for name in joint.names:
            if draws.chance(0.6):
                effort, unit = (units.force, units.length) if name in lengths else (units.torque, 1.0)
                drives[name] = draws.drive(effort, unit, readable)
    armature = 0.0
    if joint.kind in ("revolute", "prismatic") and not joint.closing and draws.chance(0.1):
        armature = (
            draws.number(0.1, 1.0) * units.mass * (units.length**2 if joint.kind == "revolute" else 1.0)
        )
    return replace(joint, drives=drives, armature=armature)


def _spring(
    mechanism: Mechanism, draws: Draws, name: str, addresses: list[str], readable: Readable
) -> SpringPart | None:
    """A spring between two bodies, unless its ends are close together."""
    units = draws.units
    start, end = draws.rng.sample(addresses, 2)
    places = body_places(mechanism)
    length = np.linalg.norm(frame_place(mechanism, places, start)[0] - frame_place(mechanism, places, end)[0])
    stiffness = draws.number(0.1, 3.0) * units.force / units.length
    damping = draws.number(0.1, 1.0) * units.force / units.length * units.time if draws.chance(0.5) else 0.0
    free = draws.number(0.1, 1.0) * units.length if draws.chance(0.6) else 0.0
    applied = draws.law(units.force, readable) if draws.chance(0.3) else ()
    if start.partition(".")[0] == end.partition(".")[0] or length < 0.1 * units.length:
        return None
    return SpringPart(name, start, end, stiffness, damping, free, applied)


def _load(
    mechanism: Mechanism, draws: Draws, name: str, addresses: list[str], readable: Readable
) -> LoadPart:
    """A force or torque on a body, with its reaction on ground or another body."""
    units, rng = draws.units, draws.rng
    is_force = draws.chance(0.6)
    on = rng.choice([address for address in addresses if not address.startswith("ground")])
    others = ["ground", *(body.name for body in mechanism.bodies if body.name != on.partition(".")[0])]
    unit = units.force if is_force else units.torque
    x, y, z = (draws.law(unit, readable, least=1) for _ in range(3))
    return LoadPart(name, is_force, on, (x, y, z), rng.choice(addresses), rng.choice(others))
