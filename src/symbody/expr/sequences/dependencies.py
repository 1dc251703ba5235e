"""Which arguments results of a sequence depend on."""

from __future__ import annotations

from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Sequence

Symbols = frozenset[tuple[str, int]]


def dependencies(sequence: Sequence) -> tuple[Symbols, ...]:
    """Return which arguments, as (group, position), each result depends on, in the order of the results."""
    read: list[Symbols] = []
    for code, operands, datum in sequence.operations:
        if code == op.SYMBOL:
            source = sequence.inputs[datum]
            read.append(frozenset([(source.group, source.position)]))
        else:
            read.append(frozenset().union(*(read[k] for k in operands)))
    return tuple(read[k] for output in sequence.outputs for k in output.values)
