"""`Recursive`: equations of motion by recursions along one tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Literal

from symbody.arguments import checked_fields
from symbody.equations.dynamics.balance import Wrench
from symbody.equations.dynamics.linear_solve import LinearSolution
from symbody.equations.dynamics.reactions import sum_wrenches
from symbody.equations.formulations.formulation import Dynamics, Formulation
from symbody.equations.recursive.recursion import Recursion
from symbody.equations.recursive.tree import base_tree, form_tree, ground_inertia
from symbody.equations.recursive.tree_energies import kinetic_energy, potential_energy
from symbody.equations.recursive.tree_reactions import joint_wrenches
from symbody.equations.recursive.udot_derivatives import acceleration_slopes
from symbody.equations.system import MultibodySystem
from symbody.expr.deadline import begin
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Symbol
from symbody.graph.topology import Topology
from symbody.spatial.matrix import Vector3


@checked_fields
@dataclass(frozen=True, slots=True)
class Recursive(Formulation):
    """Formulation by recursive Newton-Euler, composite and articulated bodies along one tree.

    Where the rotation tree is not the translation tree, or speeds are eliminated, virtual work takes its
    place, with a note.

    Attributes
    ----------
    method : str
        How accelerations of a tree without constraints are solved for: "articulated" bodies, the factors of
        the "composite" mass matrix, or "" for the one with fewer operations.
    aligned : bool
        Whether the axes of links are put along joints and common normals.
    regrouped : bool
        Whether mass that a parent can carry as well is added to the parent: base parameters.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail]), sb.Recursive(method="composite"))
    >>> eqs.mass_matrix
    Matrix([[2]])
    """

    has_lazy_velocities: ClassVar[bool] = True
    has_weights_in_loads: ClassVar[bool] = False

    method: Literal["", "articulated", "composite"] = ""
    aligned: bool = True
    regrouped: bool = True

    def obstacle(self, topology: Topology, *, eliminates: bool) -> str:
        """Return the reason why recursion is impossible."""
        if eliminates:
            return "recursion: speeds are eliminated"
        if topology.rotation_branches != topology.translation_branches:
            return "recursion: the rotation tree differs from the translation tree"
        return "" if topology.joints else "recursion: there are no joints"

    def balance_obstacle(self, *, on_positions: bool) -> str:
        """Return the reason why recursion is impossible."""
        return "recursion: some motion has no mass and is determined by balances of forces"

    def derive(self, system: MultibodySystem) -> Dynamics:
        """Return mass matrix, forcing and accelerations by recursion, each formed on request."""
        names, kinematics, topology = system.names, system.kinematics, system.topology
        tree = form_tree(topology, names, kinematics.rates, system.joint_roles, align=self.aligned)
        gravity = Vector3(names.triple(topology.model.gravity, "gravity"))
        on_ground = ground_inertia(names, topology.model.bodies, tree)
        light = tree
        if self.regrouped:
            light, to_ground = base_tree(names.graph, tree)
            on_ground = on_ground + to_ground
        rotors = tuple(system.rotors.values())
        recursion = Recursion(
            topology=topology,
            kinematics=kinematics,
            tree=tree,
            base_tree=light,
            gravity=gravity,
            loads=system.loads.loads,
            rotors=rotors,
            method=self.method,
        )
        begin("energy")
        potential = system.loads.potential_energy + potential_energy(light, on_ground, gravity)
        return RecursiveDynamics(recursion, kinetic_energy(light, rotors, number(names.graph, 0)), potential)


@dataclass(frozen=True, slots=True)
class RecursiveDynamics(Dynamics):
    """The dynamics of a tree by recursion; M by composite bodies, inverse dynamics by Newton-Euler."""

    recursion: Recursion
    kinetic_energy: Expr = field()
    potential_energy: Expr = field()

    @property
    def mass_matrix(self) -> tuple[tuple[Expr, ...], ...]:
        """M in the order of the speeds."""
        return self.recursion.mass_matrix

    @property
    def forcing(self) -> tuple[Expr, ...]:
        """F in the order of the speeds."""
        return self.recursion.forcing

    def solve(self, system: MultibodySystem, forces: Sequence[Expr]) -> LinearSolution:
        """Return u' by articulated bodies or the factors of M, and the pivots."""
        return self.recursion.solve(forces)

    def inverse_dynamics(self, udot: Sequence[Expr]) -> list[Expr]:
        """Return ``M u' - F`` by the recursive Newton-Euler algorithm."""
        return self.recursion.inverse_dynamics(udot)

    def acceleration_slopes(
        self, system: MultibodySystem, udot: Sequence[Expr], by: Sequence[Symbol], *, side_by_side: bool
    ) -> list[list[Expr]]:
        """Return the derivatives of u' from those of the inverse dynamics."""
        return acceleration_slopes(system, self.recursion, udot, by, side_by_side=side_by_side)

    def wrenches(self, system: MultibodySystem, cut: Sequence[tuple[str, Wrench]]) -> dict[str, Wrench]:
        """Return the total wrenches, summed from the leaves inward."""
        graph = system.graph
        udot = {
            node: symbol(graph, graph.symbols[graph.left[node]].derivative)
            for node in system.kinematics.speeds
        }
        return joint_wrenches(self.recursion, system.names, udot, sum_wrenches(cut))
