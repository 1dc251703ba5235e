"""Forces of a model on the graph: gravity, drives of joint coordinates, forces and torques, springs.

Returned together: the loads to project, the potential energy of those that have one, and the power of
all others, so that ``d(T + V)/dt = power`` holds identically.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.equations.kinematics import Kinematics
from symbody.equations.naming import Names
from symbody.equations.virtual_work import Effort, Inertia, Load, Moment, PointForce
from symbody.expr.expression import Expr, number, sqrt
from symbody.expr.graph import Kind
from symbody.expr.rewrite import dependence
from symbody.model.forces import Drive, Force, SpringDamper, Torque
from symbody.model.model import Model
from symbody.vectors.vector import cross, dot, vector


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
class _Law:
    """What one element does: its loads, its potential, and the power of what has none."""

    loads: tuple[Load, ...]
    potential: Expr
    power: Expr


def form_loads(model: Model, names: Names, kinematics: Kinematics, bodies: Sequence[Inertia]) -> Loads:
    """Return the loads of a model."""
    zero = number(names.graph, 0)
    laws = _weights(model, names, kinematics, bodies)
    efforts: dict[str, Expr] = {}
    for joint in model.joints:
        several = len(joint.coordinates) > 1
        for coordinate, drive in joint.drives.items():
            x, rate = names.symbol(coordinate), names.symbol(f"{coordinate}_dot")
            drive_law = _drive_law(names, drive, x, rate, f"joint {joint.name}")
            key = f"{joint.name} {coordinate}" if several else joint.name
            efforts.update((key, load.effort) for load in drive_law.loads if isinstance(load, Effort))
            laws.append(drive_law)
    for element in model.elements:
        if isinstance(element, Force):
            laws.append(_force_law(names, kinematics, element))
        elif isinstance(element, Torque):
            laws.append(_torque_law(names, kinematics, element))
        elif isinstance(element, SpringDamper):
            laws.append(_spring_law(names, kinematics, element))
    potential, power = zero, zero
    for law in laws:
        potential, power = potential + law.potential, power + law.power
    return Loads(tuple(load for law in laws for load in law.loads), potential, power, efforts)


def _weights(model: Model, names: Names, kinematics: Kinematics, bodies: Sequence[Inertia]) -> list[_Law]:
    gravity = vector("ground", names.triple(model.gravity, "gravity"))
    laws = []
    for body in bodies:
        weight = gravity * body.mass
        if not weight.is_zero:
            fallen = dot(kinematics.tree, kinematics.positions[body.frame], weight)
            laws.append(_Law((PointForce(body.frame, weight),), -fallen, number(names.graph, 0)))
    return laws


def _drive_law(names: Names, drive: Drive, x: Expr, rate: Expr, where: str) -> _Law:
    stiffness, free = names.expression(drive.stiffness, where), names.expression(drive.free, where)
    other = names.expression(drive.applied, where) - names.expression(drive.damping, where) * rate
    return _line_law(rate, stiffness, x - free, other, free)


def _line_law(rate: Expr, stiffness: Expr, stretch: Expr, other: Expr, free: Expr) -> _Law:
    """Return the law of a spring along a scalar, with another effort beside it."""
    spring = -(stiffness * stretch)
    load = Effort(rate, other + spring)
    if _constant(stiffness) and _constant(free):
        return _Law((load,), stiffness * stretch**2 / 2, other * rate)
    return _Law((load,), number(rate.graph, 0), (other + spring) * rate)


def _spring_law(names: Names, kinematics: Kinematics, spring: SpringDamper) -> _Law:
    """Return the law of a spring between two points, positive pushing them apart.

    With free length exactly 0 the spring is the vector law ``-k d``, which is smooth at length 0.
    """
    tree, where = kinematics.tree, f"spring {spring.name}"
    start, end = spring.start.frame, spring.end.frame
    arm = kinematics.positions[end] - kinematics.positions[start]
    closing = dot(tree, arm, kinematics.velocities[end] - kinematics.velocities[start])
    square = dot(tree, arm, arm)
    stiffness, free = names.expression(spring.stiffness, where), names.expression(spring.free, where)
    applied, damping = names.expression(spring.applied, where), names.expression(spring.damping, where)
    zero = number(names.graph, 0)
    length = sqrt(square)
    rate = zero if closing.is_zero else closing / length
    along = applied - damping * rate
    if not free.is_zero:
        return _line_law(rate, stiffness, length - free, along, free)
    spring_load = Effort(closing, -stiffness)
    loads = (spring_load,) if along.is_zero else (spring_load, Effort(rate, along))
    if _constant(stiffness):
        return _Law(loads, stiffness * square / 2, along * rate)
    return _Law(loads, zero, along * rate - stiffness * closing)


def _force_law(names: Names, kinematics: Kinematics, force: Force) -> _Law:
    tree = kinematics.tree
    value = vector(force.resolved_in.frame, names.triple(force.vector, f"force {force.name}"))
    on, back = force.on.frame, force.reaction_on.body
    arm = kinematics.positions[on] - kinematics.positions[back]
    v_back = kinematics.velocities[back] + cross(tree, kinematics.angular_velocities[back], arm)
    power = dot(tree, value, kinematics.velocities[on] - v_back)
    return _Law((PointForce(on, value), PointForce(back, -value, arm)), number(names.graph, 0), power)


def _torque_law(names: Names, kinematics: Kinematics, torque: Torque) -> _Law:
    value = vector(torque.resolved_in.frame, names.triple(torque.vector, f"torque {torque.name}"))
    on, back = torque.on.body, torque.reaction_on.body
    turning = kinematics.angular_velocities[on] - kinematics.angular_velocities[back]
    loads = (Moment(on, value), Moment(back, -value))
    return _Law(loads, number(names.graph, 0), dot(kinematics.tree, value, turning))


def _constant(x: Expr) -> bool:
    return dependence(x.graph, [x.index])[x.index] <= {Kind.PARAMETER}
