"""From a topology to everything a formulation delivers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from collections.abc import Set as AbstractSet

from symbody.equations.dynamics.direct import project_directly
from symbody.equations.dynamics.inertia import Rotor, form_inertia
from symbody.equations.dynamics.loads import form_loads
from symbody.equations.dynamics.virtual_work import kinetic_energy, project
from symbody.equations.formed import Formed
from symbody.equations.kinematics.closings import Row, alignments, closing_rows, motion_rows
from symbody.equations.kinematics.measured import measured_coordinates
from symbody.equations.kinematics.motion import Kinematics, form_kinematics
from symbody.equations.kinematics.naming import Names, model_names
from symbody.equations.kinematics.placing import shiftings, turnings
from symbody.equations.kinematics.variables import Use, Variables, form_variables
from symbody.equations.solving.solution import vanishing
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import time_derivative
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Kind, Symbol
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import dependence
from symbody.graph.topology import Topology
from symbody.model.joint import Joint
from symbody.model.model import Model
from symbody.model.uses import Scope


def form(topology: Topology, graph: Graph, *, spread: bool = False) -> Formed:
    """Return the equations of a mechanism in a graph.

    Parameters
    ----------
    spread : bool
        Whether they are formed for reading: vectors stay sums of terms in their own frames, and every
        body is projected by itself. The values are the same.

    Raises
    ------
    FormulationError
        If a cut joint cannot do what is asked of it, or a loop can never close.
    """
    uses = _uses(topology)
    names = _names(graph, topology, uses)
    variables = form_variables(names, uses)
    names = names.with_values(_rates_by_name(graph, variables))
    speeds = [graph.symbol(u) for u in variables.u]
    kinematics = form_kinematics(
        graph,
        turnings(topology, names, uses),
        shiftings(topology, names),
        variables.rates,
        speeds,
        spread=spread,
    )
    names = names.with_values(_second_rates(kinematics, variables))
    read = _names_read(topology.model)
    for use in uses:
        if _is_read(use, read):
            names = names.with_values(measured_coordinates(names, kinematics, use))
    rows, notes = _rows(names, kinematics, uses)
    return _formed(topology, names, uses, variables, kinematics, rows, notes)


def _formed(
    topology: Topology,
    names: Names,
    uses: Sequence[Use],
    variables: Variables,
    kinematics: Kinematics,
    rows: Sequence[Row],
    notes: tuple[str, ...],
) -> Formed:
    model = topology.model
    bodies = tuple(form_inertia(names, body) for body in model.bodies)
    loads = form_loads(model, names, kinematics, bodies, uses)
    armatures = {
        coordinate: Rotor(
            names.value(f"{coordinate}_dot"), names.expression(rotor, f"joint {use.joint.name}")
        )
        for use in uses
        for coordinate, rotor in use.joint.armature.items()
    }
    if kinematics.spread:
        projection = project_directly(kinematics, bodies, loads.loads, armatures)
    else:
        projection = project(topology, kinematics, uses, bodies, loads.loads, armatures)
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
        kinetic_energy=kinetic_energy(kinematics, bodies, armatures),
        notes=notes + _singularities(names.graph, variables),
    )


def _uses(topology: Topology) -> tuple[Use, ...]:
    """Return every joint with the parts of its law in use.

    Raises
    ------
    FormulationError
        If a formula reads an Euler parameter of a joint outside the rotation tree.
    """
    read = _names_read(topology.model)
    uses = []
    problems = []
    for joint in topology.joints:
        turning, sliding = joint.name in topology.turning, joint.name in topology.sliding
        turns = turning or _needs_angles(joint, read)
        slides = sliding or not set(joint.motions).isdisjoint(joint.translation_coordinates)
        uses.append(Use(joint, turning, sliding, turns, slides))
        if turns and not turning and joint.quaternion is not None:
            problems.append(_quaternion_asked(joint))
    if problems:
        raise FormulationError(*problems)
    return tuple(uses)


def _names_read(model: Model) -> set[str]:
    """Return the names that the formulas of forces and springs contain."""
    uses = (use for element in model.elements for use in element.uses())
    return {name for use in uses if use.scope is Scope.LOAD for name in use.formula.names}


def _is_read(use: Use, read: AbstractSet[str]) -> bool:
    """Return whether forces need a measured coordinate of a joint, or its rate."""
    measured = set(use.joint.coordinates).difference(use.coordinates)
    if not measured.isdisjoint({*use.joint.drives, *use.joint.armature}):
        return True
    return any(name in read or f"{name}_dot" in read for name in measured)


def _needs_angles(joint: Joint, read: AbstractSet[str]) -> bool:
    """Return whether a joint outside the rotation tree must still have its angles as variables.

    Displacements, their rates and the rate of a single angle are measured on the bodies. An angle is not,
    because a spring or a formula may count its turns.
    """
    angles = joint.rotation_coordinates
    driven = [joint.drives[name] for name in angles if name in joint.drives]
    if any(name in joint.motions or name in read for name in angles):
        return True
    if len(angles) == 1:
        return any(drive.stiffness.constant() != 0 for drive in driven)
    rates = {f"{name}_dot" for name in angles}
    return bool(driven) or not read.isdisjoint(rates) or not set(joint.armature).isdisjoint(angles)


def _names(graph: Graph, topology: Topology, uses: Iterable[Use]) -> Names:
    """Return the names of the model, prescribed coordinates as functions of time."""
    model = topology.model
    coordinates = [name for joint in topology.joints for name in joint.coordinates]
    quasi = [
        name
        for joint in topology.joints
        for speeds in (joint.translation_speeds, joint.rotation_speeds)
        if speeds is not None
        for name in speeds.names
    ]
    _check_clashes(topology, [*coordinates, *quasi])
    names = model_names(graph, model.parameters, model.inputs, coordinates, quasi)
    prescribed: dict[str, Expr] = {}
    for use in uses:
        for name in use.prescribed:
            value = names.expression(use.joint.motions[name], f"joint {use.joint.name}")
            for suffix in ("", "_dot", "_ddot"):
                prescribed[f"{name}{suffix}"] = value
                value = Expr(graph, time_derivative(graph, [value.index])[0])
    return names.with_values(prescribed)


def _check_clashes(topology: Topology, names: Sequence[str]) -> None:
    """Refuse symbols of the model that are called like a variable of a free body."""
    model = topology.model
    own = {*model.parameters, *model.inputs}
    clashes = sorted({name for name in names if name in own or names.count(name) > 1})
    if clashes:
        raise FormulationError(
            Problem("equations.name_clash", "tree", f"the names {', '.join(clashes)} stand for two things",
                    "bodies with absolute coordinates bring the names BODY_x .. BODY_qz, BODY_vx .. BODY_wz",
                    "rename these symbols of the model")
        )  # fmt: skip


def _rates_by_name(graph: Graph, variables: Variables) -> dict[str, Expr]:
    """Return the rates that are no symbols: those of coordinates with quasi-speeds."""
    found = {}
    for q in variables.q:
        rate = variables.rates[graph.symbol(q)]
        if rate != graph.symbol(q.derivative):
            found[q.derivative.label] = Expr(graph, rate)
    return found


def _second_rates(kinematics: Kinematics, variables: Variables) -> dict[str, Expr]:
    """Return the second rates of coordinates with quasi-speeds, in u and u'."""
    graph = kinematics.graph
    return {
        q.derivative.derivative.label: kinematics.rate(Expr(graph, variables.rates[graph.symbol(q)]))
        for q in variables.q
        if variables.rates[graph.symbol(q)] != graph.symbol(q.derivative)
    }


def _rows(names: Names, kinematics: Kinematics, uses: Sequence[Use]) -> tuple[list[Row], tuple[str, ...]]:
    """Return the constraints without those that hold identically, and what was dropped.

    Raises
    ------
    FormulationError
        If a row is a constant other than zero: the loop can never close.
    """
    rows = [
        row
        for use in uses
        for row in (*closing_rows(names, kinematics, use), *motion_rows(names, kinematics, use))
    ]
    graph = kinematics.graph
    gone = vanishing(graph, [row.value.index for row in rows])
    pairs = list(zip(rows, gone, strict=True))
    kinds = dependence(graph, [row.value.index for row in rows])
    problems = [_never_closed(row) for row, zero in pairs if not zero and row.value.number is not None]
    problems += [
        _over_driven(row, uses)
        for row, zero in pairs
        if not zero and Kind.TIME in kinds[row.value.index] and Kind.COORDINATE not in kinds[row.value.index]
    ]
    if problems:
        raise FormulationError(*problems)
    dropped: dict[str, list[str]] = {}
    for row, zero in pairs:
        if zero:
            dropped.setdefault(row.element, []).append(row.name)
    notes = tuple(
        f"joint {element}: {len(lost)} closing equations hold identically and are dropped ({', '.join(lost)})"
        for element, lost in dropped.items()
    )
    return [row for row, zero in pairs if not zero], notes


def _singularities(graph: Graph, variables: Variables) -> tuple[str, ...]:
    return tuple(
        f"joint {joint}: the angle rates do not follow from the angular velocity where "
        f"{to_text(graph, determinant.index).removeprefix('-')} = 0"
        for joint, determinant in variables.singularities.items()
    )


def _over_driven(row: Row, uses: Sequence[Use]) -> Problem:
    driven = ", ".join(name for use in uses for name in use.prescribed)
    return Problem(
        "equations.over_driven", f"joint {row.element}",
        f"its closing equation {row.name} depends on time alone: every joint of its loop is driven",
        f"prescribed are {driven}, more than the loop has freedoms",
        "let one of these coordinates free, or give it a drive instead of a motion",
    )  # fmt: skip


def _never_closed(row: Row) -> Problem:
    return Problem(
        "equations.never_closed", f"joint {row.element}",
        f"its closing equation {row.name} is the constant {row.value.number}, whatever the coordinates",
        "the frames it connects are apart in a direction in which nothing can move",
        "move the frames together, or let the loop move in this direction",
    )  # fmt: skip


def _quaternion_asked(joint: Joint) -> Problem:
    return Problem(
        "equations.cut_quaternion", f"joint {joint.name}", "its quaternion is needed, but the joint is cut",
        "a formula or a motion reads it, and a quaternion cannot be measured without a choice of sign",
        "put the joint into the rotation tree, or give it angles",
    )  # fmt: skip
