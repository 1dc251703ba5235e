"""Virtual work: the inertial wrenches of the bodies, times the free motions of the joints inward of them.

``sum over bodies of  dv_j . (m a - F) + dw_j . (I alpha + w x I w - T) = 0``  for every speed u_j, with
partial velocities dv_j, dw_j (Kane & Levinson 1985, section 6.1; Roberson & Schwertassek 1988, chapter 8).
The sum is taken joint by joint: a joint with the free motion dv, dw that carries the force and the moment of
everything outward of it contributes ``dv . force + dw . moment``, so no body is met twice.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from symbody.equations.dynamics.balance import NO_WRENCH, Wrench, balance_wrenches
from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.inertial_wrenches import inertial_wrench, subtract_loads
from symbody.equations.dynamics.load import GeneralizedForce
from symbody.equations.formulations.formulation import Dynamics, Formulation, ProjectedDynamics
from symbody.equations.formulations.projection import add_rotor, project_bodies, projected_dynamics
from symbody.equations.kinematics.mechanism_names import joint_speeds
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.system import MultibodySystem
from symbody.expr.expression import Expr, number
from symbody.graph.topology import Topology
from symbody.spatial.dyadic import times_vector
from symbody.spatial.vector import ZERO, Vector, cross, dot


@dataclass(frozen=True, slots=True)
class VirtualWork(Formulation):
    """Formulation by virtual work; any trees, any coordinates.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail]), sb.VirtualWork())
    >>> eqs.mass_matrix
    Matrix([[2]])
    """

    def derive(self, system: MultibodySystem) -> Dynamics:
        """Return the equations of motion, joint by joint; body by body where there are no joints."""
        return _project(system) if system.joint_roles else project_bodies(system)


def _project(system: MultibodySystem) -> ProjectedDynamics:
    topology, kinematics, loads = system.topology, system.kinematics, system.loads.loads
    speeds, zero = kinematics.speeds, number(kinematics.graph, 0)
    place = {u: j for j, u in enumerate(speeds)}
    mass = [[zero] * len(speeds) for _ in speeds]
    forcing = [zero] * len(speeds)
    motions = _free_motions(system)
    for u, j in place.items():
        inertial = {
            body.frame: _unit_wrench(kinematics, body, u)
            for body in system.bodies
            if _moves(kinematics, body, u)
        }
        for other, force in _generalized_forces(topology, kinematics, motions, inertial).items():
            if place[other] >= j:
                mass[j][place[other]] = mass[place[other]][j] = force
    biases = {body.frame: _bias_wrench(kinematics, body) for body in system.bodies}
    missing = subtract_loads(topology, kinematics, biases, loads)
    for u, force in _generalized_forces(topology, kinematics, motions, missing).items():
        forcing[place[u]] = forcing[place[u]] - force
    for load in loads:
        if isinstance(load, GeneralizedForce):
            for u, slope in kinematics.speed_partials(load.rate).items():
                forcing[place[u]] = forcing[place[u]] + slope * load.effort
    for rotor in system.rotors.values():
        add_rotor(kinematics, rotor, mass, forcing)
    return projected_dynamics(system, mass, forcing)


def _free_motions(system: MultibodySystem) -> list[tuple[str, int, Vector, Vector]]:
    """Return (joint, speed, dv, dw): how the end of a joint moves relative to its start, seen from there."""
    kinematics, tree = system.kinematics, system.kinematics.tree
    motions = []
    for role in system.joint_roles:
        start, end = role.joint.start.full_name, role.joint.end.full_name
        v, v_start = kinematics.velocities[end], kinematics.velocities[start]
        w, w_start = kinematics.angular_velocities[end], kinematics.angular_velocities[start]
        arm = kinematics.position(start, end)
        for u in joint_speeds(system.names, kinematics.rates, role):
            angular = w.partial(u) - w_start.partial(u) if role.in_rotation else ZERO
            linear = ZERO
            if role.in_translation:
                linear = v.partial(u) - v_start.partial(u) - cross(tree, w_start.partial(u), arm)
            motions.append((role.joint.name, u, linear, angular))
    return motions


def _generalized_forces(
    topology: Topology,
    kinematics: Kinematics,
    motions: Iterable[tuple[str, int, Vector, Vector]],
    wrenches: Mapping[str, Wrench],
) -> dict[int, Expr]:
    """Return the generalized force of each speed, from wrenches about the bodies' centres of mass."""
    tree = kinematics.tree
    transmitted = balance_wrenches(topology, kinematics, wrenches, {})
    forces: dict[int, Expr] = {}
    for joint, u, linear, angular in motions:
        wrench = transmitted.get(joint, NO_WRENCH)
        force = dot(tree, linear, wrench.force) + dot(tree, angular, wrench.moment)
        if not force.is_zero:
            forces[u] = forces[u] + force if u in forces else force
    return forces


def _moves(kinematics: Kinematics, body: Inertia, u: int) -> bool:
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    return u in v.partials or u in w.partials


def _unit_wrench(kinematics: Kinematics, body: Inertia, u: int) -> Wrench:
    """Return the inertial wrench of a body for a unit acceleration u' from rest."""
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    return Wrench(v.partial(u) * body.mass, times_vector(kinematics.tree, body.tensor, w.partial(u)))


def _bias_wrench(kinematics: Kinematics, body: Inertia) -> Wrench:
    """Return the inertial wrench of a body with all u' = 0."""
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    return inertial_wrench(kinematics, body, v.bias, w.bias)
