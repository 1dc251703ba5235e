"""What a formulation delivers: the equations of a model as roots in one graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from symbody.equations.balance import Wrench
from symbody.equations.closings import Row
from symbody.equations.inertia import Inertia
from symbody.equations.kinematics import Kinematics
from symbody.equations.loads import Loads, effort_name
from symbody.equations.naming import Names
from symbody.equations.reactions import drive_wrench, joint_wrenches, row_wrenches
from symbody.equations.variables import Use, Variables
from symbody.equations.virtual_work import Projection
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Kind, Symbol
from symbody.graph.topology import Topology
from symbody.model.element import Address, address_of
from symbody.model.lookup import places_of


@dataclass(frozen=True, slots=True)
class Formed:
    """``M u' = F + J^T lambda``, ``J u' = gamma``, ``q' = N u + nu`` and the energies, in one graph.

    Attributes
    ----------
    uses : tuple of Use
        Every joint, with the parts of its law that are in use.
    rows : tuple of Row
        The constraints, in the order of Phi.
    projection : Projection
        Mass matrix and forcing.
    notes : tuple of str
        What was dropped, and where the equations do not hold.
    armatures : mapping of node to Expr
        Inertia of rotors by the rate they turn with.
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
    armatures: Mapping[int, Expr]
    rows: tuple[Row, ...]
    projection: Projection
    kinetic_energy: Expr
    notes: tuple[str, ...]
    # Made on first request; a pure function of the fields above, so it cannot go stale.
    _wrenches: dict[str, Wrench] = field(default_factory=dict, repr=False)
    solved: list[tuple[list[Expr], list[Expr]]] = field(default_factory=list, repr=False)

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
    def multipliers(self) -> tuple[Symbol, ...]:
        """Multipliers, one a row."""
        return tuple(Symbol(row.name, Kind.MULTIPLIER) for row in self.rows)

    @property
    def jacobian(self) -> list[list[Expr]]:
        """J, one row a constraint."""
        zero = Expr(self.graph, 0)
        return [[row.slopes.get(u, zero) for u in self.kinematics.speeds] for row in self.rows]

    @property
    def wrenches(self) -> Mapping[str, Wrench]:
        """The total wrench of every joint in terms of u' and the multipliers."""
        if not self._wrenches:
            cut = [*row_wrenches(self.graph, self.rows), *self._measured_drives()]
            found = joint_wrenches(self.topology, self.kinematics, self.bodies, self.loads.loads, cut)
            self._wrenches.update(found)
        return self._wrenches

    def _measured_drives(self) -> Iterator[tuple[str, Wrench]]:
        """Return the wrenches of drives and rotors along coordinates that are not variables."""
        names, kinematics = self.names, self.kinematics
        for use in self.uses:
            joint = use.joint
            for coordinate in {**joint.drives, **joint.armature}:
                if coordinate in use.coordinates:
                    continue
                effort = self.loads.efforts.get(effort_name(joint, coordinate), Expr(self.graph, 0))
                rate = names.value(f"{coordinate}_dot")
                if rate.index in self.armatures:
                    effort = effort - self.armatures[rate.index] * kinematics.rate(rate)
                yield joint.name, drive_wrench(names, kinematics, joint, coordinate, effort)

    def with_rows(self, rows: tuple[Row, ...]) -> Formed:
        """Return the same equations under other constraints."""
        return replace(self, rows=rows, solved=[], _wrenches={})

    def expressions(self, symbols: Sequence[Symbol]) -> tuple[Expr, ...]:
        """Return symbols as expressions of the graph."""
        return tuple(Expr(self.graph, self.graph.symbol(symbol)) for symbol in symbols)

    def frame(self, name: str) -> str:
        """Return the frame of kinematics that an address means.

        Raises
        ------
        FormulationError
            If there is none, with the nearest names.
        """
        body, _, point = name.partition(".")
        places = places_of(self.topology.model.bodies, self.topology.model.ground)
        found = places.find(address_of(body, point))
        if isinstance(found, Address):
            return found.frame
        raise FormulationError(Problem("equations.unknown_frame", f"frame {name}", found[0], "", found[1]))
