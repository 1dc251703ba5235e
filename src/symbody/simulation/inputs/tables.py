"""`Table`: a function of time given by points."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from symbody.arguments import checked_fields
from symbody.errors import Problem, UsageError
from symbody.kernels.samples.sampling import ONE_INSTANT
from symbody.model.tables.csv_columns import read_points

Floats = NDArray[np.float64]

# Tables of more points are read as data: as formulas every evaluation would compute every piece.
MOST_IN_FORMULAS: Final = 64


@checked_fields
@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A function of time through given points.

    Attributes
    ----------
    t, values : (N,) arrays
        Times that increase [s], and the values there; at least two. A time given twice is a jump: from that
        instant on the later value holds.
    kind : "linear", "pchip" or "cubic"
        Straight between points; or between jumps cubics that are monotonic where the points are (Fritsch and
        Carlson), or a spline with continuous curvature (not-a-knot ends).
    outside : "hold" or "error"
        Before the first and after the last time: the first and the last value, or an error where a motion
        goes beyond them.

    Raises
    ------
    UsageError
        If a time is listed three times, times fall, shapes differ, or numbers are not finite.

    Examples
    --------
    >>> import symbody as sb
    >>> push = sb.Table(t=[0, 1, 1, 2], values=[0, 5, 0, 0])
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F"))
    >>> run = sb.simulate(sb.form_equations(sb.Model("cart", [rail], inputs=["F"])), 2.0, inputs={"F": push})
    >>> float(run["x_dot"][-1].round(6))
    1.25
    """

    t: ArrayLike
    values: ArrayLike
    kind: Literal["linear", "pchip", "cubic"] = "linear"
    outside: Literal["hold", "error"] = "hold"
    # Where each piece begins, and its polynomial in the time since, lowest power first. The first piece also
    # holds before it begins, and the last for ever.
    _starts: Floats = field(init=False, repr=False)
    _pieces: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        times, values = _numbers("times", self.t), _numbers("values", self.values)
        if times.ndim != 1 or times.shape != values.shape or times.size < 2:
            what = f"times have shape {times.shape}, values {values.shape}"
            raise _wrong(what, "give two lists of the same length, with two points or more")
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise _wrong("a time or value is not finite", "remove such points")
        _check_order(times)
        if self.kind not in ("linear", "pchip", "cubic") or self.outside not in ("hold", "error"):
            what = f"kind = {self.kind!r}, outside = {self.outside!r}: not a valid choice"
            raise _wrong(what, "kind is 'linear', 'pchip' or 'cubic', outside is 'hold' or 'error'")
        object.__setattr__(self, "t", times)
        object.__setattr__(self, "values", values)
        starts, pieces = _polynomials(times, values, self.kind)
        object.__setattr__(self, "_starts", starts)
        object.__setattr__(self, "_pieces", pieces)

    @classmethod
    def from_file(
        cls,
        path: str | os.PathLike[str],
        columns: Sequence[str | int] = (1, 2),
        units: Sequence[str] = ("", ""),
        kind: Literal["linear", "pchip", "cubic"] = "linear",
        outside: Literal["hold", "error"] = "hold",
    ) -> Table:
        """Return two columns of a CSV file as a function of time.

        Parameters
        ----------
        path : str or path
            Values separated by commas, semicolons or tabs, UTF-8; lines that begin with ``#`` are ignored.
        columns : (2,) str or int
            Of the times and of the values: names of the first row, or numbers counted from 1.
        units : (2,) str
            Of the columns, such as ``"ms"`` and ``"mm"``; ``""`` is SI.
        kind, outside : str
            As in `Table`.

        Raises
        ------
        ModelError
            If the file cannot be read, or rows are not points, with their lines.
        """
        place = os.fsdecode(path)
        # a text is one name, not its letters: "mm" is not a pair of metres
        given = (
            (columns,) if isinstance(columns, str) else tuple(columns),
            (units,) if isinstance(units, str) else tuple(units),
        )
        if any(len(pair) != 2 for pair in given):
            what = f"columns = {given[0]}, units = {given[1]}"
            raise _wrong(what, "give two columns and two units")
        times, values = zip(*read_points(place, place, *given), strict=True)
        return cls(times, values, kind, outside)

    def shift_values(self, change: float) -> Table:
        """Return this table with all values larger by a number; nothing is checked again."""
        made = copy(self)
        pieces = self._pieces.copy()
        pieces[:, 0] += change
        object.__setattr__(made, "values", np.asarray(self.values) + change)
        object.__setattr__(made, "_pieces", pieces)
        return made

    @property
    def is_short(self) -> bool:
        """Whether it is made part of the equations."""
        return np.size(self.t) <= MOST_IN_FORMULAS

    def check_span(self, name: str, start: float, end: float) -> None:
        """Reject a run that leaves a table with outside='error'.

        Raises
        ------
        UsageError
            Naming the input.
        """
        first, last = float(np.min(self.t)), float(np.max(self.t))
        rounded = ONE_INSTANT * max(abs(first), abs(last))  # 3*0.1 is 0.3 but for the last bit
        covers = first - rounded <= min(start, end) and max(start, end) <= last + rounded
        if self.outside == "error" and not covers:
            raise UsageError(
                Problem("simulation.table_range", f"input {name}",
                        f"the table covers {first:g} to {last:g} s, the motion {start:g} to {end:g} s",
                        "with outside='error' the table must cover the motion",
                        "extend the table, shorten the motion, or write outside='hold'")
            )  # fmt: skip

    def formula(self) -> str:
        """Return the table as an expression in t: pieces chosen by halving."""
        times = np.asarray(self.t)
        starts, pieces = self._starts, self._pieces
        x = f"min(max(t, {_text(times[0])}), {_text(times[-1])})"
        texts = [_piece(x, float(start), row) for start, row in zip(starts, pieces, strict=True)]
        bounds = [float(start) for start in starts[1:]]
        while len(texts) > 1:  # pairs of neighbours, then pairs of pairs
            pairs = zip(texts[::2], bounds[::2], texts[1::2], strict=False)
            joined = [f"if(t < {_text(bound)}, {left}, {right})" for left, bound, right in pairs]
            texts = joined + texts[len(texts) - len(texts) % 2 :]
            bounds = bounds[1::2]
        return texts[0]

    def reader(self) -> Callable[[float, Floats, Floats], float]:
        """Return the table as a function of t, q, u."""
        starts, pieces = self._starts, self._pieces
        first, last = (float(time) for time in np.asarray(self.t)[[0, -1]])

        def read(t: float, q: Floats, u: Floats) -> float:
            x = min(max(t, first), last)
            k = max(int(np.searchsorted(starts, t, side="right")) - 1, 0)
            value = 0.0
            for coefficient in pieces[k][::-1]:
                value = value * (x - starts[k]) + coefficient
            return float(value)

        return read

    def numbers(self) -> Floats:
        """Return the table as `symbody.kernels.tables` reads it."""
        first, last = np.asarray(self.t)[[0, -1]]
        head = [*self._pieces.shape, first, last, 0.0]
        return np.concatenate([head, self._starts, self._pieces.ravel()])

    @property
    def jumps(self) -> Floats:
        """The times that are given twice."""
        times = np.asarray(self.t)
        return np.asarray(times[1:][np.diff(times) == 0.0], dtype=np.float64)

    def at(self, t: Floats) -> Floats:
        """Return the values (N,) at times (N,)."""
        x = np.clip(t, *np.asarray(self.t)[[0, -1]])
        k = np.maximum(np.searchsorted(self._starts, t, side="right") - 1, 0)
        value = np.zeros_like(x)
        for column in self._pieces.T[::-1]:
            value = value * (x - self._starts[k]) + column[k]
        return np.asarray(value, dtype=np.float64)

    def bounds(self, start: Floats, end: Floats) -> tuple[Floats, Floats]:
        """Return the least and the largest value between times (N,) and (N,) without a jump between them."""
        times = np.unique(np.concatenate([self._starts, np.asarray(self.t)[[0, -1]], self._extrema()]))
        corners = self.at(times)
        first, stop = np.searchsorted(times, start, side="right"), np.searchsorted(times, end, side="left")
        ranges = np.stack([first, np.maximum(first, stop)], axis=1).ravel()
        found = []
        for function, beyond in ((np.minimum, np.inf), (np.maximum, -np.inf)):
            inside = function.reduceat(np.append(corners, beyond), ranges)[::2]
            own = function(self.at(start), self.at(end))
            found.append(np.where(first < stop, function(own, inside), own))
        return found[0], found[1]

    def _extrema(self) -> Floats:
        """Return the times at which the slope of a piece is zero."""
        if self.kind == "linear":
            return np.zeros(0)
        one, two, three = self._pieces.T[1:]
        with np.errstate(all="ignore"):
            root = np.sqrt(two * two - 3.0 * one * three)
            large = -(two + np.where(two < 0.0, -root, root))
            found = self._starts + np.stack([one / large, large / (3.0 * three)])
        ends = np.append(self._starts[1:], np.max(self.t))
        found = found[(found > self._starts) & (found < ends)]
        return np.asarray(found, dtype=np.float64)


def table_numbers(tables: Mapping[int, Table]) -> Floats:
    """Return tables by input as `symbody.kernels.tables` reads them; there is one at least."""
    numbers = [table.numbers() for table in tables.values()]
    first = 1 + 2 * len(numbers)
    places = first + np.cumsum([0, *(own.size for own in numbers[:-1])])
    pairs = np.column_stack([list(tables), places]).ravel()
    return np.concatenate([[len(numbers)], pairs, *numbers])


def _polynomials(times: Floats, values: Floats, kind: str) -> tuple[Floats, Floats]:
    """Return where pieces begin, (k,), and their polynomials, (k, degree + 1); see `Table`."""
    ends = np.flatnonzero(np.diff(times) == 0.0) + 1
    starts: list[Floats] = []
    pieces: list[Floats] = []
    for t, y in zip(np.split(times, ends), np.split(values, ends), strict=True):
        if t.size == 1:  # a jump at one end
            own = y[np.newaxis]
        elif kind == "linear":
            own = np.stack([y[:-1], np.diff(y) / np.diff(t)], axis=1)
        else:
            curve = scipy.interpolate.CubicSpline if kind == "cubic" else scipy.interpolate.PchipInterpolator
            own = np.asarray(curve(t, y).c[::-1].T, dtype=np.float64)
        starts.append(t[: len(own)])
        pieces.append(np.pad(own, ((0, 0), (0, 4 - own.shape[1]))))
    return np.concatenate(starts), np.concatenate(pieces)[:, : 2 if kind == "linear" else 4]


def _check_order(times: Floats) -> None:
    """Refuse times that fall, or stand there more than twice."""
    steps = np.diff(times)
    if (steps < 0.0).any():
        k = int(np.argmax(steps < 0.0))
        raise _wrong(f"time {times[k]:g} is followed by {times[k + 1]:g}", "sort the times")
    thrice = (steps[:-1] == 0.0) & (steps[1:] == 0.0)
    if thrice.any():
        k = int(np.argmax(thrice))
        fix = "give it once, or twice for a jump: the second value applies from that instant on"
        raise _wrong(f"time {times[k]:g} is listed three times", fix)
    if times[0] == times[-1]:
        raise _wrong(f"all points have the time {times[0]:g}", "give two different times")


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
