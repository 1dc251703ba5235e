"""Values of parameters that may be formulas of each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from symbody.errors import ExpressionError, ModelError, Problem, nearest
from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.numbers import formula_value

Parameters = Mapping[str, Formula | None]

_MAX_CYCLES: Final = 10


def dependence_order(parameters: Parameters) -> tuple[str, ...]:
    """Return the names, each after those its formula contains; a ModelError shows the path of each circle."""
    order, cycles = _walk(parameters)
    if cycles:
        raise ModelError(*(_cycle_problem(cycle) for cycle in cycles))
    return tuple(order)


def cycle_problems(parameters: Parameters) -> list[Problem]:
    """Return a problem for each circle of formulas."""
    return [_cycle_problem(cycle) for cycle in _walk(parameters)[1]]


def parameter_values(parameters: Parameters) -> tuple[dict[str, Constant], list[Problem]]:
    """Return the values of all parameters that have one, and what is wrong with the others' formulas.

    Exact where the formula is folded exactly, a float otherwise (pi, sin and the like). The
    formulas must not depend on each other in a circle.
    """
    values: dict[str, Constant] = {}
    problems: list[Problem] = []
    for name in _walk(parameters)[0]:
        formula = parameters[name]
        if formula is None:
            continue
        try:
            value = formula_value(formula, values)
        except ExpressionError as error:
            problems.extend(_parameter_problem(name, problem) for problem in error.problems)
            continue
        if value is None:
            continue
        if isinstance(value, float) and not math.isfinite(value):
            what = f"{name} = {formula} is {value}"
            why = "a function has no real value there, or the result is too large"
            fix = "change the formula or the values it uses"
            problems.append(Problem("parameters.not_finite", f"model, parameters.{name}", what, why, fix))
        else:
            values[name] = value
    return values, problems


def resolve(parameters: Parameters, overrides: Mapping[str, Value]) -> dict[str, Constant]:
    """Return the value of every parameter; what depends on an overridden one follows it.

    A ModelError lists all unknown names, all faulty formulas, or all parameters without value.
    """
    arguments = Arguments("parameters")
    changed: dict[str, Formula | None] = dict(parameters)
    for name, value in overrides.items():
        if name in parameters:
            changed[name] = arguments.formula(value, name)
        else:
            what = f"the model has no parameter {name!r}"
            arguments.add("parameters.unknown", name, what, "", nearest(name, parameters))
    for name, formula in changed.items():
        for word in () if formula is None else formula.names:
            if word != "pi" and word not in changed:
                what = f"{formula} contains {word!r}, which is not a parameter"
                arguments.add("names.unknown", name, what, "", nearest(word, changed))
    arguments.raise_all()
    order = dependence_order(changed)
    values, problems = parameter_values(changed)
    if problems:
        raise ModelError(*problems)
    missing = [name for name in order if changed[name] is None]
    if missing:
        what = f"no value is given for {', '.join(missing)}"
        why = "they are declared without one"
        fix = "give values in the model, or parameters={name: value}"
        raise ModelError(Problem("parameters.missing", "parameters", what, why, fix))
    return {name: values[name] for name in parameters}


def _walk(parameters: Parameters) -> tuple[list[str], list[list[str]]]:
    """Return the names in an order of dependence, and the circles met on the way."""
    order: list[str] = []
    cycles: list[list[str]] = []
    done: set[str] = set()
    for root in parameters:
        path: dict[str, list[str]] = {} if root in done else {root: _dependencies(parameters, root)}
        while path:
            name, needed = next(reversed(path.items()))
            if not needed:
                path.popitem()
                done.add(name)
                order.append(name)
                continue
            word = needed.pop(0)
            if word in path:
                if len(cycles) < _MAX_CYCLES:
                    names = list(path)
                    cycles.append([*names[names.index(word) :], word])
            elif word not in done:
                path[word] = _dependencies(parameters, word)
    return order, cycles


def _dependencies(parameters: Parameters, name: str) -> list[str]:
    formula = parameters[name]
    return [] if formula is None else [word for word in formula.names if word in parameters]


def _cycle_problem(cycle: list[str]) -> Problem:
    what = "parameters depend on each other in a cycle: " + " -> ".join(cycle)
    why = "each needs the value of the next"
    fix = "give one of them as a number"
    return Problem("parameters.cycle", f"model, parameters.{cycle[0]}", what, why, fix)


def _parameter_problem(name: str, problem: Problem) -> Problem:
    where = f"model, parameters.{name}"
    return Problem(
        problem.code,
        f"{where}, {problem.where}" if problem.where else where,
        problem.what,
        problem.why,
        problem.fix,
    )
