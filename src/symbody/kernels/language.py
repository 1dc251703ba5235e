"""The words of the kernel language beside arithmetic, as Python runs them.

``abs``, ``min`` and ``max`` are Python's own: ``min(a, b)`` is b if ``b < a``, else a. Everything works for
floats and for numbers of `mpmath`, which know their own square root.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, Protocol, Self

NAN: Final = math.nan
INFINITY: Final = math.inf
LARGEST_EXPONENT: Final = 1022  # so that powers of two and their inverses are normal numbers


class _HasSquareRoot(Protocol):
    def sqrt(self) -> float: ...


class Reals:
    """An array of reals, or the part of one that begins at an offset: a view, never a copy."""

    __slots__ = ("_offset", "_storage")

    def __init__(self, storage: Sequence[float], offset: int = 0) -> None:
        self._storage = storage if isinstance(storage, list) else list(storage)
        self._offset = offset

    @classmethod
    def zeros(cls, size: int) -> Self:
        """Return an array of zeros."""
        return cls([0.0] * size)

    def __getitem__(self, index: int) -> float:
        return self._storage[self._offset + index]

    def __setitem__(self, index: int, value: float) -> None:
        self._storage[self._offset + index] = value

    def shift(self, offset: int) -> Reals:
        """Return the part that begins `offset` entries further on."""
        return Reals(self._storage, self._offset + offset)


def part(array: Reals, offset: int, size: int) -> Reals:  # noqa: ARG001
    """Return `size` entries of an array from `offset` on; no other entry of it may be used."""
    return array.shift(offset)


def sqrt(x: float) -> float:
    """Return the square root, NaN for negative numbers."""
    if isinstance(x, float | int):
        return math.sqrt(x) if x >= 0.0 else NAN
    number: _HasSquareRoot = x
    return number.sqrt()


def is_finite(x: float) -> bool:
    """Return whether a number is neither infinite nor NaN."""
    return -INFINITY < x < INFINITY


def exponent(x: float) -> int:
    """Return e with 2^(e-1) <= x < 2^e, between -1022 and 1022; 0 unless 0 < x < infinity."""
    y = float(x)
    if not 0.0 < y < INFINITY:
        return 0
    return min(max(math.frexp(y)[1], -LARGEST_EXPONENT), LARGEST_EXPONENT)


def power_of_two(e: int) -> float:
    """Return 2^e for -1022 <= e <= 1022."""
    return math.ldexp(1.0, e)


def half(e: int) -> int:
    """Return half of an integer, rounded down."""
    return e >> 1
