"""From a topology to its equations of motion: kinematics, constraints, loads, dynamics, in this order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

from symbody.equations.constraints.loop_closure import assembly_mode
from symbody.equations.constraints.mechanism_constraints import form_constraints
from symbody.equations.contacts.bristles import bristle_values
from symbody.equations.contacts.contact_frames import add_contact_frames
from symbody.equations.contacts.rigid_contacts import contact_friction
from symbody.equations.dynamics.inertia import Rotor, form_inertia
from symbody.equations.elimination.coupled_coordinates import NONE_COUPLED, solve_couplings
from symbody.equations.elimination.dependent_speeds import eliminate_speeds, elimination_notes, named_speeds
from symbody.equations.elimination.elimination import SpeedElimination
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.formulations.recursive import Recursive
from symbody.equations.formulations.virtual_work import VirtualWork
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.frame_placement import rotation_steps, translation_steps
from symbody.equations.kinematics.joint_roles import is_read, joint_roles, names_read
from symbody.equations.kinematics.measured_coordinates import measure_coordinates
from symbody.equations.kinematics.mechanism_names import (
    mechanism_names,
    rates_by_name,
    rates_of_values,
    second_rates,
)
from symbody.equations.kinematics.motion import Kinematics, form_kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.placements import differentiate_constraints, differentiate_placements
from symbody.equations.kinematics.variables import JointRole, Variables, form_variables
from symbody.equations.loads.friction import form_friction
from symbody.equations.loads.loads import form_loads
from symbody.equations.massless.force_balances import (
    ForceBalances,
    find_balances,
    idle_dynamics,
    position_notes,
)
from symbody.equations.outputs.output_roots import raw_output
from symbody.equations.outputs.signal_outputs import explicit_outputs
from symbody.equations.signals import outputs_of_loads, substitute_values
from symbody.equations.solving.undetermined import find_identically_undetermined, share_notes
from symbody.equations.system import MultibodySystem
from symbody.expr.deadline import begin
from symbody.expr.graph import Graph
from symbody.expr.printing.text import to_text
from symbody.graph.topology import Topology
from symbody.model.constraints import Distance, Stop
from symbody.model.contacts.contact import Contact
from symbody.model.model import Model

# Outputs that redundant constraints leave undetermined stand in the notes of mechanisms of so many joints.
_MOST_LISTED: Final = 40
# Shapes that nothing can leave on the other side within a step.


def derive(
    topology: Topology,
    graph: Graph,
    formulation: Formulation | None = None,
    *,
    dependent: Sequence[str] = (),
    substitutes: bool = False,
) -> EquationsOfMotion:
    """Return the equations of a mechanism in a graph.

    Parameters
    ----------
    formulation : Formulation, optional
        By default the one that `default_formulation` returns.
    dependent : sequence of str
        Speeds to be eliminated by the constraints on velocities.
    substitutes : bool
        Whether coordinates that couplings give are substituted.

    Raises
    ------
    FormulationError
        If the law of a cut joint needs the joint in a tree, a loop can never close, or the others do not
        determine the dependent speeds.
    """
    is_chosen = formulation is not None
    formulation, notes = _possible_formulation(topology, formulation, eliminates=bool(dependent))
    roles = joint_roles(topology)
    names = mechanism_names(graph, topology, roles)
    coupled = solve_couplings(topology.model, names, roles) if substitutes else NONE_COUPLED
    roles = coupled.assign_roles(roles)
    names, variables = _variables(topology, names.with_values(coupled.values), roles)
    begin("kinematics")
    names, kinematics = _kinematics(topology, names, roles, variables, formulation)
    names = names.with_values(bristle_values(names, kinematics, topology.model))
    begin("constraints")
    constraints = form_constraints(topology, names, kinematics, roles, coupled)
    rows = constraints.rows
    if formulation.differentiates_placements:
        rows = differentiate_constraints(kinematics, rows)
    notes = constraints.notes + coupled.notes + notes

    def form_dynamics(names: Names) -> EquationsOfMotion:
        begin("loads", notes)
        system = _system(topology, names, roles, variables, kinematics, rows, formulation)
        system = replace(system, redundant=tuple(constraints.redundant), coupled=constraints.coupled)
        begin("mass matrix and forcing")
        return _equations(system, formulation, notes)

    formed = _with_outputs_for_loads(topology.model, names, form_dynamics)
    balances = find_balances(formed)
    if not isinstance(balances, ForceBalances):
        return _finish(formed, notes, dependent)
    obstacle = formulation.balance_obstacle(on_positions=bool(balances.positions))
    if obstacle:
        formed = derive(topology, graph, VirtualWork(), dependent=dependent, substitutes=substitutes)
        place = f"virtual work is used instead of {obstacle}"
        return replace(formed, notes=(*formed.notes, place) if is_chosen else formed.notes)
    more = position_notes(balances)
    formed = replace(_with_positions(formed, balances), notes=formed.notes + more)
    return _finish(formed, notes + more, dependent, balances)


def _finish(
    formed: EquationsOfMotion,
    notes: tuple[str, ...],
    dependent: Sequence[str],
    balances: ForceBalances | None = None,
) -> EquationsOfMotion:
    """Return equations with contact frames and all notes, without speeds that are eliminated."""
    complete = _with_contacts(formed)
    shares = _share_notes(complete)
    if dependent or (balances is not None and balances.velocities):
        return _eliminate(formed, dependent, notes + shares, balances)
    return replace(complete, notes=complete.notes + shares)


def _with_positions(formed: EquationsOfMotion, balances: ForceBalances) -> EquationsOfMotion:
    """Return the equations under the balances of forces that are constraints on positions."""
    if not balances.positions:
        return formed
    rows = (*formed.holonomic, *balances.positions, *(row for row in formed.rows if not row.is_holonomic))
    return formed.with_rows(rows)


def _with_outputs_for_loads(
    model: Model, names: Names, form_dynamics: Callable[[Names], EquationsOfMotion]
) -> EquationsOfMotion:
    """Return equations in which signals stand for their values.

    Where loads read outputs, these are taken from equations formed first, with symbols in their places.
    """
    formed = form_dynamics(substitute_values(names, model, {}))
    ways = outputs_of_loads(model)
    if not ways:
        return formed
    return form_dynamics(substitute_values(names, model, explicit_outputs(formed, ways, raw_output)))


def default_formulation(topology: Topology, *, eliminates: bool) -> Formulation:
    """Return the formulation whose accelerations take the fewest operations.

    That is the recursive one wherever it can be used: over robots, chains and the examples it takes from
    0.1 to 0.9 of the operations of virtual work, and linear time to form.
    """
    recursive = Recursive()
    return VirtualWork() if recursive.obstacle(topology, eliminates=eliminates) else recursive


def _possible_formulation(
    topology: Topology, formulation: Formulation | None, *, eliminates: bool
) -> tuple[Formulation, tuple[str, ...]]:
    """Return the formulation, virtual work where it cannot be used, and a note of that."""
    if formulation is None:
        return default_formulation(topology, eliminates=eliminates), ()
    obstacle = formulation.obstacle(topology, eliminates=eliminates)
    return (
        (VirtualWork(), (f"virtual work is used instead of {obstacle}",)) if obstacle else (formulation, ())
    )


def _variables(topology: Topology, names: Names, roles: Sequence[JointRole]) -> tuple[Names, Variables]:
    """Return the names of a mechanism with the rates, and its coordinates and speeds."""
    added = [name for condition in topology.model.constraints for name in condition.coordinates]
    variables = form_variables(names, roles, added)
    return names.with_values(rates_by_name(names.graph, variables)), variables


def _kinematics(
    topology: Topology,
    names: Names,
    roles: Sequence[JointRole],
    variables: Variables,
    formulation: Formulation,
) -> tuple[Names, Kinematics]:
    """Return the kinematics, and the names with second rates and the measured coordinates that are read."""
    graph = names.graph
    kinematics = form_kinematics(
        graph,
        rotation_steps(topology, names, roles),
        translation_steps(topology, names),
        variables.rates,
        [graph.symbol(u) for u in variables.u],
        lazy=formulation.has_lazy_velocities,
    )
    if formulation.differentiates_placements:
        kinematics = differentiate_placements(kinematics)
    names = names.with_values(second_rates(kinematics, variables))
    for role in roles:
        names = names.with_values(rates_of_values(names, kinematics, role.substituted))
    read = names_read(topology.model)
    for role in roles:
        if is_read(role, read):
            names = names.with_values(measure_coordinates(names, kinematics, role))
    return names, kinematics


def _system(
    topology: Topology,
    names: Names,
    roles: Sequence[JointRole],
    variables: Variables,
    kinematics: Kinematics,
    rows: Sequence[ConstraintEquation],
    formulation: Formulation,
) -> MultibodySystem:
    """Return the system with its bodies, loads, rotors and friction."""
    model = topology.model
    bodies = tuple(form_inertia(names, body) for body in model.bodies)
    contacts = [each for each in model.elements if isinstance(each, Contact)]
    rubbing = [law for each in contacts for law in contact_friction(names, kinematics, each)]
    friction = (*form_friction(names, roles), *rubbing)
    weights = formulation.has_weights_in_loads
    return MultibodySystem(
        names=names,
        topology=topology,
        joint_roles=tuple(roles),
        variables=variables,
        kinematics=kinematics,
        bodies=bodies,
        loads=form_loads(model, names, kinematics, bodies, roles, friction, weights=weights),
        rotors={
            coordinate: Rotor(
                names.value(f"{coordinate}_dot"),
                names.expression(rotor, f"joint {role.joint.name}"),
                coordinate,
            )
            for role in roles
            for coordinate, rotor in role.joint.armature.items()
        },
        rows=tuple(rows),
        friction=friction,
    )


def _equations(
    system: MultibodySystem,
    formulation: Formulation,
    notes: tuple[str, ...],
    elimination: SpeedElimination | None = None,
) -> EquationsOfMotion:
    """Return the equations of motion of a system, without contact frames."""
    names, kinematics = system.names, system.kinematics
    return EquationsOfMotion.of_system(
        system,
        formulation,
        formulation.derive(system) if elimination is None else elimination.reduce_dynamics(system),
        alignments=tuple(
            cosine for role in system.joint_roles for cosine in assembly_mode(names, kinematics, role)
        ),
        notes=notes + system.loads.notes + _notes(system),
        elimination=elimination,
    )


def _eliminate(
    formed: EquationsOfMotion,
    dependent: Sequence[str],
    notes: tuple[str, ...],
    balances: ForceBalances | None = None,
) -> EquationsOfMotion:
    """Return equations in independent speeds; loads are formed again in these."""
    begin("elimination of dependent speeds")
    chosen = named_speeds(formed.readable_names, formed.u, formed.rows, dependent) if dependent else ()
    tied = [row for row in formed.rows if dependent and not row.is_holonomic]
    dynamics = formed.dynamics
    if balances is not None:
        chosen, tied = (*chosen, *balances.dependent), [*tied, *balances.velocities]
        dynamics = idle_dynamics(dynamics, balances.idle)
    elimination = eliminate_speeds(formed.graph, formed.u, formed.rows, dynamics, chosen, tied)
    holding = {
        law.holding_effort: (formed.kinematics.speed_partials(law.rate), law.rate * 0)
        for law in formed.friction
    }
    elimination = replace(elimination, given={**elimination.given, **holding})
    variables = elimination.reduce_variables(formed.variables)
    names = elimination.substitute_names(formed.names)
    kinematics = elimination.reduce_kinematics(formed.kinematics, variables.rates)
    rows = elimination.reduce_rows(row for row in formed.rows if row.name not in {x.name for x in tied})
    notes = notes + elimination_notes(elimination)
    begin("loads", notes)
    system = _system(
        formed.topology, names, formed.joint_roles, variables, kinematics, rows, formed.formulation
    )
    begin("mass matrix and forcing")
    system = replace(system, redundant=formed.redundant, coupled=formed.coupled)
    reduced = _equations(system, formed.formulation, notes, elimination)
    return _with_contacts(reduced)


def _with_contacts(formed: EquationsOfMotion) -> EquationsOfMotion:
    """Return the equations with the frames of contacts in their kinematics."""
    elements = formed.topology.model.elements
    return replace(formed, kinematics=add_contact_frames(formed.names, formed.kinematics, elements))


def _share_notes(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return notes on reactions that redundant constraints leave undetermined."""
    if not formed.redundant:
        return ()
    listed = find_identically_undetermined(formed) if len(formed.joint_roles) <= _MOST_LISTED else ()
    return share_notes(formed, listed)


def _notes(system: MultibodySystem) -> tuple[str, ...]:
    """Return where the equations differ from what one may expect, or do not hold."""
    return (
        *_cut_coupling_notes(system.joint_roles),
        *_singularity_notes(system.graph, system.variables),
        *_gap_notes(system.topology.model),
    )


def _cut_coupling_notes(roles: Iterable[JointRole]) -> tuple[str, ...]:
    """Return notes on cut joints whose displacement depends on their angle."""
    return tuple(
        f"joint {role.joint.name}: its displacement depends on {', '.join(role.joint.coupled_coordinates)}, "
        f"so the joint has one more closing equation that relates its coordinates, although it is cut"
        for role in roles
        if role.joint.coupled_coordinates and not role.in_rotation and role.unknown_coordinates
    )


def _gap_notes(model: Model) -> Iterator[str]:
    """Yield notes on what holds in some modes alone, and on friction that is not in all of them."""
    for part in model.constraints:
        if isinstance(part, Contact) and part.friction is not None and part.friction.is_smooth:
            yield f"contact {part.name}: friction with v0 or deflection takes no part in impacts"
        holds = ""
        if isinstance(part, Distance) and part.rope:
            holds = "the taut rope; simulate switches when the rope goes slack"
        elif isinstance(part, Stop | Contact):
            holds = "the closed gap; simulate switches when the gap opens"
        if holds:
            yield f"{part.kind} {part.name}: the equations are for {holds}"


def _singularity_notes(graph: Graph, variables: Variables) -> tuple[str, ...]:
    return tuple(
        f"joint {joint}: the angular velocity does not determine the angle rates where "
        f"{to_text(graph, determinant.index).removeprefix('-')} = 0"
        for joint, determinant in variables.singularities.items()
    )
