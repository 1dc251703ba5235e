"""The equations of motion of a system as roots in one graph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Any

from symbody.equations.dynamics.balance import Wrench
from symbody.equations.dynamics.reactions import row_wrenches, sum_wrenches
from symbody.equations.elimination.coupling_multipliers import coupling_multipliers
from symbody.equations.elimination.elimination import SpeedElimination
from symbody.equations.formulations.formulation import Dynamics, Formulation
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.lazy_mapping import LazyMapping
from symbody.equations.kinematics.measured_coordinates import measure_coordinates
from symbody.equations.kinematics.naming import Names
from symbody.equations.loads.friction import Resistance
from symbody.equations.measured_wrenches import coupling_wrenches, drive_wrenches
from symbody.equations.system import MultibodySystem
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.rewrite import Substitution
from symbody.model.element import FrameRef, make_frame_ref
from symbody.single_flight import SingleFlight


@dataclass(frozen=True, slots=True, kw_only=True)
class EquationsOfMotion(MultibodySystem):
    """``M u' = F + J^T lambda``, ``J u' = gamma``, ``q' = N u + nu`` and the energies of a system.

    Attributes
    ----------
    inputs, parameters : tuple of Symbol
        In the order of the model.
    formulation : Formulation
        How the dynamics were derived.
    dynamics : Dynamics
        Mass matrix and forcing; by recursion each is formed on request.
    alignments : tuple of Expr
        Cosines that are 1, not -1, where the cut joints are closed as they should be.
    notes : tuple of str
        Rows that were dropped, and where the equations do not hold.
    elimination : SpeedElimination or None
        The elimination of dependent speeds; its rows are not among `rows`.
    slack : tuple of ConstraintEquation
        Rows of ropes that are slack; they are not among `rows`.
    modes : mapping of str to Expr
        The modes of ropes, 0 while they are taut, where these are inputs; see `modal_equations`.
    given : mapping of str to Expr
        Efforts that are not solved for: of friction by the names of its laws, and the multipliers of rows
        among `slack` that act nevertheless; see `impulsive_equations`.
    angles : frozenset of str
        Coordinates placed by hand that are angles; those of joints follow from the joints.
    outer_signals : tuple of str
        Signals whose outputs are being formed, each for the one before it: an output in quotes may lead back.
    """

    inputs: tuple[Symbol, ...]
    parameters: tuple[Symbol, ...]
    formulation: Formulation
    dynamics: Dynamics
    alignments: tuple[Expr, ...] = ()
    notes: tuple[str, ...] = ()
    elimination: SpeedElimination | None = None
    slack: tuple[ConstraintEquation, ...] = ()
    modes: Mapping[str, Expr] = field(default_factory=dict)
    given: Mapping[str, Expr] = field(default_factory=dict)
    angles: frozenset[str] = frozenset()
    outer_signals: tuple[str, ...] = ()
    # Made on first request from the fields above: what replaces one of these replaces what is made of it.
    _wrenches: SingleFlight[bool, Mapping[str, Wrench]] = field(default_factory=SingleFlight, repr=False)
    _names: SingleFlight[None, Names] = field(default_factory=SingleFlight, repr=False)
    solution: SingleFlight[None, tuple[list[Expr], list[Expr]]] = field(
        default_factory=SingleFlight, repr=False
    )
    substitution: SingleFlight[None, Substitution] = field(default_factory=SingleFlight, repr=False)
    resistances: list[Resistance] = field(default_factory=list, repr=False)
    self_stress: SingleFlight[None, object] = field(default_factory=SingleFlight, repr=False)
    _released: SingleFlight[None, Mapping[str, Expr]] = field(default_factory=SingleFlight, repr=False)
    _substituted: SingleFlight[None, Mapping[str, Expr]] = field(default_factory=SingleFlight, repr=False)

    @classmethod
    def of_system(
        cls, system: MultibodySystem, formulation: Formulation, dynamics: Dynamics, **others: Any
    ) -> EquationsOfMotion:
        """Return the equations of a system; `others` are the fields with defaults."""
        model = system.topology.model
        inputs = (*model.inputs, *(signal.name for signal in model.held_signals))
        return cls(
            **{part.name: getattr(system, part.name) for part in fields(MultibodySystem)},
            inputs=tuple(Symbol(name, SymbolKind.INPUT) for name in inputs),
            parameters=tuple(Symbol(name, SymbolKind.PARAMETER) for name in model.parameters),
            formulation=formulation,
            dynamics=dynamics,
            **others,
        )

    @property
    def kinetic_energy(self) -> Expr:
        """Kinetic energy relative to ground [J]."""
        return self.dynamics.kinetic_energy

    @property
    def potential_energy(self) -> Expr:
        """Potential energy of gravity and springs [J]."""
        return self.dynamics.potential_energy

    @property
    def dependent_names(self) -> tuple[str, ...]:
        """Names of the speeds eliminated."""
        return () if self.elimination is None else tuple(u.label for u in self.elimination.dependent)

    @property
    def light_balances(self) -> Mapping[Symbol, ConstraintEquation]:
        """The balances of forces along motions that move no mass, by the speeds that follow from them."""
        if self.elimination is None:
            return {}
        pairs = zip(self.elimination.dependent, self.elimination.rows, strict=True)
        return {speed: row for speed, row in pairs if row.is_balance}

    @property
    def eliminated_multipliers(self) -> Mapping[str, Expr]:
        """The multipliers of rows eliminated, in u', the other multipliers and friction efforts."""
        if self.elimination is None or all(row.is_balance for row in self.elimination.rows):
            return {}
        # Rows that were silenced have no slopes, and their multipliers are 0.
        others = [row.name for row in self.rows if row.jacobian]
        return self._released.get(None, partial(self.elimination.multipliers, others))

    @property
    def coupling_multipliers(self) -> Mapping[str, Expr]:
        """The multipliers of couplings that are substituted, in u', the other multipliers and friction."""
        if not self.coupled.rows:
            return {}
        return self._substituted.get(
            None, lambda: coupling_multipliers(self, self.solved_wrenches, self.bearing_rows)
        )

    @property
    def rows_and_multipliers(self) -> list[tuple[ConstraintEquation, Expr]]:
        """All constraints, those eliminated too, each with its multiplier."""
        eliminated = () if self.elimination is None else self.elimination.rows
        return [
            *self._with_multipliers(self.rows),
            *((row, self.eliminated_multipliers[row.name]) for row in eliminated if not row.is_balance),
        ]

    @property
    def given_rows(self) -> list[tuple[ConstraintEquation, Expr]]:
        """The rows that are open and act nevertheless, each with the multiplier that is given."""
        return [(row, self.given[row.name]) for row in self.slack if row.name in self.given]

    @property
    def position_jacobian(self) -> list[list[Expr]]:
        """The derivatives of Phi by q, one row a holonomic constraint."""
        by = [q.index for q in self.expressions(self.q)]
        rows = jacobian(self.graph, [row.value.index for row in self.holonomic], by)
        return [[Expr(self.graph, entry) for entry in row] for row in rows]

    @property
    def wrenches(self) -> Mapping[str, Wrench]:
        """The total wrench of every joint as a formula in u' and the multipliers, of redundant rows too."""
        return self._wrenches.get(False, partial(self._form_wrenches, is_solved=False))

    @property
    def solved_wrenches(self) -> Mapping[str, Wrench]:
        """The same wrenches for evaluation; those of Newton-Euler come from its system with u'."""
        return self._wrenches.get(True, partial(self._form_wrenches, is_solved=True))

    def _form_wrenches(self, *, is_solved: bool) -> Mapping[str, Wrench]:
        rows = [*self.bearing_rows, *self.given_rows]
        cut = [*row_wrenches(rows), *drive_wrenches(self), *coupling_wrenches(self, rows)]
        total = self.dynamics.solved_wrenches(self, cut) if is_solved else self.dynamics.wrenches(self, cut)
        if total is None:
            return self.wrenches
        contacts = [pair for pair in rows if pair[0].element in self.topology.contacts]
        return total | sum_wrenches(row_wrenches(contacts))

    def with_rows(
        self, rows: tuple[ConstraintEquation, ...], redundant: tuple[ConstraintEquation, ...] | None = None
    ) -> EquationsOfMotion:
        """Return the same equations under other constraints."""
        return replace(
            self,
            rows=rows,
            redundant=self.redundant if redundant is None else redundant,
            solution=SingleFlight(),
            substitution=SingleFlight(),
            resistances=[],
            self_stress=SingleFlight(),
            _wrenches=SingleFlight(),
            _names=SingleFlight(),
            _released=SingleFlight(),
            _substituted=SingleFlight(),
        )

    def with_names(self, values: Mapping[str, Expr], inputs: Iterable[Symbol] = ()) -> EquationsOfMotion:
        """Return the same equations with more names for values, some of them further inputs."""
        return replace(
            self,
            names=self.names.with_values(values),
            inputs=(*self.inputs, *inputs),
            _names=SingleFlight(),
        )

    def with_independent(self, kept: Iterable[int]) -> EquationsOfMotion:
        """Return the equations without rows that follow from those kept; they still bear loads."""
        places = set(kept)
        rows = tuple(row for k, row in enumerate(self.rows) if k in places)
        others = tuple(row for k, row in enumerate(self.rows) if k not in places)
        return self.with_rows(rows, (*self.redundant, *others))

    def rest_in_all_speeds(self, row: ConstraintEquation) -> Expr:
        """Return the rest of a row in all speeds, the eliminated ones too."""
        return row.drift if self.elimination is None else self.elimination.given[row.name][1]

    @property
    def readable_names(self) -> Names:
        """The names with multipliers, and all coordinates of cut joints, measured on first request."""
        return self._names.get(None, self._form_names)

    def _form_names(self) -> Names:
        multipliers = zip(self.multipliers, self.expressions(self.multipliers), strict=True)
        values = {symbol.label: value for symbol, value in multipliers} | dict(self.eliminated_multipliers)
        pivots = {} if self.elimination is None else self.elimination.pivots
        names = self.names.with_values(values | dict(pivots))
        for role in self.joint_roles:
            names = names.with_values(measure_coordinates(names, self.kinematics, role))
        if not self.coupled.rows:
            return names
        # On request: they take the wrenches of all joints.
        any_value = next(iter(self.coupled.values))
        rules = {
            row.name: (any_value, partial(self._coupling_multiplier, row.name)) for row in self.coupled.rows
        }
        return Names(names.graph, names.symbols, LazyMapping(names.values, rules))

    def _coupling_multiplier(self, name: str, _: Expr) -> Expr:
        return self.coupling_multipliers[name]

    def frame(self, name: str) -> str:
        """Return the frame of kinematics that an address means.

        Raises
        ------
        FormulationError
            If there is none, with the nearest names.
        """
        element = self.topology.output_scope.elements.get(name)
        if element is not None and element.has_frame:
            return name  # its frame is at the point of contact
        body, _, point = name.partition(".")
        found = self.topology.output_scope.frames.find(make_frame_ref(body, point))
        if isinstance(found, FrameRef):
            return found.full_name
        raise FormulationError(Problem("equations.unknown_frame", f"frame {name}", found[0], "", found[1]))
