"""Results of compiled functions: one array cut into outputs, and named tuples of several."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from collections.abc import Sequence as Items
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.expr.sequence import Output, Sequence

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


def result_type(sequence: Sequence) -> Callable[..., Any] | None:
    """Return a named tuple class, or None for a single output; expressions get the names _0, _1, ..."""
    if len(sequence.outputs) == 1:
        return None
    return _named_tuple(tuple(output.name for output in sequence.outputs))


@lru_cache(maxsize=256)
def _named_tuple(names: tuple[str, ...]) -> Callable[..., Any]:
    """Return the class for these names: Python compiles each new one. Two threads may make one each."""
    return namedtuple("Outputs", names, rename=True)
