"""Random numbers, frames, tensors and laws from one generator of random numbers."""

from __future__ import annotations

import math
import random
from itertools import product

import numpy as np

from tests.laws.parts import EXACT_ANGLES, BodyPart, DrivePart, FramePart, Law, MotionPart, Term, Units
from tests.laws.rotations import Array, Axis, turned, unit

SEQUENCES = tuple("".join(w) for w in product("xyz", repeat=3) if w[0] != w[1] != w[2])
EXACT_AXES = ((1.0, 2.0, 2.0), (3.0, 0.0, 4.0), (2.0, -3.0, 6.0), (0.0, 0.0, -1.0), (-1.0, 4.0, 8.0))
PLANE = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}


class Draws:
    """A seeded source; lengths, masses and times come in the units given."""

    def __init__(self, rng: random.Random, units: Units) -> None:
        self.rng, self.units = rng, units

    def chance(self, share: float) -> bool:
        return self.rng.random() < share

    def number(self, low: float = -1.0, high: float = 1.0) -> float:
        """A decimal of three digits; never so small that it means zero."""
        found = round(self.rng.uniform(low, high), 3)
        return found if abs(found) > 0.02 else 0.3

    def axis(self) -> Axis:
        """A letter, an axis of rational length, or a general one."""
        kind = self.rng.randrange(3)
        if kind == 0:
            return self.rng.choice("xyz")
        return self.rng.choice(EXACT_AXES) if kind == 1 else (self.number(), self.number(), self.number())

    def across(self, axis: Axis) -> Axis:
        """An axis perpendicular to another."""
        others = [letter for letter in "xyz" if letter != axis]
        if isinstance(axis, str) and self.chance(0.5):
            return self.rng.choice(others)
        x, y, z = np.cross(unit(axis), unit(self.axis()))
        if x * x + y * y + z * z < 0.1:
            return self.across(axis)
        return (float(x), float(y), float(z))

    def at(self) -> tuple[float, float, float]:
        """An offset; some components are zero."""
        x, y, z = (self.number() * self.units.length if self.chance(0.8) else 0.0 for _ in range(3))
        return (x, y, z)

    def turns(self) -> tuple[tuple[Axis, float | str], ...]:
        """No to three turns about general axes."""
        return tuple((self.axis(), self.angle()) for _ in range(self.rng.choice([0, 0, 1, 1, 2, 3])))

    def angle(self) -> float | str:
        return self.rng.choice(list(EXACT_ANGLES)) if self.chance(0.25) else self.number(-3.0, 3.0)

    def frame(self) -> FramePart:
        return FramePart(self.at(), self.turns(), by_matrix=self.chance(0.15))

    def flat_frame(self, normal: str) -> FramePart:
        """A frame in a plane, turned about its normal."""
        at = [0.0, 0.0, 0.0]
        for k in PLANE[normal]:
            at[k] = self.number() * self.units.length
        return FramePart((at[0], at[1], at[2]), ((normal, self.angle()),) if self.chance(0.6) else ())

    def rotation(self) -> Array:
        """A random rotation matrix."""
        return turned(self.axis(), self.number(-3, 3)) @ turned(self.axis(), self.number(-3, 3))

    def body(self, name: str) -> BodyPart:
        """Mass over three decades; radii of gyration near the unit of length; a possible tensor."""
        mass = self.units.mass * 10 ** self.rng.uniform(-1.5, 1.5)
        a, b, c = (self.number(0.1, 1.0) for _ in range(3))
        kind = self.rng.choice(["general", "general", "diagonal", "axisymmetric", "isotropic"])
        if kind == "isotropic":
            a = b = c
        if kind == "axisymmetric":
            a, b, c = self.rng.choice([(a, a, c), (a, b, b), (a, b, a)])
        tensor = mass * self.units.length**2 * 0.3 * np.diag([b + c, a + c, a + b])
        if kind == "general":
            r = self.rotation()
            tensor = r @ tensor @ r.T
            tensor = (tensor + tensor.T) / 2
        return BodyPart(name, mass, tensor)

    def sequence(self, quaternions: bool = True) -> str:
        """Any of 12 sequences about body axes, 12 about space axes, or a quaternion."""
        if quaternions and self.chance(0.3):
            return "quaternion"
        word = self.rng.choice(SEQUENCES)
        word = "".join("123"["xyz".index(c)] for c in word) if self.chance(0.5) else word
        return f"space {word}" if self.chance(0.5) else word

    def orientation(self, sequence: str) -> tuple[float, ...]:
        """Coordinates at least 0.4 rad away from the singularity of the sequence."""
        if sequence == "quaternion":
            e = np.array([self.rng.gauss(0, 1) for _ in range(4)])
            return tuple(float(x) for x in e / np.linalg.norm(e))
        letters = sequence.removeprefix("space ")
        middle = self.number(0.4, math.pi - 0.4) * self.rng.choice([-1, 1])
        if letters[0] != letters[2]:
            middle = self.number(0.4 - math.pi / 2, math.pi / 2 - 0.4)
        return (self.number(-3, 3), middle, self.number(-3, 3))

    def motion(self, value: float, unit: float, t: float) -> MotionPart:
        """A motion that has a value at a time."""
        amplitude, scale = self.number(0.1, 0.8) * unit, self.number(0.5, 2.0) * self.units.time
        return MotionPart(value - amplitude * math.sin(t / scale), amplitude, scale)

    def law(self, unit: float, readable: list[tuple[str, float]], least: int = 0) -> Law:
        """A sum of functions of names, each given with its unit."""
        terms = []
        for _ in range(self.rng.randint(least, 2)):
            factor = self.number() * unit
            name, scale = self.rng.choice(readable)
            word = self.rng.choice(["one", "line", "sin", "cos", "square"])
            terms.append(Term(factor) if word == "one" else Term(factor, word, name, scale))
        return tuple(terms)

    def drive(self, effort: float, unit: float, readable: list[tuple[str, float]]) -> DrivePart:
        """A drive along a coordinate with the given units of effort and coordinate."""
        stiffness = self.number(0.1, 3.0) * effort / unit if self.chance(0.6) else 0.0
        damping = self.number(0.05, 1.0) * effort / unit * self.units.time if self.chance(0.6) else 0.0
        free = self.number() * unit if stiffness and self.chance(0.5) else 0.0
        return DrivePart(self.law(effort, readable), stiffness, damping, free)
