"""Values of formulas in parameters: as sequences, and as numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from collections.abc import Sequence as Items
from dataclasses import replace

import numpy as np

from symbody.codegen.formation.formula_values import FormulaValues
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.formation.sequences import input_places, parameter_nodes
from symbody.codegen.function import CompiledFunction
from symbody.codegen.shared_code import SharedCode
from symbody.codegen.signature import Signature
from symbody.equations.equation_set import EquationSet
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import substitute
from symbody.expr.sequences.sequence import Roots, build_sequence
from symbody.model.declarations.arguments import plain_value
from symbody.model.numbers import as_float


def formula_function(
    eqs: EquationSet,
    formulas: Mapping[str, Value],
    parameters: Mapping[str, Value] | None = None,
    free: Iterable[str] = (),
) -> CompiledFunction:
    """Return formulas in parameters and t as a function ``f(t, (), (), (), p)`` of the `free` ones.

    Raises
    ------
    CompileError
        If a parameter has no value, or a name is unknown.
    ExpressionError
        If a formula reads something else than parameters.
    """
    chosen = parameter_set(eqs, parameters, tuple(free))
    read = [Formula.from_value(plain_value(value), where=name) for name, value in formulas.items()]
    signature = Signature((), (), (), (*chosen.free, *chosen.numbers))

    def compile_formulas() -> SharedCode:
        graph, names = eqs.formed.graph, eqs.formed.names
        nodes = [names.expression(formula, name).index for formula, name in zip(read, formulas, strict=True)]
        replaced = substitute(graph, nodes, chosen.replacements())
        roots = [Roots(name, (), (node,)) for name, node in zip(formulas, replaced, strict=True)]
        places = input_places(eqs, signature, graph)
        return SharedCode(build_sequence(graph, roots, places), quick=True)

    key = "formulas", tuple([formula.text for formula in read]), tuple(formulas), chosen.pattern
    code: SharedCode = eqs.plans.get(key, compile_formulas)
    values = np.array([as_float(chosen.values[name]) for name in chosen.numbers])
    return CompiledFunction.from_code(code, replace(signature, p=chosen.free), values)


def constant_values(
    eqs: EquationSet, formulas: Mapping[str, Value], parameters: Mapping[str, Value] | None = None
) -> dict[str, float]:
    """Return the values of formulas in parameters.

    Raises
    ------
    CompileError, ExpressionError
        If a parameter has no value, a formula reads something else than parameters, or divides by zero.
    """
    plain = {
        name: float(value)
        for name, value in formulas.items()
        if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    }
    if len(plain) == len(formulas):
        return plain
    read = {
        name: Formula.from_value(value, where=name) for name, value in formulas.items() if name not in plain
    }
    key = "values", tuple([formula.text for formula in read.values()])
    values: FormulaValues = eqs.plans.get(key, lambda: FormulaValues(eqs, read.values()))
    computed = dict(zip(read, values.numbers(parameter_set(eqs, parameters).floats), strict=True))
    numbers = {name: computed[name] if name in read else plain[name] for name in formulas}
    if not all(map(math.isfinite, numbers.values())):
        _check_exactly(eqs, [*read.values()], parameters or {})
    return numbers


def _check_exactly(eqs: EquationSet, formulas: Items[Formula], parameters: Mapping[str, Value]) -> None:
    """Refuse formulas that divide by zero, naming the operation."""
    names, replacements = eqs.formed.names, parameter_nodes(eqs, parameters, ())
    nodes = [names.expression(formula, formula.text).index for formula in formulas]
    substitute(eqs.formed.graph, nodes, replacements)
