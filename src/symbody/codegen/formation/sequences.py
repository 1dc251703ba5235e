"""Computational sequences of outputs: what stands for parameters and inputs is put into the equations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from collections.abc import Sequence as Items
from dataclasses import replace

import numpy as np

from symbody.codegen.formation.names import Value, check_names, missing_value, unknown_name
from symbody.codegen.massless import massless_problem, massless_speeds, undetermined_problem
from symbody.codegen.signature import Signature
from symbody.codegen.stored_sequence import read_sequence, sequence_key, store_sequence
from symbody.collection import without_collection
from symbody.equations.cache_key import store_notes
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.input_formulas import input_law_nodes
from symbody.errors import CompileError, ExpressionError
from symbody.expr.deadline import begin
from symbody.expr.graph import TIME, Graph
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import substitute, substitute_into, symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, Sequence, build_sequence
from symbody.model.content import content_bytes
from symbody.model.declarations.arguments import plain_value
from symbody.model.model import Model, value_problems
from symbody.model.signals.block import SignalBlock


@without_collection()
def form_sequence(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    parameters: Mapping[str, Value] | None = None,
    free: Iterable[str] = (),
    inputs: Mapping[str, Value] | None = None,
) -> tuple[Sequence, Signature]:
    """Return the sequence of the `outputs` and the names of its arguments.

    `inputs` replaces inputs by expressions in time, states, parameters; those not named stay arguments.
    """
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    kept, values, replaced = tuple(free), dict(parameters or {}), dict(inputs or {})
    key = sequence_key(eqs.identity, content_bytes(names, values, kept, replaced) if eqs.identity else b"")
    known = read_sequence(key)
    if known is None:
        known = _specialized_sequence(eqs, names, values, kept, replaced)
        if store_sequence(key, *known):
            store_notes(eqs.identity, eqs.notes)
    return known


def _specialized_sequence(
    eqs: EquationSet,
    names: Items[str],
    parameters: Mapping[str, Value],
    kept: tuple[str, ...],
    inputs: Mapping[str, Value],
) -> tuple[Sequence, Signature]:
    begin("equations")
    impossible = value_problems(eqs.model, parameters, kept) if isinstance(eqs.model, Model) else []
    if impossible:
        raise CompileError(*impossible)
    replacements = parameter_nodes(eqs, parameters, kept)
    if eqs.multiplier_names or eqs.formed.coupled.rows:
        eqs = eqs.for_values(_known_values(eqs, replacements))
    # What belongs to values of this call alone goes when it is done: equations serve for many calls.
    graph = Graph() if parameters or inputs else eqs.formed.graph
    return outputs_sequence(eqs, names, replacements, kept, inputs, graph)


def outputs_sequence(
    eqs: EquationSet,
    outputs: Items[str],
    replacements: Mapping[int, int],
    arguments: tuple[str, ...],
    inputs: Mapping[str, Value],
    graph: Graph,
) -> tuple[Sequence, Signature]:
    """Return the sequence of outputs with replacements for some parameters.

    Parameters
    ----------
    arguments : tuple of str
        Parameters, and inputs that are given like them, which form p.
    inputs : mapping of name to number or formula
        What takes the place of other inputs; those not named stay arguments.
    graph : Graph
        Where the outputs are put together.
    """
    nodes = dict(replacements) | input_nodes(eqs, inputs, replacements)
    left = tuple(name for name in eqs.input_names if name not in inputs and name not in arguments)
    signature = Signature(eqs.coordinate_names, eqs.speed_names, left, arguments, eqs.signal_state_names)
    try:
        roots = []
        for name in outputs:
            begin(f"output {name}")
            roots.append(_replace_symbols(eqs, eqs.code_roots(name), nodes, graph))
    except ExpressionError as error:
        raise _explain_undefined(eqs, outputs, nodes, signature, error) from error
    signature = replace(signature, r=(*left, *_accelerations_read(eqs, roots, graph)))
    begin("computational sequence")
    return build_sequence(graph, roots, input_places(eqs, signature, graph)), signature


def _accelerations_read(eqs: EquationSet, roots: Items[Roots], graph: Graph) -> tuple[str, ...]:
    """Return the names of u' where outputs read them as given, as inverse dynamics do; none elsewhere."""
    given = {graph.symbol(u.derivative) for u in eqs.formed.u}
    read = symbols_of(graph, [node for output in roots for node in output.nodes])
    return () if given.isdisjoint(read) else eqs.acceleration_names


def _replace_symbols(eqs: EquationSet, roots: Roots, replacements: Mapping[int, int], graph: Graph) -> Roots:
    """Return roots with symbols replaced, in the graph of the equations or in another one."""
    own, all_nodes = eqs.formed.graph, (*roots.nodes, *roots.given)
    if graph is own:
        nodes = substitute(own, all_nodes, replacements)
    else:
        nodes = substitute_into(graph, own, all_nodes, replacements)
    count = len(roots.nodes)
    return Roots(roots.name, roots.shape, tuple(nodes[:count]), tuple(nodes[count:]))


def _explain_undefined(
    eqs: EquationSet,
    outputs: Items[str],
    replacements: Mapping[int, int],
    signature: Signature,
    error: ExpressionError,
) -> CompileError | ExpressionError:
    """Return why outputs cannot be formed with these values: what no mass resists, or what was divided."""
    lost = _undefined_balances(eqs, replacements)
    if lost:
        return CompileError(undetermined_problem("compile.massless", lost))
    graph = eqs.formed.graph
    matrices = [
        _replace_symbols(eqs, eqs.roots(name), replacements, graph) for name in ("mass_matrix", "jacobian")
    ]
    sequence = build_sequence(graph, matrices, input_places(eqs, signature, graph))
    # A configuration without symmetries; mass matrices that are singular everywhere are so there.
    anywhere = {
        group: [0.3 + math.sin(1 + k) / 4 for k in range(len(signature.names(group)))] for group in "qurp"
    }
    mass, rows = evaluate_sequence(sequence, {"t": [0.7], **anywhere})
    n = len(eqs.speed_names)
    places = massless_speeds(np.reshape(mass, (n, n)), np.reshape(rows, (-1, n))) if n else []
    if places:
        names = [eqs.speed_names[k] for k in places]
        return CompileError(massless_problem("compile.singular_mass", names, eqs.coordinate_names))
    where = _undefined_formula(eqs, replacements) or f"output {', '.join(outputs)}"
    return ExpressionError(*(p if p.where else replace(p, where=where) for p in error.problems))


def _undefined_balances(eqs: EquationSet, replacements: Mapping[int, int]) -> list[str]:
    """Return the names of motions without mass that forces do not determine with these parameters."""
    formed = eqs.formed
    light = [speed.label for speed in formed.light_balances]
    inverse = [] if formed.elimination is None or not light else formed.elimination.inverse
    positions = {row.name.removeprefix("balance_"): row.value for row in formed.rows if row.is_balance}
    try:
        substitute(formed.graph, [x.index for row in inverse for x in row], replacements)
        light = []
    except ExpressionError:
        return light
    for name, value in positions.items():
        try:
            substitute(formed.graph, [value.index], replacements)
        except ExpressionError:
            light.append(name)
    return light


def _undefined_formula(eqs: EquationSet, replacements: Mapping[int, int]) -> str:
    """Return where the first formula of the model stands that has no value with these parameters."""
    names, graph = eqs.formed.names, eqs.formed.graph
    for element in eqs.model.elements:
        for use in element.formula_sites():
            where = f"{element.kind} {element.name}, {use.path}"
            if use.local_names:
                continue
            try:
                substitute(graph, [names.expression(use.formula, where).index], replacements)
            except ExpressionError:
                return where
    return _undefined_signal(eqs, replacements)


def _undefined_signal(eqs: EquationSet, replacements: Mapping[int, int]) -> str:
    """Return which signal that a block expands into has no value with these parameters."""
    names, graph = eqs.formed.names, eqs.formed.graph
    for block in eqs.model.elements:
        for signal in block.signals if isinstance(block, SignalBlock) else ():
            for use in signal.formula_sites():
                where = f"block {block.name}, {use.path} of its signal {signal.name}, {use.formula.text}"
                try:
                    substitute(graph, [names.expression(use.formula, where).index], replacements)
                except ExpressionError:
                    return where
    return ""


def input_places(eqs: EquationSet, signature: Signature, graph: Graph) -> dict[int, Input]:
    """Return where the symbols of a graph are found at call time."""
    names, own = eqs.formed.names, eqs.formed.graph
    places = {graph.symbol(TIME): Input("t", "t", 0)}
    for group in ("q", "u", "r", "p"):
        for k, name in enumerate(signature.names(group)):
            symbol = own.symbols[own.left[names.value(name).index]]
            places[graph.symbol(symbol)] = Input(name, group, k)
    return places


def parameter_nodes(eqs: EquationSet, given: Mapping[str, Value], free: Items[str]) -> dict[int, int]:
    """Return the nodes that take the place of parameters, computed in the order of their dependence."""
    model, names, graph = eqs.model, eqs.formed.names, eqs.formed.graph
    check_names(eqs, given, free)
    symbol_nodes = {name: names.value(name).index for name in (*model.parameters, *free)}
    nodes = {symbol_nodes[name]: symbol_nodes[name] for name in free}
    missing = []
    asked = {
        name: Formula.from_value(plain_value(value), where=name)
        for name, value in given.items()
        if name in symbol_nodes
    }
    for name in model.parameter_order(asked):
        if symbol_nodes[name] in nodes:
            continue
        formula = asked.get(name, model.parameters[name])
        if formula is None:
            missing.append(name)
        else:
            node = names.expression(formula, f"parameter {name}").index
            nodes[symbol_nodes[name]] = substitute(graph, [node], nodes)[0]
    if missing:
        raise CompileError(missing_value(missing))
    return {symbol: node for symbol, node in nodes.items() if symbol != node}


def _known_values(eqs: EquationSet, nodes: Mapping[int, int]) -> dict[str, float]:
    """Return the values of the parameters that have been given nodes without symbols."""
    graph = eqs.formed.graph
    known = {node: made for node, made in nodes.items() if not symbols_of(graph, [made])}
    roots = [Roots("values", (len(known),), tuple(known.values()))]
    values = evaluate_sequence(build_sequence(graph, roots, {}), {})[0]
    return {
        graph.symbols[graph.left[node]].name: float(value) for node, value in zip(known, values, strict=True)
    }


def input_nodes(eqs: EquationSet, given: Mapping[str, Value], known: Mapping[int, int]) -> dict[int, int]:
    """Return the nodes that take the place of inputs."""
    names, graph = eqs.formed.names, eqs.formed.graph
    problems = [unknown_name("input", name, eqs.input_names) for name in given if name not in eqs.input_names]
    if problems:
        raise CompileError(*problems)
    laws = input_law_nodes(eqs.formed, given)
    return {names.value(name).index: substitute(graph, [node], known)[0] for name, node in laws.items()}
