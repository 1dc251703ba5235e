"""Where derivatives do not exist: absolute values, signs and branches that change over at the very state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.expr.canonical import sub
from symbody.expr.opcodes import ABS, EQ, LE, LT, MAX, MIN, NAMES, SIGN
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import symbols_of
from symbody.tolerances import ASSEMBLED

Switch = tuple[str, int]


def switches(eqs: EquationSet, nodes: Sequence[int]) -> tuple[Switch, ...]:
    """Return what has another derivative on either side, with the node that is zero between both."""
    first: dict[int, str] = {}
    for what, node in _switches(eqs, nodes):
        first.setdefault(node, what)
    return tuple((what, node) for node, what in first.items())


def _switches(eqs: EquationSet, nodes: Sequence[int]) -> Iterator[Switch]:
    for law in eqs.formed.friction:
        if law.switches:
            yield f"the friction of joint {law.joint.name}", law.rate.index
    graph = eqs.formed.graph
    for node in graph.reachable(nodes):
        op, a, b = graph.ops[node], graph.left[node], graph.right[node]
        if op in (ABS, SIGN) and symbols_of(graph, [a]):
            yield NAMES[op], a
        elif op in (MIN, MAX, LT, LE, EQ) and symbols_of(graph, [a, b]):
            yield NAMES[op], sub(graph, a, b)


def kink_notes(
    eqs: EquationSet,
    listed: Sequence[Switch],
    values: NDArray[np.float64],
    beside: NDArray[np.float64],
) -> tuple[str, ...]:
    """Return what should be known of derivatives at a state, where switches have `values`.

    `beside` are their values at a state as far away as the mechanism is large.
    """
    changes = np.abs(np.asarray(beside) - values)
    is_zero = np.abs(values) <= ASSEMBLED * np.where(np.isfinite(changes), changes, 1.0)
    here = [switch for switch, yes in zip(listed, is_zero, strict=True) if yes]
    return tuple(
        f"{what} changes over at this state, where {to_text(eqs.formed.graph, node)} = 0: the matrices hold "
        "on one side of it at most; a smooth law, such as friction with v0, holds on both"
        for what, node in here
    )
