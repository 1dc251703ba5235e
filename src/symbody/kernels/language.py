"""The words of the kernel language beside arithmetic, as Python runs them.

``abs``, ``min`` and ``max`` are Python's own: ``min(a, b)`` is b if ``b < a``, else a. Everything works for
floats and for numbers of `mpmath`, which know their own square root.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from typing import Any, Final, Protocol, Self

NAN: Final = math.nan
INFINITY: Final = math.inf
LARGEST_EXPONENT: Final = 1022  # so that powers of two and their inverses are normal numbers


class _HasSquareRoot(Protocol):
    def sqrt(self) -> float: ...


class Reals:
    """An array of reals, or the part of one that begins at an offset: a view, never a copy."""

    __slots__ = ("entries", "offset")

    def __init__(self, storage: Sequence[float], offset: int = 0) -> None:
        self.entries: Any = storage if isinstance(storage, list) else list(storage)
        self.offset = offset

    @classmethod
    def zeros(cls, size: int) -> Self:
        """Return an array of zeros."""
        return cls([0.0] * size)

    def __getitem__(self, index: int) -> float:
        entry: float = self.entries[self.offset + index]
        return entry

    def __setitem__(self, index: int, value: float) -> None:
        self.entries[self.offset + index] = value

    def shift(self, offset: int) -> Reals:
        """Return the part that begins `offset` entries further on."""
        return Reals(self.entries, self.offset + offset)


# A function of generated code: t, q, u, r, p, c, out, work to a status, 0 if all went well.
Function = Callable[[Reals, Reals, Reals, Reals, Reals, Reals, Reals, Reals], int]


def part(array: Reals, offset: int, size: int) -> Reals:  # noqa: ARG001
    """Return `size` entries of an array from `offset` on; no other entry of it may be used."""
    return array.shift(offset)


# How many lanes a register has; what is made for a processor follows its own.
LANES: Final = 4


class Lanes:
    """As many reals as a register holds; a comparison gives the truth of each lane."""

    __slots__ = ("values",)

    def __init__(self, values: Sequence[float]) -> None:
        self.values = tuple(values)

    def _each(self, operation: Callable[[float, float], float], other: Lanes | float) -> Lanes:
        others = other.values if isinstance(other, Lanes) else [other] * len(self.values)
        return Lanes([operation(a, b) for a, b in zip(self.values, others, strict=True)])

    def __add__(self, other: Lanes | float) -> Lanes:
        return self._each(operator.add, other)

    def __sub__(self, other: Lanes | float) -> Lanes:
        return self._each(operator.sub, other)

    def __mul__(self, other: Lanes | float) -> Lanes:
        return self._each(operator.mul, other)

    def __rmul__(self, other: float) -> Lanes:
        return self._each(operator.mul, other)

    def __truediv__(self, other: Lanes | float) -> Lanes:
        return self._each(operator.truediv, other)

    def __rtruediv__(self, other: float) -> Lanes:
        return spread(other) / self

    def __abs__(self) -> Lanes:
        return Lanes([abs(a) for a in self.values])

    def __lt__(self, other: Lanes | float) -> tuple[bool, ...]:
        return self._compare(operator.lt, other)

    def __gt__(self, other: Lanes | float) -> tuple[bool, ...]:
        return self._compare(operator.gt, other)

    def _compare(self, test: Callable[[float, float], bool], other: Lanes | float) -> tuple[bool, ...]:
        others = other.values if isinstance(other, Lanes) else [other] * len(self.values)
        return tuple(test(a, b) for a, b in zip(self.values, others, strict=True))


def spread(x: float) -> Lanes:
    """Return a real in every lane."""
    return Lanes([x] * LANES)


def take(array: Reals, place: int) -> Lanes:
    """Return the entries of an array from a place on, one for each lane."""
    return Lanes([array[place + lane] for lane in range(LANES)])


def put(array: Reals, place: int, values: Lanes) -> None:
    """Store the entries of all lanes from a place of an array on."""
    for lane in range(LANES):
        array[place + lane] = values.values[lane]


def where(mask: tuple[bool, ...], a: Lanes, b: Lanes) -> Lanes:
    """Return the lanes of a where the mask is true, and those of b elsewhere."""
    return Lanes([x if is_so else y for is_so, x, y in zip(mask, a.values, b.values, strict=True)])


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
