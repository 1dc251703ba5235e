"""Random mechanisms whose prescribed rates jump, and the speeds behind the jump, by NumPy alone.

Corners stand in prescribed coordinates of joints, closing ones among them, in moving lengths and angles of
constraints and in offsets of couplings; equations in rates have steps. The rates s of all freedoms jump by what
rods, pins and motors can transmit: the momenta of all admissible directions N stay, ``N^T M (s' - s) = 0``, and
``A s'`` is what is prescribed behind the corner [Pars, A treatise on analytical dynamics, chapter 14].
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

import symbody as sb
from tests.laws.building import build_model
from tests.laws.consistent_states import State, admissible_rates, state_of_rates
from tests.laws.draws import Draws
from tests.laws.joint_laws import angle_axes, freedoms, translations
from tests.laws.mechanisms import random_mechanism
from tests.laws.motion import Freedoms, Places, all_freedoms, body_places, demands, freedom_scales
from tests.laws.moved import Twists, moved
from tests.laws.parts import ContactPart, CouplingPart, JointPart, Mechanism, MotionPart
from tests.laws.rotations import Array

# Rows are dependent below the first share of the largest, and independent above the second; else nothing is compared.
DEPENDENT, INDEPENDENT = 1e-9, 2e-2


@dataclass(frozen=True, slots=True)
class Cornered(MotionPart):
    """A motion with a corner, or with a step: one moment before it or, if `is_behind`, after it.

    Attributes
    ----------
    jump : float
        By which the rate jumps; for steps the value.
    bend : str
        A function of t with a jump of 1, zero before it.
    """

    jump: float = 0.0
    bend: str = "0"
    is_step: bool = False
    is_behind: bool = False

    @property
    def text(self) -> str:
        plain = MotionPart(self.mean, self.amplitude, self.scale).text
        return f"{plain} + ({self.jump!r})*({self.bend})"

    def at(self, t: float) -> float:
        return MotionPart.at(self, t) + self.jump * (self.is_step and self.is_behind)

    def rate(self, t: float) -> float:
        return MotionPart.rate(self, t) + self.jump * (self.is_behind and not self.is_step)


@dataclass(frozen=True, slots=True, eq=False)
class Struck:
    """A mechanism with corners at its time `t`, the states around them, and what they do.

    Attributes
    ----------
    before, behind : State
    gained : float
        Kinetic energy that comes from the motors.
    speed, energy : float
        The largest rate, in the mechanism's units, and the largest kinetic energy.
    words : str
        How the corners are written.
    rank : int
        Of the rows on the rates.
    magnified : float
        By how much more rates are off than joints and constraints are open, as shares: coordinates of a mechanism
        that is open by phi are off by ``|A^+| phi``, rows ``A`` by as much (lengths are numbers of order one), and
        the rates that these determine by ``|A^+|`` times that; so too for the freedoms of each joint.
    condition : float
        By how much more rates behind the corners are off than those before them and what is prescribed, as shares.
    """

    mechanism: Mechanism
    before: State
    behind: State
    gained: float
    speed: float
    energy: float
    words: str
    rank: int
    magnified: float
    condition: float

    def model(self, width: float = 0.0) -> sb.Model:
        """The model; with a width corners are rounded over twice that time, and steps are ramps."""
        mechanism = self.mechanism
        rounded = _changed(mechanism, _Rounded(mechanism.t, width)) if width else mechanism
        return build_model(rounded)

    def at(self, places: Places, twists: Twists) -> Struck:
        """What the corners do to a motion that arrives elsewhere, or with other rates, as errors on the way leave it.

        Parameters
        ----------
        places : mapping of body to (position, rotation matrix)
        twists : mapping of body to (velocity of the centre of mass, angular velocity), in ground axes
        """
        mechanism = moved(self.mechanism, places)
        motion = all_freedoms(mechanism, places)
        length = mechanism.units.length
        rows = [
            x
            for body in mechanism.bodies
            for x in (motion.slides[body.name] / length, motion.spins[body.name])
        ]
        rates = [
            x for body in mechanism.bodies for x in (twists[body.name][0] / length, twists[body.name][1])
        ]
        scales = freedom_scales(mechanism, motion)
        s = np.linalg.lstsq(np.vstack(rows) * scales, np.concatenate(rates), rcond=None)[0]
        return _balanced(mechanism, places, s * mechanism.units.time, self.words, self.rank)[0]


def struck(seed: int) -> Struck | None:
    """The mechanism of a seed with corners; None where none of the motions tried is possible."""
    plain = random_mechanism(seed)
    for number in range(6):
        draws = Draws(random.Random(f"impulses {seed}/{number}"), plain.units)
        found = _struck(_changed(_driven(plain, draws), _Bent(draws, plain.t)))
        if found is not None:
            return found
    return None


def _struck(mechanism: Mechanism) -> Struck | None:
    """The states before and behind the corners; None if there are none, or rates do not fit."""
    words = sorted({part.bend for _, part in _moving_parts(mechanism) if isinstance(part, Cornered)})
    if not words:
        return None
    places = body_places(mechanism)
    motion = all_freedoms(mechanism, places)
    s = admissible_rates(mechanism, places, motion) / freedom_scales(mechanism, motion) * mechanism.units.time
    sizes = np.linalg.svd(_prescribed(mechanism, places)[0], compute_uv=False)
    if ((sizes > DEPENDENT * sizes[0]) & (sizes < INDEPENDENT)).any():
        return None
    rank = int((sizes > DEPENDENT * sizes[0]).sum())
    found, left, jump = _balanced(mechanism, places, s, ", ".join(words), rank)
    return None if left > 1e-9 or jump < 0.05 else found


def _balanced(
    mechanism: Mechanism, places: Places, s: Array, words: str, rank: int
) -> tuple[Struck, float, float]:
    """What corners do to rates s in the mechanism's units; how far rates miss their values, and their jump."""
    motion = all_freedoms(mechanism, places)
    scales, time = freedom_scales(mechanism, motion), mechanism.units.time
    A, before = _prescribed(mechanism, places)
    behind = _prescribed(_changed(mechanism, _Later()), places)[1]
    left_side, sizes, right_side = np.linalg.svd(A)
    inverse = right_side[:rank].T / sizes[:rank] @ left_side[:, :rank].T
    free = right_side[rank:].T
    jump = inverse @ (behind - A @ s)
    left = max(np.abs(A @ s - before).max(), np.abs(A @ (s + jump) - behind).max())
    M = _mass_matrix(mechanism, motion, places, scales / time)
    kept = np.linalg.solve(free.T @ M @ free, free.T @ M)  # the momenta of admissible directions, as rates
    jump = jump - free @ (kept @ jump)
    states = [state_of_rates(mechanism, places, motion, x * scales / time) for x in (s, s + jump)]
    energies = [float(x @ M @ x) / 2 for x in (s, s + jump)]
    inverted = max(1.0, 1.0 / float(sizes[rank - 1]), 1.0 / _least_turn(mechanism))
    condition = (1.0 + float(np.linalg.norm(kept))) * inverted
    struck = Struck(
        mechanism, before=states[0], behind=states[1], gained=energies[1] - energies[0],
        speed=float(np.abs([s, s + jump]).max()), energy=max(energies), words=words, rank=rank,
        magnified=inverted**2, condition=condition,
    )  # fmt: skip
    return struck, float(left), float(np.abs(jump).max())


def _least_turn(mechanism: Mechanism) -> float:
    """The least singular value of a joint's directions: small where its angles come near a singularity."""
    least = 1.0
    for joint in (joint for joint in mechanism.joints if joint.names):
        turning, sliding = freedoms(joint)
        if joint.kind in ("spherical", "free") and joint.sequence != "quaternion":
            turning[:, -3:] = angle_axes(joint)
        directions = np.vstack([turning, sliding / mechanism.units.length])
        directions = directions / np.linalg.norm(directions, axis=0)
        least = min(least, float(np.linalg.svd(directions, compute_uv=False)[-1]))
    return least


def _prescribed(mechanism: Mechanism, places: Places) -> tuple[Array, Array]:
    """All rows on the rates of the freedoms, these in the mechanism's units, and their values."""
    motion = all_freedoms(mechanism, places)
    scales, time = freedom_scales(mechanism, motion), mechanism.units.time
    demand = demands(mechanism, places, motion)
    own = np.eye(motion.size)[list(motion.known)]
    rates = [
        joint.motions[name].rate(mechanism.t) * time / scales[k] for k, (joint, name) in motion.known.items()
    ]
    return np.vstack([demand.rows * scales, own]), np.concatenate([demand.values * time, rates])


def _mass_matrix(mechanism: Mechanism, motion: Freedoms, places: Places, scales: Array) -> Array:
    """The mass matrix of all freedoms: bodies, and rotors that turn with a coordinate."""
    M = np.zeros((motion.size, motion.size))
    for body in mechanism.bodies:
        axes = places[body.name][1]
        slide, spin = motion.slides[body.name] * scales, motion.spins[body.name] * scales
        M += body.mass * slide.T @ slide + spin.T @ axes @ body.tensor @ axes.T @ spin
    for joint in (joint for joint in mechanism.joints if joint.armature):
        k = motion.columns[joint.name].start
        M[k, k] += joint.armature * scales[k] ** 2
    return M


def _driven(mechanism: Mechanism, draws: Draws) -> Mechanism:
    """The mechanism with up to two motions more."""
    joints = list(mechanism.joints)
    for _ in range(draws.rng.choice([0, 1, 1, 2])):
        open_ones = [k for k, joint in enumerate(joints) if _may_be_driven(joint)]
        if open_ones:
            k = draws.rng.choice(open_ones)
            joint = joints[k]
            place = draws.rng.randrange(len(joint.names))
            name = joint.names[place]
            unit = draws.units.length if name in translations(joint) else 1.0
            motions = {name: draws.motion(joint.values[place], unit, mechanism.t)}
            joints[k] = replace(joint, motions=motions, as_constraint=draws.chance(0.4))
    return replace(mechanism, joints=tuple(joints))


def _may_be_driven(joint: JointPart) -> bool:
    return joint.kind not in ("weld", "spherical", "free") and joint.named and not joint.motions


Holder = JointPart | ContactPart | CouplingPart


def _moving_parts(mechanism: Mechanism) -> Iterator[tuple[Holder, MotionPart]]:
    """Every prescribed motion, with what it belongs to."""
    for joint in mechanism.joints:
        for part in joint.motions.values():
            yield joint, part
    for contact in mechanism.contacts:
        if contact.kind in ("distance", "angle") and contact.value.amplitude:
            yield contact, contact.value
    for coupling in mechanism.couplings:
        if coupling.offset.amplitude or coupling.along:
            yield coupling, coupling.offset


@dataclass(frozen=True, slots=True, eq=False)
class _Bent:
    """Gives motions corners, each with a chance of three in four."""

    draws: Draws
    t: float

    def __call__(self, owner: Holder, name: str, part: MotionPart) -> MotionPart:
        draws, t, time = self.draws, repr(self.t), self.draws.units.time
        if not draws.chance(0.75):
            return part
        is_step = isinstance(owner, CouplingPart) and bool(owner.along)
        is_length = isinstance(owner, ContactPart) and owner.kind == "distance"
        is_length |= isinstance(owner, CouplingPart) and owner.kind in ("rack", "belt")
        is_length |= isinstance(owner, JointPart) and name in translations(owner)
        unit = draws.units.length if is_length else 1.0
        corners = [
            f"max(0, t - {t})", f"-min(0, {t} - t)", f"if(t < {t}, 0, t - {t})", f"(abs(t - {t}) + t - {t})/2",
            f"interp1(t, {self.t - 2 * time!r}, 0, {t}, 0, {self.t + 2 * time!r}, {2 * time!r})",
        ]  # fmt: skip
        steps = [f"if(t < {t}, 0, 1)", f"(1 + sign(t - {t}))/2"]
        bend = draws.rng.choice(steps if is_step else corners)
        jump = draws.number(0.3, 1.5) * draws.rng.choice([-1, 1]) * unit / time
        return Cornered(part.mean, part.amplitude, part.scale, jump, bend, is_step)


@dataclass(frozen=True, slots=True)
class _Later:
    """Takes what is prescribed behind corners."""

    def __call__(self, owner: Holder, name: str, part: MotionPart) -> MotionPart:
        return replace(part, is_behind=True) if isinstance(part, Cornered) else part


@dataclass(frozen=True, slots=True)
class _Rounded:
    """Makes corners smooth: the rate passes from one value to the other as 3 x^2 - 2 x^3 over twice a width."""

    t: float
    width: float

    def __call__(self, owner: Holder, name: str, part: MotionPart) -> MotionPart:
        if not isinstance(part, Cornered):
            return part
        t, w = repr(self.t), repr(self.width)
        x = f"((t - {t} + {w})/(2*{w}))"
        inside, behind = (
            (f"{x}^2*(3 - 2*{x})", "1") if part.is_step else (f"2*{w}*({x}^3 - {x}^4/2)", f"t - {t}")
        )
        return replace(part, bend=f"if(t < {t} - {w}, 0, if(t > {t} + {w}, {behind}, {inside}))")


def _changed(mechanism: Mechanism, change: _Bent | _Later | _Rounded) -> Mechanism:
    """The mechanism with every prescribed motion changed."""
    moving = {id(part) for _, part in _moving_parts(mechanism)}
    joints = tuple(
        replace(joint, motions={name: change(joint, name, part) for name, part in joint.motions.items()})
        for joint in mechanism.joints
    )
    contacts = tuple(
        replace(part, value=change(part, "", part.value)) if id(part.value) in moving else part
        for part in mechanism.contacts
    )
    couplings = tuple(
        replace(part, offset=change(part, "", part.offset)) if id(part.offset) in moving else part
        for part in mechanism.couplings
    )
    return replace(mechanism, joints=joints, contacts=contacts, couplings=couplings)
