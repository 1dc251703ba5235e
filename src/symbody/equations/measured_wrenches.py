"""Wrenches of what acts along coordinates that are measured, because their joint is cut."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symbody.equations.dynamics.balance import NO_WRENCH, Wrench, balance_wrenches
from symbody.equations.dynamics.load import GeneralizedForce
from symbody.equations.dynamics.reactions import drive_wrench, row_wrenches, sum_wrenches
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.variables import JointRole
from symbody.equations.system import MultibodySystem
from symbody.expr.expression import Expr, number


def unit_wrenches(system: MultibodySystem) -> Iterator[tuple[str, tuple[str, Wrench]]]:
    """Return for each measured coordinate with a load its joint, and the wrench of a unit effort along it."""
    one = number(system.graph, 1)
    for role, coordinate in _loaded_coordinates(system):
        wrench = drive_wrench(system.names, system.kinematics, role.joint, coordinate, one)
        yield coordinate, (role.joint.name, wrench)


def drive_wrenches(system: MultibodySystem) -> Iterator[tuple[str, Wrench]]:
    """Return the wrenches of loads and rotors along measured coordinates, by joint."""
    names, kinematics = system.names, system.kinematics
    for role, coordinate in _loaded_coordinates(system):
        joint = role.joint
        effort = number(system.graph, 0)
        if coordinate in system.rotors:
            rotor = system.rotors[coordinate]
            effort = effort - rotor.inertia * kinematics.rate(rotor.rate)
        for load in system.loads.loads:
            if isinstance(load, GeneralizedForce) and load.coordinate == coordinate:
                effort = effort + load.effort
        yield joint.name, drive_wrench(names, kinematics, joint, coordinate, effort)


def _loaded_coordinates(system: MultibodySystem) -> Iterator[tuple[JointRole, str]]:
    """Return the measured coordinates with a load or a rotor."""
    along = {load.coordinate for load in system.loads.loads if isinstance(load, GeneralizedForce)}
    for role in system.joint_roles:
        for coordinate in role.joint.coordinates:
            if coordinate not in role.coordinates and (
                coordinate in along or coordinate in role.joint.armature
            ):
                yield role, coordinate


def coupling_wrenches(
    system: MultibodySystem, rows: Sequence[tuple[ConstraintEquation, Expr]]
) -> Iterator[tuple[str, Wrench]]:
    """Return the wrenches along measured coordinates of constraints, with their multipliers, by joint."""
    for row, multiplier in rows:
        for joint, share in unit_coupling_wrenches(system, row):
            yield joint, Wrench(share.force * multiplier, share.moment * multiplier)


def unit_coupling_wrenches(system: MultibodySystem, row: ConstraintEquation) -> Iterator[tuple[str, Wrench]]:
    """Return the wrenches of a unit multiplier of a row along the measured coordinates it contains."""
    for role in system.joint_roles:
        measured = set(role.joint.coordinates).difference(role.coordinates)
        for coordinate, share in row.shares.items():
            if coordinate in measured:
                wrench = drive_wrench(system.names, system.kinematics, role.joint, coordinate, share)
                yield role.joint.name, wrench


def static_wrenches(
    system: MultibodySystem, rows: Sequence[tuple[ConstraintEquation, Expr]]
) -> dict[str, Wrench]:
    """Return the total wrench of every joint if multipliers alone act, on bodies without mass or load."""
    cut = sum_wrenches([*row_wrenches(rows), *coupling_wrenches(system, rows)])
    idle = dict.fromkeys((joint.name for joint in system.topology.joints), NO_WRENCH)
    return idle | cut | balance_wrenches(system.topology, system.kinematics, {}, cut)
