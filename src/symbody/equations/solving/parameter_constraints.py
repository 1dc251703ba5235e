"""Constraints on parameters alone, such as ``L - 2 = 0``, which only values can fulfil."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.graph import SymbolKind
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import dependence, symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.tolerances import TYPED


def check_parameter_constraints(formed: EquationsOfMotion, parameters: Mapping[str, float]) -> None:
    """Refuse values of parameters that a constraint on parameters alone, or a substituted coupling excludes.

    Parameters
    ----------
    parameters : mapping of name to number
        A constraint with others is not judged.

    Raises
    ------
    FormulationError
        With each such constraint and its value, or the factor that is 0.
    """
    graph, own = formed.graph, {part.name for part in formed.topology.model.constraints}
    rows = [row for row in formed.holonomic if row.element in own and not row.value.is_zero]
    kinds = dependence(graph, [row.value.index for row in rows])
    problems = list(_pivot_problems(formed, parameters))
    for row in rows:
        if kinds[row.value.index] != {SymbolKind.PARAMETER}:
            continue
        known = _named_values(row.value, parameters)
        value = None if known is None else _evaluate(formed, row.value, known)
        if known is None or value is None or abs(value) <= TYPED * max(map(abs, known.values())):
            continue
        problems.append(
            Problem("equations.never_closed", f"constraint {row.element}",
                    f"its equation {row.name}, {to_text(graph, row.value.index)} = 0, has the left-hand "
                    f"side {value:g} with {_list_values(known)}", "nothing in it can move",
                    "give other values, or leave the constraint out")
        )  # fmt: skip
    if problems:
        raise FormulationError(*problems)


def _pivot_problems(formed: EquationsOfMotion, parameters: Mapping[str, float]) -> Iterator[Problem]:
    """Return a problem for each substituted coordinate whose factor in its coupling is 0."""
    for coordinate, factor in formed.coupled.divisors.items():
        known = _named_values(factor, parameters)
        if known and _evaluate(formed, factor, known) == 0:
            listed = ", ".join(formed.coupled.combinations[coordinate])
            yield Problem(
                "equations.vanishing_factor", f"coordinate {coordinate}",
                f"its factor {to_text(formed.graph, factor.index)} in {listed} is 0 with "
                f"{_list_values(known)}",
                f"the coupling was solved for {coordinate}, but does not determine it with these values",
                "give other values, or form the equations without substitute=True",
            )  # fmt: skip


def _named_values(expression: Expr, parameters: Mapping[str, float]) -> dict[str, float] | None:
    """Return the values of the parameters in an expression, or None if one is not given."""
    graph = expression.graph
    names = [graph.symbols[graph.left[node]].name for node in symbols_of(graph, [expression.index])]
    return {name: parameters[name] for name in names} if all(name in parameters for name in names) else None


def _evaluate(formed: EquationsOfMotion, expression: Expr, known: Mapping[str, float]) -> float:
    places = {formed.names.value(name).index: Input(name, "p", k) for k, name in enumerate(known)}
    program = build_sequence(formed.graph, [Roots("value", (), (expression.index,))], places)
    return float(evaluate_sequence(program, {"p": list(known.values())})[0][0])


def _list_values(known: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {x:g}" for name, x in known.items())
