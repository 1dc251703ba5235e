"""Bodies that fall on a floor, each described by its numbers, so that any engine can build them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import symbody as sb

Floats = NDArray[np.float64]

GRAVITY: Final = 9.81  # m/s^2
SAMPLE: Final = 0.1  # s between the times at which places are compared
MU: Final = 0.5
_SPEEDS: Final = tuple(f"move_{kind}{axis}" for kind in "vw" for axis in "xyz")  # of the joint in space
CREEP: Final = 1e-3  # m/s, the slip at which friction is at 0.71 of its strength


@dataclass(frozen=True)
class Falling:
    """A body that falls, tumbles and slides on a floor.

    Attributes
    ----------
    place : str
        "line": it moves along z alone; "plane": x, z and an angle about y; "space": all.
    sizes : tuple of float
        Radius of a ball, or edges of a box [m].
    height, angles, velocity, rates : float or tuple of float
        Of its centre [m]; of rotations about x, y and z, in this order [rad]; [m/s]; [rad/s].
    restitution, speed : float
        Of an impact with that speed [m/s].
    stiffness : float
        Of the law of Hunt and Crossley, exponent 3/2; of a box on an edge [N/m^1.5].
    """

    place: str
    sizes: tuple[float, ...]
    mass: float
    height: float
    restitution: float
    speed: float
    end: float
    angles: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rates: tuple[float, float, float] = (0.0, 0.0, 0.0)
    stiffness: float = 1e6

    @property
    def is_ball(self) -> bool:
        """Whether it is a ball, else a box."""
        return len(self.sizes) == 1

    @property
    def inertia(self) -> tuple[float, float, float]:
        """About its centre [kg m^2]."""
        if self.is_ball:
            return (0.4 * self.mass * self.sizes[0] ** 2,) * 3
        x, y, z = (side * side for side in self.sizes)
        return self.mass * (y + z) / 12, self.mass * (x + z) / 12, self.mass * (x + y) / 12

    @property
    def duration(self) -> float:
        """Of an elastic impact by Hertz's law with the speed [s]: 2.943 d/v (Johnson 1985, section 11.4)."""
        depth = float((1.25 * self.mass * self.speed**2 / self.stiffness) ** 0.4)
        return 2.943 * depth / self.speed

    @property
    def times(self) -> Floats:
        """When places are compared [s]."""
        return np.array(SAMPLE * np.arange(1, round(self.end / SAMPLE) + 1), dtype=np.float64)

    @cached_property
    def quaternion(self) -> Floats:
        """Of the first rotation, scalar part first."""
        w, x, y, z = 1.0, 0.0, 0.0, 0.0
        for axis, angle in enumerate(self.angles):
            c, s = math.cos(angle / 2), math.sin(angle / 2)
            a, b, d = (s if axis == k else 0.0 for k in range(3))
            w, x, y, z = (
                w * c - x * a - y * b - z * d,
                w * a + x * c + y * d - z * b,
                w * b - x * d + y * c + z * a,
                w * d + x * b - y * a + z * c,
            )
        return np.array([w, x, y, z])


PROBLEMS: Final[Mapping[str, Falling]] = MappingProxyType(
    {
        "bouncing ball": Falling("line", (0.1,), 1.0, 1.1, 0.8, math.sqrt(2 * GRAVITY), 5.0),
        "sliding box": Falling(
            "plane", (0.4, 0.2, 0.3), 2.0, 0.6, 0.3, 2.5, 2.0,
            angles=(0, 0.5, 0), velocity=(1.0, 0, 0), rates=(0, -1.0, 0),
        ),
        "tumbling box": Falling(
            "space", (0.4, 0.2, 0.3), 2.0, 0.6, 0.3, 2.5, 1.0,
            angles=(0.4, 0.5, 0.2), velocity=(1.0, 0.2, 0), rates=(1.0, -1.0, 2.0),
        ),
    }
)  # fmt: skip


def model_of(problem: Falling, *, rigid: bool) -> sb.Model:
    """Return the body over its floor as a model, the contact rigid or by Hunt and Crossley."""
    body = sb.Body("Body", mass=problem.mass, inertia=problem.inertia)
    shape: Any = {"sphere": problem.sizes[0]} if problem.is_ball else {"box": list(problem.sizes)}
    share = {"line": 1, "plane": 2, "space": 1}[problem.place]  # corners at an end of an edge in the plane
    law = sb.NormalForce(
        stiffness=problem.stiffness / share, restitution=problem.restitution, speed=problem.speed
    )
    friction = None if problem.place == "line" else sb.Friction(mu=MU, v0=None if rigid else CREEP)
    floor = sb.Contact(
        "floor", "ground", body, ["plane", shape], friction=friction,
        normal="rigid" if rigid else law, restitution=problem.restitution if rigid else 0,
    )  # fmt: skip
    joint: Any
    if problem.place == "line":
        joint = sb.Prismatic("move", "ground", body, axis="z", coordinate="z")
    elif problem.place == "plane":
        joint = sb.Planar("move", "ground", body, axis="y", coordinates=["z", "x", "angle"])
    else:
        joint = sb.Free("move", "ground", body)
    return sb.Model(problem.place, [joint, floor], gravity=(0, 0, -GRAVITY), initial=_initial(problem, joint))


def _initial(problem: Falling, joint: Any) -> dict[str, float]:
    """Return the first values of a joint; in space its rates are along the axes of the body."""
    if problem.place == "line":
        return {"z": problem.height}
    if problem.place == "plane":
        return {
            "z": problem.height, "angle": problem.angles[1],
            "x_dot": problem.velocity[0], "angle_dot": problem.rates[1],
        }  # fmt: skip
    values = (0.0, 0.0, problem.height, *problem.quaternion, *problem.velocity, *problem.rates)
    return dict(zip((*joint.coordinates, *_SPEEDS), map(float, values), strict=True))


def height_and_way(problem: Falling) -> tuple[int, ...]:
    """Return which coordinates of the model are places: z; z and x; x, y and z."""
    return {"line": (0,), "plane": (0, 1), "space": (0, 1, 2)}[problem.place]
