"""Cases of a test by tier."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def cases(values: Iterable[Any], fast: Callable[[Any], bool] | Iterable[Any]) -> list[Any]:
    """Return the values of a parameter, of which all but the fast ones are left to the exhaustive tier."""
    return rows(((value,) for value in values), fast if callable(fast) else [(value,) for value in fast])


def rows(
    values: Iterable[tuple[Any, ...]], fast: Callable[..., bool] | Iterable[tuple[Any, ...]]
) -> list[Any]:
    """Return the values of several parameters in the same way."""
    chosen = None if callable(fast) else list(fast)
    return [
        pytest.param(*value, marks=[] if is_fast else [pytest.mark.exhaustive])
        for value in values
        for is_fast in [fast(*value) if callable(fast) else value in (chosen or ())]
    ]
