"""Values of formulas in parameters: as sequences, and as numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import ParameterSet
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


class FormulaValues:
    """Formulas in parameters and t; ``numbers(parameters)`` gives their values at t = 0.

    Parameters
    ----------
    formulas : iterable of number or formula

    Raises
    ------
    ExpressionError
        If a formula reads something else than parameters and time.
    """

    def __init__(self, eqs: EquationSet, formulas: Iterable[Value]) -> None:
        read = [Formula.from_value(value) for value in formulas]
        plain = [formula.constant() for formula in read]
        self._numbers = [0.0 if number is None else as_float(number) for number in plain]
        self._places = [k for k, number in enumerate(plain) if number is None]
        self._names = tuple(eqs.model.parameters)
        self._sequence = None
        if self._places:
            graph, names = eqs.formed.graph, eqs.formed.names
            nodes = tuple(names.expression(read[k], read[k].text).index for k in self._places)
            signature = Signature((), (), (), self._names)
            places = input_places(eqs, signature, graph)
            self._sequence = build_sequence(graph, [Roots("values", (len(nodes),), nodes)], places)

    def numbers(self, parameters: ParameterSet) -> list[float]:
        """Return the value of each formula."""
        if self._sequence is None:
            return self._numbers
        known = parameters.floats
        given = {"t": [0.0], "p": [known[name] for name in self._names]}
        result = list(self._numbers)
        for k, value in zip(self._places, evaluate_sequence(self._sequence, given)[0], strict=True):
            result[k] = float(value)
        return result


def constant_values(
    eqs: EquationSet, formulas: Mapping[str, Value], parameters: Mapping[str, Value] | None = None
) -> dict[str, float]:
    """Return the values of formulas in parameters.

    Raises
    ------
    CompileError
        If a parameter has no value, or a formula reads something else than parameters.
    """
    plain = {name: value for name, value in formulas.items() if type(value) is float or type(value) is int}
    if len(plain) == len(formulas) and all(map(math.isfinite, plain.values())):
        return {name: float(value) for name, value in plain.items()}
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
