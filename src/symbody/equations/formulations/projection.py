"""Sums over bodies that formulations share: projection on partial velocities, generalized forces, energy.

``sum over bodies of  dv_j . (m a - F) + dw_j . (I alpha + w x I w - T) = 0``  needs no tree, so it serves
mechanisms placed by hand and free bodies; along a tree `virtual_work` needs fewer operations.
"""

from __future__ import annotations

from collections.abc import Mapping

from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.load import GeneralizedForce, Load, Moment, PointToPointForce
from symbody.equations.formulations.formulation import ProjectedDynamics
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.system import MultibodySystem
from symbody.expr.deadline import begin
from symbody.expr.expression import Expr, number
from symbody.spatial.dyadic import gyroscopic, quadratic, times_vector
from symbody.spatial.vector import cross, dot


def project_bodies(system: MultibodySystem) -> ProjectedDynamics:
    """Return the equations of motion in the speeds, each body projected by itself."""
    kinematics = system.kinematics
    speeds, zero = kinematics.speeds, number(kinematics.graph, 0)
    mass = [[zero] * len(speeds) for _ in speeds]
    forcing = [zero] * len(speeds)
    for body in system.bodies:
        _add_body(kinematics, body, mass, forcing)
    place = {u: j for j, u in enumerate(speeds)}
    for load in system.loads.loads:
        for u, work in generalized_force(kinematics, load).items():
            forcing[place[u]] = forcing[place[u]] + work
    for rotor in system.rotors.values():
        add_rotor(kinematics, rotor, mass, forcing)
    return projected_dynamics(system, mass, forcing)


def projected_dynamics(
    system: MultibodySystem, mass: list[list[Expr]], forcing: list[Expr]
) -> ProjectedDynamics:
    """Return dynamics of a mass matrix and a forcing, with the energies of the system.

    Parameters
    ----------
    mass : list of list of Expr
        M, both halves, in the order of ``system.kinematics.speeds``.
    forcing : list of Expr
        F in the same order, free of u'.

    Raises
    ------
    AssertionError
        If they have other sizes: an error of the formulation.
    """
    n = len(system.kinematics.speeds)
    if len(forcing) != n:
        raise AssertionError(f"F has {len(forcing)} entries for {n} speeds")
    if [len(row) for row in mass] != [n] * n:
        raise AssertionError(f"M is not {n} by {n}")
    begin("energy")
    return ProjectedDynamics(
        tuple(map(tuple, mass)), tuple(forcing), kinetic_energy(system), system.loads.potential_energy
    )


def kinetic_energy(system: MultibodySystem) -> Expr:
    """Return the kinetic energy of the bodies relative to ground, and of rotors along their rates [J]."""
    kinematics = system.kinematics
    tree = kinematics.tree
    total = number(tree.graph, 0)
    for body in system.bodies:
        v = kinematics.velocities[body.frame].value
        w = kinematics.angular_velocities[body.frame].value
        total = total + body.mass * dot(tree, v, v) + quadratic(tree, w, body.tensor, w)
    for rotor in system.rotors.values():
        total = total + rotor.inertia * rotor.rate**2
    return total / 2


def add_rotor(kinematics: Kinematics, rotor: Rotor, mass: list[list[Expr]], forcing: list[Expr]) -> None:
    """Add a rotor along a rate to the mass matrix and the forcing."""
    slopes = kinematics.speed_partials(rotor.rate)
    bias = kinematics.bias(rotor.rate)
    for i, u in enumerate(kinematics.speeds):
        if u in slopes:
            forcing[i] = forcing[i] - rotor.inertia * bias * slopes[u]
            for j, other in enumerate(kinematics.speeds):
                if other in slopes:
                    mass[i][j] = mass[i][j] + rotor.inertia * slopes[u] * slopes[other]


def _add_body(kinematics: Kinematics, body: Inertia, mass: list[list[Expr]], forcing: list[Expr]) -> None:
    tree = kinematics.tree
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    torque = times_vector(tree, body.tensor, w.bias) + gyroscopic(tree, w.value, body.tensor)
    moving = [(j, u) for j, u in enumerate(kinematics.speeds) if u in v.partials or u in w.partials]
    for i, u in moving:
        if not body.mass.is_zero:
            forcing[i] = forcing[i] - body.mass * dot(tree, v.partial(u), v.bias)
        forcing[i] = forcing[i] - dot(tree, w.partial(u), torque)
        for j, other in moving:
            if j > i:
                break
            share = quadratic(tree, w.partial(u), body.tensor, w.partial(other))
            if not body.mass.is_zero:
                share = share + body.mass * dot(tree, v.partial(u), v.partial(other))
            mass[i][j] = mass[i][j] + share
            mass[j][i] = mass[i][j]


def generalized_force(kinematics: Kinematics, load: Load) -> Mapping[int, Expr]:
    """Return the generalized force of a load for each speed on which it works."""
    tree = kinematics.tree
    if isinstance(load, GeneralizedForce):
        return {u: slope * load.effort for u, slope in kinematics.speed_partials(load.rate).items()}
    if isinstance(load, Moment):
        partials = kinematics.angular_velocities[load.frame].partials
        return {u: dot(tree, partial, load.torque) for u, partial in partials.items()}
    if isinstance(load, PointToPointForce):
        closing = kinematics.velocities[load.end] - kinematics.velocities[load.start]
        return {u: load.factor * dot(tree, load.position, partial) for u, partial in closing.partials.items()}
    v = kinematics.velocities[load.frame]
    work = {u: dot(tree, partial, load.force) for u, partial in v.partials.items()}
    if not load.position.is_zero:
        moment = cross(tree, load.position, load.force)
        for u, partial in kinematics.angular_velocities[load.frame].partials.items():
            more = dot(tree, partial, moment)
            work[u] = work[u] + more if u in work else more
    return work
