"""Forces of a model on the graph: gravity, drives of joint coordinates, forces and torques, springs.

Returned together: the loads to project, the potential energy of those that have one, and the power of
all others, so that ``d(T + V)/dt = power`` holds identically.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Final

from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.load import (
    GeneralizedForce,
    Law,
    Load,
    Moment,
    PointForce,
    is_constant,
    load_law,
)
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.loads.limits import limit_law
from symbody.equations.loads.springs import law_value
from symbody.expr.expression import Expr, number
from symbody.model.class_folders import module_names
from symbody.model.joint import Joint
from symbody.model.loads.forces import Drive, Force, Torque
from symbody.model.model import Model
from symbody.spatial.vector import cross, dot, vector

_FOLDER: Final = __name__.rpartition(".")[0]


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
    efforts : mapping of joint or spring to Expr
        Applied + spring + damper + limits along the positive coordinate; "joint coordinate" where several.
    without_potential : tuple of Load
        What the loads do beside the potential energy.
    measures : mapping of output to Expr
        Lengths and angles of springs: "length S", "angle S".
    notes : tuple of str
        What was chosen.
    """

    loads: tuple[Load, ...]
    potential_energy: Expr
    power: Expr
    efforts: Mapping[str, Expr]
    without_potential: tuple[Load, ...] = ()
    measures: Mapping[str, Expr] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def form_loads(
    model: Model,
    names: Names,
    kinematics: Kinematics,
    bodies: Sequence[Inertia],
    roles: Sequence[JointRole],
    friction: Sequence[FrictionLaw] = (),
    *,
    weights: bool = True,
) -> Loads:
    """Return the loads of a model.

    The drive of a prescribed coordinate does nothing here: it is part of the effort that holds the motion.

    Parameters
    ----------
    weights : bool
        Whether gravity is among the loads; a recursion accelerates ground instead.
    """
    _register_laws()
    zero = number(names.graph, 0)
    laws = _weights(model, names, kinematics, bodies) if weights else []
    efforts: dict[str, Expr] = {}
    for role in roles:
        for coordinate in role.joint.loaded_coordinates:
            if coordinate in role.prescribed_coordinates:
                continue
            acting = _laws_along(names, role.joint, coordinate)
            total = zero
            for load in (load for law in acting for load in law.loads):
                total = total + load.effort if isinstance(load, GeneralizedForce) else total
            efforts[role.joint.effort_name(coordinate)] = total
            laws += acting
    laws += [Law(rubbing.loads, zero, rubbing.effort * rubbing.rate) for rubbing in friction]
    for element in model.elements:
        law = load_law(element, names, kinematics, roles)
        if law is not None:
            laws.append(law)
    potential, power = zero, zero
    measures: dict[str, Expr] = {}
    for law in laws:
        potential, power = potential + law.potential, power + law.power
        efforts.update(law.efforts)
        measures.update(law.measures)
    without_potential = tuple(
        load
        for law in laws
        for load in (law.loads if law.without_potential is None else law.without_potential)
    )
    loads = tuple(load for law in laws for load in law.loads)
    notes = tuple(note for law in laws for note in law.notes)
    return Loads(loads, potential, power, efforts, without_potential, measures, notes)


@cache
def _register_laws() -> None:
    """Load the files of this folder, each of which registers the laws of its elements."""
    for file in module_names(_FOLDER):
        import_module(f"{_FOLDER}.{file}")


def _laws_along(names: Names, joint: Joint, coordinate: str) -> list[Law]:
    """Return what drive and compliant limits of a joint do along a coordinate."""
    where, laws = f"joint {joint.name}", []
    if coordinate in joint.drives:
        x, rate = names.value(coordinate), names.value(f"{coordinate}_dot")
        laws.append(_drive_law(names, joint.drives[coordinate], x, rate, coordinate, where))
    if coordinate in joint.compliant_limits:
        laws.append(limit_law(names, joint.compliant_limits[coordinate], coordinate, where))
    return laws


def _weights(model: Model, names: Names, kinematics: Kinematics, bodies: Sequence[Inertia]) -> list[Law]:
    gravity = vector("ground", names.triple(model.gravity, "gravity"))
    laws = []
    for body in bodies:
        weight = gravity * body.mass
        if not weight.is_zero:
            fallen = dot(kinematics.tree, kinematics.position("ground", body.frame), weight)
            laws.append(Law((PointForce(body.frame, weight),), -fallen, number(names.graph, 0), ()))
    return laws


def _drive_law(names: Names, drive: Drive, x: Expr, rate: Expr, coordinate: str, where: str) -> Law:
    stiffness, free = names.expression(drive.stiffness, where), names.expression(drive.free, where)
    other = names.expression(drive.applied, where) - names.expression(drive.damping, where) * rate
    other, stretch = other + law_value(names, drive.law, x, where), x - free
    spring = -(stiffness * stretch)
    load = GeneralizedForce(rate, other + spring, coordinate)
    if is_constant(stiffness) and is_constant(free):
        return Law(
            (load,), stiffness * stretch**2 / 2, other * rate, (GeneralizedForce(rate, other, coordinate),)
        )
    return Law((load,), number(rate.graph, 0), (other + spring) * rate)


@load_law.register(Force)
def _force_law(force: Force, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]) -> Law:
    tree = kinematics.tree
    value = vector(force.resolved_in.full_name, names.triple(force.vector, f"force {force.name}"))
    on, back = force.on.full_name, force.reaction_on.body
    arm = kinematics.position(back, on)
    turning = cross(tree, kinematics.angular_velocities[back].value, arm)
    v_back = kinematics.velocities[back].value + turning
    power = dot(tree, value, kinematics.velocities[on].value - v_back)
    return Law((PointForce(on, value), PointForce(back, -value, arm)), number(names.graph, 0), power)


@load_law.register(Torque)
def _torque_law(torque: Torque, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]) -> Law:
    value = vector(torque.resolved_in.full_name, names.triple(torque.vector, f"torque {torque.name}"))
    on, back = torque.on.body, torque.reaction_on.body
    turning = kinematics.angular_velocities[on].value - kinematics.angular_velocities[back].value
    loads = (Moment(on, value), Moment(back, -value))
    return Law(loads, number(names.graph, 0), dot(kinematics.tree, value, turning))
