"""Constant subexpressions of a sequence as numbers, for languages that would compute them each time."""

from __future__ import annotations

import math
from dataclasses import replace

from symbody.expr.graph import Constant
from symbody.expr.opcodes import FLOAT, SYMBOL
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Operation, Sequence


def fold_constants(sequence: Sequence) -> Sequence:
    """Return the sequence with what depends on no input evaluated once, in floats.

    Values that are not finite stay as they are.
    """
    head, tail = sequence.split(())
    if not head.output_size:
        return sequence
    values = evaluate_sequence(head, {})[0]
    if not all(math.isfinite(value) for value in values):
        return sequence
    constants: list[Constant] = list(tail.constants)
    operations: list[Operation] = []
    for operation in tail.operations:
        if operation.op == SYMBOL and tail.inputs[operation.datum].group == "c":
            constants.append(values[tail.inputs[operation.datum].position])
            operations.append(Operation(FLOAT, (), len(constants) - 1))
        else:
            operations.append(operation)
    # The inputs "c" stand last, so dropping them moves no other.
    inputs = tuple(entry for entry in tail.inputs if entry.group != "c")
    return replace(tail, inputs=inputs, constants=tuple(constants), operations=tuple(operations))
