"""`ClosedGapSearch`: equilibria of mechanisms with ropes and stops, each with the gaps that are closed there.

An equilibrium is one of the equations with some of the gaps as constraints, whose efforts open them, while
none of the others is negative. From each start the gaps that are 0 are closed; those whose efforts would shut
them open, and those that would be negative close until all fit (an active-set method; Nocedal & Wright 2006,
section 16.5). From the guess each gap is closed by itself, too, those with equal shares together first: a box
lies on all corners of a face. If nothing leads to an equilibrium, all sets are tried.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations, islice
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.analysis.configurations.closed_gaps import AT_LENGTH, gap_shares, with_closed_gaps
from symbody.analysis.configurations.gap_words import gap_words
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.equilibrium.equilibrium_search import EquilibriumSearch
from symbody.analysis.equilibrium.static_balance import StaticBalance, StaticResidual, static_balance
from symbody.equations.solving.unilateral import row_places, unilateral_elements
from symbody.tolerances import BALANCED, BEARING

Floats = NDArray[np.float64]

_MOST_SETS: Final = 64
_FEW_STARTS: Final = 8  # for each set
_FEW_GROUPS: Final = 16  # of gaps that are closed from the guess, one after the other
_EQUAL: Final = 9  # decimal digits of shares that are equal


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A configuration, the equations whose forces were balanced there, and the states of its gaps.

    Attributes
    ----------
    notes : tuple of str
        The state of each rope and stop.
    edges : tuple of str
        Those that are closed without effort.
    fault : str
        Why it is not an equilibrium although the forces balance; else empty.
    """

    search: EquilibriumSearch
    residual: StaticResidual
    notes: tuple[str, ...] = ()
    edges: tuple[str, ...] = ()
    fault: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ClosedGapSearch:
    """Searches for equilibria with any of the gaps closed; fields as of `EquilibriumSearch`."""

    evaluator: ConstraintEvaluator
    unknowns: tuple[str, ...]
    start: Floats
    fixed: frozenset[str]
    _searches: dict[frozenset[str], EquilibriumSearch] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the ropes and stops."""
        return unilateral_elements(self.evaluator.eqs.formed)

    def search_with(self, closed: frozenset[str]) -> EquilibriumSearch:
        """Return the search with some of the gaps closed."""
        if closed not in self._searches:
            evaluator, eqs = self.evaluator, with_closed_gaps(self.evaluator.eqs, closed)
            if eqs is not evaluator.eqs:
                evaluator = constraint_evaluator(
                    eqs, evaluator.parameters, evaluator.inputs, evaluator.t, evaluator.mechanism,
                    signals=evaluator.signals,
                )  # fmt: skip
            self._searches[closed] = EquilibriumSearch(self._balance(evaluator), self.start, self.fixed)
        return self._searches[closed]

    def nearest_set(self) -> EquilibriumSearch:
        """Return the search with the gaps closed that are 0 at the guess."""
        return self.search_with(self._closed_gaps(self.start, AT_LENGTH))

    def candidates(self) -> tuple[list[Candidate], list[Candidate]]:
        """Return the equilibria that starts lead to, and where other starts end."""
        starts = self.search_with(frozenset()).starts()
        good: list[Candidate] = []
        others: list[Candidate] = []
        settled: set[frozenset[str]] = set()  # from the guess
        for start in starts:
            is_guess = start is self.start
            closed = self._closed_gaps(start, AT_LENGTH if is_guess else 0.0)
            self._sort(self._settle(start, closed, settled if is_guess else set()), good, others)
        waiting = self._close_groups(settled, good, others)
        if not good and self.names:
            for closed in self._sets():
                for start in starts[:_FEW_STARTS]:
                    if start is not self.start:
                        self._sort(self._settle(start, closed, set()), good, others)
                    elif closed not in settled:
                        self._sort(self._settle(start, closed, settled), good, others)
        left_out = sorted(frozenset().union(*waiting))
        if left_out:
            note = f"there are many gaps: starts with {', '.join(left_out)} closed at the guess were left out"
            good = [replace(one, notes=(*one.notes, note)) for one in good]
        return good, others

    def _close_groups(
        self, settled: set[frozenset[str]], good: list[Candidate], others: list[Candidate]
    ) -> list[frozenset[str]]:
        """Close groups of gaps from the guess, and gaps of those that lead nowhere; return what a cap leaves.

        Limits on both sides have equal shares midway, and never close together.
        """
        waiting, count = self._groups(), 0
        while waiting and count < _FEW_GROUPS:
            group, before = waiting.pop(0), len(good)
            if group in settled:
                continue
            count += 1
            self._sort(self._settle(self.start, group, settled), good, others)
            if len(good) == before and len(group) > 1:
                waiting += [frozenset([name]) for name in self.names if name in group]
        return [group for group in waiting if group not in settled]

    def _groups(self) -> list[frozenset[str]]:
        """Return the gaps whose shares are equal at the guess, the smallest share first."""
        if not self.names:
            return []
        groups: dict[float, list[str]] = {}
        for name, share in gap_shares(self.evaluator, self.start).items():
            groups.setdefault(round(share, _EQUAL), []).append(name)
        return [frozenset(groups[share]) for share in sorted(groups)]

    def _sort(self, ends: list[Candidate], good: list[Candidate], others: list[Candidate]) -> None:
        for one in ends:
            (good if one.search.is_good(one.residual) and not one.fault else others).append(one)

    def _balance(self, evaluator: ConstraintEvaluator) -> StaticBalance:
        return static_balance(evaluator, self.unknowns)

    def _sets(self) -> Iterator[frozenset[str]]:
        """Return all sets of gaps, those of many first."""
        counts = range(len(self.names), -1, -1)
        return islice((frozenset(c) for n in counts for c in combinations(self.names, n)), _MOST_SETS)

    def _closed_gaps(self, q: Floats, share: float) -> frozenset[str]:
        """Return the gaps that are not open by more than a share of their size."""
        if not self.names:
            return frozenset()
        return frozenset(name for name, shares in gap_shares(self.evaluator, q).items() if shares <= share)

    def _settle(self, start: Floats, closed: frozenset[str], seen: set[frozenset[str]]) -> list[Candidate]:
        """Return the ends of a start, with gaps closing and opening as they must.

        The sets that were closed are added to those seen; what was seen before is not looked at again.
        """
        while True:
            seen.add(closed)
            search = self.search_with(closed)
            ends = [self._candidate(search, rest, closed) for rest in search.attempts(start)]
            if not self.names or not any(search.is_good(one.residual) for one in ends):
                return ends
            best = next(one for one in ends if search.is_good(one.residual))
            change = self._change(best, closed) if best.fault else None
            if change is None or change in seen:
                return ends
            closed = change

    def _candidate(self, search: EquilibriumSearch, end: StaticResidual, closed: frozenset[str]) -> Candidate:
        """Return a configuration with what its ropes and stops do."""
        if not search.is_good(end):
            return Candidate(search, end)
        end = search.unwind(end)
        if not self.names:
            return Candidate(search, end)
        shares = gap_shares(self.evaluator, end.q)
        efforts, limits = self._limited_efforts(search, end, closed)
        negative = [name for name in self.names if name not in closed and shares[name] < -AT_LENGTH]
        shut = [name for name, effort in efforts.items() if effort < -limits[name]]
        words = {name: gap_words(self.evaluator.eqs, name) for name in self.names}
        fault = ", ".join(
            [words[name].describe_wrong_way(efforts[name]) for name in shut]
            + [f"{words[name].subject}: {words[name].impossible}" for name in negative]
        )
        touching = [name for name in self.names if name not in closed and abs(shares[name]) <= AT_LENGTH]
        if touching and not fault:
            search, end, closed = self._share_efforts(search, end, closed, touching)
            efforts, limits = self._limited_efforts(search, end, closed)
        edges = [name for name, effort in efforts.items() if abs(effort) <= limits[name]]
        edges += [name for name in touching if name not in closed]
        notes = [words[name].with_effort(effort) for name, effort in efforts.items() if name not in edges]
        notes += [
            f"{words[name].subject} is {words[name].open}" for name in self.names if shares[name] > AT_LENGTH
        ]
        notes += [
            f"{words[name].subject} is {words[name].without_effort}, so linear equations do not show whether "
            f"the equilibrium is stable"
            for name in edges
        ]
        return Candidate(search, end, tuple(notes), tuple(edges), fault)

    def _share_efforts(
        self, search: EquilibriumSearch, end: StaticResidual, closed: frozenset[str], touching: list[str]
    ) -> tuple[EquilibriumSearch, StaticResidual, frozenset[str]]:
        """Return an equilibrium with those of the touching gaps closed that may bear a part of the efforts.

        Where points of a contact coincide, one alone balances what both share.
        """
        wide = self.search_with(closed.union(touching))
        wide_end = wide.balance.residual(end.q, end.inputs, wide.balance.largest_term(self.start))
        if not wide.is_good(wide_end):
            return search, end, closed
        efforts, limits = self._limited_efforts(wide, wide_end, closed.union(touching))
        bearing = closed.union(name for name in touching if efforts[name] > limits[name])
        if bearing == closed or any(efforts[name] < -limits[name] for name in efforts):
            return search, end, closed
        wide = self.search_with(bearing)
        wide_end = wide.balance.residual(end.q, end.inputs, wide.balance.largest_term(self.start))
        return (wide, wide_end, bearing) if wide.is_good(wide_end) else (search, end, closed)

    def _limited_efforts(
        self, search: EquilibriumSearch, end: StaticResidual, closed: frozenset[str]
    ) -> tuple[dict[str, float], dict[str, float]]:
        """Return the efforts that open gaps, and below which size each counts as none.

        They are known as well as the forces that they balance, which may be large where they are not.
        """
        work = np.abs(end.multipliers) * search.balance.scales
        largest = float(work.max(initial=search.balance.largest_term(self.start)))
        mechanism, small = search.evaluator.mechanism, BALANCED * largest
        limits = {name: small / mechanism.gap(search.evaluator.eqs, name) for name in closed}
        return self._efforts(search, end, closed, limits), limits

    def _change(self, candidate: Candidate, closed: frozenset[str]) -> frozenset[str] | None:
        """Return the gaps to be closed next: with negative ones, or without the one that is shut most."""
        efforts, _ = self._limited_efforts(candidate.search, candidate.residual, closed)
        negative = self._closed_gaps(candidate.residual.q, -AT_LENGTH) - closed
        if negative:
            return closed | negative
        worst = min(efforts, key=lambda name: efforts[name], default="")
        return closed - {worst} if worst and efforts[worst] < 0.0 else None

    def _efforts(
        self,
        search: EquilibriumSearch,
        end: StaticResidual,
        closed: frozenset[str],
        limits: Mapping[str, float],
    ) -> dict[str, float]:
        """Return the efforts that open gaps; of undetermined ones, shares that open all, if any do."""
        order = [name for name in self.names if name in closed]
        places = row_places(search.evaluator.eqs.formed, order)
        rows = search.evaluator.eqs.formed.rows
        senses = np.array([rows[place].sense for place in places], dtype=np.float64)
        efforts = senses * end.multipliers[places]
        small = np.array([limits[name] for name in order])
        if (efforts <= small).any():
            freedoms = senses[:, np.newaxis] * search.undetermined_multipliers(end)[places]
            efforts = _least_shutting(efforts, freedoms)
            if (efforts <= small).any() and (efforts >= -small).all():
                efforts = _most_opening(efforts, freedoms, small)
        return dict(zip(order, efforts.tolist(), strict=True))


def _has_freedom(freedoms: Floats) -> bool:
    return bool(np.abs(freedoms).max(initial=0.0) > BEARING)


def _least_shutting(efforts: Floats, freedoms: Floats) -> Floats:
    """Return efforts ``efforts + freedoms @ y`` of which the least is as large as it can be."""
    if not _has_freedom(freedoms):
        return efforts
    n, k = freedoms.shape
    scale = float(np.abs(efforts).max(initial=0.0)) or 1.0
    cost = np.append(np.zeros(k), -1.0)
    bounds = [(None, None)] * k + [(None, 1.0)]
    rows = np.hstack([-freedoms, np.ones((n, 1))])
    optimum = scipy.optimize.linprog(cost, rows, efforts / scale, bounds=bounds)
    return efforts if optimum.x is None else np.asarray(efforts + scale * freedoms @ optimum.x[:k])


def _most_opening(efforts: Floats, freedoms: Floats, small: Floats) -> Floats:
    """Return efforts ``efforts + freedoms @ y`` of which none shuts, and as many as can be open.

    They are the mean of those in which one of the small ones is as large as it can be, up to the largest: if
    any shares open a gap, so does their mean.
    """
    if not _has_freedom(freedoms):
        return efforts
    scale = float(np.abs(efforts).max(initial=0.0)) or 1.0
    bounds = [(None, None)] * freedoms.shape[1]
    found = []
    for k in np.flatnonzero(efforts <= small):
        rows = np.vstack([-freedoms, freedoms[k]])
        room = np.append(np.maximum(efforts, 0.0) / scale, 1.0 - efforts[k] / scale)
        optimum = scipy.optimize.linprog(-freedoms[k], rows, room, bounds=bounds)
        if optimum.x is not None:
            found.append(efforts + scale * freedoms @ optimum.x)
    return np.asarray(np.mean(found, axis=0)) if found else efforts
