"""Results of compiled functions: one array cut into outputs, and named tuples of several."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from collections.abc import Sequence as Items
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.signature import Signature
from symbody.expr.sequences.sequence import Output, Sequence

Floats = NDArray[np.float64]


def split_outputs(outputs: Items[Output], flat: Floats, batch: tuple[int, ...] = ()) -> list[Floats]:
    """Return outputs that lie one after the other on the last axis, each in its shape behind the batch."""
    results, start = [], 0
    for output in outputs:
        stop = start + len(output.values)
        part, shape = flat[..., start:stop], batch + output.shape
        results.append(part if part.shape == shape else part.reshape(shape))
        start = stop
    return results


class CallLayout(NamedTuple):
    """What all calls of a sequence have in common.

    Attributes
    ----------
    result : callable or None
        Makes the result of several outputs.
    reads_s : bool
        Whether states of signals are read.
    sizes : list of (group, count)
    """

    result: Callable[..., Any] | None
    reads_s: bool
    sizes: list[tuple[str, int]]


def call_layout(sequence: Sequence, signature: Signature) -> CallLayout:
    """Return what all calls of a sequence have in common."""
    n_q = len(signature.q)  # states of signals stand behind the coordinates
    reads_s = any(x.group == "q" and x.position >= n_q for x in sequence.inputs)
    sizes = (n_q + len(signature.s), *(len(signature.names(group)) for group in "urp"))
    return CallLayout(result_type(sequence), reads_s, list(zip("qurp", sizes, strict=True)))


def result_type(sequence: Sequence) -> Callable[..., Any] | None:
    """Return a named tuple class, or None for a single output; expressions get the names _0, _1, ..."""
    if len(sequence.outputs) == 1:
        return None
    return _named_tuple(tuple(output.name for output in sequence.outputs))


@lru_cache(maxsize=256)
def _named_tuple(names: tuple[str, ...]) -> Callable[..., Any]:
    """Return the class for these names: Python compiles each new one. Two threads may make one each."""
    return namedtuple("Outputs", names, rename=True)
