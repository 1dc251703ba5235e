"""`Table`: a function of time given by points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from symbody.arguments import checked_fields
from symbody.errors import Problem, UsageError

Floats = NDArray[np.float64]

# Tables of more points are read by Python: as formulas every evaluation would compute every piece.
MOST_IN_FORMULAS: Final = 64


@checked_fields
@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A function of time through given points.

    Attributes
    ----------
    t, values : (N,) arrays
        Times that increase [s], and the values there; at least two.
    kind : "linear" or "cubic"
        Straight between points, or a spline with continuous curvature (not-a-knot ends).
    outside : "hold" or "error"
        Before the first and after the last time: the first and the last value, or a refusal to simulate
        beyond them.

    Raises
    ------
    UsageError
        If times repeat or fall, shapes differ, or numbers are not finite.
    """

    t: ArrayLike
    values: ArrayLike
    kind: Literal["linear", "cubic"] = "linear"
    outside: Literal["hold", "error"] = "hold"

    def __post_init__(self) -> None:
        times, values = _numbers("times", self.t), _numbers("values", self.values)
        if times.ndim != 1 or times.shape != values.shape or times.size < 2:
            what = f"times have shape {times.shape}, values {values.shape}"
            raise _wrong(what, "give two lists of the same length, with two points or more")
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise _wrong("a time or value is not finite", "leave such points out")
        steps = np.diff(times)
        if (steps <= 0.0).any():
            k = int(np.argmax(steps <= 0.0))
            word = "stands there twice" if steps[k] == 0.0 else f"is followed by {times[k + 1]:g}"
            fix = "sort the times, each only once; a jump needs two times that differ a little"
            raise _wrong(f"time {times[k]:g} {word}", fix)
        if self.kind not in ("linear", "cubic") or self.outside not in ("hold", "error"):
            what = f"kind = {self.kind!r}, outside = {self.outside!r} mean nothing"
            raise _wrong(what, "kind is 'linear' or 'cubic', outside is 'hold' or 'error'")
        object.__setattr__(self, "t", times)
        object.__setattr__(self, "values", values)

    @property
    def is_short(self) -> bool:
        """Whether it is made part of the equations."""
        return np.size(self.t) <= MOST_IN_FORMULAS

    def check_span(self, name: str, start: float, end: float) -> None:
        """Refuse a run that leaves a table which must not be left.

        Raises
        ------
        UsageError
            Naming the input.
        """
        first, last = float(np.min(self.t)), float(np.max(self.t))
        if self.outside == "error" and not (first <= min(start, end) and max(start, end) <= last):
            raise UsageError(
                Problem("simulation.table_range", f"input {name}",
                        f"the table covers {first:g} to {last:g} s, the motion {start:g} to {end:g} s",
                        "outside='error' refuses to guess",
                        "extend the table, shorten the motion, or write outside='hold'")
            )  # fmt: skip

    def formula(self) -> str:
        """Return the table as an expression in t: pieces chosen by halving."""
        times, pieces = np.asarray(self.t), self._pieces()
        x = f"min(max(t, {_text(times[0])}), {_text(times[-1])})"
        texts = [_piece(x, float(start), row) for start, row in zip(times, pieces, strict=False)]
        bounds = [float(time) for time in times[1:-1]]
        while len(texts) > 1:  # pairs of neighbours, then pairs of pairs
            pairs = zip(texts[::2], bounds[::2], texts[1::2], strict=False)
            joined = [f"if(t < {_text(bound)}, {left}, {right})" for left, bound, right in pairs]
            texts = joined + texts[len(texts) - len(texts) % 2 :]
            bounds = bounds[1::2]
        return texts[0]

    def reader(self) -> Callable[[float, Floats, Floats], float]:
        """Return the table as a function of t, q, u."""
        times, pieces = np.asarray(self.t), self._pieces()
        first, last = float(times[0]), float(times[-1])

        def read(t: float, q: Floats, u: Floats) -> float:
            x = min(max(t, first), last)
            k = min(int(np.searchsorted(times, x, side="right")) - 1, len(pieces) - 1)
            value = 0.0
            for coefficient in pieces[k][::-1]:
                value = value * (x - times[k]) + coefficient
            return float(value)

        return read

    def _pieces(self) -> Floats:
        """Return the polynomial of each piece in the time since its start, lowest power first."""
        times, values = np.asarray(self.t), np.asarray(self.values)
        if self.kind == "linear":
            return np.stack([values[:-1], np.diff(values) / np.diff(times)], axis=1)
        return np.asarray(CubicSpline(times, values).c[::-1].T, dtype=np.float64)


def _piece(x: str, start: float, coefficients: Floats) -> str:
    text = _text(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        text = f"({_text(coefficient)} + ({x} - {_text(start)})*{text})"
    return text


def _text(value: float) -> str:
    return f"({float(value)!r})"


def _numbers(what: str, given: ArrayLike) -> Floats:
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise _wrong(f"{what} are not numbers", "give lists of numbers") from error


def _wrong(what: str, fix: str) -> UsageError:
    return UsageError(Problem("simulation.table", "Table", what, fix=fix))
