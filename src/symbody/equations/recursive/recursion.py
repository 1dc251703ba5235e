"""`Recursion`: mass matrix, forcing and accelerations of a tree, each formed on first use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from symbody.equations.dynamics.inertia import Rotor
from symbody.equations.dynamics.linear_solve import LinearSolution, Rows, TreeFactors, factor, solve_factored
from symbody.equations.dynamics.load import GeneralizedForce, Load
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.recursive.coupled_aba import UncoupledMotions, can_uncouple, uncouple_motions
from symbody.equations.recursive.crba import mass_rows, row_numbers
from symbody.equations.recursive.link_loads import link_loads
from symbody.equations.recursive.links import KinematicTree, LinkWrench
from symbody.equations.recursive.rnea import generalized_forces, inertial_wrenches, link_motions
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.expr.rewrite import operation_count
from symbody.graph.topology import Topology
from symbody.single_flight import SingleFlight
from symbody.spatial.matrix import Vector3, zero_vector
from symbody.spatial.twist import Wrench

# Composite bodies are not even tried where their entries and elimination are estimated to cost this
# many times what articulated bodies do.
_HOPELESS: Final = 2.0
# Factors of M serve many right-hand sides while a speed is carried by fewer than this many on average:
# 4 operations a right-hand side for each of them, 70 a link for articulated bodies.
_LONG: Final = 18
# Operations: of an articulated body, of carrying a column of the mass matrix over one link, and of a link in
# one more pass for a coupling.
_ARTICULATED, _CARRYING, _PASS = 300, 18, 70


@dataclass(frozen=True, slots=True)
class Recursion:
    """The equations of motion of a tree by recursion.

    Attributes
    ----------
    tree : KinematicTree
        Links as they are.
    base_tree : KinematicTree
        Links with their base parameters only: the same motion, other reactions. M and F come from it.
    method : str
        "articulated", "composite", or "" for the one with fewer operations.
    """

    topology: Topology
    kinematics: Kinematics
    tree: KinematicTree
    base_tree: KinematicTree
    gravity: Vector3[Expr]
    loads: tuple[Load, ...]
    rotors: tuple[Rotor, ...]
    method: str = ""
    # Made on first request; pure functions of the fields above, so they cannot go stale.
    _rows: SingleFlight[None, Rows] = field(default_factory=SingleFlight, repr=False)
    _factors: SingleFlight[None, TreeFactors] = field(default_factory=SingleFlight, repr=False)
    _motions: SingleFlight[None, UncoupledMotions] = field(default_factory=SingleFlight, repr=False)
    _joined: SingleFlight[None, bool] = field(default_factory=SingleFlight, repr=False)
    _forcing: SingleFlight[None, tuple[Expr, ...]] = field(default_factory=SingleFlight, repr=False)
    _chosen: SingleFlight[None, str] = field(default_factory=SingleFlight, repr=False)
    _solutions: SingleFlight[tuple[int, ...], LinearSolution] = field(
        default_factory=SingleFlight, repr=False
    )

    @property
    def graph(self) -> Graph:
        """The graph of all expressions."""
        return self.kinematics.graph

    @property
    def mass_matrix(self) -> tuple[tuple[Expr, ...], ...]:
        """M in the order of the speeds."""
        rows, row = self._mass_rows(), self._row_numbers
        order = [row[u] for u in self.kinematics.speeds]
        zero = number(self.graph, 0)

        def entry(i: int, j: int) -> Expr:
            return rows[max(i, j)].get(min(i, j), zero)

        return tuple(tuple(entry(i, j) for j in order) for i in order)

    @property
    def forcing(self) -> tuple[Expr, ...]:
        """F in the order of the speeds."""
        return self._forcing.get(None, self._form_forcing)

    def _form_forcing(self) -> tuple[Expr, ...]:
        needed, zero = self.force_for_accelerations(), number(self.graph, 0)
        return tuple(
            effort - needed.get(u, zero)
            for u, effort in zip(self.kinematics.speeds, self._efforts(), strict=True)
        )

    def _mass_rows(self) -> Rows:
        return self._rows.get(
            None, lambda: mass_rows(self.base_tree, self._row_numbers, self.rotor_entries())
        )

    def force_for_accelerations(self, udot: Mapping[int, Expr] | None = None) -> dict[int, Expr]:
        """Return the force along each speed that accelerations need, less loads on bodies; by default u' = 0.

        Efforts along coordinates and rotors are not in it.
        """
        wrenches = inertial_wrenches(self.base_tree, link_motions(self.base_tree, self.gravity, udot))
        for k, load in self._link_loads().items():
            wrenches[k] = wrenches[k] - load
        return generalized_forces(self.base_tree, wrenches)

    def inverse_dynamics(self, udot: Sequence[Expr]) -> list[Expr]:
        """Return ``M u' - F``, the generalized forces still missing for the accelerations `udot`."""
        given = dict(zip(self.kinematics.speeds, udot, strict=True))
        return self._with_efforts(self.force_for_accelerations(given), given)

    def inverse_dynamics_of_loads(self, udot: Sequence[Expr]) -> list[Expr]:
        """Return the inverse dynamics of loads and rotors alone, without the links."""
        given = dict(zip(self.kinematics.speeds, udot, strict=True))
        zero = zero_vector(self.graph)
        wrenches = [Wrench(zero, zero) for _ in self.base_tree.links]
        for k, load in self._link_loads().items():
            wrenches[k] = -load
        return self._with_efforts(generalized_forces(self.base_tree, wrenches), given)

    def _link_loads(self) -> dict[int, LinkWrench]:
        return link_loads(self.topology, self.kinematics, self.base_tree, self.loads)

    def _with_efforts(self, needed: Mapping[int, Expr], given: Mapping[int, Expr]) -> list[Expr]:
        """Return ``M u' - F`` with efforts along coordinates and rotors."""
        speeds, zero = self.kinematics.speeds, number(self.graph, 0)
        total = {u: needed.get(u, zero) - effort for u, effort in zip(speeds, self._efforts(), strict=True)}
        for (one, two), inertia in self.rotor_entries().items():
            total[one] = total[one] + inertia * given[two]
        return [total[u] for u in speeds]

    def solve(self, forces: Sequence[Expr]) -> LinearSolution:
        """Return u' with ``M u' = forces``, and the pivots, in the order of the speeds."""
        method = self._chosen.get(None, lambda: self.method or self._cheaper(forces))
        key = tuple(force.index for force in forces)
        values, pivots = self._solutions.get(key, lambda: self._solve_with(method, forces))
        return LinearSolution(list(values), list(pivots))

    def solve_columns(self, columns: Sequence[Sequence[Expr]]) -> list[list[Expr]]:
        """Return u' with ``M u' = column`` for many columns; by other operations than `solve`."""
        method = self.method_for_columns
        return [self._solve_with(method, column).values for column in columns]

    @property
    def method_for_columns(self) -> str:
        """The method that many columns are solved by: factors of M, unless chains are long."""
        if self.method:
            return self.method
        links = zip(self.base_tree.depths, self.base_tree.links, strict=True)
        carried = sum(depth * len(link.motion.columns) for depth, link in links)
        short = carried < _LONG * len(self.kinematics.speeds)
        return "composite" if short or self._needs_mass_matrix else "articulated"

    @property
    def chosen_method(self) -> str:
        """The method that `solve` takes; empty before its first call."""
        return self._chosen.peek(None) or ""

    def _cheaper(self, forces: Sequence[Expr]) -> str:
        """Return the method with fewer operations."""
        depths = [
            d
            for d, link in zip(self.base_tree.depths, self.base_tree.links, strict=True)
            if link.motion.columns
        ]
        composite = sum(d * d + _CARRYING * d for d in depths)
        articulated = (_ARTICULATED + _PASS * len(self.base_tree.followers)) * len(depths)
        if self._needs_mass_matrix or (self.base_tree.followers and _HOPELESS * composite < articulated):
            return "composite"
        if composite > _HOPELESS * articulated:
            return "articulated"
        counts = {
            method: operation_count(self.graph, [x.index for x in self._solve_with(method, forces).values])
            for method in ("composite", "articulated")
        }
        return min(counts, key=counts.__getitem__)

    def _solve_with(self, method: str, forces: Sequence[Expr]) -> LinearSolution:
        speeds = self.kinematics.speeds
        if method == "articulated" and not self._needs_mass_matrix:
            motions = self._motions.get(None, self._uncouple_motions)
            udot, pivots = motions.accelerations(dict(zip(speeds, forces, strict=True))), motions.pivots
            return LinearSolution([udot[u] for u in speeds], [pivots[u] for u in speeds])
        factors, row = self._factors.get(None, lambda: factor(self._mass_rows())), self._row_numbers
        right = [forces[0]] * len(row) if forces else []
        for u, force in zip(speeds, forces, strict=True):
            right[row[u]] = force
        x = solve_factored(factors, right)
        return LinearSolution([x[row[u]] for u in speeds], [factors.pivots[row[u]] for u in speeds])

    def _uncouple_motions(self) -> UncoupledMotions:
        rotors = {one: inertia for (one, _), inertia in self.rotor_entries().items()}
        return uncouple_motions(self.base_tree, rotors)

    @property
    def _needs_mass_matrix(self) -> bool:
        """Whether free motions cannot be taken apart.

        Rotors on several speeds join links that do not carry each other, and a coupled joint has other free
        motions, or no mass by itself.
        """
        return self._joined.get(None, self._find_joined)

    def _find_joined(self) -> bool:
        if any(one != two for one, two in self.rotor_entries()) or not can_uncouple(self.base_tree):
            return True
        if not self.base_tree.followers:
            return False
        pivots = self._motions.get(None, self._uncouple_motions).pivots.values()
        return any(pivot.is_zero for pivot in pivots)

    def rotor_entries(self) -> dict[tuple[int, int], Expr]:
        """Return the entries of rotors in the mass matrix, by pairs of speeds."""
        entries: dict[tuple[int, int], Expr] = {}
        for rotor in self.rotors:
            slopes = self._speed_partials(rotor.rate)
            for one, a in slopes.items():
                for two, b in slopes.items():
                    entry = rotor.inertia * a * b
                    entries[one, two] = entries[one, two] + entry if (one, two) in entries else entry
        return entries

    def _efforts(self) -> list[Expr]:
        """Return the generalized forces of drives, and of rotors with all u' = 0."""
        speeds, zero = self.kinematics.speeds, number(self.graph, 0)
        total = dict.fromkeys(speeds, zero)
        for load in self.loads:
            if isinstance(load, GeneralizedForce):
                for u, slope in self._speed_partials(load.rate).items():
                    total[u] = total[u] + slope * load.effort
        for rotor in self.rotors:
            bias = self.kinematics.bias(rotor.rate)
            for u, slope in self._speed_partials(rotor.rate).items():
                total[u] = total[u] - rotor.inertia * bias * slope
        return [total[u] for u in speeds]

    def _speed_partials(self, rate: Expr) -> dict[int, Expr]:
        """Return the coefficients of the speeds; most rates are a speed."""
        if rate.index in self._places:
            return {rate.index: number(self.graph, 1)}
        return self.kinematics.speed_partials(rate)

    @property
    def _row_numbers(self) -> dict[int, int]:
        return row_numbers(self.base_tree, self.kinematics.speeds)

    @property
    def _places(self) -> frozenset[int]:
        return frozenset(self.kinematics.speeds)
