"""Values of formulas in parameters: as sequences, and as numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import input_places, parameter_nodes
from symbody.codegen.function import Signature
from symbody.equations.equation_set import EquationSet
from symbody.expr.evaluate import evaluate_sequence
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import substitute
from symbody.expr.sequence import Roots, Sequence, build_sequence
from symbody.model.numbers import as_float


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
    replacements = parameter_nodes(eqs, parameters or {}, kept)
    nodes = [
        names.expression(Formula.from_value(value, where=name), name).index
        for name, value in formulas.items()
    ]
    made = substitute(graph, nodes, replacements)
    roots = [Roots(name, (), (node,)) for name, node in zip(formulas, made, strict=True)]
    signature = Signature((), (), (), kept)
    return build_sequence(graph, roots, input_places(eqs, signature, graph)), signature


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
    replacements = parameter_nodes(eqs, parameters or {}, ())
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
