"""`form_equations`: from a model to its equations of motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symbody.equations.equation_set import EquationSet
from symbody.equations.formed import Formed
from symbody.equations.kinematics import Kinematics, Step, form_kinematics
from symbody.equations.loads import Loads, form_loads
from symbody.equations.naming import Names, model_names
from symbody.equations.virtual_work import Inertia, VirtualWork, kinetic_energy, project
from symbody.expr.graph import Graph, Kind, Symbol
from symbody.graph.spanning_tree import Branch
from symbody.graph.topology import Topology, choose_topology
from symbody.model.element import Address
from symbody.model.frame import Frame
from symbody.model.joint import Turn as JointTurn
from symbody.model.model import Model
from symbody.vectors.rotation import Turn
from symbody.vectors.vector import NULL, vector


def form_equations(model: Model, formulation: VirtualWork | None = None) -> EquationSet:
    """Return the equations of motion of a model; all parameters stay symbols.

    Parameters
    ----------
    model : Model
        The mechanism.
    formulation : VirtualWork, optional
        How the equations are formed; virtual work by default.

    Raises
    ------
    FormulationError
        If a body is joined to nothing, or the joints close a loop.
    """
    topology = choose_topology(model)
    graph = Graph()
    names = _names(graph, model)
    coordinates = _coordinates(topology)
    rates = {graph.symbol(q): graph.symbol(q.derivative) for q in coordinates}
    kinematics = form_kinematics(graph, _steps(topology, names), rates)
    bodies = [_inertia(names, model, name) for name in (body.name for body in model.bodies)]
    loads = form_loads(model, names, kinematics, bodies)
    return EquationSet(
        model, _formed(model, names, coordinates, kinematics, bodies, loads), model.notes + topology.notes
    )


def _formed(
    model: Model,
    names: Names,
    coordinates: tuple[Symbol, ...],
    kinematics: Kinematics,
    bodies: Sequence[Inertia],
    loads: Loads,
) -> Formed:
    graph = names.graph
    speeds = tuple(q.derivative for q in coordinates)
    return Formed(
        graph=graph,
        names=names,
        q=coordinates,
        u=speeds,
        inputs=tuple(Symbol(name, Kind.INPUT) for name in model.inputs),
        parameters=tuple(Symbol(name, Kind.PARAMETER) for name in model.parameters),
        kinematics=kinematics,
        projection=project(kinematics, [graph.symbol(u) for u in speeds], bodies, loads.loads),
        kinetic_energy=kinetic_energy(kinematics, bodies),
        potential_energy=loads.potential_energy,
        power=loads.power,
        efforts=loads.efforts,
    )


def _names(graph: Graph, model: Model) -> Names:
    coordinates = [name for joint in model.joints for name in joint.coordinates]
    return model_names(graph, model.parameters, model.inputs, coordinates)


def _coordinates(topology: Topology) -> tuple[Symbol, ...]:
    """Return the tree's coordinates in the order of its branches, root first."""
    return tuple(
        Symbol(name, Kind.COORDINATE)
        for branch in topology.tree.branches
        for name in topology.joint(branch.edge.name).coordinates
    )


def _steps(topology: Topology, names: Names) -> list[Step]:
    """Return the steps that place all frames, outward from ground."""
    model = topology.model
    steps = [_frame_step(names, "ground", frame, place) for frame, place in model.ground.items()]
    for branch in topology.tree.branches:
        steps.extend(_branch_steps(topology, names, branch))
        body = model.body(branch.child)
        steps.extend(_frame_step(names, body.name, frame, place) for frame, place in body.frames.items())
    return steps


def _frame_step(names: Names, body: str, name: str, frame: Frame) -> Step:
    """Return the step from a body to a frame fixed on it."""
    where = f"frame {body}.{name}"
    turns = _turns(names, frame.turns(), where)
    return Step(f"{body}.{name}", body, turns, vector(body, names.triple(frame.at, where)))


def _branch_steps(topology: Topology, names: Names, branch: Branch) -> list[Step]:
    """Return the steps from the parent's joint frame across the joint to the child body.

    A joint walked against its direction has its turns reversed; its shift is then seen from the far side.
    """
    joint = topology.joint(branch.edge.name)
    where = f"joint {joint.name}"
    near, far = (joint.start, joint.end) if branch.forward else (joint.end, joint.start)
    turns = _turns(names, joint.turns(), where)
    shift = names.triple(joint.shift(), where)
    mid, end = f"{joint.name}|across", f"{joint.name}|end"
    if branch.forward:
        across = [Step(mid, near.frame, (), vector(near.frame, shift)), Step(end, mid, turns, NULL)]
    else:
        back = (-shift[0], -shift[1], -shift[2])
        across = [Step(mid, near.frame, _reversed(turns), NULL), Step(end, mid, (), vector(mid, back))]
    return [*across, _body_step(names, topology.model, far, end)]


def _body_step(names: Names, model: Model, address: Address, parent: str) -> Step:
    """Return the step from a frame that coincides with a body's frame, at `address`, to the body itself."""
    body = address.body
    if not address.point:
        return Step(body, parent, (), NULL)
    place = model.body(body).frames[address.point]
    turns = _reversed(_turns(names, place.turns(), address.frame))
    x, y, z = names.triple(place.at, address.frame)
    return Step(body, parent, turns, vector(body if turns else parent, (-x, -y, -z)))


def _turns(names: Names, turns: Iterable[JointTurn], where: str) -> tuple[Turn, ...]:
    return tuple(Turn(names.triple(turn.axis, where), names.expression(turn.angle, where)) for turn in turns)


def _reversed(turns: tuple[Turn, ...]) -> tuple[Turn, ...]:
    return tuple(Turn(turn.axis, -turn.angle) for turn in reversed(turns))


def _inertia(names: Names, model: Model, name: str) -> Inertia:
    body = model.body(name)
    where = f"body {name}"
    xx, yy, zz = names.triple(body.inertia, where)
    xy, xz, yz = names.triple(body.products, where)
    tensor = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    return Inertia(name, names.expression(body.mass, where), tensor)
