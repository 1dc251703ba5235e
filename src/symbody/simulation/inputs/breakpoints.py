"""Times at which what depends on time alone changes: found before the motion, so that no step passes over it.

The span is divided until everything that depends on time alone is a polynomial to a share of its variation in
each piece, and nothing can be hidden between the samples: a function as steep as exp is looked at over all
values that its operand takes between them. Conditions divide the span where they change.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.expr.opcodes import SYMBOL
from symbody.simulation.inputs.steepness import NODES, TO_COEFFICIENTS, may_hide_features
from symbody.simulation.inputs.time_functions import STEPS, TimeFunctions

Floats = NDArray[np.float64]
Places = NDArray[np.intp]
Flags = NDArray[np.bool_]

EPSILON: Final = 2.220446049250313e-16
# Times are computed to so many roundings of the largest.
_ROUNDINGS: Final = 16.0
# A piece is resolved if its last coefficients are this share of the variation in it, or of that of the span.
_LOCALLY: Final = 1e-2
_GLOBALLY: Final = 1e-4
_ROUNDED: Final = 1e-12
# A value jumps if it changes by more than this share of its variation.
_JUMP: Final = 1e-9
_DEEPEST: Final = 40  # halvings of the span
_MOST_PIECES: Final = 4096  # of one span
_WIDENINGS: Final = 16
_TOGETHER: Final = 256  # cases that are searched at once
_MOST_WHOLE: Final = 4096  # whole numbers that a rounded value passes


@dataclass(frozen=True, slots=True, eq=False)
class Breakpoints:
    """Pieces of time and the steps that they allow.

    Attributes
    ----------
    times : (m,) array
        Where pieces meet, ascending [s].
    longest : (m + 1,) array
        How long a step may be that enters each piece [s].
    jumps : (m,) array of bool
        Whether values jump there.
    margins : (m,) array
        A jump happens within so much of its time [s].
    is_complete : bool
        Whether all changes were found.
    """

    times: Floats
    longest: Floats
    jumps: Flags
    margins: Floats
    is_complete: bool = True

    def rows_along(self, direction: float) -> Floats:
        """Return a row of time, longest step, jump and margin for each piece in the order of a motion.

        The last time is never.
        """
        step, rows = 1 if direction > 0.0 else -1, np.zeros((self.longest.size, 4))
        rows[:-1, 0], rows[-1, 0] = self.times[::step], direction * np.inf
        rows[:, 1] = self.longest[::step]
        rows[:-1, 2], rows[:-1, 3] = self.jumps[::step], self.margins[::step]
        return rows

    def truncate(self, end: float) -> Breakpoints:
        """Return those up to a time, for motions that do not pass it."""
        count = int(np.searchsorted(self.times, end, side="right"))
        first = slice(count)
        return replace(
            self, times=self.times[first], longest=self.longest[: count + 1], jumps=self.jumps[first],
            margins=self.margins[first],
        )  # fmt: skip

    def jumps_alone(self) -> Breakpoints:
        """Return the jumps, with any step between them."""
        count = int(self.jumps.sum())
        if not count:
            return NO_BREAKPOINTS
        longest, jumps = np.full(count + 1, np.inf), np.ones(count, dtype=np.bool_)
        return Breakpoints(self.times[self.jumps], longest, jumps, self.margins[self.jumps], self.is_complete)

    def notes(self, step: float | None) -> tuple[str, ...]:
        """Return what steps of one length, or a search that was broken off, may miss."""
        notes = []
        if step is not None and (shortest := float(self.longest.min())) < step:
            k = int(np.argmin(self.longest))
            at = self.times[min(max(k - 1, 0), self.times.size - 1)]
            notes.append(
                f"formulas of time change within {shortest:.3g} s near t = {at:.6g} s: steps of {step:.3g} "
                f"s may miss the change; use a shorter step"
            )
        if not self.is_complete:
            notes.append(
                "formulas of time change too often to be searched in advance: for short pulses between long "
                "pauses, give the integrator a max_step="
            )
        return tuple(notes)

    def unite(self, other: Breakpoints) -> Breakpoints:
        """Return the pieces of both."""
        if self is NO_BREAKPOINTS or other is NO_BREAKPOINTS:
            return self if other is NO_BREAKPOINTS else other
        times = np.union1d(self.times, other.times)
        between = 0.5 * (times[1:] + times[:-1])
        inside = np.concatenate([times[:1] - 1.0, between, times[-1:] + 1.0]) if times.size else np.zeros(1)
        longest = [own.longest[np.searchsorted(own.times, inside)] for own in (self, other)]
        jumps = [np.isin(times, own.times[own.jumps]) for own in (self, other)]
        margins = np.zeros_like(times)
        for own in (self, other):
            places = np.searchsorted(times, own.times)
            margins[places] = np.maximum(margins[places], own.margins)
        return Breakpoints(
            times,
            np.minimum(*longest),
            jumps[0] | jumps[1],
            margins,
            self.is_complete and other.is_complete,
        )


# One piece that allows any step.
NO_BREAKPOINTS: Final = Breakpoints(np.zeros(0), np.full(1, np.inf), np.zeros(0, dtype=np.bool_), np.zeros(0))


def find_breakpoints(
    functions: TimeFunctions, span: tuple[float, float], parameters: Floats | None = None
) -> list[Breakpoints]:
    """Return the pieces of a span for each row of free parameters (cases, n_p), by default one without.

    Pieces also meet at the ends of the span where a motion would read values from beyond a jump.
    """
    p = np.zeros((1, 0)) if parameters is None else parameters
    if span[0] == span[1] or functions.are_straight:
        return [NO_BREAKPOINTS] * len(p)
    search = _PieceSearch(functions, span, np.ascontiguousarray(p.T))
    search.divide()
    return search.results()


def search_ahead(
    functions: Iterable[TimeFunctions | None], span: tuple[float, float], parameters: Floats | None = None
) -> list[Breakpoints]:
    """Return the pieces of several functions together, for each case, or one for all.

    Parameters
    ----------
    parameters : (cases, n_p) array, optional
        Those that the functions read.
    """
    count = 1 if parameters is None else len(parameters)
    found = [NO_BREAKPOINTS] * count
    for each in functions:
        if each is None:
            continue
        for first in range(0, count, _TOGETHER):
            part = slice(first, first + _TOGETHER)
            pieces = find_breakpoints(each, span, None if parameters is None else parameters[part])
            found[part] = [a.unite(b) for a, b in zip(found[part], pieces, strict=True)]
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """Pieces (N,) of the spans of several cases."""

    start: Floats
    end: Floats
    case: Places

    def select(self, which: Flags | Places) -> _Pieces:
        return _Pieces(self.start[which], self.end[which], self.case[which])

    def halves(self) -> _Pieces:
        middle = self.start + 0.5 * (self.end - self.start)
        return join_pieces([_Pieces(self.start, middle, self.case), _Pieces(middle, self.end, self.case)])


def join_pieces(parts: list[_Pieces]) -> _Pieces:
    """Return all pieces of some lists."""
    return _Pieces(
        np.concatenate([part.start for part in parts]),
        np.concatenate([part.end for part in parts]),
        np.concatenate([part.case for part in parts]),
    )


class _PieceSearch:
    """The pieces of the spans of several cases, divided as far as necessary."""

    def __init__(self, functions: TimeFunctions, span: tuple[float, float], p: Floats) -> None:
        self._functions, self._p = functions, p
        self._start, self._end = sorted(span)
        self._first, self._last = span
        self._cases = p.shape[1]
        self.margin = _ROUNDINGS * EPSILON * max(abs(self._start), abs(self._end))
        self._known, self._open = functions.known_switches, functions.open_switches
        rows = len(functions.operations) + self._open.size
        self._least, self._most = np.full((self._cases, rows), np.inf), np.full((self._cases, rows), -np.inf)
        self._cuts: list[tuple[Floats, Places, Floats]] = []
        # spans may be too short for any
        self._leaves = [_Pieces(np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.intp))]
        self._is_complete = True

    def divide(self) -> None:
        """Divide the spans."""
        everything = np.arange(self._cases)
        whole = _Pieces(np.full(self._cases, self._start), np.full(self._cases, self._end), everything)
        times, cases = self._affine_switch_times()
        pieces = self._cut_pieces(whole, times, cases, np.full(times.size, self.margin))
        for _ in range(_DEEPEST):
            if not pieces.start.size:
                return
            pieces = self._examine(pieces)
        self._leaves.append(pieces)
        self._is_complete = False

    def _examine(self, pieces: _Pieces) -> _Pieces:
        """Keep the pieces that need no division; return the parts of the others."""
        t = pieces.start[:, np.newaxis] + (pieces.end - pieces.start)[:, np.newaxis] * NODES
        t[:, -1] = pieces.end
        values = self._values(t, pieces.case)
        differences = values[len(self._functions.operations) :]
        symbols = self._symbols(differences)
        times, cases, widths = self._locate_switches(t, symbols, pieces.case)
        is_cut = (symbols[:, :, 1:] != symbols[:, :, :-1]).any(axis=(0, 2))
        with np.errstate(all="ignore"):
            rough = ~is_cut & self._is_rough(values, pieces)
        is_short = pieces.end - pieces.start < 64.0 * self.margin
        count = np.bincount(pieces.case, minlength=self._cases)
        is_full = (count > _MOST_PIECES)[pieces.case]
        self._is_complete &= not (rough & is_full).any()
        divided = rough & ~is_short & ~is_full
        self._leaves.append(pieces.select(~is_cut & ~divided))
        parts = [pieces.select(divided).halves()]
        if is_cut.any():
            parts.append(self._cut_pieces(pieces.select(is_cut), times, cases, widths))
        return join_pieces(parts)

    def _values(self, t: Floats, case: Places, only: Places | None = None) -> Floats:
        """Return all values, and differences of open switches, (rows, N, k) at times (N, k)."""
        flat = self._functions.values(t.ravel(), np.repeat(self._p[:, case], t.shape[1], axis=1), only)
        with np.errstate(all="ignore"):
            values = np.concatenate([flat, self._functions.differences(flat, self._open)])
        return values.reshape(len(values), *t.shape)

    def _symbols(self, differences: Floats) -> Floats:
        """Return a number for the formula that each open switch uses."""
        counts = self._functions.counts(self._open)
        shape = (-1,) + (1,) * (differences.ndim - 1)
        found: Floats = np.where(counts.reshape(shape), np.floor(differences), np.sign(differences))
        return np.nan_to_num(found)

    def _affine_switch_times(self) -> tuple[Floats, Places]:
        """Return where switches of affine functions change, and tables jump: times and cases."""
        everything = np.arange(self._cases)
        ends = np.tile([self._start, self._end], (self._cases, 1))
        flat = self._functions.values(ends.ravel(), np.repeat(self._p, 2, axis=1))
        values = flat.reshape(-1, self._cases, 2)
        changes = [(np.zeros(0), np.zeros(0, dtype=np.intp))]
        for place, d in enumerate(self._functions.differences(values, self._known)):
            k = self._known[place : place + 1]
            levels = _levels(d) if self._functions.counts(k)[0] else [np.zeros(self._cases)]
            for level in levels:
                first, last = d[:, 0] - level, d[:, 1] - level
                is_passed = (np.sign(first) != np.sign(last)) & np.isfinite(first) & np.isfinite(last)
                share = -first[is_passed] / (last - first)[is_passed]
                exact = self._functions.exact_zeros(int(k[0]), values[:, is_passed, 0])
                times = self._start + share * (self._end - self._start) if exact is None else exact
                changes.append((times, everything[is_passed]))
        for code, operands, datum in self._functions.operations:
            if code == STEPS:
                x = values[operands[0]]
                changes += self._step_times(self._functions.steps[datum].bounds, x, operands[0])
        for table in self._functions.tables.values():
            times = np.tile(table.jumps, self._cases)
            changes.append((times, np.repeat(everything, table.jumps.size)))
        return np.concatenate([times for times, _ in changes]), np.concatenate(
            [cases for _, cases in changes]
        )

    def _step_times(self, bounds: Floats, x: Floats, place: int) -> list[tuple[Floats, Places]]:
        """Return when values (cases, 2), from the start to the end affine in time, pass bounds."""
        first, last = x[:, :1] - bounds, x[:, 1:] - bounds
        case, own = np.nonzero((np.sign(first) != np.sign(last)) & np.isfinite(first) & np.isfinite(last))
        if self._functions.operations[place].op == SYMBOL:  # time itself
            return [(bounds[own], case)]
        share = -first[case, own] / (last - first)[case, own]
        return [(self._start + share * (self._end - self._start), case)]

    def _locate_switches(self, t: Floats, symbols: Floats, case: Places) -> tuple[Floats, Places, Floats]:
        """Return where open switches change between samples, by bisection: times, cases, and widths."""
        switch, piece, node = np.nonzero(symbols[:, :, 1:] != symbols[:, :, :-1])
        low, high = t[piece, node].copy(), t[piece, node + 1].copy()
        target = symbols[switch, piece, node]
        own, n = np.arange(switch.size), len(self._functions.operations)
        for _ in range(60 if switch.size else 0):
            middle = 0.5 * (low + high)
            values = self._values(middle[:, np.newaxis], case[piece], self._functions.before_open)
            found = self._symbols(values[n:])[switch, own, 0]
            low, high = np.where(found == target, middle, low), np.where(found == target, high, middle)
            if (high - low <= 0.25 * self.margin).all():
                break
        times = 0.5 * (low + high)
        return times, case[piece], self._widths(times, case[piece], switch)

    def _widths(self, t: Floats, case: Places, switch: Places) -> Floats:
        """Return how far beside its time a switch has changed whatever its operands are rounded by."""
        functions, columns = self._functions, np.arange(t.size)
        counts, n = functions.counts(self._open)[switch], len(functions.operations)
        operands = [np.array([functions.operations[k].operands[i] for k in self._open]) for i in (0, -1)]
        width = np.full(t.size, self.margin)
        for _ in range(_WIDENINGS if t.size else 0):
            beside = np.stack([t - width, t + width], axis=1)
            values = self._values(beside, case, functions.before_open)
            d = values[n:][switch, columns]
            d = np.where(counts[:, np.newaxis], d - np.round(d.mean(axis=1, keepdims=True)), d)
            size = np.maximum(*(np.abs(values[places[switch], columns]).max(axis=1) for places in operands))
            is_clear = np.abs(d).min(axis=1) > _ROUNDINGS * EPSILON * size
            if is_clear.all():
                break
            width = np.where(is_clear, width, 2.0 * width)
        return width

    def _cut_pieces(self, pieces: _Pieces, times: Floats, cases: Places, widths: Floats) -> _Pieces:
        """Return the parts of pieces between some times, a width away from these."""
        order = np.lexsort((times, cases))
        times, cases, widths = times[order], cases[order], widths[order]
        is_new = np.ones(times.size, dtype=np.bool_)
        is_new[1:] = (np.diff(times) > 4.0 * widths[1:]) | (np.diff(cases) != 0)
        times, cases, widths = times[is_new], cases[is_new], widths[is_new]
        inside = (times > self._start + 4.0 * widths) & (times < self._end - 4.0 * widths)
        self._cuts.append((times[inside], cases[inside], widths[inside]))
        parts = [_Pieces(np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.intp))]
        widest = float(widths.max(initial=0.0))
        for start, end, case in zip(pieces.start, pieces.end, pieces.case, strict=True):
            low, high = np.searchsorted(cases, [case, case + 1])  # they are in order, by case and by time
            low, high = low + np.searchsorted(times[low:high], [start - widest, end + widest])
            near, wide = times[low:high], widths[low:high]
            is_own = (near > start - wide) & (near < end + wide)
            a = np.concatenate([[start], near[is_own] + wide[is_own]])
            b = np.concatenate([near[is_own] - wide[is_own], [end]])
            is_kept = b - a > 2.0 * self.margin
            parts.append(_Pieces(a[is_kept], b[is_kept], np.full(int(is_kept.sum()), case)))
        return join_pieces(parts)

    def _is_rough(self, values: Floats, pieces: _Pieces) -> Flags:
        """Return which pieces are not resolved by their samples (rows, N, nodes), or may hide something."""
        finite = np.isfinite(values)
        is_torn = (finite.any(axis=2) & ~finite.all(axis=2)).any(axis=0)
        values = np.where(finite, values, 0.0)
        least, most = values.min(axis=2), values.max(axis=2)
        np.minimum.at(self._least, pieces.case, least.T)
        np.maximum.at(self._most, pieces.case, most.T)
        whole = (self._most - self._least)[pieces.case].T
        size = np.maximum(np.abs(least), np.abs(most))
        allowed = _LOCALLY * (most - least) + _GLOBALLY * whole + _ROUNDED * size
        last = np.abs(values @ TO_COEFFICIENTS[-2:].T).max(axis=2)
        rough: Flags = is_torn | (last > allowed).any(axis=0)
        return rough | may_hide_features(self._functions, values, whole, (pieces.start, pieces.end))

    def results(self) -> list[Breakpoints]:
        """Return the pieces of each case."""
        leaves = join_pieces(self._leaves)
        leaves = leaves.select(np.lexsort((leaves.start, leaves.case)))
        cuts, owners, widths = (np.concatenate(parts) for parts in zip(*self._cuts, strict=True))
        order = np.argsort(cuts, kind="stable")
        cuts, owners, widths = cuts[order], owners[order], widths[order]
        found = []
        for case in range(self._cases):
            own, is_own = leaves.select(leaves.case == case), owners == case
            pieces = self._result(own, cuts[is_own], widths[is_own], case)
            found.append(self._with_jumps_at_ends(pieces, case))
        return found

    def _with_jumps_at_ends(self, pieces: Breakpoints, case: int) -> Breakpoints:
        """Return pieces that also meet at the ends of a motion that would read values beyond a jump there."""
        margin = 2.0 * self.margin
        behind = self._first + np.copysign(margin, self._last - self._first)
        sides = np.array([[self._first, behind], [self._last - margin, self._last + margin]])
        is_jump = self._jump(sides[:, 0], sides[:, 1], case)
        for t in np.array([self._first, self._last])[is_jump]:
            k = pieces.times.size if t == self._end else 0
            times, jumps = np.insert(pieces.times, k, t), np.insert(pieces.jumps, k, True)
            longest = np.insert(pieces.longest, k, pieces.longest[k])
            margins = np.insert(pieces.margins, k, margin)
            pieces = Breakpoints(times, longest, jumps, margins, pieces.is_complete)
        return pieces

    def _jump(self, before: Floats, after: Floats, case: int) -> Flags:
        """Return whether some value jumps between each of some pairs of times."""
        shown = self._functions.shown
        values = self._values(np.stack([before, after], axis=1), np.full(before.size, case))[shown]
        whole = (self._most - self._least)[case, shown][:, np.newaxis]
        with np.errstate(all="ignore"):
            change = np.abs(values[:, :, 1] - values[:, :, 0])
            moved = change > _JUMP * whole + _ROUNDED * np.abs(values).max(axis=2)
        jumps: Flags = moved.any(axis=0)
        return jumps

    def _result(self, leaves: _Pieces, cuts: Floats, widths: Floats, case: int) -> Breakpoints:
        if leaves.start.size < 2:
            return NO_BREAKPOINTS
        before, after = leaves.end[:-1], leaves.start[1:]
        times, margins = before + 0.5 * (after - before), np.full(before.size, self.margin)
        if cuts.size:  # as they were found, not as they follow from the margin
            place = np.clip(np.searchsorted(cuts, before), 0, cuts.size - 1)
            is_cut = (cuts[place] > before) & (cuts[place] < after)
            times, margins = np.where(is_cut, cuts[place], times), np.where(is_cut, widths[place], margins)
        is_jump = self._jump(before, after, case) & (after > before)
        return Breakpoints(times, leaves.end - leaves.start, is_jump, margins, self._is_complete)


def _levels(d: Floats) -> list[Floats]:
    """Return the whole numbers that affine values (cases, 2) pass, some for each case."""
    if not np.isfinite(d).all():
        return []
    low, high = np.ceil(d.min(axis=1)), np.floor(d.max(axis=1))
    count = int(min((high - low).max(initial=-1.0) + 1.0, _MOST_WHOLE))
    return [low + k for k in range(count)]
