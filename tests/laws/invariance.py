"""Laws: the same mechanism, said in another way, moves the same way.

Each transformation returns the other mechanism and how bodies correspond; where the world is turned, the
accelerations are turned back before they are compared.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from tests.laws.agreement import Outcome, acceleration_error, outcome
from tests.laws.consistent_states import RENAMED, consistent_state
from tests.laws.evaluation import equations
from tests.laws.mechanisms import random_mechanism
from tests.laws.parts import BodyPart, FramePart, JointPart, Law, Mechanism, Units
from tests.laws.rotations import Array, Axis, euler_zyx, turned, unit

WORLD: Axis = (2.0, -3.0, 6.0)
WORLD_ANGLE = 1.1
MILLI = 1e3
# Constraints that hold their two ends in the same way.
_MUTUAL = ("distance", "parallel", "perpendicular", "angle")


def errors_of(mechanism: Mechanism, transforms: Iterable[str]) -> dict[str, float]:
    """The difference that each transformation makes, in units of eps cond scale; those that do not apply left out."""
    state = consistent_state(mechanism)
    one = outcome(mechanism, equations(mechanism), state)
    errors = {}
    for transform in transforms:
        other = TRANSFORMS[transform](mechanism)
        if other is not None:
            two = outcome(other, equations(other), consistent_state(other))
            errors[transform] = acceleration_error(
                mechanism, state, one, _brought_back(mechanism, two, transform)
            )
    return errors


def _brought_back(mechanism: Mechanism, found: Outcome, transform: str) -> Outcome:
    accelerations = dict(found.accelerations)
    if transform == "turn the world":
        r = turned(WORLD, WORLD_ANGLE)
        accelerations = {b: np.concatenate([r.T @ a[:3], r.T @ a[3:]]) for b, a in accelerations.items()}
    if transform == "other units":
        accelerations = {b: np.concatenate([a[:3] / MILLI, a[3:]]) for b, a in accelerations.items()}
    if transform == "other names":
        accelerations = {b: accelerations[f"{RENAMED}{b}"] for b in (body.name for body in mechanism.bodies)}
    if transform == "weld a body in two":
        accelerations = {b.name: accelerations[b.name] for b in mechanism.bodies}
    return replace(found, accelerations=accelerations)


def turn_the_world(mechanism: Mechanism) -> Mechanism:
    """Everything on ground turned, gravity too; forces given in ground axes stay where they are said to be."""
    r = turned(WORLD, WORLD_ANGLE)
    turn: tuple[Axis, float] = (WORLD, WORLD_ANGLE)
    ground = {
        name: FramePart(_triple(r @ np.array(frame.at)), (turn, *frame.turns))
        for name, frame in mechanism.ground.items()
    }
    ground["world"] = FramePart((0.0, 0.0, 0.0), (turn,))
    loads = tuple(
        replace(load, resolved_in="ground.world") if load.resolved_in == "ground" else load
        for load in mechanism.loads
    )
    placed = {name: (r @ at, r @ axes) for name, (at, axes) in mechanism.placed.items()}
    gravity = _triple(r @ np.array(mechanism.gravity))
    return replace(mechanism, ground=ground, loads=loads, placed=placed, gravity=gravity)


def other_names(mechanism: Mechanism) -> Mechanism:
    """Every name another one, in another alphabetical order; elements in another order."""

    def place(address: str) -> str:
        body, dot, frame = address.partition(".")
        return address if body == "ground" else f"{RENAMED}{body}{dot}{frame}"

    words = {name: f"w{k}" for k, name in enumerate(reversed([n for j in mechanism.joints for n in j.names]))}
    words |= {f"{old}_dot": f"{new}_dot" for old, new in list(words.items())}
    words |= {name: f"in_{name}" for name in mechanism.inputs}

    def law(terms: Law) -> Law:
        return tuple(replace(term, name=words.get(term.name, term.name)) for term in terms)

    def joint(part: JointPart) -> JointPart:
        drives = {
            words[name]: replace(drive, applied=law(drive.applied)) for name, drive in part.drives.items()
        }
        return replace(
            part, name=f"{RENAMED}{part.name}", start=place(part.start), end=place(part.end), drives=drives, named=True,
            names=tuple(words[n] for n in part.names), motions={words[n]: m for n, m in part.motions.items()},
        )  # fmt: skip

    return replace(
        mechanism,
        bodies=tuple(replace(body, name=f"{RENAMED}{body.name}") for body in mechanism.bodies[::-1]),
        joints=tuple(joint(part) for part in mechanism.joints),
        springs=tuple(
            replace(s, name=f"q{s.name}", start=place(s.start), end=place(s.end), applied=law(s.applied))
            for s in mechanism.springs[::-1]
        ),
        loads=tuple(
            replace(
                load,
                name=f"a{load.name}",
                on=place(load.on),
                resolved_in=place(load.resolved_in),
                reaction_on=place(load.reaction_on),
                vector=(law(load.vector[0]), law(load.vector[1]), law(load.vector[2])),
            )  # fmt: skip
            for load in mechanism.loads[::-1]
        ),
        contacts=tuple(
            replace(part, name=f"{RENAMED}{part.name}", start=place(part.start), end=place(part.end))
            for part in mechanism.contacts[::-1]
        ),
        couplings=tuple(
            replace(
                part,
                name=f"{RENAMED}{part.name}",
                terms=law(part.terms),
                along=tuple(words[name] for name in part.along),
            )
            for part in mechanism.couplings[::-1]
        ),
        inputs={f"in_{name}": value for name, value in mechanism.inputs.items()},
        placed={f"{RENAMED}{name}": place for name, place in mechanism.placed.items()},
    )


def other_order(mechanism: Mechanism) -> Mechanism:
    """Bodies and loads in another order; joints in an order that still leads outward from ground."""
    rng = random.Random(f"order {mechanism.seed}")
    bodies, loads, springs = list(mechanism.bodies), list(mechanism.loads), list(mechanism.springs)
    contacts, couplings = list(mechanism.contacts), list(mechanism.couplings)
    for items in (bodies, loads, springs, contacts, couplings):
        rng.shuffle(items)
    waiting, reached, joints = list(mechanism.joints), {"ground", *mechanism.placed}, []
    while waiting:
        ready = [
            j for j in waiting if j.closing or {j.start.partition(".")[0], j.end.partition(".")[0]} & reached
        ]
        joint = rng.choice(ready)
        waiting.remove(joint)
        joints.append(joint)
        if not joint.closing:
            reached |= {joint.start.partition(".")[0], joint.end.partition(".")[0]}
    return replace(
        mechanism, bodies=tuple(bodies), joints=tuple(joints), loads=tuple(loads), springs=tuple(springs),
        contacts=tuple(contacts), couplings=tuple(couplings),
    )  # fmt: skip


def exchange_ends(mechanism: Mechanism) -> Mechanism | None:
    """Start and end exchanged: seen from the other side the end of a joint moves backwards along the axis."""
    joints = tuple(_exchanged(joint) for joint in mechanism.joints)
    contacts = tuple(
        replace(c, start=c.end, end=c.start, axis=c.second, second=c.axis) if c.kind in _MUTUAL else c
        for c in mechanism.contacts
    )
    if joints == mechanism.joints and contacts == mechanism.contacts:
        return None
    return replace(mechanism, joints=joints, contacts=contacts)


def _exchanged(joint: JointPart) -> JointPart:
    if joint.kind not in ("weld", "revolute", "prismatic", "screw", "cylindrical"):
        return joint
    x, y, z = (-component for component in unit(joint.axis))
    axis: Axis = (x, y, z) if joint.kind != "weld" else joint.axis
    if isinstance(joint.axis, tuple):
        x, y, z = (-component for component in joint.axis)
        axis = (x, y, z)
    return replace(joint, start=joint.end, end=joint.start, axis=axis)


def weld_in_two(mechanism: Mechanism) -> Mechanism | None:
    """A third of a body made a body of its own, turned, and welded to the rest."""
    rng = random.Random(f"split {mechanism.seed}")
    joined = [body for body in mechanism.bodies if body.name not in mechanism.placed]
    if not joined:
        return None
    whole = rng.choice(joined)
    r = turned("x", 0.7) @ turned((1.0, 2.0, 2.0), -1.3)
    length = mechanism.units.length
    at = np.array([0.4, -0.3, 0.2]) * length
    angles = euler_zyx(r.T)
    # The part's frame lies at the point of the whole, with the axes of the whole.
    own = FramePart(_triple(r.T @ at), tuple(zip("zyx", angles, strict=True)))
    part = BodyPart("Part", whole.mass / 3, _symmetric(r.T @ whole.tensor @ r) / 3, {"weld": own})
    rest = replace(whole, mass=whole.mass * 2 / 3, tensor=whole.tensor * 2 / 3,
                   frames={**whole.frames, "weld": FramePart(_triple(at))})  # fmt: skip
    bodies = (*(rest if body is whole else body for body in mechanism.bodies), part)
    return replace(
        mechanism,
        bodies=bodies,
        joints=(*mechanism.joints, JointPart("Seam", "weld", f"{whole.name}.weld", "Part.weld")),
    )


def other_units(mechanism: Mechanism) -> Mechanism:
    """The same mechanism in millimetres and grams."""
    units = mechanism.units
    return random_mechanism(mechanism.seed, Units(units.length * MILLI, units.mass * MILLI, units.time))


def _triple(a: Array) -> tuple[float, float, float]:
    return (float(a[0]), float(a[1]), float(a[2]))


def _symmetric(a: Array) -> Array:
    found: Array = (a + a.T) / 2
    return found


TRANSFORMS: dict[str, Callable[[Mechanism], Mechanism | None]] = {
    "turn the world": turn_the_world,
    "other names": other_names,
    "other order": other_order,
    "exchange ends": exchange_ends,
    "weld a body in two": weld_in_two,
    "other units": other_units,
}
