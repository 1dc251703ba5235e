"""Forces of a model on the graph: gravity, drives of joint coordinates, forces and torques, springs.

Returned together: the loads to project, the potential energy of those that have one, and the power of
all others, so that ``d(T + V)/dt = power`` holds identically.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.equations.kinematics import Kinematics
from symbody.equations.naming import Names
from symbody.equations.virtual_work import Effort, Inertia, Load, PointForce
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Kind
from symbody.expr.rewrite import dependence
from symbody.model.forces import Drive
from symbody.model.model import Model
from symbody.vectors.vector import dot, vector


@dataclass(frozen=True, slots=True)
class Loads:
    """Everything that acts on the bodies.

    Attributes
    ----------
    loads : tuple of Load
        What is projected on the partial velocities.
    potential_energy : Expr
        Of gravity and of springs with constant stiffness and free length [J].
    power : Expr
        Of everything else [W].
    efforts : mapping of joint name to Expr
        Applied + spring + damper along the positive coordinate; "joint coordinate" where several.
    """

    loads: tuple[Load, ...]
    potential_energy: Expr
    power: Expr
    efforts: Mapping[str, Expr]


@dataclass(frozen=True, slots=True)
class _DriveLaw:
    """One drive along a scalar: its effort, and how the effort's power divides."""

    effort: Expr
    potential: Expr
    power: Expr


def form_loads(model: Model, names: Names, kinematics: Kinematics, bodies: Sequence[Inertia]) -> Loads:
    """Return the loads of a model."""
    zero = number(names.graph, 0)
    gravity = vector("ground", names.triple(model.gravity, "gravity"))
    loads: list[Load] = []
    potential, power = zero, zero
    for body in bodies:
        weight = gravity * body.mass
        if not weight.is_zero:
            loads.append(PointForce(body.frame, weight))
            potential = potential - dot(kinematics.tree, kinematics.positions[body.frame], weight)
    efforts: dict[str, Expr] = {}
    for joint in model.joints:
        several = len(joint.coordinates) > 1
        for coordinate, drive in joint.drives.items():
            x, rate = names.symbol(coordinate), names.symbol(f"{coordinate}_dot")
            law = _drive_law(names, drive, x, rate, f"joint {joint.name}")
            loads.append(Effort(rate, law.effort))
            efforts[f"{joint.name} {coordinate}" if several else joint.name] = law.effort
            potential, power = potential + law.potential, power + law.power
    return Loads(tuple(loads), potential, power, efforts)


def _drive_law(names: Names, drive: Drive, x: Expr, rate: Expr, where: str) -> _DriveLaw:
    stiffness = names.expression(drive.stiffness, where)
    stretch = x - names.expression(drive.free, where)
    spring = -(stiffness * stretch)
    other = names.expression(drive.applied, where) - names.expression(drive.damping, where) * rate
    if _constant(stiffness) and _constant(names.expression(drive.free, where)):
        return _DriveLaw(other + spring, stiffness * stretch**2 / 2, other * rate)
    return _DriveLaw(other + spring, number(names.graph, 0), (other + spring) * rate)


def _constant(x: Expr) -> bool:
    return dependence(x.graph, [x.index])[x.index] <= {Kind.PARAMETER}
