"""Values of formulas in parameters: as sequences, and as numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from collections.abc import Sequence as Items

from symbody.codegen.formation.formula_values import FormulaValues
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.formation.sequences import input_places, parameter_nodes
from symbody.codegen.function import Signature
from symbody.equations.equation_set import EquationSet
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import substitute
from symbody.expr.sequence import Roots, Sequence, build_sequence


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
    CompileError, ExpressionError
        If a parameter has no value, a formula reads something else than parameters, or divides by zero.
    """
    if all(
        type(value) is int or (type(value) is float and math.isfinite(value)) for value in formulas.values()
    ):
        return {name: float(value) for name, value in formulas.items()}  # type: ignore[arg-type]
    read = [Formula.from_value(value, where=name) for name, value in formulas.items()]
    key = "values", tuple([formula.text for formula in read])
    values: FormulaValues = eqs.plans.get(key, lambda: FormulaValues(eqs, read))
    numbers = dict(zip(formulas, values.numbers(parameter_set(eqs, parameters).floats), strict=True))
    if not all(map(math.isfinite, numbers.values())):
        _check_exactly(eqs, read, parameters or {})
    return numbers


def _check_exactly(eqs: EquationSet, formulas: Items[Formula], parameters: Mapping[str, Value]) -> None:
    """Refuse formulas that divide by zero, naming the operation."""
    names, replacements = eqs.formed.names, parameter_nodes(eqs, parameters, ())
    nodes = [names.expression(formula, formula.text).index for formula in formulas]
    substitute(eqs.formed.graph, nodes, replacements)
