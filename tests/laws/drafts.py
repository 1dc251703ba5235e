"""A mechanism while it grows: bodies hung on by joints, one after the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.laws.draws import PLANE, Draws
from tests.laws.joint_laws import FREEDOMS, LAYOUT, letters
from tests.laws.motion import all_freedoms
from tests.laws.parts import BodyPart, FramePart, JointPart, Mechanism
from tests.laws.rotations import Array, Axis


class Rejection(Exception):
    """Why an attempt was given up."""


class Draft:
    """Parts of a mechanism; `normal` is set while the parts stay in a plane."""

    def __init__(self, draws: Draws, t: float) -> None:
        self.draws, self.t = draws, t
        self.normal = ""
        self.ground: dict[str, FramePart] = {}
        self.bodies: list[BodyPart] = []
        self.joints: list[JointPart] = []
        self.placed: dict[str, tuple[Array, Array]] = {}

    def frame(self, body: str) -> str:
        """The address of a new frame on a body, or seldom of its centre of mass."""
        if body != "ground" and self.draws.chance(0.08):
            return body
        return self.put(body, self.draws.flat_frame(self.normal) if self.normal else self.draws.frame())

    def put(self, body: str, frame: FramePart) -> str:
        """The address of a given frame, entered on a body."""
        frames = self.ground if body == "ground" else next(b for b in self.bodies if b.name == body).frames
        name = f"f{len(frames)}"
        frames[name] = frame
        return f"{body}.{name}"

    def drop(self, joint: JointPart) -> None:
        """Take back the frames made for a joint."""
        for address in (joint.start, joint.end):
            body, _, name = address.partition(".")
            if name:
                frames = (
                    self.ground if body == "ground" else next(b for b in self.bodies if b.name == body).frames
                )
                del frames[name]

    def add_body(self, kind: str) -> None:
        """Hang a new body on ground or an earlier body; "none" leaves it free."""
        draws, rng = self.draws, self.draws.rng
        name = f"B{len(self.bodies) + 1}"
        last = self.bodies[-1].name if self.bodies else "ground"
        others = ["ground", *(body.name for body in self.bodies if body.name not in self.placed)]
        parent = last if last in others and draws.chance(0.6) else rng.choice(others)
        self.bodies.append(draws.body(name))
        if kind == "none":
            r = np.array(draws.at())
            self.placed[name] = (r, draws.rotation())
            return
        start, end = self.frame(parent), self.frame(name)
        if draws.chance(0.4):
            start, end = end, start
        self.joints.append(self.joint(kind, start, end))

    def joint(self, kind: str, start: str, end: str, closing: bool = False) -> JointPart:
        """A joint with random coordinates; between frames of a planar draft it stays in the plane."""
        draws, rng = self.draws, self.draws.rng
        name = f"J{len(self.joints) + 1}"
        sequence, speeds = "", "rates"
        speed_names: tuple[str, ...] = ()
        if "o" in LAYOUT[kind]:
            sequence = draws.sequence(kind in ("spherical", "free"))
        values: tuple[float, ...] = ()
        for letter in LAYOUT[kind]:
            if letter == "o":
                values += draws.orientation(sequence)
            else:
                values += (draws.number(-3, 3) if letter == "a" else draws.number() * draws.units.length,)
        if kind == "constant_velocity":  # away from the singularity; a bend backwards is another azimuth
            values = (draws.number(0.3, 1.4), values[1])
        if kind in ("spherical", "free"):
            words = ["start", "end", "rates"] + ["twist"] * (kind == "free")
            speeds = rng.choice([w for w in words if w != "rates" or sequence != "quaternion"])
            if speeds != "rates" and draws.chance(0.3):
                speed_names = tuple(f"{name}_s{k}" for k in range(FREEDOMS[kind]))
        named = not (closing and draws.chance(0.4))
        axis = self.axis(kind)
        second: Axis = self.axis("prismatic") if self.normal else draws.across(axis)
        joint = JointPart(
            name, kind, start, end, coordinate_names(name, kind, sequence, named), values, axis, second,
            draws.number(-4, 4) * draws.units.length, sequence, speeds, speed_names, named, closing=closing,
        )  # fmt: skip
        return self._driven(joint)

    def _driven(self, joint: JointPart) -> JointPart:
        """The joint, with one of its coordinates prescribed now and then."""
        draws = self.draws
        if joint.kind in ("weld", "spherical", "free") or not draws.chance(0.07 if joint.closing else 0.12):
            return joint
        k = draws.rng.randrange(len(joint.names))
        is_angle = letters(joint)[k] != "d"
        motion = draws.motion(joint.values[k], 1.0 if is_angle else draws.units.length, self.t)
        return replace(joint, motions={joint.names[k]: motion}, as_constraint=draws.chance(0.4))

    def axis(self, kind: str) -> Axis:
        draws = self.draws
        if not self.normal:
            plain = kind in ("planar", "rectangular", "constant_velocity")
            return draws.rng.choice("xyz") if plain else draws.axis()
        if kind != "prismatic":
            return self.normal
        first, second = PLANE[self.normal]
        if draws.chance(0.5):
            return "xyz"[first]
        parts = [0.0, 0.0, 0.0]
        parts[first], parts[second] = draws.number(), draws.number()
        return (parts[0], parts[1], parts[2])

    def finished(self) -> Mechanism:
        """The mechanism so far."""
        found = Mechanism(
            0, "", self.draws.units, (0.0, 0.0, 0.0), self.ground, tuple(self.bodies), tuple(self.joints),
            placed=self.placed, t=self.t,
        )  # fmt: skip
        return found


def coordinate_names(name: str, kind: str, sequence: str, named: bool) -> tuple[str, ...]:
    """Names of the coordinates: of their own, or those that the joint's name gives."""
    orientation = ("qw", "qx", "qy", "qz") if sequence == "quaternion" else ("1", "2", "3")
    count = len(LAYOUT[kind].replace("o", "ooo"))
    words = tuple(str(k + 1) for k in range(count)) if count > 1 else ("",) * count
    if kind in ("spherical", "free"):
        words = ("x", "y", "z", *orientation)[0 if kind == "free" else 3 :]
    own = f"c{name}" if named else name
    return tuple(f"{own}_{word}" if word else own for word in words)


def independent_speeds(mechanism: Mechanism, rank: int, places: dict[str, tuple[Array, Array]]) -> int:
    """Freedoms without prescribed ones, less what loops remove."""
    motion = all_freedoms(mechanism, places)
    return motion.size - len(motion.known) - rank
