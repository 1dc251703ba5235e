"""What a formulation delivers: the equations of a model as roots in one graph."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from symbody.equations.dynamics.balance import NOTHING, Wrench, balanced
from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.projection import Projection
from symbody.equations.dynamics.reactions import drive_wrench, joint_wrenches, row_wrenches, summed
from symbody.equations.elimination.elimination import Elimination
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.formulations.newton_euler import FreeBodies, NewtonEuler, Solution
from symbody.equations.formulations.virtual_work import VIRTUAL_WORK
from symbody.equations.kinematics.measured import measured_coordinates
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.placing import joint_shift
from symbody.equations.kinematics.row import Row
from symbody.equations.kinematics.variables import Use, Variables
from symbody.equations.loads.friction import FrictionLaw, Resistance
from symbody.equations.loads.loads import Loads, effort_name
from symbody.equations.recursive.reactions import joint_wrenches as recursive_wrenches
from symbody.equations.recursive.recursion import Recursion
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr, symbol
from symbody.expr.graph import Graph, Kind, Symbol
from symbody.graph.topology import Topology
from symbody.model.constraints import Rolling
from symbody.model.element import Address, address_of
from symbody.model.lookup import places_of
from symbody.single_flight import SingleFlight


@dataclass(frozen=True, slots=True)
class Formed:
    """``M u' = F + J^T lambda``, ``J u' = gamma``, ``q' = N u + nu`` and the energies, in one graph.

    Attributes
    ----------
    uses : tuple of Use
        Every joint, with the parts of its law that are in use.
    rows : tuple of Row
        The constraints, in the order of Phi.
    alignments : tuple of Expr
        Cosines that are 1, not -1, where the cut joints are closed as they should be.
    projection : Projection or Recursion
        Mass matrix and forcing; by recursion each when it is asked for.
    notes : tuple of str
        What was dropped, and where the equations do not hold.
    friction : tuple of FrictionLaw
        What holds joints back; its efforts are unknowns of the forcing.
    armatures : mapping of coordinate to Rotor
        What turns with the rates of joints.
    formulation : VirtualWork, NewtonEuler or Lagrange
        How mass matrix and forcing were found.
    elimination : Elimination or None
        What made some speeds functions of the others; their rows are not among `rows`.
    slack : tuple of Row
        Rows of ropes that are slack; they are not among `rows`.
    redundant : tuple of Row
        Rows that follow from `rows` and are not among them; they bear loads too, see `solving.self_stress`.
    angles : frozenset of str
        Coordinates placed by hand that whole turns change nothing of; those of joints are known by these.
    """

    names: Names
    topology: Topology
    uses: tuple[Use, ...]
    variables: Variables
    inputs: tuple[Symbol, ...]
    parameters: tuple[Symbol, ...]
    kinematics: Kinematics
    bodies: tuple[Inertia, ...]
    loads: Loads
    armatures: Mapping[str, Rotor]
    rows: tuple[Row, ...]
    alignments: tuple[Expr, ...]
    projection: Projection | Recursion
    kinetic_energy: Expr
    notes: tuple[str, ...]
    friction: tuple[FrictionLaw, ...] = ()
    formulation: Formulation = VIRTUAL_WORK
    elimination: Elimination | None = None
    slack: tuple[Row, ...] = ()
    redundant: tuple[Row, ...] = ()
    angles: frozenset[str] = frozenset()
    # Made on first request; a pure function of the fields above, so it cannot go stale.
    _wrenches: SingleFlight[None, Mapping[str, Wrench]] = field(default_factory=SingleFlight, repr=False)
    _names: SingleFlight[None, Names] = field(default_factory=SingleFlight, repr=False)
    solved: SingleFlight[None, tuple[list[Expr], list[Expr]]] = field(
        default_factory=SingleFlight, repr=False
    )
    resistances: list[Resistance] = field(default_factory=list, repr=False)
    self_stress: SingleFlight[None, object] = field(default_factory=SingleFlight, repr=False)
    _free: SingleFlight[None, Solution] = field(default_factory=SingleFlight, repr=False)
    _released: SingleFlight[None, Mapping[str, Expr]] = field(default_factory=SingleFlight, repr=False)

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
    def holonomic(self) -> tuple[Row, ...]:
        """The constraints on positions, which stand first."""
        return tuple(row for row in self.rows if row.is_holonomic)

    @property
    def multipliers(self) -> tuple[Symbol, ...]:
        """Multipliers, one a row."""
        return tuple(Symbol(row.name, Kind.MULTIPLIER) for row in self.rows)

    @property
    def jacobian(self) -> list[list[Expr]]:
        """J, one row a constraint."""
        zero = Expr(self.graph, 0)
        return [[row.slopes.get(u, zero) for u in self.kinematics.speeds] for row in self.rows]

    @property
    def dependent_names(self) -> tuple[str, ...]:
        """Names of the speeds eliminated."""
        return () if self.elimination is None else tuple(u.label for u in self.elimination.dependent)

    @property
    def released(self) -> Mapping[str, Expr]:
        """The multipliers of rows eliminated, in u', the other multipliers and friction efforts."""
        if self.elimination is None:
            return {}
        # Rows that were silenced have no slopes, and their multipliers are 0.
        others = [row.name for row in self.rows if row.slopes]
        return self._released.get(None, partial(self.elimination.multipliers, others))

    @property
    def rows_and_multipliers(self) -> list[tuple[Row, Expr]]:
        """All constraints, those eliminated too, each with its multiplier."""
        found = list(zip(self.rows, self.expressions(self.multipliers), strict=True))
        tied = () if self.elimination is None else self.elimination.rows
        return [*found, *((row, self.released[row.name]) for row in tied)]

    @property
    def bearing_rows(self) -> list[tuple[Row, Expr]]:
        """All constraints that bear loads, redundant ones too, each with its multiplier."""
        symbols = tuple(Symbol(row.name, Kind.MULTIPLIER) for row in self.redundant)
        spare = zip(self.redundant, self.expressions(symbols), strict=True)
        return [*self.rows_and_multipliers, *spare]

    @property
    def position_jacobian(self) -> list[list[Expr]]:
        """The derivatives of Phi by q, one row a holonomic constraint."""
        by = [q.index for q in self.expressions(self.q)]
        rows = jacobian(self.graph, [row.value.index for row in self.holonomic], by)
        return [[Expr(self.graph, entry) for entry in row] for row in rows]

    @property
    def wrenches(self) -> Mapping[str, Wrench]:
        """The total wrench of every joint in terms of u' and the multipliers, of redundant rows too.

        By Newton-Euler those that the saddle system gives; `balanced_wrenches` are formulas.
        """
        return self._wrenches.get(None, lambda: self._form_wrenches(self.free_bodies))

    @property
    def balanced_wrenches(self) -> Mapping[str, Wrench]:
        """The total wrench of every joint as a formula in u' and the multipliers."""
        return self.wrenches if self.free_bodies is None else self._form_wrenches(None)

    def _form_wrenches(self, free: Solution | None) -> Mapping[str, Wrench]:
        rows = self.bearing_rows
        cut = [*row_wrenches(rows), *self._measured_drives(), *self._couplings(rows)]
        if isinstance(self.projection, Recursion):
            rates = zip(self.expressions(self.u), self.u, strict=True)
            udot = {u.index: symbol(self.graph, name.derivative) for u, name in rates}
            found = recursive_wrenches(self.projection, self.names, udot, summed(cut))
        elif free is None:
            found = joint_wrenches(self.topology, self.kinematics, self.bodies, self.loads.loads, cut)
        else:
            found = dict.fromkeys((joint.name for joint in self.topology.joints), NOTHING)
            found |= summed([*cut, *free.wrenches.items(), *self._carried(free.multipliers)])
        contacts = [pair for pair in rows if pair[0].element in self.topology.contacts]
        return found | summed(row_wrenches(contacts))

    @property
    def free_bodies(self) -> Solution | None:
        """Accelerations, multipliers and wrenches with every reaction an unknown, by Newton-Euler.

        None for other formulations, with friction, without joints, and where speeds were eliminated: there
        the balance of bodies follows the accelerations.
        """
        if not isinstance(self.formulation, NewtonEuler) or self.friction:
            return None
        if self.elimination is not None or not self.uses:
            return None
        return self._free.get(None, self._solve_free_bodies)

    def _solve_free_bodies(self) -> Solution:
        return FreeBodies(
            topology=self.topology,
            kinematics=self.kinematics,
            uses=self.uses,
            shifts={use.joint.name: joint_shift(self.names, use.joint) for use in self.uses},
            bodies=self.bodies,
            loads=self.loads.loads,
            rotors=tuple(self.armatures.values()),
            rows=self.rows,
            within=dict(self._measured_efforts()),
            coupled={row.name: tuple(self._coupled(row)) for row in self.rows if row.shares},
        ).solved()

    def _measured_efforts(self) -> Iterator[tuple[str, tuple[str, Wrench]]]:
        """Return what a unit effort along each measured coordinate does."""
        names, one = self.names, Expr(self.graph, self.graph.constant(1))
        for use in self.uses:
            joint = use.joint
            rubbing = {law.coordinate: law for law in self.friction if law.joint.name == joint.name}
            for coordinate in {**joint.drives, **joint.armature, **rubbing}:
                if coordinate not in use.coordinates:
                    share = drive_wrench(names, self.kinematics, joint, coordinate, one)
                    yield coordinate, (joint.name, share)

    def _measured_drives(self) -> Iterator[tuple[str, Wrench]]:
        """Return the wrenches of drives and rotors along coordinates that are not variables."""
        names, kinematics = self.names, self.kinematics
        for use in self.uses:
            joint = use.joint
            rubbing = {law.coordinate: law for law in self.friction if law.joint.name == joint.name}
            for coordinate in {**joint.drives, **joint.armature, **rubbing}:
                if coordinate in use.coordinates:
                    continue
                effort = self.loads.efforts.get(effort_name(joint, coordinate), Expr(self.graph, 0))
                if coordinate in self.armatures:
                    rotor = self.armatures[coordinate]
                    effort = effort - rotor.inertia * kinematics.rate(rotor.rate)
                if coordinate in rubbing:
                    effort = effort + rubbing[coordinate].effort
                yield joint.name, drive_wrench(names, kinematics, joint, coordinate, effort)

    def _carried(self, solution: Sequence[Expr]) -> Iterator[tuple[str, Wrench]]:
        """Return what branches carry more where multipliers differ from those of their wrenches."""
        pairs = self.bearing_rows
        found = [*solution, *(Expr(self.graph, 0) for _ in self.redundant)]
        more = [(row, symbol - value) for (row, symbol), value in zip(pairs, found, strict=True)]
        cut = summed([*row_wrenches(more), *self._couplings(more)])
        for name, wrench in balanced(self.topology, self.kinematics, {}, cut).items():
            own = cut.get(name, NOTHING)
            yield name, Wrench(wrench.force - own.force, wrench.moment - own.moment)

    def static_wrenches(self) -> dict[str, Wrench]:
        """Return the total wrench of every joint if multipliers alone act, on bodies that need nothing."""
        rows = self.bearing_rows
        cut = summed([*row_wrenches(rows), *self._couplings(rows)])
        found = dict.fromkeys((joint.name for joint in self.topology.joints), NOTHING)
        return found | cut | balanced(self.topology, self.kinematics, {}, cut)

    def _couplings(self, rows: Sequence[tuple[Row, Expr]]) -> Iterator[tuple[str, Wrench]]:
        """Return the wrenches of constraints written in coordinates that are not variables."""
        for row, multiplier in rows:
            for joint, share in self._coupled(row):
                yield joint, Wrench(share.force * multiplier, share.moment * multiplier)

    def _coupled(self, row: Row) -> Iterator[tuple[str, Wrench]]:
        """Return what a unit multiplier of a row does along measured coordinates it is written in."""
        for use in self.uses:
            measured = set(use.joint.coordinates).difference(use.coordinates)
            for coordinate, share in row.shares.items():
                if coordinate in measured:
                    wrench = drive_wrench(self.names, self.kinematics, use.joint, coordinate, share)
                    yield use.joint.name, wrench

    def with_rows(self, rows: tuple[Row, ...], redundant: tuple[Row, ...] | None = None) -> Formed:
        """Return the same equations under other constraints."""
        return replace(
            self,
            rows=rows,
            redundant=self.redundant if redundant is None else redundant,
            solved=SingleFlight(),
            resistances=[],
            self_stress=SingleFlight(),
            _wrenches=SingleFlight(),
            _names=SingleFlight(),
            _free=SingleFlight(),
            _released=SingleFlight(),
        )

    def with_independent(self, kept: Iterable[int]) -> Formed:
        """Return the equations without rows that follow from those kept; they still bear loads."""
        places = set(kept)
        rows = tuple(row for k, row in enumerate(self.rows) if k in places)
        others = tuple(row for k, row in enumerate(self.rows) if k not in places)
        return self.with_rows(rows, (*self.redundant, *others))

    def own_rest(self, row: Row) -> Expr:
        """Return the rest of a row as it is in all speeds: what it demands of them."""
        return row.rest if self.elimination is None else self.elimination.given[row.name][1]

    def expressions(self, symbols: Sequence[Symbol]) -> tuple[Expr, ...]:
        """Return symbols as expressions of the graph."""
        return tuple(Expr(self.graph, self.graph.symbol(symbol)) for symbol in symbols)

    @property
    def readable_names(self) -> Names:
        """The names with multipliers, and all coordinates of cut joints, measured on first request."""
        return self._names.get(None, self._form_names)

    def _form_names(self) -> Names:
        multipliers = zip(self.multipliers, self.expressions(self.multipliers), strict=True)
        values = {symbol.label: value for symbol, value in multipliers} | dict(self.released)
        pivots = {} if self.elimination is None else self.elimination.pivots
        names = self.names.with_values(values | dict(pivots))
        for use in self.uses:
            names = names.with_values(measured_coordinates(names, self.kinematics, use))
        return names

    def frame(self, name: str) -> str:
        """Return the frame of kinematics that an address means.

        Raises
        ------
        FormulationError
            If there is none, with the nearest names.
        """
        link = self.topology.link(name)
        if isinstance(link, Rolling):
            return link.name
        body, _, point = name.partition(".")
        places = places_of(self.topology.model.bodies, self.topology.model.ground)
        found = places.find(address_of(body, point))
        if isinstance(found, Address):
            return found.frame
        raise FormulationError(Problem("equations.unknown_frame", f"frame {name}", found[0], "", found[1]))
