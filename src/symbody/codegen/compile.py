"""`compile` and `generate_code`: from equations and outputs asked for to functions and source text.

The only file of this folder that imports EquationSet.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from collections.abc import Sequence as Items
from dataclasses import replace
from typing import Final

import numpy as np

from symbody.arguments import checked_arguments
from symbody.codegen.function import CompiledFunction, Signature, source_text
from symbody.codegen.massless import massless_problem, massless_speeds
from symbody.codegen.stored_sequence import read_sequence, sequence_key, store_sequence
from symbody.equations.cache_key import store_notes
from symbody.equations.equation_set import EquationSet
from symbody.errors import CompileError, ExpressionError, Problem, nearest
from symbody.expr.deadline import begin, in_time
from symbody.expr.evaluate import evaluate_sequence
from symbody.expr.graph import TIME, Graph
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import substitute, substitute_into, symbols_of
from symbody.expr.sequence import Input, Roots, Sequence, build_sequence
from symbody.model.arguments import plain_value
from symbody.model.content import content_bytes
from symbody.model.model import Model, value_problems
from symbody.model.numbers import as_float

_LESS: Final = "ask for fewer outputs at a time, or for code in less time by quick=True"
Value = int | float | str | Formula


@checked_arguments
def compile(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    parameters: Mapping[str, Value] | None = None,
    free: Iterable[str] = (),
    *,
    quick: bool = False,
    lanes: bool | None = None,
    time_limit: float | None = None,
) -> CompiledFunction:
    """Return a native function ``f(t, q, u, r=(), p=(), *, out=None, threads=1)`` of the `outputs`.

    Parameters
    ----------
    eqs : EquationSet
        The equations.
    outputs : str or iterable of str
        Output names, for instance ``"udot"`` or ``["mass_matrix", "forcing"]``, or expressions. For
        ``"inverse_dynamics"`` the inputs are followed by the accelerations, ``eqs.acceleration_names``.
    parameters : mapping of name to number or formula
        Overrides values of the model; parameters that are formulas of others follow.
    free : iterable of str
        Parameters that stay arguments; they form p in this order.
    quick : bool
        Compile in less than half the time for calls that take 1.5 to 3 times as long; it pays below about
        100,000 evaluations. Results do not depend on it, nor on `lanes`.
    lanes : bool, optional
        Whether batches are computed several points at once. True compiles that at the first batch, None when
        300,000 points have been asked for, False never.
    time_limit : float, optional
        Seconds after which this ends with an error that names the stage; outputs whose formulas were found
        stay with `eqs`, so that the next call goes on from there. By default it takes its time.

    Raises
    ------
    CompileError
        If parameters have no value, listing all of them, or names are unknown.
    TimeLimitError
        When time is up.
    """

    def make_function() -> CompiledFunction:
        return CompiledFunction(*form_sequence(eqs, outputs, parameters, free), quick=quick, lanes=lanes)

    return in_time(time_limit, "compiling", _LESS, make_function)


@checked_arguments
def generate_code(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    language: str = "c",
    parameters: Mapping[str, Value] | None = None,
) -> str:
    """Return source text that computes the `outputs`.

    Parameters
    ----------
    language : str
        "c" for C99, "python" for a module that needs NumPy alone, "fortran" for Fortran 2008, "matlab"
        (or "octave"), "julia", "rust", "javascript" for an ES module, "jax", or "casadi"; each text explains
        itself at its head.
    parameters : mapping, optional
        Values to put in; None leaves every parameter an argument, in the order of ``eqs.parameters``.

    Raises
    ------
    CompileError
        If the language or an output is unknown, or parameters have no value.
    """
    free = eqs.parameter_names if parameters is None else ()
    sequence, signature = form_sequence(eqs, outputs, parameters or {}, free)
    return source_text(sequence, language, signature)


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
        known = _made_sequence(eqs, names, values, kept, replaced)
        if store_sequence(key, *known):
            store_notes(eqs.identity, eqs.notes)
    return known


def _made_sequence(
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
    replacements = _parameter_nodes(eqs, parameters, kept)
    eqs = eqs.for_values(_known_values(eqs, replacements)) if eqs.multiplier_names else eqs
    replacements |= _input_nodes(eqs, inputs, replacements)
    left = tuple(name for name in eqs.input_names if name not in inputs)
    signature = Signature(eqs.coordinate_names, eqs.speed_names, left, kept)
    # What belongs to values of this call alone goes when it is done: equations serve for many calls.
    graph = Graph() if parameters or inputs else eqs.formed.graph
    try:
        roots = []
        for name in names:
            begin(f"output {name}")
            roots.append(_replace_symbols(eqs, eqs.code_roots(name), replacements, graph))
    except ExpressionError as error:
        raise _explain_undefined(eqs, names, replacements, signature, error) from error
    signature = replace(signature, r=(*left, *_accelerations_read(eqs, roots, graph)))
    begin("computational sequence")
    return build_sequence(graph, roots, _places(eqs, signature, graph)), signature


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
    graph = eqs.formed.graph
    matrices = [
        _replace_symbols(eqs, eqs.roots(name), replacements, graph) for name in ("mass_matrix", "jacobian")
    ]
    sequence = build_sequence(graph, matrices, _places(eqs, signature, graph))
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


def _undefined_formula(eqs: EquationSet, replacements: Mapping[int, int]) -> str:
    """Return where the first formula of the model stands that has no value with these parameters."""
    names, graph = eqs.formed.names, eqs.formed.graph
    for element in eqs.model.elements:
        for site in element.formula_sites():
            where = f"{element.kind} {element.name}, {site.path}"
            if site.local_names:
                continue
            try:
                substitute(graph, [names.expression(site.formula, where).index], replacements)
            except ExpressionError:
                return where
    return ""


def _places(eqs: EquationSet, signature: Signature, graph: Graph) -> dict[int, Input]:
    """Return where the symbols of a graph are found at call time."""
    names, own = eqs.formed.names, eqs.formed.graph
    places = {graph.symbol(TIME): Input("t", "t", 0)}
    for group in ("q", "u", "r", "p"):
        for k, name in enumerate(signature.names(group)):
            symbol = own.symbols[own.left[names.value(name).index]]
            places[graph.symbol(symbol)] = Input(name, group, k)
    return places


def _parameter_nodes(eqs: EquationSet, given: Mapping[str, Value], free: Items[str]) -> dict[int, int]:
    """Return the nodes that take the place of parameters, computed in the order of their dependence."""
    model, names, graph = eqs.model, eqs.formed.names, eqs.formed.graph
    _check_names(eqs, given, free)
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
        raise CompileError(_missing_value(missing))
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


def _input_nodes(eqs: EquationSet, given: Mapping[str, Value], known: Mapping[int, int]) -> dict[int, int]:
    names, graph = eqs.formed.names, eqs.formed.graph
    problems = [_unknown("input", name, eqs.input_names) for name in given if name not in eqs.input_names]
    if problems:
        raise CompileError(*problems)
    result = {}
    for name, value in given.items():
        node = names.expression(Formula.from_value(value, where=f"input {name}"), f"input {name}").index
        result[names.value(name).index] = substitute(graph, [node], known)[0]
    return result


def _check_names(eqs: EquationSet, given: Mapping[str, Value], free: Items[str]) -> None:
    known = eqs.parameter_names
    problems = [_unknown("parameter", name, known) for name in (*given, *free) if name not in known]
    if problems:
        raise CompileError(*problems)


def _unknown(kind: str, name: str, known: Items[str]) -> Problem:
    return Problem(
        f"compile.unknown_{kind}", name, f"the model has no {kind} {name!r}", "", nearest(name, known)
    )


def _missing_value(names: Items[str]) -> Problem:
    listed = ", ".join(names)
    return Problem(
        "compile.missing_value", "parameters", f"no value is given for {listed}",
        "a number is needed to compute with", f"give parameters={{{names[0]!r}: ...}}, or name them in free=",
    )  # fmt: skip


def form_values(
    eqs: EquationSet,
    formulas: Mapping[str, Value],
    parameters: Mapping[str, Value] | None = None,
    free: Iterable[str] = (),
) -> tuple[Sequence, Signature]:
    """Return the sequence of formulas in parameters, and the names of the `free` ones, its arguments p.

    Raises
    ------
    CompileError
        If a parameter has no value, or a name is unknown.
    ExpressionError
        If a formula reads something else than parameters.
    """
    kept = tuple(free)
    graph, names = eqs.formed.graph, eqs.formed.names
    replacements = _parameter_nodes(eqs, parameters or {}, kept)
    nodes = [
        names.expression(Formula.from_value(value, where=name), name).index
        for name, value in formulas.items()
    ]
    made = substitute(graph, nodes, replacements)
    roots = [Roots(name, (), (node,)) for name, node in zip(formulas, made, strict=True)]
    signature = Signature((), (), (), kept)
    return build_sequence(graph, roots, _places(eqs, signature, graph)), signature


def constant_values(
    eqs: EquationSet, formulas: Mapping[str, Value], parameters: Mapping[str, Value] | None = None
) -> dict[str, float]:
    """Return the values of formulas in parameters.

    Raises
    ------
    CompileError
        If a parameter has no value, or a formula reads something else than parameters.
    """
    if not formulas:
        return {}
    graph, names = eqs.formed.graph, eqs.formed.names
    replacements = _parameter_nodes(eqs, parameters or {}, ())
    read = {name: Formula.from_value(value, where=name) for name, value in formulas.items()}
    distinct = dict.fromkeys(formula for formula in read.values() if formula.constant() is None)
    nodes = [names.expression(formula, formula.text).index for formula in distinct]
    roots = [Roots(str(k), (), (node,)) for k, node in enumerate(substitute(graph, nodes, replacements))]
    values = evaluate_sequence(build_sequence(graph, roots, {}), {}) if roots else []
    numbers = {formula: float(value[0]) for formula, value in zip(distinct, values, strict=True)}
    return {
        name: numbers[formula] if formula in numbers else as_float(formula.constant() or 0)
        for name, formula in read.items()
    }
