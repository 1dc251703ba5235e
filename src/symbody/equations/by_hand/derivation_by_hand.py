"""From a mechanism by hand to the same equations of motion as those of mechanisms that are drawn.

A hand-placed mechanism has bodies and frames, but no joints: its topology is empty, its coordinates are its
own, and its frames are entered one step after another. Nothing after this file depends on the difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symbody.equations.by_hand.energies_by_hand import kinetic_energy
from symbody.equations.by_hand.frames import Chain, frame_names, frame_steps
from symbody.equations.by_hand.loads_by_hand import loads_by_hand
from symbody.equations.by_hand.mechanism import MechanismByHand
from symbody.equations.by_hand.restated import Restatement
from symbody.equations.by_hand.rows_by_hand import rows_by_hand
from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.formulations.formulation import Dynamics, Formulation
from symbody.equations.formulations.lagrange import project_energies
from symbody.equations.kinematics.motion import Kinematics, form_kinematics
from symbody.equations.kinematics.naming import model_names
from symbody.equations.kinematics.placements import differentiate_placements
from symbody.equations.kinematics.variables import Variables
from symbody.equations.system import MultibodySystem
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.trigonometry.whole_turns import turning_symbols
from symbody.graph.spanning_tree import SpanningTree
from symbody.graph.topology import Topology
from symbody.model.model import Model
from symbody.spatial.dyadic import symmetric_split
from symbody.spatial.placed import homogeneous


def derive_by_hand(
    model: Model,
    mechanism: MechanismByHand,
    coordinates: Sequence[str],
    formulation: Formulation,
    *,
    natural: bool = False,
) -> EquationsOfMotion:
    """Return the equations of a mechanism by hand.

    Parameters
    ----------
    model : Model
        Its bodies, parameters and inputs; see `form`.
    mechanism : MechanismByHand
        In coordinates, inputs and parameters, each of its kind.
    coordinates : sequence of str
        In the order of q.
    natural : bool
        Whether the kinetic energy is that of natural coordinates; see `energies.kinetic_energy`.

    Raises
    ------
    FormulationError
        If a constraint is not of first degree in the rates, or can never hold.
    """
    graph = Graph()
    placed = Restatement(graph, {}).mechanism(mechanism)
    variables = _variables(graph, coordinates)
    kinematics, frames = _kinematics(graph, placed, variables, formulation)
    rows, notes = rows_by_hand(placed, kinematics)
    system = MultibodySystem(
        names=model_names(graph, model.parameters, model.inputs, coordinates),
        topology=Topology(model, (), SpanningTree((), ()), SpanningTree((), ()), ()),
        joint_roles=(),
        variables=variables,
        kinematics=kinematics,
        bodies=tuple(
            Inertia(body.name, body.mass, symmetric_split(body.name, body.tensor)) for body in placed.bodies
        ),
        loads=loads_by_hand(placed, kinematics, frames),
        rotors={},
        rows=rows,
    )
    return EquationsOfMotion.of_system(
        system,
        formulation,
        _natural_dynamics(system, placed) if natural else formulation.derive(system),
        notes=notes,
        angles=_angles(mechanism, coordinates),
    )


def _kinematics(
    graph: Graph, mechanism: MechanismByHand, variables: Variables, formulation: Formulation
) -> tuple[Kinematics, dict[Chain, str]]:
    """Return the kinematics of all frames, and the names of the frames."""
    names = frame_names(mechanism)
    speeds = tuple(variables.rates.values())
    rotations, translations = frame_steps(graph, names, mechanism.bodies)
    kinematics = form_kinematics(graph, rotations, translations, variables.rates, speeds)
    return (
        differentiate_placements(kinematics) if formulation.differentiates_placements else kinematics
    ), names


def _natural_dynamics(system: MultibodySystem, mechanism: MechanismByHand) -> Dynamics:
    """Return Lagrange's equations with the kinetic energy that has a constant mass matrix."""
    kinetic = kinetic_energy(system.graph, mechanism.bodies, natural=True)
    return replace(project_energies(system, kinetic), kinetic_energy=kinetic)


def _angles(mechanism: MechanismByHand, coordinates: Sequence[str]) -> frozenset[str]:
    """Return the coordinates by whose whole turns no body moves and no constraint changes."""
    graph = Graph()
    placed = Restatement(graph, {}).mechanism(mechanism)
    points = [body.centre for body in placed.bodies]
    values = [entry for point in points for row in homogeneous(point.frame, graph) for entry in row]
    values += [x for point in points for x in point.coordinates]
    values += [x for constraint in placed.constraints for x in constraint.values]
    symbols = {graph.symbol(Symbol(name, SymbolKind.COORDINATE)): name for name in coordinates}
    whole_turns = turning_symbols(graph, [value.index for value in values], list(symbols))
    return frozenset(symbols[node] for node in whole_turns)


def _variables(graph: Graph, coordinates: Sequence[str]) -> Variables:
    q = tuple(Symbol(name, SymbolKind.COORDINATE) for name in coordinates)
    rates = {graph.symbol(symbol): graph.symbol(symbol.derivative) for symbol in q}
    return Variables(q, tuple(symbol.derivative for symbol in q), rates, (), {})
