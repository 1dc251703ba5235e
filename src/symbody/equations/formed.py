"""What a formulation delivers: the equations of a model as roots in one graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from symbody.equations.dynamics.balance import Wrench
from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.loads import Loads, effort_name
from symbody.equations.dynamics.reactions import drive_wrench, joint_wrenches, row_wrenches
from symbody.equations.dynamics.virtual_work import Projection
from symbody.equations.kinematics.closings import Row
from symbody.equations.kinematics.measured import measured_coordinates
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import Use, Variables
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
    alignments : tuple of Expr
        Cosines that are 1, not -1, where the cut joints are closed as they should be.
    projection : Projection
        Mass matrix and forcing.
    notes : tuple of str
        What was dropped, and where the equations do not hold.
    armatures : mapping of coordinate to Rotor
        What turns with the rates of joints.
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
    projection: Projection
    kinetic_energy: Expr
    notes: tuple[str, ...]
    # Made on first request; a pure function of the fields above, so it cannot go stale.
    _wrenches: dict[str, Wrench] = field(default_factory=dict, repr=False)
    _names: list[Names] = field(default_factory=list, repr=False)
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
                if coordinate in self.armatures:
                    rotor = self.armatures[coordinate]
                    effort = effort - rotor.inertia * kinematics.rate(rotor.rate)
                yield joint.name, drive_wrench(names, kinematics, joint, coordinate, effort)

    def with_rows(self, rows: tuple[Row, ...]) -> Formed:
        """Return the same equations under other constraints."""
        return replace(self, rows=rows, solved=[], _wrenches={}, _names=[])

    def expressions(self, symbols: Sequence[Symbol]) -> tuple[Expr, ...]:
        """Return symbols as expressions of the graph."""
        return tuple(Expr(self.graph, self.graph.symbol(symbol)) for symbol in symbols)

    @property
    def readable_names(self) -> Names:
        """The names with all coordinates of cut joints, which are measured on first request."""
        if not self._names:
            names = self.names
            for use in self.uses:
                names = names.with_values(measured_coordinates(names, self.kinematics, use))
            self._names.append(names)
        return self._names[0]

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
