"""The names of a mechanism on the graph: symbols, prescribed motions, rates in quasi-speeds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names, model_names
from symbody.equations.kinematics.tables import tables_of_time
from symbody.equations.kinematics.variables import JointRole, Variables
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import time_derivative
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.graph.topology import Topology


def mechanism_names(graph: Graph, topology: Topology, roles: Iterable[JointRole]) -> Names:
    """Return the names of the model, prescribed coordinates as functions of time."""
    model = topology.model
    coordinates = [name for joint in topology.joints for name in joint.coordinates]
    coordinates += [name for condition in model.constraints for name in condition.coordinates]
    quasi = [
        name
        for joint in topology.joints
        for speeds in (joint.translation_speeds, joint.rotation_speeds)
        if speeds is not None
        for name in speeds.names
    ]
    _check_clashes(topology, [*coordinates, *quasi])
    signals = [signal.name for signal in model.signals]
    inputs = [*model.inputs, *(signal.name for signal in model.held_signals)]
    names = model_names(graph, model.parameters, inputs, coordinates, quasi, signals)
    names = names.with_values(tables_of_time(names, model))
    prescribed: dict[str, Expr] = {}
    for role in roles:
        for name in role.prescribed_coordinates:
            value = names.expression(role.joint.motions[name], f"joint {role.joint.name}")
            for suffix in ("", "_dot", "_ddot"):
                prescribed[f"{name}{suffix}"] = value
                value = Expr(graph, time_derivative(graph, [value.index])[0])
    return names.with_values(prescribed)


def _check_clashes(topology: Topology, names: Sequence[str]) -> None:
    """Refuse symbols of the model that are called like a variable of a free body."""
    model = topology.model
    symbols = {
        *model.parameters,
        *model.inputs,
        *(element.name for element in (*model.signals, *model.held_signals, *model.tables)),
    }
    clashes = sorted({name for name in names if name in symbols or names.count(name) > 1})
    if clashes:
        raise FormulationError(
            Problem("equations.name_clash", "tree", f"the names {', '.join(clashes)} are used twice",
                    "bodies with absolute coordinates use the names BODY_x .. BODY_qz, BODY_vx .. BODY_wz",
                    "rename these symbols of the model")
        )  # fmt: skip


def rates_by_name(graph: Graph, variables: Variables) -> dict[str, Expr]:
    """Return the rates that are no symbols: those of coordinates with quasi-speeds."""
    rates = {}
    for q in variables.q:
        rate = variables.rates[graph.symbol(q)]
        if rate != graph.symbol(q.derivative):
            rates[q.derivative.label] = Expr(graph, rate)
    return rates


def second_rates(kinematics: Kinematics, variables: Variables) -> dict[str, Expr]:
    """Return the second rates of coordinates with quasi-speeds, in u and u'."""
    graph = kinematics.graph
    return {
        q.derivative.derivative.label: kinematics.rate(Expr(graph, variables.rates[graph.symbol(q)]))
        for q in variables.q
        if variables.rates[graph.symbol(q)] != graph.symbol(q.derivative)
    }


def rates_of_values(names: Names, kinematics: Kinematics, coordinates: Iterable[str]) -> dict[str, Expr]:
    """Return first and second rates of coordinates that stand for expressions in others."""
    rates: dict[str, Expr] = {}
    for name in coordinates:
        first = kinematics.rate(names.value(name))
        rates |= {f"{name}_dot": first, f"{name}_ddot": kinematics.rate(first)}
    return rates


def joint_speeds(names: Names, rates: Mapping[int, int], role: JointRole) -> list[int]:
    """Return the nodes of the speeds that a joint moves with: its own, and those of joints it is coupled to.

    Parameters
    ----------
    rates : mapping of node to node
        q' in terms of u.
    """
    graph = names.graph
    speeds = [graph.symbol(speed) for speed in role.speeds]
    values = [names.value(name).index for name in role.substituted]
    inside = symbols_of(graph, time_derivative(graph, values, rates))
    return [*speeds, *(node for node in inside if _is_speed(graph, node) and node not in speeds)]


def _is_speed(graph: Graph, node: int) -> bool:
    """Return whether a symbol is a speed: the rate of a coordinate, or a symbol of its own."""
    symbol = graph.symbols[graph.left[node]]
    return (symbol.kind, symbol.order) in ((SymbolKind.COORDINATE, 1), (SymbolKind.SPEED, 0))
