"""`TautSearch`: equilibria of mechanisms with ropes, each with the ropes that are taut there.

A rope pulls at its length or is slack, so an equilibrium is one of the equations with some of the ropes as
constraints at which none of these pushes and none of the others is longer than it is. From each start ropes
at their length are taut; those that would push go slack and those that would be longer go taut until all fit
(an active-set method; Nocedal & Wright 2006, section 16.5). If no start leads there, all sets are tried.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations, islice
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.analysis.configurations.ropes import AT_LENGTH, slackness, with_taut
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.equilibrium.equilibrium_search import EquilibriumSearch
from symbody.analysis.equilibrium.static_balance import StaticBalance, StaticResidual, static_balance
from symbody.equations.solving.unilateral import row_places, unilateral_elements
from symbody.tolerances import BALANCED, BEARING

Floats = NDArray[np.float64]

_MOST_SETS: Final = 64
_FEW_STARTS: Final = 8  # for each set


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A configuration, the equations whose forces were balanced there, and the states of its ropes.

    Attributes
    ----------
    notes : tuple of str
        The state of each rope.
    edges : tuple of str
        Ropes that are at their length without tension.
    fault : str
        Why it is not an equilibrium although the forces balance; else empty.
    """

    search: EquilibriumSearch
    residual: StaticResidual
    notes: tuple[str, ...] = ()
    edges: tuple[str, ...] = ()
    fault: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class TautSearch:
    """Searches for equilibria with any of the ropes taut; fields as of `EquilibriumSearch`."""

    evaluator: ConstraintEvaluator
    unknowns: tuple[str, ...]
    start: Floats
    fixed: frozenset[str]
    _searches: dict[frozenset[str], EquilibriumSearch] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the ropes."""
        return unilateral_elements(self.evaluator.eqs.formed)

    def search_with(self, taut: frozenset[str]) -> EquilibriumSearch:
        """Return the search with some of the ropes taut."""
        if taut not in self._searches:
            evaluator, eqs = self.evaluator, with_taut(self.evaluator.eqs, taut)
            if eqs is not evaluator.eqs:
                evaluator = constraint_evaluator(
                    eqs, evaluator.parameters, evaluator.inputs, evaluator.t, evaluator.mechanism,
                    signals=evaluator.signals,
                )  # fmt: skip
            self._searches[taut] = EquilibriumSearch(self._balance(evaluator), self.start, self.fixed)
        return self._searches[taut]

    def nearest_set(self) -> EquilibriumSearch:
        """Return the search with the ropes taut that are at their length at the guess."""
        return self.search_with(self._taut_ropes(self.start, AT_LENGTH))

    def candidates(self) -> tuple[list[Candidate], list[Candidate]]:
        """Return the equilibria that starts lead to, and where other starts end."""
        starts = self.search_with(frozenset()).starts()
        good: list[Candidate] = []
        others: list[Candidate] = []
        for start in starts:
            taut = (
                self._taut_ropes(start, 0.0)
                if start is not self.start
                else self._taut_ropes(start, AT_LENGTH)
            )
            self._sort(self._settle(start, taut), good, others)
        if not good and self.names:
            for taut in self._sets():
                for start in starts[:_FEW_STARTS]:
                    self._sort(self._settle(start, taut), good, others)
        return good, others

    def _sort(self, ends: list[Candidate], good: list[Candidate], others: list[Candidate]) -> None:
        for one in ends:
            (good if one.search.is_good(one.residual) and not one.fault else others).append(one)

    def _balance(self, evaluator: ConstraintEvaluator) -> StaticBalance:
        return static_balance(evaluator, self.unknowns)

    def _sets(self) -> Iterator[frozenset[str]]:
        """Return all sets of ropes, those of many first."""
        counts = range(len(self.names), -1, -1)
        return islice((frozenset(c) for n in counts for c in combinations(self.names, n)), _MOST_SETS)

    def _taut_ropes(self, q: Floats, share: float) -> frozenset[str]:
        """Return the ropes that are not slack by more than a share of their length."""
        if not self.names:
            return frozenset()
        return frozenset(name for name, slack in slackness(self.evaluator, q).items() if slack <= share)

    def _settle(self, start: Floats, taut: frozenset[str]) -> list[Candidate]:
        """Return the ends of a start, with ropes going taut and slack as they must."""
        seen: set[frozenset[str]] = set()
        while True:
            seen.add(taut)
            search = self.search_with(taut)
            ends = [self._candidate(search, rest, taut) for rest in search.attempts(start)]
            if not self.names or not any(search.is_good(one.residual) for one in ends):
                return ends
            best = next(one for one in ends if search.is_good(one.residual))
            change = self._change(best, taut) if best.fault else None
            if change is None or change in seen:
                return ends
            taut = change

    def _candidate(self, search: EquilibriumSearch, end: StaticResidual, taut: frozenset[str]) -> Candidate:
        """Return a configuration with what its ropes do."""
        if not search.is_good(end):
            return Candidate(search, end)
        end = search.unwind(end)
        if not self.names:
            return Candidate(search, end)
        pulls, slack = self._pulls(search, end, taut), slackness(self.evaluator, end.q)
        longer = [name for name in self.names if name not in taut and slack[name] < -AT_LENGTH]
        work = np.abs(end.multipliers) * search.balance.scales
        limit = BALANCED * float(work.max(initial=0.0)) / search.evaluator.mechanism.length
        pushing = [name for name, pull in pulls.items() if pull < -limit]
        fault = ", ".join(
            [f"rope {name} would have to push with {-pulls[name]:.4g} N" for name in pushing]
            + [f"rope {name} would have to be longer" for name in longer]
        )
        edges = [name for name, pull in pulls.items() if abs(pull) <= limit]
        edges += [name for name in self.names if name not in taut and abs(slack[name]) <= AT_LENGTH]
        notes = [
            f"rope {name} is taut with {pull:.6g} N" for name, pull in pulls.items() if name not in edges
        ]
        notes += [f"rope {name} is slack" for name in self.names if slack[name] > AT_LENGTH]
        notes += [
            f"rope {name} is at its length without tension: it pulls for small deviations to one side only, "
            f"so linear equations do not show whether the equilibrium is stable"
            for name in edges
        ]  # fmt: skip
        return Candidate(search, end, tuple(notes), tuple(edges), fault)

    def _change(self, candidate: Candidate, taut: frozenset[str]) -> frozenset[str] | None:
        """Return the ropes to be taut next: with those longer, or without the one that pushes most."""
        search, rest = candidate.search, candidate.residual
        pulls = self._pulls(search, rest, taut)
        longer = self._taut_ropes(rest.q, -AT_LENGTH) - taut
        if longer:
            return taut | longer
        worst = min(pulls, key=lambda name: pulls[name], default="")
        return taut - {worst} if worst and pulls[worst] < 0.0 else None

    def _pulls(
        self, search: EquilibriumSearch, rest: StaticResidual, taut: frozenset[str]
    ) -> dict[str, float]:
        """Return the tensions; of those that the forces leave undetermined, the shares that push least."""
        order = [name for name in self.names if name in taut]
        places = row_places(search.evaluator.eqs.formed, order)
        tensions = -rest.multipliers[places]
        if (tensions < 0.0).any():
            tensions = _least_pushing(tensions, -search.undetermined_multipliers(rest)[places])
        return dict(zip(order, tensions.tolist(), strict=True))


def _least_pushing(tensions: Floats, freedoms: Floats) -> Floats:
    """Return tensions ``tensions + freedoms @ y`` of which the least is as large as it can be."""
    if not freedoms.size or not np.abs(freedoms).max(initial=0.0) > BEARING:
        return tensions
    n, k = freedoms.shape
    scale = float(np.abs(tensions).max(initial=0.0)) or 1.0
    cost = np.append(np.zeros(k), -1.0)
    bounds = [(None, None)] * k + [(None, 1.0)]
    rows = np.hstack([-freedoms, np.ones((n, 1))])
    optimum = scipy.optimize.linprog(cost, rows, tensions / scale, bounds=bounds)
    return tensions if optimum.x is None else np.asarray(tensions + scale * freedoms @ optimum.x[:k])
