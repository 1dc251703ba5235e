"""`ModeNumbers`: which dry joints stick and which ropes pull at a state, from the output `OF_MODES`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.modes.reduced_modes import ModeCandidate, ModeSolution, ModeVerdict, Responses, decide
from symbody.analysis.scales import Scales
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.mode_responses import candidate_gaps, candidate_laws, reaction_sizes
from symbody.kernels.modes.mode_problem import BOUNDED, HOLDS, LOOSE, UNILATERAL
from symbody.tolerances import BALANCED, CANCELLED

Floats = NDArray[np.float64]


class Opening(NamedTuple):
    """What is known of an element before its mode is decided.

    Attributes
    ----------
    mode : int
        ``HOLDS``, or the sign of slip; ``LOOSE`` for a slack rope.
    is_decided : bool
        Whether that is its mode, since it moves.
    """

    mode: int
    is_decided: bool = False


UNDECIDED = Opening(HOLDS)


@dataclass(frozen=True, slots=True, eq=False)
class ModeNumbers:
    """What decides about modes at a state.

    Attributes
    ----------
    joints, ropes : tuple of str
        Joints whose friction switches or depends on reactions, and ropes: the order of the candidates.
    responses : Responses
    candidates : tuple of ModeCandidate
        Undecided but for joints with smooth friction.
    """

    joints: tuple[str, ...]
    ropes: tuple[str, ...]
    responses: Responses
    candidates: tuple[ModeCandidate, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All candidates."""
        return (*self.joints, *self.ropes)

    def slight_effort(self, name: str) -> float:
        """Return the effort that is rounding: that of the mass a candidate moves, by what cancels."""
        k = self.names.index(name)
        response = float(self.responses.matrix[k, k])
        return CANCELLED / BALANCED * self.candidates[k].rounding / response if response > 0.0 else 0.0

    def decide(self, openings: Mapping[str, Opening]) -> ModeSolution:
        """Return which candidates hold.

        Ropes that are slack whatever the efforts are take no part: at length 0 they have no direction.
        """
        opened = [self._open(k, openings) for k in range(len(self.names))]
        acting = [k for k, one in enumerate(opened) if not (one.kind == UNILATERAL and one.moves)]
        found = decide([opened[k] for k in acting], self.responses.of_rows(acting))
        modes, efforts = np.full(len(opened), LOOSE), np.zeros(len(opened))
        modes[acting], efforts[acting] = found.modes, found.efforts
        accelerations = self.responses.offsets + self.responses.matrix[:, acting] @ found.efforts
        accelerations[acting] = found.accelerations
        return found._replace(modes=tuple(modes.tolist()), efforts=efforts, accelerations=accelerations)

    def strike(self, rates: Mapping[str, float]) -> dict[str, float] | None:
        """Return the impulses after which the ends of no rope move apart; None where there are none.

        Parameters
        ----------
        rates : mapping of rope to float
            Of slackness before, of those at their length.
        """
        places = [self.names.index(name) for name in rates]
        responses = self.responses.of_rows(places)._replace(offsets=np.array(list(rates.values())))
        ends = [ModeCandidate(UNILATERAL, self.candidates[k].scale) for k in places]
        found = decide(ends, responses._replace(loads=np.zeros(0), reactions=np.zeros((0, len(places)))))
        if found.verdict is not ModeVerdict.ONE:
            return None
        triples = zip(rates, found.modes, found.efforts.tolist(), strict=True)
        return {name: impulse for name, mode, impulse in triples if mode == HOLDS}

    def _open(self, k: int, openings: Mapping[str, Opening]) -> ModeCandidate:
        candidate = self.candidates[k]
        opening = openings.get(self.names[k])
        if opening is None:
            return candidate
        return candidate.with_slip(opening.mode, moves=opening.is_decided)


def mode_numbers(eqs: EquationSet, values: Sequence[float], scales: Scales) -> ModeNumbers:
    """Return what decides about modes from the values of the output `OF_MODES`."""
    formed = eqs.formed
    laws, lines = candidate_laws(formed), candidate_gaps(formed)
    counts: list[int] = eqs.plans.get("reaction sizes", lambda: reaction_sizes(formed))
    n, c = len(laws) + len(lines), sum(counts)
    sizes = [3 * len(laws), n, n * n, c, c * n, n]
    parts = np.split(np.asarray(values, dtype=np.float64), np.cumsum(sizes))
    strengths = parts[0].reshape(-1, 3)
    responses = Responses(parts[1], parts[2].reshape(n, n), parts[3], parts[4].reshape(c, n))
    units = [1.0 if law.turns else scales.length for law in laws] + [scales.gap(eqs, name) for name in lines]
    rounding = BALANCED * parts[5] + CANCELLED * np.array(units) / scales.time**2
    candidates = [
        ModeCandidate(BOUNDED, unit, count, float(sliding), float(static), rounding=float(slight))
        .with_slip(0.0 if law.switches else float(slip), moves=not law.switches)
        for law, unit, count, (slip, sliding, static), slight
        in zip(laws, units, counts, strengths, rounding, strict=False)
    ]  # fmt: skip
    candidates += [
        ModeCandidate(UNILATERAL, unit, rounding=float(slight))
        for unit, slight in zip(units[len(laws) :], rounding[len(laws) :], strict=True)
    ]
    names = tuple(law.joint.name for law in laws)
    return ModeNumbers(names, tuple(lines), responses, tuple(candidates))
