"""Law: every choice of trees and of orientation coordinates gives the same accelerations and reactions."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

import symbody as sb
from symbody.graph.trees import TreeChoice, Trees
from tests.laws.consistent_states import State
from tests.laws.evaluation import EPS, Condition, condition, values_at
from tests.laws.joint_laws import orientation
from tests.laws.parts import JointPart, Mechanism
from tests.laws.rotations import Array, euler_zyx, quaternion

SYSTEM = ("mass_matrix", "forcing", "jacobian", "gamma", "udot")


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What the equations say at a state.

    Attributes
    ----------
    accelerations : mapping of body to (6,)
        Of the centre of mass and of the rotation, in ground axes.
    reactions : mapping of joint to (6,)
    """

    accelerations: dict[str, Array]
    reactions: dict[str, Array]
    condition: Condition


def outcome(mechanism: Mechanism, eqs: sb.EquationSet, state: State) -> Outcome:
    """Accelerations and reactions at a state, by plain evaluation."""
    vdot = {body.name: f"frame vdot {body.name} ground ground" for body in mechanism.bodies}
    wdot = {body.name: f"frame wdot {body.name} ground ground" for body in mechanism.bodies}
    reactions = {name: f"reaction {name}" for name in mechanism.linked}
    found = values_at(eqs, state, [*SYSTEM, *vdot.values(), *wdot.values(), *reactions.values()])
    return Outcome(
        {name: np.concatenate([found[vdot[name]], found[wdot[name]]]) for name in vdot},
        {name: found[output] for name, output in reactions.items()},
        condition(found),
    )


def acceleration_error(mechanism: Mechanism, state: State, one: Outcome, two: Outcome) -> float:
    """The difference of two outcomes in units of ``eps cond scale``, accelerations weighted by masses.

    The scale is the norm of the accelerations themselves, at least that of one unit of acceleration: all data
    are of order one in the mechanism's units, so this is the size of the terms that cancel.
    """
    difference = {b: one.accelerations[b] - two.accelerations[b] for b in one.accelerations}
    unit = float(np.sqrt(sum(body.mass for body in mechanism.bodies))) * mechanism.units.acceleration
    scale = max(_weighted(mechanism, state, one.accelerations), unit)
    return _weighted(mechanism, state, difference) / (
        EPS * max(one.condition.number, two.condition.number) * scale
    )


def reaction_error(mechanism: Mechanism, one: Outcome, two: Outcome) -> float | None:
    """The same for reactions, moments divided by the unit of length; undetermined ones have one share."""
    if not one.reactions:
        return None
    weights = np.array([1.0] * 3 + [1 / mechanism.units.length] * 3)
    size = max(np.abs(r * weights).max() for r in one.reactions.values())
    scale = max(size, max(body.mass for body in mechanism.bodies) * mechanism.units.acceleration)
    error = max(np.abs((one.reactions[j] - two.reactions[j]) * weights).max() for j in one.reactions)
    return float(error / (EPS * max(one.condition.number, two.condition.number) * scale))


def _weighted(mechanism: Mechanism, state: State, accelerations: dict[str, Array]) -> float:
    """The norm whose square is twice the kinetic energy of such velocities."""
    total = 0.0
    for body in mechanism.bodies:
        a = accelerations[body.name]
        turning = state.places[body.name][1].T @ a[3:]
        total += body.mass * float(a[:3] @ a[:3]) + float(turning @ body.tensor @ turning)
    return float(np.sqrt(total))


def random_trees(mechanism: Mechanism, rng: random.Random) -> Trees:
    """Any two forests of joints; what they do not reach gets absolute coordinates."""
    rotation, translation = _forest(mechanism, rng), _forest(mechanism, rng)
    # What needs the orientation for its translation is in both trees or in neither: speeds in axes of the end
    # frame, screws, displacements along axes of the end frame.
    parted = {
        j.name
        for j in mechanism.joints
        if (j.speeds == "twist" or j.kind in ("screw", "telescoping"))
        and (j.name in rotation) != (j.name in translation)
    }
    return Trees([j for j in rotation if j not in parted], [j for j in translation if j not in parted])


def _forest(mechanism: Mechanism, rng: random.Random) -> list[str]:
    group = {"ground": "ground"} | {body.name: body.name for body in mechanism.bodies}
    chosen = []
    joints = list(mechanism.joints)
    rng.shuffle(joints)
    for joint in joints:
        a, b = (group[address.partition(".")[0]] for address in (joint.start, joint.end))
        if a != b and rng.random() < 0.8:
            chosen.append(joint.name)
            group = {name: a if root == b else root for name, root in group.items()}
    return chosen


def choices(mechanism: Mechanism, number: int) -> Iterator[TreeChoice]:
    """Choices of trees: automatic first, absolute, then random ones."""
    rng = random.Random(f"trees {mechanism.seed}")
    yield "joints"
    yield "absolute"
    for _ in range(number):
        yield random_trees(mechanism, rng)


def other_orientations(mechanism: Mechanism) -> Mechanism:
    """The mechanism with other coordinates and speeds for orientations whose angles nothing drives."""
    rng = random.Random(f"orientations {mechanism.seed}")
    return replace(mechanism, joints=tuple(_other(joint, rng) for joint in mechanism.joints))


def _other(joint: JointPart, rng: random.Random) -> JointPart:
    if joint.kind not in ("spherical", "free") or joint.drives:
        return joint
    r = orientation(joint, joint.values)
    position = joint.values[:3] if joint.kind == "free" else ()
    words = ["start", "end"] + ["twist"] * (joint.kind == "free")
    if joint.sequence == "quaternion":
        angles = euler_zyx(r)
        if abs(np.cos(angles[1])) > 0.3:
            first, second, third = angles
            sequence, values = rng.choice([("zyx", angles), ("space xyz", (third, second, first))])
            return _renamed(joint, sequence, (*position, *values), rng.choice([*words, "rates"]))
    return _renamed(joint, "quaternion", (*position, *(float(x) for x in quaternion(r))), rng.choice(words))


def _renamed(joint: JointPart, sequence: str, values: tuple[float, ...], speeds: str) -> JointPart:
    names = tuple(f"o{joint.name}_{k}" for k in range(len(values)))
    return replace(
        joint, sequence=sequence, values=values, speeds=speeds, names=names, speed_names=(), named=True
    )
