"""`MultibodySystem`: bodies, their kinematics, loads and constraints, before any equations of motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.elimination.coupled_coordinates import NONE_COUPLED, CoupledCoordinates
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole, Variables
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.loads.loads import Loads
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.graph.topology import Topology


@dataclass(frozen=True, slots=True, kw_only=True)
class MultibodySystem:
    """What a formulation derives the equations of motion from, in one graph.

    Attributes
    ----------
    joint_roles : tuple of JointRole
        Every joint, with the parts of its law that are in use; none for mechanisms placed by hand.
    rotors : mapping of coordinate to Rotor
        Rotors that turn with the rates of joints.
    rows : tuple of ConstraintEquation
        The constraints, in the order of Phi.
    redundant : tuple of ConstraintEquation
        Rows that follow from `rows` and are not among them; they bear loads too, see `solving.self_stress`.
    friction : tuple of FrictionLaw
        Dry friction in joints; its efforts are unknowns of the forcing.
    coupled : CoupledCoordinates
        Coordinates that are substituted, and the couplings that give them.
    """

    names: Names
    topology: Topology
    joint_roles: tuple[JointRole, ...]
    variables: Variables
    kinematics: Kinematics
    bodies: tuple[Inertia, ...]
    loads: Loads
    rotors: Mapping[str, Rotor]
    rows: tuple[ConstraintEquation, ...]
    redundant: tuple[ConstraintEquation, ...] = ()
    friction: tuple[FrictionLaw, ...] = ()
    coupled: CoupledCoordinates = NONE_COUPLED

    @property
    def graph(self) -> Graph:
        """The graph of all expressions."""
        return self.names.graph

    @property
    def q(self) -> tuple[Symbol, ...]:
        """Coordinates, in the order of the joints."""
        return self.variables.q

    @property
    def u(self) -> tuple[Symbol, ...]:
        """Speeds, in the order of the joints."""
        return self.variables.u

    @property
    def signal_states(self) -> tuple[Symbol, ...]:
        """The states s of signals, in the order of the model, without bristles along which nothing slips."""
        signals = (s.name for s in self.topology.model.signals if s.is_state)
        return tuple(Symbol(s, SymbolKind.SIGNAL) for s in signals if s not in self.names.values)

    @property
    def holonomic(self) -> tuple[ConstraintEquation, ...]:
        """The constraints on positions, which stand first."""
        return tuple(row for row in self.rows if row.is_holonomic)

    @property
    def multipliers(self) -> tuple[Symbol, ...]:
        """Multipliers, one a row."""
        return tuple(Symbol(row.name, SymbolKind.MULTIPLIER) for row in self.rows)

    @property
    def jacobian(self) -> list[list[Expr]]:
        """J, one row a constraint."""
        zero = Expr(self.graph, 0)
        return [[row.jacobian.get(u, zero) for u in self.kinematics.speeds] for row in self.rows]

    @property
    def rows_and_multipliers(self) -> list[tuple[ConstraintEquation, Expr]]:
        """The constraints, each with its multiplier."""
        return self._with_multipliers(self.rows)

    @property
    def bearing_rows(self) -> list[tuple[ConstraintEquation, Expr]]:
        """All constraints that bear loads, redundant ones too, each with its multiplier."""
        return [*self.rows_and_multipliers, *self._with_multipliers(self.redundant)]

    def _with_multipliers(
        self, rows: tuple[ConstraintEquation, ...]
    ) -> list[tuple[ConstraintEquation, Expr]]:
        symbols = self.expressions([Symbol(row.name, SymbolKind.MULTIPLIER) for row in rows])
        return list(zip(rows, symbols, strict=True))

    def expressions(self, symbols: Sequence[Symbol]) -> tuple[Expr, ...]:
        """Return symbols as expressions of the graph."""
        return tuple(Expr(self.graph, self.graph.symbol(symbol)) for symbol in symbols)
