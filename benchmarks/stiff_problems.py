"""Stiff mechanisms, each described by its numbers, so that any engine can build it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import singledispatch
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import symbody as sb

Floats = NDArray[np.float64]

GRAVITY: Final = 9.81  # m/s^2


@dataclass(frozen=True, slots=True)
class Beam:
    """A beam of rigid segments with springs between them, hinged and released level.

    Kane, Ryan and Banerjee 1987: 10 m, 1.2 kg/m, 14 kN m^2; `delay` is damping over stiffness [s].
    """

    count: int
    delay: float = 0.0
    beam_length: float = 10.0
    beam_mass: float = 12.0
    bending: float = 1.4e4

    @property
    def length(self) -> float:
        """Of a segment [m]."""
        return self.beam_length / self.count

    @property
    def mass(self) -> float:
        """Of a segment [kg]."""
        return self.beam_mass / self.count

    @property
    def inertia(self) -> tuple[float, float, float]:
        """Of a segment about its centre [kg m^2]."""
        across = self.mass * self.length**2 / 12.0
        return (1e-6, across, across)

    @property
    def stiffness(self) -> float:
        """Of the spring between two segments [N m/rad]."""
        return self.bending / self.length


@dataclass(frozen=True, slots=True)
class Bushing:
    """A pendulum whose pivot is a soft joint: `arm` [m] from the centre of mass to the pivot."""

    mass: float = 2.0
    inertia: float = 0.5
    arm: float = 1.0
    stiffness: float = 1e7
    damping: float = 1e4
    start: float = 1.5


@dataclass(frozen=True, slots=True)
class Ball:
    """A ball dropped on ground that pushes back with k x^1.5 (1 + d x') at depth x (Hunt, Crossley 1975)."""

    mass: float = 1.0
    height: float = 1.0
    stiffness: float = 1e8
    damping: float = 0.1


@dataclass(frozen=True, slots=True)
class Box:
    """A box on a spring, sliding on ground until it sticks: friction mu m g v / sqrt(v^2 + v0^2)."""

    mass: float = 1.0
    stiffness: float = 100.0
    mu: float = 0.3
    v0: float = 1e-4
    start: float = 0.2


Stiff = Beam | Bushing | Ball | Box

PROBLEMS: Final[Mapping[str, Stiff]] = MappingProxyType(
    {
        "8 segments": Beam(8),
        "16 segments": Beam(16),
        "32 segments": Beam(32),
        "16 segments, damped": Beam(16, delay=2e-3),
        "bushing": Bushing(),
        "bouncing ball": Ball(),
        "sliding box": Box(),
    }
)


@singledispatch
def model_of(problem: Any) -> sb.Model:
    """Return the mechanism as a model."""
    raise TypeError(problem)


@model_of.register
def _(problem: Beam) -> sb.Model:
    half = 0.5 * problem.length
    ends = {"a": sb.Frame(at=(-half, 0, 0)), "b": sb.Frame(at=(half, 0, 0))}
    spring = sb.Drive(stiffness=problem.stiffness, damping=problem.delay * problem.stiffness)
    parts: list[Any] = []
    before = "ground"
    for k in range(problem.count):
        parts.append(sb.Body(f"S{k}", mass=problem.mass, inertia=problem.inertia, frames=ends))
        torque = spring if k else None
        parts.append(sb.Revolute(f"j{k}", before, f"S{k}.a", axis="z", coordinate=f"q{k}", torque=torque))
        before = f"S{k}.b"
    return sb.Model("beam", parts, gravity=(0, -GRAVITY, 0))


@model_of.register
def _(problem: Bushing) -> sb.Model:
    pivot = {"pivot": sb.Frame(at=(0, problem.arm, 0))}
    arm = sb.Body("Arm", mass=problem.mass, inertia=(0, 0, problem.inertia), frames=pivot)
    rubber = sb.Drive(stiffness=problem.stiffness, damping=problem.damping)
    force = {"x": rubber, "y": rubber}
    mount = sb.Planar("mount", "ground", "Arm.pivot", coordinates=["x", "y", "theta"], force=force)
    return sb.Model("bushing", [arm, mount], gravity=(0, -GRAVITY, 0), initial={"theta": problem.start})


@model_of.register
def _(problem: Ball) -> sb.Model:
    law = f"{problem.stiffness}*max(-y, 0)^1.5*(1 - {problem.damping}*y_dot)"
    return _sliding(problem.mass, "y", law, problem.height)


@model_of.register
def _(problem: Box) -> sb.Model:
    strength = problem.mu * problem.mass * GRAVITY
    law = f"-{problem.stiffness}*x - {strength}*x_dot/sqrt(x_dot^2 + {problem.v0}^2)"
    return _sliding(problem.mass, "x", law, problem.start)


def _sliding(mass: float, coordinate: str, law: str, start: float) -> sb.Model:
    body = sb.Body("Body", mass=mass)
    guide = sb.Prismatic(
        "guide", "ground", "Body", axis=coordinate, coordinate=coordinate, force=sb.Drive(applied=law)
    )
    return sb.Model("body", [body, guide], gravity=(0, -GRAVITY, 0), initial={coordinate: start})


def places(problem: Stiff) -> Callable[[Floats], Floats]:
    """Return what gives the places [m] or angles [rad] at the end, from coordinates in the model's order."""
    if isinstance(problem, Beam):
        return lambda q: _tip(problem.length, q)
    if isinstance(problem, Bushing):
        return lambda q: q[2:]
    return lambda q: q


def _tip(length: float, q: Floats) -> Floats:
    angles = np.cumsum(q)
    return length * np.array([np.cos(angles).sum(), np.sin(angles).sum()])
