"""Forces of a model on the graph: gravity, drives of joint coordinates, forces and torques, springs.

Returned together: the loads to project, the potential energy of those that have one, and the power of
all others, so that ``d(T + V)/dt = power`` holds identically.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.load import Effort, Load, Moment, PointForce, Pull
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import Use
from symbody.expr.expression import Expr, number, sqrt
from symbody.expr.graph import Kind
from symbody.expr.rewrite import dependence
from symbody.model.forces import Drive, Force, SpringDamper, Torque
from symbody.model.joint import Joint
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


def form_loads(
    model: Model, names: Names, kinematics: Kinematics, bodies: Sequence[Inertia], uses: Sequence[Use]
) -> Loads:
    """Return the loads of a model.

    The drive of a prescribed coordinate does nothing here: it is part of the effort that holds the motion.
    """
    zero = number(names.graph, 0)
    laws = _weights(model, names, kinematics, bodies)
    efforts: dict[str, Expr] = {}
    for use in uses:
        for coordinate, drive in use.joint.drives.items():
            if coordinate in use.prescribed:
                continue
            x, rate = names.value(coordinate), names.value(f"{coordinate}_dot")
            drive_law = _drive_law(names, drive, x, rate, f"joint {use.joint.name}")
            key = effort_name(use.joint, coordinate)
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


def effort_name(joint: Joint, coordinate: str) -> str:
    """Return the name of the effort along a coordinate: the joint, and the coordinate if it has several."""
    return f"{joint.name} {coordinate}" if len(joint.coordinates) > 1 else joint.name


def _weights(model: Model, names: Names, kinematics: Kinematics, bodies: Sequence[Inertia]) -> list[_Law]:
    gravity = vector("ground", names.triple(model.gravity, "gravity"))
    laws = []
    for body in bodies:
        weight = gravity * body.mass
        if not weight.is_zero:
            fallen = dot(kinematics.tree, kinematics.arm("ground", body.frame), weight)
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
    arm = kinematics.arm(start, end)
    closing = dot(tree, arm, kinematics.velocities[end].value - kinematics.velocities[start].value)
    square = dot(tree, arm, arm)
    stiffness, free = names.expression(spring.stiffness, where), names.expression(spring.free, where)
    applied, damping = names.expression(spring.applied, where), names.expression(spring.damping, where)
    zero = number(names.graph, 0)
    length = sqrt(square)
    rate = zero if closing.is_zero else closing / length
    along = applied - damping * rate
    factor = -stiffness if along.is_zero else along / length - stiffness
    energy = stiffness * square / 2
    if not free.is_zero:
        factor = (along - stiffness * (length - free)) / length
        energy = stiffness * (length - free) ** 2 / 2
    load = Pull(start, end, arm, factor)
    if _constant(stiffness) and _constant(free):
        return _Law((load,), energy, along * rate)
    return _Law((load,), zero, factor * closing)


def _force_law(names: Names, kinematics: Kinematics, force: Force) -> _Law:
    tree = kinematics.tree
    value = vector(force.resolved_in.frame, names.triple(force.vector, f"force {force.name}"))
    on, back = force.on.frame, force.reaction_on.body
    arm = kinematics.arm(back, on)
    turning = cross(tree, kinematics.angular_velocities[back].value, arm)
    v_back = kinematics.velocities[back].value + turning
    power = dot(tree, value, kinematics.velocities[on].value - v_back)
    return _Law((PointForce(on, value), PointForce(back, -value, arm)), number(names.graph, 0), power)


def _torque_law(names: Names, kinematics: Kinematics, torque: Torque) -> _Law:
    value = vector(torque.resolved_in.frame, names.triple(torque.vector, f"torque {torque.name}"))
    on, back = torque.on.body, torque.reaction_on.body
    turning = kinematics.angular_velocities[on].value - kinematics.angular_velocities[back].value
    loads = (Moment(on, value), Moment(back, -value))
    return _Law(loads, number(names.graph, 0), dot(kinematics.tree, value, turning))


def _constant(x: Expr) -> bool:
    return dependence(x.graph, [x.index])[x.index] <= {Kind.PARAMETER}
