"""Laws of inputs: formulas in time, states, parameters and outputs, as nodes of the graph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from graphlib import CycleError

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.output_roots import quoted_output, raw_output
from symbody.equations.outputs.signal_outputs import substitute_signals
from symbody.equations.solving.solution import substitute_solution
from symbody.errors import ExpressionError, FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.language.formula import Formula, FormulaLike
from symbody.expr.rewrite import substitute, symbols_of
from symbody.model.checks.signals import dependence_order
from symbody.model.output_names import kind_of


def input_formula(value: FormulaLike, name: str) -> Formula:
    """Return the law of an input as a formula.

    Outputs stand in single quotes, ``"-k*'length S'"``; the whole name of one needs none.
    Raises ExpressionError if it is not a formula.
    """
    where = f"input {name}"
    if isinstance(value, str) and kind_of(value) is not None and "'" not in value:
        try:
            return Formula.from_value(value, where=where, has_outputs=True)
        except ExpressionError:
            return Formula.from_value(f"'{value.strip()}'", where=where, has_outputs=True)
    return Formula.from_value(value, where=where, has_outputs=True)


def input_law_nodes(formed: EquationsOfMotion, laws: Mapping[str, FormulaLike]) -> dict[str, int]:
    """Return the node of each input's law, in which other laws stand in place of their inputs.

    Raises ExpressionError if a law reads what does not exist, FormulationError if it reads what follows from
    its own input, naming what it reads.
    """
    nodes = {name: _law_node(formed, input_formula(law, name), name) for name, law in laws.items()}
    read = {name: _inputs_read(formed, node, nodes) for name, node in nodes.items()}
    resolved: dict[str, int] = {}
    try:
        order = dependence_order(read)
    except CycleError as error:
        ring = error.args[1][:0:-1]  # each reads the next, and the last the first
        first = min(map([*laws].index, ring))
        ring = [*ring, *ring][ring.index([*laws][first]) :][: len(ring)]
        raise FormulationError(_ring_problem(formed, ring, laws)) from None
    for name in order:
        replacements = {formed.names.value(other).index: resolved[other] for other in read[name]}
        resolved[name] = (
            substitute(formed.graph, [nodes[name]], replacements)[0] if replacements else nodes[name]
        )
    return {name: resolved[name] for name in laws}


def _law_node(formed: EquationsOfMotion, formula: Formula, name: str) -> int:
    where = f"input {name}"
    is_name = len(formula.program) == 1 and formula.program[0].kind == "name"
    if is_name and formed.names.node(formula.text) is None:  # the whole name of an output, perhaps
        quoted = Formula.from_value(f"'{formula.text}'", where=where, has_outputs=True)
        try:
            value = formed.names.expression(quoted, where, outputs=quoted_output(formed, quoted, where))
            return _explicit(formed, value)
        except ExpressionError as error:
            if error.problems[0].what.startswith(f"{formula.text!r} is not a number"):
                raise
    value = formed.names.expression(formula, where, outputs=quoted_output(formed, formula, where))
    return _explicit(formed, value)


def _explicit(formed: EquationsOfMotion, value: Expr) -> int:
    """Return the node of an expression in t, q, u, s, inputs and parameters alone."""
    return substitute_solution(formed, substitute_signals(formed, [value], raw_output))[0].index


def _inputs_read(formed: EquationsOfMotion, node: int, among: Iterable[str]) -> tuple[str, ...]:
    graph = formed.graph
    symbols = {graph.symbols[graph.left[k]].name for k in symbols_of(graph, [node])}
    return tuple(name for name in among if name in symbols) if symbols else ()


def _ring_problem(formed: EquationsOfMotion, ring: list[str], laws: Mapping[str, FormulaLike]) -> Problem:
    name, following = ring[0], ring[1] if len(ring) > 1 else ring[0]
    formula = input_formula(laws[name], name)
    texts = {**{text: f"'{text}'" for text in formula.outputs}, **{text: text for text in formula.names}}
    reading = [
        text for text, law in texts.items()
        if following in _inputs_read(formed, _law_node(formed, input_formula(law, name), name), laws)
    ]  # fmt: skip
    what = f"its formula reads {', '.join(reading) or formula.text}, which follows from {following}"
    way = " -> ".join([*ring, name])
    return Problem(
        "equations.input_loop", f"input {name}", what,
        "accelerations, reactions and efforts are computed from the forces, so they do not exist before the "
        f"inputs have values: {way}",
        "read positions and speeds instead, or put a state in between, such as a signal with a rate (a "
        "first-order filter)",
    )  # fmt: skip
