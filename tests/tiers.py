"""Cases of a test by tier."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def cases(values: Iterable[Any], fast: Callable[[Any], bool] | Iterable[Any]) -> list[Any]:
    """Return the values of a parameter, of which all but the fast ones are left to the exhaustive tier."""
    chosen = None if callable(fast) else list(fast)
    is_fast = fast if callable(fast) else lambda value: value in (chosen or ())
    return [
        value if is_fast(value) else pytest.param(value, marks=pytest.mark.exhaustive) for value in values
    ]
