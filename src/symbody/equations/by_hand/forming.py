"""From a mechanism by hand to what every formulation delivers: the seam with mechanisms that are drawn.

A hand-placed mechanism has bodies and frames, but no joints: its topology is empty, its coordinates are its
own, and its frames are entered one step after another. From there on nothing knows the difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symbody.equations.by_hand.energies import kinetic_energy
from symbody.equations.by_hand.frames import frame_names, frame_steps
from symbody.equations.by_hand.loads import loads_by_hand
from symbody.equations.by_hand.mechanism import HandPlaced
from symbody.equations.by_hand.restated import Restated
from symbody.equations.by_hand.rows import rows_by_hand
from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.projection import Projection
from symbody.equations.formed import Formed
from symbody.equations.formulations.direct import project_directly
from symbody.equations.formulations.formulation import Formulation, differentiates
from symbody.equations.formulations.lagrange import Energies, Lagrange, form_energies, project_energies
from symbody.equations.formulations.virtual_work import kinetic_energy as energy_of
from symbody.equations.kinematics.motion import Kinematics, form_kinematics
from symbody.equations.kinematics.naming import model_names
from symbody.equations.kinematics.placements import differentiated
from symbody.equations.kinematics.variables import Variables
from symbody.equations.loads.loads import Loads
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Kind, Symbol
from symbody.expr.trigonometry.whole_turns import turning_symbols
from symbody.graph.spanning_tree import SpanningTree
from symbody.graph.topology import Topology
from symbody.model.model import Model
from symbody.vectors.dyadic import symmetric_split
from symbody.vectors.placed import homogeneous


@dataclass(frozen=True, slots=True, eq=False)
class ByHand:
    """What equations of a mechanism by hand are formed from.

    Attributes
    ----------
    mechanism : HandPlaced
        In coordinates, inputs and parameters, each of its kind.
    coordinates : tuple of str
        In the order of q.
    natural : bool
        Whether the kinetic energy is that of natural coordinates; see `energies.kinetic_energy`.
    """

    model: Model
    mechanism: HandPlaced
    coordinates: tuple[str, ...]
    formulation: Formulation
    natural: bool = False

    def formed(self, graph: Graph) -> Formed:
        """Return the equations in a graph.

        Raises
        ------
        FormulationError
            If a constraint is not of first degree in the rates, or can never hold.
        """
        mechanism = Restated(graph, {}).mechanism(self.mechanism)
        variables = _variables(graph, self.coordinates)
        names = frame_names(mechanism)
        rotations, translations = frame_steps(graph, names, mechanism.bodies)
        speeds = tuple(variables.rates.values())
        kinematics = form_kinematics(graph, rotations, translations, variables.rates, speeds)
        if differentiates(self.formulation):
            kinematics = differentiated(kinematics)
        bodies = tuple(
            Inertia(body.name, body.mass, symmetric_split(body.name, body.tensor))
            for body in mechanism.bodies
        )
        loads = loads_by_hand(mechanism, kinematics, names)
        rows, notes = rows_by_hand(mechanism, kinematics)
        projection, kinetic = self._projected(mechanism, kinematics, bodies, loads)
        return Formed(
            names=model_names(graph, self.model.parameters, self.model.inputs, self.coordinates),
            topology=Topology(self.model, (), SpanningTree((), ()), SpanningTree((), ()), ()),
            uses=(),
            variables=variables,
            inputs=tuple(Symbol(name, Kind.INPUT) for name in self.model.inputs),
            parameters=tuple(Symbol(name, Kind.PARAMETER) for name in self.model.parameters),
            kinematics=kinematics,
            bodies=bodies,
            loads=loads,
            armatures={},
            rows=rows,
            alignments=(),
            projection=projection,
            kinetic_energy=kinetic,
            notes=notes,
            formulation=self.formulation,
            angles=_angles(self.mechanism, self.coordinates),
        )

    def _projected(
        self, mechanism: HandPlaced, kinematics: Kinematics, bodies: Sequence[Inertia], loads: Loads
    ) -> tuple[Projection, Expr]:
        """Return mass matrix and forcing, and the kinetic energy."""
        if self.natural:
            graph, q = kinematics.graph, tuple(kinematics.rates)
            kinetic = kinetic_energy(graph, mechanism.bodies, natural=True)
            energies = Energies(
                q, kinematics.speeds, kinetic, loads.potential_energy, loads.without_potential
            )
            return project_energies(kinematics, energies), kinetic
        kinetic = energy_of(kinematics, bodies, {})
        if isinstance(self.formulation, Lagrange):
            energies = form_energies(kinematics, bodies, loads.potential_energy, loads.without_potential, ())
            return project_energies(kinematics, energies), kinetic
        return project_directly(kinematics, bodies, loads.loads, {}), kinetic


def _angles(mechanism: HandPlaced, coordinates: Sequence[str]) -> frozenset[str]:
    """Return the coordinates by whose whole turns no body moves and no constraint changes."""
    graph = Graph()
    placed = Restated(graph, {}).mechanism(mechanism)
    points = [body.centre for body in placed.bodies]
    values = [entry for point in points for row in homogeneous(point.frame, graph) for entry in row]
    values += [x for point in points for x in point.coordinates]
    values += [x for constraint in placed.constraints for x in constraint.values]
    symbols = {graph.symbol(Symbol(name, Kind.COORDINATE)): name for name in coordinates}
    found = turning_symbols(graph, [value.index for value in values], list(symbols))
    return frozenset(symbols[node] for node in found)


def _variables(graph: Graph, coordinates: Sequence[str]) -> Variables:
    q = tuple(Symbol(name, Kind.COORDINATE) for name in coordinates)
    rates = {graph.symbol(symbol): graph.symbol(symbol.derivative) for symbol in q}
    return Variables(q, tuple(symbol.derivative for symbol in q), rates, (), {})
