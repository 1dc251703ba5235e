"""Formulas that read what no equations give: work, and outputs that only the file of a motion holds."""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.codegen.signature import Signature
from symbody.equations.outputs.output_roots import OF_MOTIONS
from symbody.errors import ExpressionError, Problem, UsageError
from symbody.expr.graph import TIME, Graph, Symbol, SymbolKind
from symbody.expr.language.formula import Formula, build
from symbody.expr.sequences.sequence import Input, Roots, build_sequence

Floats = NDArray[np.float64]


def formula_of_samples(text: str, stored: Collection[str]) -> Formula | None:
    """Return a formula that has to be computed from samples: in quotes it reads work, or what is stored."""
    if "'" not in text:
        return None
    try:
        formula = Formula.from_value(text, has_outputs=True)
    except ExpressionError:  # the equations say what is wrong with it
        return None
    read = {*formula.outputs}
    return formula if read & {*OF_MOTIONS} or (read and read <= {*stored}) else None


def evaluate_samples(
    formula: Formula, values: Callable[[str], Floats], t: Floats, shape: tuple[int, ...]
) -> Floats:
    """Return a formula's value at each sample.

    Parameters
    ----------
    values : callable
        Takes a name or an output, returns its samples.
    t : array
        Times, the last axis of the result.
    shape : tuple of int
        Of the result, to which all samples are broadcast.

    Raises
    ------
    UsageError
        If what it reads is not a number at each sample.
    """
    graph, columns = Graph(), dict[str, Floats]()

    def look_up(name: str, column: int) -> int:
        if name == "pi":
            return graph.pi()
        columns[name] = np.asarray(t if name == "t" else values(name), dtype=np.float64)
        if not _fits(columns[name].shape, shape):
            raise _not_a_number(formula, name, columns[name])
        return graph.symbol(Symbol(name, SymbolKind.INPUT))

    node = build(formula, graph, look_up)
    names = tuple(columns)
    places = {
        graph.symbol(Symbol(name, SymbolKind.INPUT)): Input(name, "r", k) for k, name in enumerate(names)
    }
    places[graph.symbol(TIME)] = Input("t", "t", 0)
    sequence = build_sequence(graph, [Roots("formula", (), (node,))], places)
    function = CompiledFunction(sequence, Signature((), (), names, ()), quick=True)
    r = np.stack([np.broadcast_to(column, shape) for column in columns.values()], axis=-1)
    nothing = np.zeros((*shape, 0))
    found: Floats = np.asarray(function(np.broadcast_to(t, shape), nothing, nothing, r), dtype=np.float64)
    return found


def _fits(inner: tuple[int, ...], outer: tuple[int, ...]) -> bool:
    sizes = zip(reversed(inner), reversed(outer), strict=False)
    return len(inner) <= len(outer) and all(size in (1, whole) for size, whole in sizes)


def _not_a_number(formula: Formula, name: str, values: Floats) -> UsageError:
    what = f"{name!r} is not a number: its samples have shape {values.shape}"
    fix = "name one component, such as 'reaction A Fx'"
    return UsageError(Problem("trajectory.formula", formula.text, what, fix=fix))
