"""Newton-Euler: every body free, every reaction an unknown, one saddle system.

``m a = F + sum of forces``, ``I alpha + w x I w = T + sum of moments`` for each body; for each branch of the
trees three rows of force or moment that say how the end may move relative to the start,
``X V'_end - X V'_start - S u' = X b``; for each constraint its row. V' are the accelerations of the bodies,
those of centres of mass in ground axes, angular ones in body axes, where the inertia is constant; b is V' at
u' = 0. The multiplier of a branch's row is a component of the joint's total wrench, so that forces and
motions are found together (Haug 1989, chapter 11, where the bodies have no joint coordinates beside).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from symbody.equations.dynamics.balance import NOTHING, Wrench
from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.load import Effort, Load
from symbody.equations.dynamics.needs import without_loads
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.placements import flow, moved, moved_matrix, spin, unit, without_zeros
from symbody.equations.kinematics.row import Row
from symbody.equations.kinematics.variables import Use
from symbody.equations.kinematics.velocity import Velocity
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr, number, saddle_entry
from symbody.expr.graph import Kernel
from symbody.graph.topology import Topology
from symbody.vectors.dyadic import apply, gyroscopic
from symbody.vectors.matrix import Triple
from symbody.vectors.vector import NULL, Vector, components, cross

_AXES: Final = range(3)
# Coefficients of the unknown accelerations by column; zeros may be left out.
_Column = dict[int, Expr]


@dataclass(frozen=True, slots=True)
class NewtonEuler:
    """Formulation with free bodies and unknown reactions; any trees, any coordinates."""


@dataclass(frozen=True, slots=True)
class FreeBodies:
    """Bodies with what acts on them, cut free of each other.

    Attributes
    ----------
    kinematics : Kinematics
        Differentiated placements.
    shifts : mapping of joint to Vector
        From start to end in the joint's own coordinates, in the start frame.
    within : mapping of coordinate to (joint, Wrench)
        What a unit effort along a measured coordinate does to the end of its joint.
    coupled : mapping of row name to ((joint, Wrench), ...)
        The same for a unit multiplier of rows written in measured coordinates.
    """

    topology: Topology
    kinematics: Kinematics
    uses: tuple[Use, ...]
    shifts: Mapping[str, Vector]
    bodies: tuple[Inertia, ...]
    loads: tuple[Load, ...]
    rotors: tuple[Rotor, ...]
    rows: tuple[Row, ...]
    within: Mapping[str, tuple[str, Wrench]]
    coupled: Mapping[str, tuple[tuple[str, Wrench], ...]]

    def solved(self) -> Solution:
        """Return accelerations, multipliers and wrenches of branches as entries of one kernel node."""
        return _System(self, number(self.kinematics.graph, 0)).solved()


@dataclass(frozen=True, slots=True)
class Solution:
    """What the saddle system gives.

    Attributes
    ----------
    udot, multipliers : list of Expr
    wrenches : mapping of joint to Wrench
        On the end body at the end's origin, as far as the joint is in a tree.
    """

    udot: list[Expr]
    multipliers: list[Expr]
    wrenches: dict[str, Wrench]


@dataclass(frozen=True, slots=True)
class _System:
    """The saddle system being put together; columns are six a body, then the speeds."""

    free: FreeBodies
    zero: Expr

    @property
    def speeds(self) -> tuple[int, ...]:
        return self.free.kinematics.speeds

    @property
    def first(self) -> int:
        """The column of the first speed."""
        return 6 * len(self.free.bodies)

    def solved(self) -> Solution:
        graph = self.free.kinematics.graph
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
        nodes = tuple(x.index for x in without_zeros(graph, operands))
        kernel = graph.kernel(Kernel(n, m))
        found = [saddle_entry(graph, kernel, nodes, k) for k in range(n + m)]
        wrenches: dict[str, Wrench] = {}
        for (joint, share, _, _), value in zip(branches, found[n:], strict=False):
            total = wrenches.get(joint, NOTHING)
            wrenches[joint] = Wrench(total.force + share.force * value, total.moment + share.moment * value)
        return Solution(found[self.first : n], found[n + len(branches) :], wrenches)

    # Rows

    def _branches(self) -> Iterator[tuple[str, Wrench, _Column, Expr]]:
        """Return (joint, unit wrench, row, right-hand side) for all that joints transmit as branches."""
        graph = self.free.kinematics.graph
        for use in self.free.uses:
            name = use.joint.name
            parts: list[tuple[Wrench, _Column]] = []
            if use.in_translation:
                frame, rate = self._slide(use)
                slides = self._free_motion(use, frame, rate)
                parts += [(self._push(use, frame, k), slides[k]) for k in _AXES]
            if use.in_rotation:
                turns = self._free_motion(use, *self._turn(use))
                parts += [(Wrench(NULL, unit(graph, "ground", k)), turns[k]) for k in _AXES]
            for share, own in parts:
                row = self._transmitted(name, share)
                yield name, share, {**row, **own}, self._bias(row)

    def _slide(self, use: Use) -> tuple[str, Triple]:
        """Return the frame and the components of the rate of a joint's shift."""
        kinematics, shift = self.free.kinematics, self.free.shifts[use.joint.name]
        frame = next(iter(shift.terms), use.joint.start.frame)
        x, y, z = moved(kinematics.graph, components(kinematics.tree, shift, frame), flow(kinematics))
        return frame, (x, y, z)

    def _push(self, use: Use, frame: str, k: int) -> Wrench:
        """Return a unit force of a joint; if its shift turns with the end, through the start's origin."""
        tree, joint = self.free.kinematics.tree, use.joint
        force = unit(tree.graph, "ground", k)
        if frame != joint.end.frame or frame == joint.start.frame:
            return Wrench(force, NULL)
        return Wrench(force, -cross(tree, self.free.kinematics.arm(joint.start.frame, frame), force))

    def _turn(self, use: Use) -> tuple[str, Triple]:
        """Return the end frame and the angular velocity of a joint's end relative to its start."""
        kinematics = self.free.kinematics
        R = kinematics.tree.matrix(use.joint.start.frame, use.joint.end.frame)
        return use.joint.end.frame, spin(R, moved_matrix(kinematics.graph, R, flow(kinematics)))

    def _free_motion(self, use: Use, frame: str, rate: Triple) -> list[_Column]:
        """Return -S for a joint's own speeds, one row for each axis of ground."""
        kinematics = self.free.kinematics
        graph, R = kinematics.graph, kinematics.tree.matrix("ground", frame)
        own = [graph.symbol(symbol) for symbol in use.speeds]
        slopes = jacobian(graph, [x.index for x in rate], own)
        found: list[_Column] = [{}, {}, {}]
        for j, u in enumerate(own):
            x, y, z = (Expr(graph, slopes[k][j]) for k in _AXES)
            for k, entry in enumerate(R @ (x, y, z)):
                found[k][self.first + self.speeds.index(u)] = -entry
        return found

    def _constraints(self) -> Iterator[tuple[_Column, Expr]]:
        """Return the rows of the constraints on the accelerations of bodies; on speeds what is left.

        A row that was silenced, all its slopes gone, stays silent.
        """
        kinematics = self.free.kinematics
        for row in self.free.rows:
            if not row.slopes:
                yield {}, row.gamma
                continue
            column = self._transmitted(row.element, Wrench(row.force, row.moment))
            for joint, share in self.free.coupled.get(row.name, ()):
                for k, entry in self._transmitted(joint, share).items():
                    column[k] = column.get(k, self.zero) + entry
            rest = [row.slopes.get(u, self.zero) - self._along(column, u) for u in self.speeds]
            clean = without_zeros(kinematics.graph, rest)
            own = {self.first + j: entry for j, entry in enumerate(clean) if not entry.is_zero}
            yield {**column, **own}, row.gamma + self._bias(column)

    def _transmitted(self, element: str, share: Wrench) -> _Column:
        """Return what a wrench at a joint does to its two bodies: the coefficients of V' in its row."""
        found: _Column = {}
        ends = self.free.topology.link(element)
        if ends is None:
            return found
        for body, sign in ((ends.end.body, 1), (ends.start.body, -1)):
            for column, entry in self._applied(body, ends.end.frame, share).items():
                found[column] = found.get(column, self.zero) + entry * sign
        return found

    def _applied(self, body: str, frame: str, share: Wrench) -> _Column:
        """Return a wrench at a frame's origin as the six components that act on a body; none on ground."""
        kinematics, tree = self.free.kinematics, self.free.kinematics.tree
        place = {inertia.frame: k for k, inertia in enumerate(self.free.bodies)}
        if body not in place:
            return {}
        moment = share.moment + cross(tree, kinematics.arm(body, frame), share.force)
        six = (*components(tree, share.force, "ground"), *components(tree, moment, body))
        return {6 * place[body] + k: entry for k, entry in enumerate(six) if not entry.is_zero}

    def _bias(self, row: _Column) -> Expr:
        """Return ``X b``."""
        kinematics, total = self.free.kinematics, self.zero
        for column, entry in row.items():
            body, k = divmod(column, 6)
            velocity, axes = self._velocity(body, k)
            total = total + entry * components(kinematics.tree, velocity.bias, axes)[k % 3]
        return total

    def _along(self, row: _Column, u: int) -> Expr:
        """Return ``X A`` for one speed, A its partial velocities."""
        kinematics, total = self.free.kinematics, self.zero
        for column, entry in row.items():
            body, k = divmod(column, 6)
            velocity, axes = self._velocity(body, k)
            total = total + entry * components(kinematics.tree, velocity.partial(u), axes)[k % 3]
        return total

    def _velocity(self, body: int, k: int) -> tuple[Velocity, str]:
        """Return the velocity of which a body's component k is one, and its axes."""
        kinematics, frame = self.free.kinematics, self.free.bodies[body].frame
        if k < 3:
            return kinematics.velocities[frame], "ground"
        return kinematics.angular_velocities[frame], frame

    # Inertia and loads

    def _inertia(self) -> tuple[dict[tuple[int, int], Expr], _Column]:
        """Return the mass matrix and what acts, without reactions."""
        free = self.free
        kinematics, tree = free.kinematics, free.kinematics.tree
        mass: dict[tuple[int, int], Expr] = {}
        forcing: _Column = {}
        swirl = {}
        for place, body in enumerate(free.bodies):
            w = kinematics.angular_velocities[body.frame].value
            swirl[body.frame] = Wrench(NULL, gyroscopic(tree, w, body.tensor))
            for k in _AXES:
                mass[6 * place + k, 6 * place + k] = body.mass
                column = apply(tree, body.tensor, unit(tree.graph, body.frame, k))
                for i, entry in enumerate(components(tree, column, body.frame)):
                    mass[6 * place + 3 + i, 6 * place + 3 + k] = entry
        needed = without_loads(free.topology, kinematics, swirl, free.loads)
        for body in free.bodies:
            wrench = needed[body.frame]
            self._add(forcing, self._applied(body.frame, body.frame, wrench), number(tree.graph, -1))
        for load in free.loads:
            if isinstance(load, Effort):
                self._add(forcing, self._along_rate(load), load.effort)
        for rotor in free.rotors:
            self._add_rotor(rotor, mass, forcing)
        return mass, forcing

    def _add_rotor(self, rotor: Rotor, mass: dict[tuple[int, int], Expr], forcing: _Column) -> None:
        """Add what turns with a rate; inside a cut joint it acts on the joint's bodies."""
        row = self._along_rate(rotor)
        (rest,) = moved(self.zero.graph, [rotor.rate], flow(self.free.kinematics))
        bodies = {column: entry for column, entry in row.items() if column < self.first}
        rest = rest - self._bias(bodies)
        self._add(forcing, row, -rotor.inertia * rest)
        for i, a in row.items():
            for j, b in row.items():
                mass[i, j] = mass.get((i, j), self.zero) + rotor.inertia * a * b

    def _along_rate(self, along: Effort | Rotor) -> _Column:
        """Return where a unit effort along a rate acts: on speeds, or on bodies where it is measured."""
        inside = self.free.within.get(along.coordinate)
        if inside is not None:
            return self._transmitted(*inside)
        slopes = self.free.kinematics.slopes(along.rate)
        return {self.first + self.speeds.index(u): slope for u, slope in slopes.items()}

    def _add(self, forcing: _Column, column: _Column, factor: Expr) -> None:
        for k, entry in column.items():
            forcing[k] = forcing.get(k, self.zero) + entry * factor
