"""`Formulation` and `Dynamics`: what every way to the equations of motion takes and gives.

A formulation is one file here and one line in ``equations/__init__.pyi``: see docs/extending.md.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from symbody.equations.dynamics.balance import Wrench
from symbody.equations.dynamics.linear_solve import LinearSolution, solve_positive_definite
from symbody.equations.dynamics.reactions import joint_wrenches
from symbody.equations.system import MultibodySystem
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol
from symbody.graph.topology import Topology


class Formulation(ABC):
    """One derivation of ``M u' = F + J^T lambda``; its fields are its options.

    Attributes
    ----------
    differentiates_placements : bool
        Whether velocities are derivatives of placements; else they are summed along the trees.
    has_lazy_velocities : bool
        Whether velocities of frames are formed on request: along a chain they are many.
    has_weights_in_loads : bool
        Whether gravity is among the loads.
    takes_kinetic_energy : bool
        Whether the equations follow from a kinetic energy, which may then be given.
    """

    __slots__ = ()

    differentiates_placements: ClassVar[bool] = False
    has_lazy_velocities: ClassVar[bool] = False
    has_weights_in_loads: ClassVar[bool] = True
    takes_kinetic_energy: ClassVar[bool] = False

    @abstractmethod
    def derive(self, system: MultibodySystem) -> Dynamics:
        """Return mass matrix, forcing and energies of a system."""

    def obstacle(self, topology: Topology, *, eliminates: bool) -> str:
        """Return the reason why virtual work has to take the place of this formulation, empty if none.

        Parameters
        ----------
        eliminates : bool
            Whether dependent speeds are eliminated.
        """
        return ""

    def balance_obstacle(self, *, on_positions: bool) -> str:
        """Return the reason why virtual work has to take its place where motions move no mass, empty if none.

        Parameters
        ----------
        on_positions : bool
            Whether balances of forces become constraints on positions.
        """
        return ""


class Dynamics(ABC):
    """``M u' = F`` of a system and what follows from it; constraints come with the system given.

    A derivation gives M, F and the energies. It overrides the methods for which it has a way of its own.
    """

    __slots__ = ()

    @property
    @abstractmethod
    def mass_matrix(self) -> tuple[tuple[Expr, ...], ...]:
        """M, symmetric, in the order of the speeds."""

    @property
    @abstractmethod
    def forcing(self) -> tuple[Expr, ...]:
        """F, in the order of the speeds; affine in the efforts of friction."""

    @property
    @abstractmethod
    def kinetic_energy(self) -> Expr:
        """Kinetic energy relative to ground [J]."""

    @property
    @abstractmethod
    def potential_energy(self) -> Expr:
        """Potential energy of gravity and springs [J]."""

    def solve(self, system: MultibodySystem, forces: Sequence[Expr]) -> LinearSolution:
        """Return u' with ``M u' = forces``, and the pivots, in the order of the speeds."""
        return solve_positive_definite(self.mass_matrix, forces, _outward(system))

    def accelerations(self, system: MultibodySystem) -> tuple[list[Expr], list[Expr]] | None:
        """Return u' and the multipliers if they come from a system of the derivation's own, else None."""
        return None

    def inverse_dynamics(self, udot: Sequence[Expr]) -> list[Expr]:
        """Return ``M u' - F``: what is missing along each speed for the accelerations `udot`."""
        rows = zip(self.mass_matrix, self.forcing, strict=True)
        return [sum((m * a for m, a in zip(row, udot, strict=True)), -force) for row, force in rows]

    def acceleration_slopes(
        self, system: MultibodySystem, udot: Sequence[Expr], by: Sequence[Symbol], *, side_by_side: bool
    ) -> list[list[Expr]]:
        """Return the derivatives of u' of a tree by symbols, one row a speed, all others held fixed.

        Parameters
        ----------
        udot : sequence of Expr
            The accelerations.
        side_by_side : bool
            Whether programs for several columns may be among the nodes: faster as code, not for formulas.
        """
        return differentiate(system, udot, by)

    def wrenches(self, system: MultibodySystem, cut: Sequence[tuple[str, Wrench]]) -> dict[str, Wrench]:
        """Return the total wrench of every joint as a formula in u' and the multipliers.

        Parameters
        ----------
        cut : sequence of (joint or constraint, Wrench)
            What they transmit where they are cut, in any number of parts.
        """
        return joint_wrenches(system.topology, system.kinematics, system.bodies, system.loads.loads, cut)

    def solved_wrenches(
        self, system: MultibodySystem, cut: Sequence[tuple[str, Wrench]]
    ) -> dict[str, Wrench] | None:
        """Return the total wrenches if `accelerations` found them together with u', else None."""
        return None


@dataclass(frozen=True, slots=True)
class ProjectedDynamics(Dynamics):
    """Mass matrix, forcing and energies that are at hand, by whatever derivation."""

    # field(): without it the properties of the base class would count as default values.
    mass_matrix: tuple[tuple[Expr, ...], ...] = field()
    forcing: tuple[Expr, ...] = field()
    kinetic_energy: Expr = field()
    potential_energy: Expr = field()


def differentiate(system: MultibodySystem, udot: Sequence[Expr], by: Sequence[Symbol]) -> list[list[Expr]]:
    """Return the derivatives of a solution by symbols, one row a speed."""
    graph = system.graph
    rows = jacobian(graph, [rate.index for rate in udot], [graph.symbol(symbol) for symbol in by])
    return [[Expr(graph, entry) for entry in row] for row in rows]


def _outward(system: MultibodySystem) -> list[int]:
    """Return the speeds in the order of the branches they belong to, from ground to the leaves."""
    topology = system.topology
    branches = [*topology.translation.branches, *topology.rotation.branches]
    depth: dict[str, int] = {}
    for branch in branches:
        depth.setdefault(branch.edge.name, len(depth))
    owner = {speed.label: role.joint.name for role in system.joint_roles for speed in role.speeds}
    if not owner:  # placed by hand: the order given
        return list(range(len(system.u)))
    return sorted(range(len(system.u)), key=lambda k: depth[owner[system.u[k].label]])
