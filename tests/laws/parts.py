"""What a random mechanism consists of: plain values that NumPy can compute with, and the model made of them.

Every number is in the mechanism's own units of length, mass and time, already multiplied by them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from tests.laws.rotations import Array, Axis, turned

# Angles that stay exact in the model.
EXACT_ANGLES = {
    "pi/2": math.pi / 2,
    "-pi/2": -math.pi / 2,
    "pi": math.pi,
    "pi/3": math.pi / 3,
    "-pi/6": -math.pi / 6,
}
Angle = float | str
SLOPES: dict[str, Callable[[float], float]] = {
    "one": lambda x: 0.0, "line": lambda x: 1.0, "square": lambda x: 2 * x, "sin": math.cos,
    "cos": lambda x: -math.sin(x),
}  # fmt: skip
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "one": lambda x: 1.0, "line": lambda x: x, "square": lambda x: x * x, "sin": math.sin, "cos": math.cos,
}  # fmt: skip


def angle_value(angle: Angle) -> float:
    """The number of an angle."""
    return EXACT_ANGLES[angle] if isinstance(angle, str) else angle


@dataclass(frozen=True, slots=True)
class Term:
    """``factor * function(name / scale)``"""

    factor: float
    function: str = "one"
    name: str = ""
    scale: float = 1.0

    @property
    def text(self) -> str:
        factor = f"({self.factor!r})"
        argument = f"({self.name}/{self.scale!r})"
        if self.function == "one":
            return factor
        if self.function in ("line", "square"):
            return f"{factor}*{argument}" + ("**2" if self.function == "square" else "")
        return f"{factor}*{self.function}{argument}"

    def value(self, known: Mapping[str, float]) -> float:
        return self.factor * float(
            FUNCTIONS[self.function](known[self.name] / self.scale if self.name else 0.0)
        )

    def slope(self, known: Mapping[str, float]) -> float:
        """The derivative by what is named."""
        return self.factor / self.scale * float(SLOPES[self.function](known[self.name] / self.scale))


Law = tuple[Term, ...]


def law_text(law: Law) -> str:
    """A law as the model reads it."""
    return " + ".join(term.text for term in law) or "0"


def law_value(law: Law, known: Mapping[str, float]) -> float:
    """The value of a law."""
    return sum(term.value(known) for term in law)


@dataclass(frozen=True, slots=True, eq=False)
class FramePart:
    """A frame on a body: origin, and successive turns."""

    at: tuple[float, float, float]
    turns: tuple[tuple[Axis, Angle], ...] = ()
    by_matrix: bool = False

    @property
    def matrix(self) -> Array:
        r = np.eye(3)
        for axis, angle in self.turns:
            r = r @ turned(axis, angle_value(angle))
        return r


@dataclass(frozen=True, slots=True, eq=False)
class BodyPart:
    """A rigid body; the tensor is about its centre of mass."""

    name: str
    mass: float
    tensor: Array
    frames: dict[str, FramePart] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class DrivePart:
    """``applied - stiffness (x - free) - damping x_dot``"""

    applied: Law = ()
    stiffness: float = 0.0
    damping: float = 0.0
    free: float = 0.0


@dataclass(frozen=True, slots=True)
class MotionPart:
    """``mean + amplitude sin(t / scale)``"""

    mean: float
    amplitude: float
    scale: float

    @property
    def text(self) -> str:
        return f"({self.mean!r}) + ({self.amplitude!r})*sin(t/({self.scale!r}))"

    def at(self, t: float) -> float:
        return self.mean + self.amplitude * math.sin(t / self.scale)

    def rate(self, t: float) -> float:
        return self.amplitude / self.scale * math.cos(t / self.scale)

    def second_rate(self, t: float) -> float:
        return -self.amplitude / self.scale**2 * math.sin(t / self.scale)


@dataclass(frozen=True, slots=True)
class JointPart:
    """A joint with the values of its coordinates at the pose.

    Attributes
    ----------
    kind : str
        The type as a model file calls it.
    start, end : str
        "Body.frame", or "ground.frame".
    names : tuple of str
        Coordinates; of a free joint three for the position, then the orientation.
    second : letter or components
        The second axis of a universal joint or pin in a slot.
    pitch : float
        Of a screw, for a full turn.
    sequence : str
        Of joints that turn in any direction: "xyz", "space xyz", "quaternion".
    """

    name: str
    kind: str
    start: str
    end: str
    names: tuple[str, ...] = ()
    values: tuple[float, ...] = ()
    axis: Axis = "z"
    second: Axis = "x"
    pitch: float = 0.0
    sequence: str = ""
    speeds: str = "rates"
    speed_names: tuple[str, ...] = ()
    named: bool = True
    drives: dict[str, DrivePart] = field(default_factory=dict)
    motions: dict[str, MotionPart] = field(default_factory=dict)
    as_constraint: bool = False
    closing: bool = False
    armature: float = 0.0


@dataclass(frozen=True, slots=True)
class SpringPart:
    """A spring and damper between two frames."""

    name: str
    start: str
    end: str
    stiffness: float
    damping: float
    free: float
    applied: Law = ()


@dataclass(frozen=True, slots=True)
class LoadPart:
    """A force in a frame's origin, or a torque, and its reaction on another body."""

    name: str
    is_force: bool
    on: str
    vector: tuple[Law, Law, Law]
    resolved_in: str
    reaction_on: str


STILL = MotionPart(0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class ContactPart:
    """A constraint between two frames.

    Attributes
    ----------
    kind : str
        distance, line, plane, surface, parallel, perpendicular, angle, knife, sphere or disc.
    axis, second : letter or components
        A direction in start (of the line, the normal of plane or ground) and one in end (of the blade, the axle).
    value : MotionPart
        The distance, the angle or, still, the radius.
    surface : tuple of laws in x, y, z
    """

    name: str
    kind: str
    start: str
    end: str
    axis: Axis = "z"
    second: Axis = "z"
    value: MotionPart = STILL
    surface: tuple[Law, ...] = ()

    @property
    def rolls(self) -> bool:
        """Whether it is a sphere or a disc, which has a contact frame of its own."""
        return self.kind in ("sphere", "disc")


@dataclass(frozen=True, slots=True)
class CouplingPart:
    """An equation in coordinates, ``sum of terms = offset``, or in rates, ``sum of terms times rates = offset``.

    Attributes
    ----------
    kind : str
        gear, rack, belt, differential (terms are lines without scales), equation or rates.
    along : tuple of str
        The coordinate whose rate each term is multiplied by; () where coordinates are coupled.
    """

    name: str
    kind: str
    terms: Law
    offset: MotionPart = STILL
    along: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Units:
    """Units of length, mass and time in terms of those the numbers are in."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    @property
    def acceleration(self) -> float:
        return self.length / self.time**2

    @property
    def force(self) -> float:
        return self.mass * self.acceleration

    @property
    def torque(self) -> float:
        return self.force * self.length


@dataclass(frozen=True, slots=True, eq=False)
class Mechanism:
    """A mechanism, a pose in which all its loops are closed, and what kind it is.

    Attributes
    ----------
    placed : mapping of body to (position, rotation matrix)
        Where bodies without any joint are.
    inputs : mapping of name to number
        Values of the inputs at the pose.
    loops : int
        Closing joints that remove freedom.
    freedoms : int
        Independent speeds; prescribed motions have none.
    redundant : int
        Locked directions of all joints that depend on others; reactions are unique where it is 0.
    rejected : tuple of str
        Reasons of earlier attempts with the same seed.
    """

    seed: int
    family: str
    units: Units
    gravity: tuple[float, float, float]
    ground: dict[str, FramePart]
    bodies: tuple[BodyPart, ...]
    joints: tuple[JointPart, ...]
    springs: tuple[SpringPart, ...] = ()
    loads: tuple[LoadPart, ...] = ()
    contacts: tuple[ContactPart, ...] = ()
    couplings: tuple[CouplingPart, ...] = ()
    inputs: dict[str, float] = field(default_factory=dict)
    placed: dict[str, tuple[Array, Array]] = field(default_factory=dict)
    t: float = 0.0
    symbolic: bool = True
    loops: int = 0
    freedoms: int = 0
    redundant: int = 0
    rejected: tuple[str, ...] = ()

    @property
    def linked(self) -> tuple[str, ...]:
        """Names of joints and contacts: each has a reaction."""
        return (*(joint.name for joint in self.joints), *(contact.name for contact in self.contacts))

    @property
    def constrained(self) -> tuple[tuple[str, str], ...]:
        """Name and kind of each constraint."""
        found = [(contact.name, contact.kind) for contact in self.contacts]
        return (*found, *((coupling.name, coupling.kind) for coupling in self.couplings))

    def frame(self, address: str) -> tuple[str, FramePart]:
        """The body and the frame of an address."""
        body, _, name = address.partition(".")
        if not name:
            return body, FramePart((0.0, 0.0, 0.0))
        frames = self.ground if body == "ground" else self.body(body).frames
        return body, frames[name]

    def body(self, name: str) -> BodyPart:
        return next(body for body in self.bodies if body.name == name)

    def joint(self, name: str) -> JointPart:
        return next(joint for joint in self.joints if joint.name == name)
