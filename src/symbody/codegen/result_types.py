"""Named tuples of several outputs."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from symbody.expr.sequence import Sequence


def result_type(sequence: Sequence) -> Callable[..., Any] | None:
    """Return a named tuple class, or None for a single output; expressions get the names _0, _1, ..."""
    if len(sequence.outputs) == 1:
        return None
    return _named_tuple(tuple(output.name for output in sequence.outputs))


@lru_cache(maxsize=256)
def _named_tuple(names: tuple[str, ...]) -> Callable[..., Any]:
    """Return the class for these names: Python compiles each new one. Two threads may make one each."""
    return namedtuple("Outputs", names, rename=True)
