"""Constraints on parameters alone, such as ``L - 2 = 0``, which only values can fulfil."""

from __future__ import annotations

from collections.abc import Mapping

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.errors import FormulationError, Problem
from symbody.expr.evaluate import evaluate_sequence
from symbody.expr.graph import SymbolKind
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import dependence, symbols_of
from symbody.expr.sequence import Input, Roots, build_sequence
from symbody.tolerances import TYPED


def check_parameter_constraints(formed: EquationsOfMotion, parameters: Mapping[str, float]) -> None:
    """Refuse values of parameters that a constraint on parameters alone excludes.

    Parameters
    ----------
    parameters : mapping of name to number
        A constraint with others is not judged.

    Raises
    ------
    FormulationError
        With each such constraint and its value.
    """
    graph, own = formed.graph, {part.name for part in formed.topology.model.constraints}
    rows = [row for row in formed.holonomic if row.element in own and not row.value.is_zero]
    kinds = dependence(graph, [row.value.index for row in rows])
    problems = []
    for row in rows:
        if kinds[row.value.index] != {SymbolKind.PARAMETER}:
            continue
        names = [graph.symbols[graph.left[node]].name for node in symbols_of(graph, [row.value.index])]
        if not all(name in parameters for name in names):
            continue
        known = [parameters[name] for name in names]
        places = {formed.names.value(name).index: Input(name, "p", k) for k, name in enumerate(names)}
        program = build_sequence(graph, [Roots("value", (), (row.value.index,))], places)
        value = float(evaluate_sequence(program, {"p": known})[0][0])
        if not abs(value) <= TYPED * max(map(abs, known)):
            given = ", ".join(f"{name} = {x:g}" for name, x in zip(names, known, strict=True))
            problems.append(
                Problem("equations.never_closed", f"constraint {row.element}",
                        f"its equation {row.name}, {to_text(graph, row.value.index)} = 0, has the left-hand "
                        f"side {value:g} with {given}", "there is nothing in it that could move",
                        "give other values, or leave the constraint out")
            )  # fmt: skip
    if problems:
        raise FormulationError(*problems)
