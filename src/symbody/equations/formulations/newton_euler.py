"""Newton-Euler: every body free, every reaction an unknown, one saddle system.

``m a = F + sum of forces``, ``I alpha + w x I w = T + sum of moments`` for each body; for each branch of the
trees three rows of force or moment that restrict the motion of the end relative to the start,
``X V'_end - X V'_start - S u' = X b``; for each constraint its row. V' are the accelerations of the bodies,
those of centres of mass in ground axes, angular ones in body axes, where the inertia is constant; b is V' at
u' = 0. The multiplier of a branch's row is a component of the joint's total wrench, so that forces and
motions are found together (Haug 1989, chapter 11, where the bodies have no joint coordinates beside).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, NamedTuple

from symbody.equations.dynamics.balance import NO_WRENCH, Wrench, balance_wrenches
from symbody.equations.dynamics.inertia import Rotor
from symbody.equations.dynamics.inertial_wrenches import subtract_loads
from symbody.equations.dynamics.load import GeneralizedForce
from symbody.equations.dynamics.reactions import row_wrenches, sum_wrenches
from symbody.equations.formulations.formulation import Dynamics, Formulation, ProjectedDynamics
from symbody.equations.formulations.projection import project_bodies
from symbody.equations.kinematics.frame_placement import joint_shift
from symbody.equations.kinematics.mechanism_names import joint_speeds
from symbody.equations.kinematics.placements import (
    differentiate,
    differentiate_matrix,
    flow,
    fold_zeros,
    spin,
    unit,
)
from symbody.equations.kinematics.variables import JointRole
from symbody.equations.kinematics.velocity import Velocity
from symbody.equations.measured_wrenches import coupling_wrenches, unit_coupling_wrenches, unit_wrenches
from symbody.equations.system import MultibodySystem
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr, number, saddle_entry
from symbody.expr.graph import KernelNode
from symbody.spatial.dyadic import gyroscopic, times_vector
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import ZERO, components, cross

_AXES: Final = range(3)
# Coefficients of the unknown accelerations by column; zeros may be left out.
_Column = dict[int, Expr]


@dataclass(frozen=True, slots=True)
class NewtonEuler(Formulation):
    """Formulation with free bodies and unknown reactions; any trees, any coordinates.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail]), sb.NewtonEuler())
    >>> eqs.mass_matrix
    Matrix([[2]])
    """

    differentiates_placements: ClassVar[bool] = True

    def balance_obstacle(self, *, on_positions: bool) -> str:
        """Return the reason why free bodies cannot be solved for where balances transmit nothing."""
        return (
            "free bodies: a position follows from a balance of forces, which transmits no reaction"
            if on_positions
            else ""
        )

    def derive(self, system: MultibodySystem) -> Dynamics:
        """Return the equations of motion; M and F are the free bodies projected on the partial velocities."""
        projected = project_bodies(system)
        return NewtonEulerDynamics(
            projected.mass_matrix, projected.forcing, projected.kinetic_energy, projected.potential_energy
        )


@dataclass(frozen=True, slots=True)
class NewtonEulerDynamics(ProjectedDynamics):
    """Dynamics in which accelerations and all reactions solve one system.

    With friction, or without joints, the accelerations follow from M and F, and the balance of the bodies
    follows the accelerations.
    """

    def accelerations(self, system: MultibodySystem) -> tuple[list[Expr], list[Expr]] | None:
        """Return u' and the multipliers."""
        if system.friction or not system.joint_roles:
            return None
        solution = solve_free_bodies(system)
        return solution.udot, solution.multipliers

    def solved_wrenches(
        self, system: MultibodySystem, cut: Sequence[tuple[str, Wrench]]
    ) -> dict[str, Wrench] | None:
        """Return the total wrenches, those of branches from the solution."""
        if system.friction or not system.joint_roles:
            return None
        solution = solve_free_bodies(system)
        more = _difference(system, solution.multipliers)
        idle = dict.fromkeys((joint.name for joint in system.topology.joints), NO_WRENCH)
        return idle | sum_wrenches([*cut, *solution.wrenches.items(), *more])


def _difference(system: MultibodySystem, multipliers: Sequence[Expr]) -> Iterator[tuple[str, Wrench]]:
    """Return how the wrenches of branches change where multipliers differ from those of the solution."""
    pairs = system.bearing_rows
    values = [*multipliers, *(number(system.graph, 0) for _ in system.redundant)]
    more = [(row, symbol - value) for (row, symbol), value in zip(pairs, values, strict=True)]
    cut = sum_wrenches([*row_wrenches(more), *coupling_wrenches(system, more)])
    for name, wrench in balance_wrenches(system.topology, system.kinematics, {}, cut).items():
        share = cut.get(name, NO_WRENCH)
        yield name, Wrench(wrench.force - share.force, wrench.moment - share.moment)


class FreeBodySolution(NamedTuple):
    """Entries of one kernel node: accelerations, multipliers, and wrenches by the joint of their branch.

    A wrench acts on the end body at the origin of the end frame, as far as the joint is in a tree.
    """

    udot: list[Expr]
    multipliers: list[Expr]
    wrenches: dict[str, Wrench]


def solve_free_bodies(system: MultibodySystem) -> FreeBodySolution:
    """Return what the saddle system of the bodies, cut free of each other, gives."""
    return _FreeBodies(system, dict(unit_wrenches(system)), number(system.graph, 0)).solve()


@dataclass(frozen=True, slots=True)
class _FreeBodies:
    """The saddle system being put together; columns are six a body, then the speeds.

    Attributes
    ----------
    measured : mapping of coordinate to (joint, Wrench)
        The wrench of a unit effort along each measured coordinate that is loaded, on the end of its joint.
    """

    system: MultibodySystem
    measured: Mapping[str, tuple[str, Wrench]]
    zero: Expr

    @property
    def speeds(self) -> tuple[int, ...]:
        return self.system.kinematics.speeds

    @property
    def first(self) -> int:
        """The column of the first speed."""
        return 6 * len(self.system.bodies)

    def solve(self) -> FreeBodySolution:
        graph = self.system.graph
        branches = list(self._branches())
        matrix, gamma = [], []
        for row, right in (*((row, right) for _, _, row, right in branches), *self._constraints()):
            matrix.append(row)
            gamma.append(right)
        mass, forcing = self._inertia()
        n, m = self.first + len(self.speeds), len(matrix)
        operands = [mass.get((i, j), self.zero) for i in range(n) for j in range(n)]
        operands += [row.get(j, self.zero) for row in matrix for j in range(n)]
        operands += [*(forcing.get(i, self.zero) for i in range(n)), *gamma]
        nodes = tuple(x.index for x in fold_zeros(graph, operands))
        kernel = graph.kernel(KernelNode(n, m))
        solution = [saddle_entry(graph, kernel, nodes, k) for k in range(n + m)]
        wrenches: dict[str, Wrench] = {}
        for (joint, share, _, _), value in zip(branches, solution[n:], strict=False):
            total = wrenches.get(joint, NO_WRENCH)
            wrenches[joint] = Wrench(total.force + share.force * value, total.moment + share.moment * value)
        return FreeBodySolution(solution[self.first : n], solution[n + len(branches) :], wrenches)

    # Rows

    def _branches(self) -> Iterator[tuple[str, Wrench, _Column, Expr]]:
        """Return (joint, unit wrench, row, right-hand side) for all that joints transmit as branches."""
        graph = self.system.kinematics.graph
        for role in self.system.joint_roles:
            name = role.joint.name
            parts: list[tuple[Wrench, _Column]] = []
            if role.in_translation:
                frame, rate = self._shift_rate(role)
                slides = self._free_motion(role, frame, rate)
                parts += [(self._unit_force(role, frame, k), slides[k]) for k in _AXES]
            if role.in_rotation:
                turns = self._free_motion(role, *self._relative_angular_velocity(role))
                parts += [(Wrench(ZERO, unit(graph, "ground", k)), turns[k]) for k in _AXES]
            for share, speeds in parts:
                row = self._body_columns(name, share)
                yield name, share, {**row, **speeds}, self._bias(row)

    def _shift_rate(self, role: JointRole) -> tuple[str, Triple]:
        """Return the frame and the components of the rate of a joint's shift."""
        kinematics, shift = self.system.kinematics, joint_shift(self.system.names, role.joint)
        frame = next(iter(shift.terms), role.joint.start.full_name)
        x, y, z = differentiate(kinematics.graph, components(kinematics.tree, shift, frame), flow(kinematics))
        return frame, (x, y, z)

    def _unit_force(self, role: JointRole, frame: str, k: int) -> Wrench:
        """Return a unit force of a joint; if its shift turns with the end, through the start's origin."""
        tree, joint = self.system.kinematics.tree, role.joint
        force = unit(tree.graph, "ground", k)
        if frame != joint.end.full_name or frame == joint.start.full_name:
            return Wrench(force, ZERO)
        return Wrench(
            force, -cross(tree, self.system.kinematics.position(joint.start.full_name, frame), force)
        )

    def _relative_angular_velocity(self, role: JointRole) -> tuple[str, Triple]:
        """Return the end frame and the angular velocity of a joint's end relative to its start."""
        kinematics = self.system.kinematics
        R = kinematics.tree.matrix(role.joint.start.full_name, role.joint.end.full_name)
        return role.joint.end.full_name, spin(R, differentiate_matrix(kinematics.graph, R, flow(kinematics)))

    def _free_motion(self, role: JointRole, frame: str, rate: Triple) -> list[_Column]:
        """Return -S for the speeds a joint moves with, one row for each axis of ground."""
        kinematics = self.system.kinematics
        graph, R = kinematics.graph, kinematics.tree.matrix("ground", frame)
        speeds = joint_speeds(self.system.names, kinematics.rates, role)
        slopes = jacobian(graph, [x.index for x in rate], speeds)
        rows: list[_Column] = [{}, {}, {}]
        for j, u in enumerate(speeds):
            x, y, z = (Expr(graph, slopes[k][j]) for k in _AXES)
            for k, entry in enumerate(R @ (x, y, z)):
                rows[k][self.first + self.speeds.index(u)] = -entry
        return rows

    def _constraints(self) -> Iterator[tuple[_Column, Expr]]:
        """Return the rows of the constraints on the accelerations of bodies; on speeds what is left.

        A row that was silenced, all its slopes gone, stays silent.
        """
        kinematics = self.system.kinematics
        for row in self.system.rows:
            if not row.jacobian:
                yield {}, row.gamma
                continue
            column = self._body_columns(row.element, Wrench(row.force, row.moment))
            for joint, share in unit_coupling_wrenches(self.system, row):
                for k, entry in self._body_columns(joint, share).items():
                    column[k] = column.get(k, self.zero) + entry
            rest = [row.jacobian.get(u, self.zero) - self._speed_coefficient(column, u) for u in self.speeds]
            clean = fold_zeros(kinematics.graph, rest)
            speeds = {self.first + j: entry for j, entry in enumerate(clean) if not entry.is_zero}
            yield {**column, **speeds}, row.gamma + self._bias(column)

    def _body_columns(self, element: str, share: Wrench) -> _Column:
        """Return the coefficients of V' in the row of a unit wrench at a joint, for both of its bodies."""
        columns: _Column = {}
        ends = self.system.topology.link(element)
        if ends is None:
            return columns
        for body, sign in ((ends.end.body, 1), (ends.start.body, -1)):
            for column, entry in self._wrench_columns(body, ends.end.full_name, share).items():
                columns[column] = columns.get(column, self.zero) + entry * sign
        return columns

    def _wrench_columns(self, body: str, frame: str, share: Wrench) -> _Column:
        """Return a wrench at a frame's origin as the six components that act on a body; none on ground."""
        kinematics, tree = self.system.kinematics, self.system.kinematics.tree
        place = {inertia.frame: k for k, inertia in enumerate(self.system.bodies)}
        if body not in place:
            return {}
        moment = share.moment + cross(tree, kinematics.position(body, frame), share.force)
        six = (*components(tree, share.force, "ground"), *components(tree, moment, body))
        return {6 * place[body] + k: entry for k, entry in enumerate(six) if not entry.is_zero}

    def _bias(self, row: _Column) -> Expr:
        """Return ``X b``."""
        kinematics, total = self.system.kinematics, self.zero
        for column, entry in row.items():
            body, k = divmod(column, 6)
            velocity, axes = self._velocity(body, k)
            total = total + entry * components(kinematics.tree, velocity.bias, axes)[k % 3]
        return total

    def _speed_coefficient(self, row: _Column, u: int) -> Expr:
        """Return ``X A`` for one speed, A its partial velocities."""
        kinematics, total = self.system.kinematics, self.zero
        for column, entry in row.items():
            body, k = divmod(column, 6)
            velocity, axes = self._velocity(body, k)
            total = total + entry * components(kinematics.tree, velocity.partial(u), axes)[k % 3]
        return total

    def _velocity(self, body: int, k: int) -> tuple[Velocity, str]:
        """Return the velocity of which a body's component k is one, and its axes."""
        kinematics, frame = self.system.kinematics, self.system.bodies[body].frame
        if k < 3:
            return kinematics.velocities[frame], "ground"
        return kinematics.angular_velocities[frame], frame

    # Inertia and loads

    def _inertia(self) -> tuple[dict[tuple[int, int], Expr], _Column]:
        """Return the mass matrix and the forces, without reactions."""
        system = self.system
        kinematics, tree = system.kinematics, system.kinematics.tree
        mass: dict[tuple[int, int], Expr] = {}
        forcing: _Column = {}
        gyroscopic_wrenches = {}
        for place, body in enumerate(system.bodies):
            w = kinematics.angular_velocities[body.frame].value
            gyroscopic_wrenches[body.frame] = Wrench(ZERO, gyroscopic(tree, w, body.tensor))
            for k in _AXES:
                mass[6 * place + k, 6 * place + k] = body.mass
                column = times_vector(tree, body.tensor, unit(tree.graph, body.frame, k))
                for i, entry in enumerate(components(tree, column, body.frame)):
                    mass[6 * place + 3 + i, 6 * place + 3 + k] = entry
        missing = subtract_loads(system.topology, kinematics, gyroscopic_wrenches, system.loads.loads)
        for body in system.bodies:
            wrench = missing[body.frame]
            self._add(forcing, self._wrench_columns(body.frame, body.frame, wrench), number(tree.graph, -1))
        for load in system.loads.loads:
            if isinstance(load, GeneralizedForce):
                self._add(forcing, self._effort_columns(load), load.effort)
        for rotor in system.rotors.values():
            self._add_rotor(rotor, mass, forcing)
        return mass, forcing

    def _add_rotor(self, rotor: Rotor, mass: dict[tuple[int, int], Expr], forcing: _Column) -> None:
        """Add a rotor; inside a cut joint it acts on the joint's bodies."""
        row = self._effort_columns(rotor)
        (rest,) = differentiate(self.zero.graph, [rotor.rate], flow(self.system.kinematics))
        bodies = {column: entry for column, entry in row.items() if column < self.first}
        rest = rest - self._bias(bodies)
        self._add(forcing, row, -rotor.inertia * rest)
        for i, a in row.items():
            for j, b in row.items():
                mass[i, j] = mass.get((i, j), self.zero) + rotor.inertia * a * b

    def _effort_columns(self, along: GeneralizedForce | Rotor) -> _Column:
        """Return where a unit effort along a rate acts: on speeds, or on bodies where it is measured."""
        joint_and_wrench = self.measured.get(along.coordinate)
        if joint_and_wrench is not None:
            return self._body_columns(*joint_and_wrench)
        slopes = self.system.kinematics.speed_partials(along.rate)
        return {self.first + self.speeds.index(u): slope for u, slope in slopes.items()}

    def _add(self, forcing: _Column, column: _Column, factor: Expr) -> None:
        for k, entry in column.items():
            forcing[k] = forcing.get(k, self.zero) + entry * factor
