"""From a topology to everything a formulation delivers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from symbody.equations.constraints.closings import alignments
from symbody.equations.constraints.rolling import add_contact_frames
from symbody.equations.constraints.rows import form_rows
from symbody.equations.dynamics.inertia import Rotor, form_inertia
from symbody.equations.dynamics.projection import Projection
from symbody.equations.elimination.dependent_speeds import eliminated, elimination_notes
from symbody.equations.elimination.elimination import Elimination
from symbody.equations.formed import Formed
from symbody.equations.formulations.formulation import (
    Formulation,
    differentiates,
    legal_formulation,
    projected,
)
from symbody.equations.formulations.recursive import Recursive
from symbody.equations.formulations.virtual_work import VIRTUAL_WORK, kinetic_energy
from symbody.equations.kinematics.measured import measured_coordinates
from symbody.equations.kinematics.mechanism_names import mechanism_names, rates_by_name, second_rates
from symbody.equations.kinematics.motion import Kinematics, form_kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.placements import differentiated, differentiated_rows
from symbody.equations.kinematics.placing import shiftings, turnings
from symbody.equations.kinematics.row import Row
from symbody.equations.kinematics.uses import is_read, joint_uses, names_read
from symbody.equations.kinematics.variables import Use, Variables, form_variables
from symbody.equations.loads.friction import form_friction
from symbody.equations.loads.loads import form_loads
from symbody.equations.recursive.form_recursion import form_recursion
from symbody.equations.recursive.recursion import Recursion
from symbody.equations.solving.undetermined import identically_undetermined, share_notes
from symbody.expr.deadline import begin
from symbody.expr.graph import Graph, Kind, Symbol
from symbody.expr.printing.text import to_text
from symbody.graph.topology import Topology
from symbody.model.constraints import Distance
from symbody.model.model import Model

# Outputs that redundant constraints leave undetermined stand in the notes of mechanisms of so many joints.
_MOST_LISTED: Final = 40


def form(
    topology: Topology,
    graph: Graph,
    formulation: Formulation = VIRTUAL_WORK,
    *,
    dependent: Sequence[str] = (),
) -> Formed:
    """Return the equations of a mechanism in a graph.

    Parameters
    ----------
    dependent : sequence of str
        Speeds to be eliminated by the constraints on velocities.

    Raises
    ------
    FormulationError
        If a cut joint cannot do what is asked of it, a loop can never close, or the dependent speeds do not
        follow from the others.
    """
    formulation, fallback = legal_formulation(topology, formulation, dependent=bool(dependent))
    uses = joint_uses(topology)
    names = mechanism_names(graph, topology, uses)
    own = [name for condition in topology.model.constraints for name in condition.coordinates]
    variables = form_variables(names, uses, own)
    names = names.with_values(rates_by_name(graph, variables))
    speeds = [graph.symbol(u) for u in variables.u]
    begin("kinematics")
    kinematics = form_kinematics(
        graph,
        turnings(topology, names, uses),
        shiftings(topology, names),
        variables.rates,
        speeds,
        lazy=isinstance(formulation, Recursive),
    )
    if differentiates(formulation):
        kinematics = differentiated(kinematics)
    names = names.with_values(second_rates(kinematics, variables))
    read = names_read(topology.model)
    for use in uses:
        if is_read(use, read):
            names = names.with_values(measured_coordinates(names, kinematics, use))
    begin("constraints")
    found = form_rows(topology, names, kinematics, uses)
    rows, notes = found.rows, found.notes + fallback
    if differentiates(formulation):
        rows = differentiated_rows(kinematics, rows)
    formed = _formed(formulation, topology, names, uses, variables, kinematics, rows, notes)
    formed = replace(formed, redundant=tuple(found.redundant))
    if found.redundant:
        told = identically_undetermined(formed) if len(uses) <= _MOST_LISTED else ()
        shares = share_notes(formed, told)
        notes, formed = notes + shares, replace(formed, notes=formed.notes + shares)
    if dependent:
        formed = _without_dependent(formed, dependent, notes)
    contacts = topology.contacts.values()
    return replace(formed, kinematics=add_contact_frames(formed.names, formed.kinematics, contacts))


def _without_dependent(formed: Formed, dependent: Sequence[str], notes: tuple[str, ...]) -> Formed:
    """Return equations in independent speeds; everything but the projection is formed anew in these."""
    assert isinstance(formed.projection, Projection)  # with dependent speeds nothing is done by recursion
    begin("elimination of dependent speeds")
    found = eliminated(formed.readable_names, formed.u, formed.rows, formed.projection, dependent)
    holding = {law.holding: (formed.kinematics.slopes(law.rate), law.rate * 0) for law in formed.friction}
    found = replace(found, given={**found.given, **holding})
    variables = found.variables(formed.variables)
    reduced = _formed(
        formed.formulation,
        formed.topology,
        found.names(formed.names),
        formed.uses,
        variables,
        found.kinematics(formed.kinematics, variables.rates),
        found.reduced_rows(formed.holonomic),
        notes + elimination_notes(found),
        found,
    )
    return replace(reduced, redundant=formed.redundant)


def _formed(
    formulation: Formulation,
    topology: Topology,
    names: Names,
    uses: Sequence[Use],
    variables: Variables,
    kinematics: Kinematics,
    rows: Sequence[Row],
    notes: tuple[str, ...],
    elimination: Elimination | None = None,
) -> Formed:
    begin("loads", notes)
    model = topology.model
    bodies = tuple(form_inertia(names, body) for body in model.bodies)
    friction = form_friction(names, uses)
    weights = not isinstance(formulation, Recursive)
    loads = form_loads(model, names, kinematics, bodies, uses, friction, weights=weights)
    armatures = {
        coordinate: Rotor(
            names.value(f"{coordinate}_dot"),
            names.expression(rotor, f"joint {use.joint.name}"),
            coordinate,
        )
        for use in uses
        for coordinate, rotor in use.joint.armature.items()
    }
    begin("mass matrix and forcing")
    projection: Projection | Recursion
    if isinstance(formulation, Recursive):
        projection, kinetic, loads = form_recursion(
            formulation, topology, names, kinematics, uses, loads, armatures
        )
    elif elimination is None:
        projection = projected(formulation, topology, names, kinematics, uses, bodies, loads, armatures)
    else:
        projection = elimination.projection()
    begin("energy")
    if not isinstance(formulation, Recursive):
        kinetic = kinetic_energy(kinematics, bodies, armatures)
    return Formed(
        names=names,
        topology=topology,
        uses=tuple(uses),
        variables=variables,
        inputs=tuple(Symbol(name, Kind.INPUT) for name in model.inputs),
        parameters=tuple(Symbol(name, Kind.PARAMETER) for name in model.parameters),
        kinematics=kinematics,
        bodies=bodies,
        loads=loads,
        armatures=armatures,
        rows=tuple(rows),
        alignments=tuple(cosine for use in uses for cosine in alignments(names, kinematics, use)),
        projection=projection,
        kinetic_energy=kinetic,
        notes=notes + loads.notes + _tied(uses) + _singularities(names.graph, variables) + _ropes(model),
        friction=friction,
        formulation=formulation,
        elimination=elimination,
    )


def _tied(uses: Iterable[Use]) -> tuple[str, ...]:
    """Return what is said of cut joints whose displacement depends on their angle."""
    return tuple(
        f"joint {use.joint.name}: its displacement depends on {', '.join(use.joint.coupled_coordinates)}, "
        "which joins the coordinates with one more closing equation, although the joint is cut"
        for use in uses
        if use.joint.coupled_coordinates and not use.in_rotation and use.unknown
    )


def _ropes(model: Model) -> tuple[str, ...]:
    names = [part.name for part in model.constraints if isinstance(part, Distance) and part.rope]
    return tuple(
        f"constraint {name}: the equations are those of the taut rope; simulate switches to slack ones"
        for name in names
    )


def _singularities(graph: Graph, variables: Variables) -> tuple[str, ...]:
    return tuple(
        f"joint {joint}: the angle rates do not follow from the angular velocity where "
        f"{to_text(graph, determinant.index).removeprefix('-')} = 0"
        for joint, determinant in variables.singularities.items()
    )
