"""From a mechanism by hand to the same equations of motion as those of mechanisms that are drawn.

A hand-placed mechanism has bodies and frames, but no joints: its topology is empty, its coordinates are its
own, and its frames are entered one step after another. Nothing after this file depends on the difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from symbody.equations.by_hand.energies_by_hand import is_on_velocities, kinetic_energy
from symbody.equations.by_hand.frames import Chain, convert_vector, frame_names, frame_steps, position_of
from symbody.equations.by_hand.mechanism import MechanismByHand, PlacedBody, PlacedForce, PlacedLoad
from symbody.equations.by_hand.restated import Restatement
from symbody.equations.constraints.couplings import velocity_equation
from symbody.equations.constraints.frame_constraints import time_partial
from symbody.equations.constraints.integrability import is_integrable
from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.load import Load, Moment, PointForce
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.formulations.formulation import Dynamics, Formulation
from symbody.equations.formulations.lagrange import project_energies
from symbody.equations.kinematics.constraint_equation import ConstraintEquation, scalar_equation
from symbody.equations.kinematics.motion import Kinematics, form_kinematics
from symbody.equations.kinematics.naming import model_names
from symbody.equations.kinematics.placements import differentiate_placements
from symbody.equations.kinematics.variables import Variables
from symbody.equations.loads.loads import Loads
from symbody.equations.system import MultibodySystem
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr, number
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.printing.text import to_text
from symbody.expr.trigonometry.whole_turns import turning_symbols
from symbody.graph.spanning_tree import SpanningTree
from symbody.graph.topology import Topology
from symbody.model.model import Model
from symbody.spatial.dyadic import symmetric_split
from symbody.spatial.placed import homogeneous
from symbody.spatial.vector import cross, dot


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
    rows, notes = _rows_by_hand(placed, kinematics)
    system = MultibodySystem(
        names=model_names(graph, model.parameters, model.inputs, coordinates),
        topology=Topology(model, (), SpanningTree((), ()), SpanningTree((), ()), ()),
        joint_roles=(),
        variables=variables,
        kinematics=kinematics,
        bodies=tuple(
            Inertia(body.name, body.mass, symmetric_split(body.name, body.tensor)) for body in placed.bodies
        ),
        loads=_loads_by_hand(placed, kinematics, frames),
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


def _loads_by_hand(mechanism: MechanismByHand, kinematics: Kinematics, names: Mapping[Chain, str]) -> Loads:
    """Return the loads of a mechanism; weights have the only potential energy."""
    tree, graph = kinematics.tree, kinematics.graph
    weights: list[Load] = []
    potential = power = number(graph, 0)
    if mechanism.gravity is not None:
        gravity = convert_vector(names, mechanism.gravity)
        for body in mechanism.bodies:
            weight = gravity * body.mass
            weights.append(PointForce(body.name, weight))
            potential = potential - dot(tree, kinematics.position("ground", body.name), weight)
    others: list[Load] = []
    for load in mechanism.loads:
        for on, sign in ((load.on, 1), (load.reaction_on, -1)):
            if on is not None:
                found, spent = _load_on_body(kinematics, names, load, on, sign)
                others.append(found)
                power = power + spent
    return Loads((*weights, *others), potential, power, {}, tuple(others))


def _load_on_body(
    kinematics: Kinematics, names: Mapping[Chain, str], load: PlacedLoad, body: PlacedBody, sign: int
) -> tuple[Load, Expr]:
    """Return what a load does to one body, and its power there."""
    tree = kinematics.tree
    acting = convert_vector(names, load.vector) * sign
    w = kinematics.angular_velocities[body.name].value
    if not isinstance(load, PlacedForce):
        return Moment(body.name, acting), dot(tree, acting, w)
    arm = position_of(kinematics, names, body, load.point)
    v = kinematics.velocities[body.name].value + cross(tree, w, arm)
    return PointForce(body.name, acting, arm), dot(tree, acting, v)


def _rows_by_hand(
    mechanism: MechanismByHand, kinematics: Kinematics
) -> tuple[tuple[ConstraintEquation, ...], tuple[str, ...]]:
    """Return the rows, those on positions first, and what is said of them.

    Raises
    ------
    FormulationError
        If one is not of first degree in the rates, or holds nothing that moves.
    """
    rows, notes, problems = [], [], []
    for row in sorted(_rows(mechanism, kinematics), key=lambda row: not row.is_holonomic):
        graph = kinematics.graph
        idle = all(find_zeros(graph, [slope.index for slope in row.jacobian.values()]))
        left = row.value if row.is_holonomic else row.drift
        if not idle:
            rows.append(row)
            if not row.is_holonomic and is_integrable(kinematics, row):
                notes.append(
                    f"constraint {row.element}: it constrains rates, but is the time derivative of a "
                    f"position constraint; write it in coordinates, so that positions do not drift"
                )
        elif find_zeros(graph, [left.index])[0]:
            notes.append(f"constraint {row.element}: it holds identically and is dropped")
        else:
            problems.append(_never(row, to_text(graph, left.index)))
    if problems:
        raise FormulationError(*problems)
    return tuple(rows), tuple(notes)


def _rows(mechanism: MechanismByHand, kinematics: Kinematics) -> Iterator[ConstraintEquation]:
    for constraint in mechanism.constraints:
        for value, name in zip(constraint.values, constraint.multipliers, strict=True):
            if is_on_velocities(kinematics.graph, value.index):
                row = velocity_equation(kinematics, name, value, f"constraint {name}")
                yield replace(row, name=name, driven=-row.drift)
            else:
                row = scalar_equation(kinematics, name, name, value)
                yield replace(row, driven=-time_partial(value))


def _never(row: ConstraintEquation, left: str) -> Problem:
    return Problem(
        "by_hand.never_closed", f"constraint {row.element}",
        f"its left-hand side is always {left}",
        "it contains no coordinate", "leave it out, or write it in the coordinates that it constrains",
    )  # fmt: skip
