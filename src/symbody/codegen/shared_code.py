"""`SharedCode`: machine code of a sequence, in two parts, for any values of the parameters.

What parameters alone determine is computed once a set of values, into the numbers c; the code that is called
again and again reads c, and no parameter. Functions with different values of parameters share it.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.native_call import GROUPS, NativeCall
from symbody.codegen.portable_text import portable_sequence
from symbody.expr.deadline import begin
from symbody.expr.opcodes import DIV, POW, SYMBOL
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.sequence import Sequence
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Places = NDArray[np.intp]
_MOST_NOTES: Final = 16
_NOTHING: Final = np.zeros(0)


class SharedCode:
    """Machine code of a sequence.

    Parameters
    ----------
    sequence : Sequence
        What is computed.
    quick : bool
        Compile in less than half the time for calls that take 1.5 to 3 times as long.
    lanes : bool or None
        Whether batches are computed several points at once; see `NativeCall`.
    portable : bool
        Whether no operation is fused; then `portable_text` has the same bits.

    Attributes
    ----------
    head : NativeCall or None
        Computes c from the parameters; None where nothing depends on them.
    tail : NativeCall
        Computes the outputs from t, q, u, r and c.
    divisors : (n,) array of int
        Places of c by which the outputs are divided as they stand.
    notes : SingleFlight
        What others have learned from the sequence.
    """

    __slots__ = ("divisors", "head", "lanes", "notes", "portable", "quick", "sequence", "tail")

    def __init__(
        self,
        sequence: Sequence,
        *,
        quick: bool = False,
        lanes: bool | None = None,
        portable: bool = False,
    ) -> None:
        self.sequence = sequence
        self.quick = quick
        self.lanes = lanes
        self.portable = portable
        self.notes: SingleFlight[Hashable, Any] = SingleFlight(_MOST_NOTES)
        begin("constants")
        folded = portable_sequence(sequence) if portable else fold_constants(sequence)
        head, tail = folded.split("p")
        self.head = NativeCall(head, quick=True, portable=portable) if head.output_size else None
        self.tail = NativeCall(tail, quick=quick, lanes=lanes, portable=portable)
        self.divisors = _divisors(tail)

    @property
    def constant_count(self) -> int:
        """How many numbers c are."""
        return 0 if self.head is None else self.head.output_size

    def constants(self, p: Floats) -> Floats:
        """Return c (..., n_c) for parameters (..., n_p).

        Raises
        ------
        SimulationError
            If equations in parameters alone have no solution.
        """
        if self.head is None:
            return _NOTHING
        if p.ndim == 1:
            return self.head.at_point(p=p)
        given = {group: _NOTHING for group in GROUPS} | {"p": p}
        return self.head(given, p.shape[:-1])


def _divisors(tail: Sequence) -> Places:
    """Return the places of c that stand below a fraction line, or have a negative exponent."""
    places = {
        k: tail.inputs[operation.datum].position
        for k, operation in enumerate(tail.operations)
        if operation.op == SYMBOL and tail.inputs[operation.datum].group == "c"
    }
    below = {operation.operands[1] for operation in tail.operations if operation.op == DIV}
    for operation in tail.operations:
        exponent = tail.constant_value(operation.operands[1]) if operation.op == POW else None
        if exponent is not None and exponent < 0:
            below.add(operation.operands[0])
    return np.array(sorted(places[k] for k in below & places.keys()), dtype=np.intp)
