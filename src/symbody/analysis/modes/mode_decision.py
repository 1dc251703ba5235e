"""`ModeNumbers`: what sticks and which gaps are closed at a state, from the output `OF_MODES`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.modes.reduced_modes import ModeCandidate, ModeSolution, Responses, decide
from symbody.analysis.scales import Scales
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.mode_responses import candidate_gaps, candidate_laws, reaction_sizes
from symbody.kernels.modes.mode_problem import BOUNDED, CONE, HOLDS, LOOSE, UNILATERAL
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
OPEN = Opening(LOOSE, is_decided=True)  # of a gap


@dataclass(frozen=True, slots=True, eq=False)
class ModeNumbers:
    """What decides about modes at a state.

    Attributes
    ----------
    joints, gaps : tuple of str
        Joints and contacts whose friction switches or depends on reactions, and gaps: the candidates.
    responses : Responses
    candidates : tuple of ModeCandidate
        Undecided but for joints with smooth friction.
    """

    joints: tuple[str, ...]
    gaps: tuple[str, ...]
    responses: Responses
    candidates: tuple[ModeCandidate, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All candidates."""
        return (*self.joints, *self.gaps)

    def decide(self, openings: Mapping[str, Opening]) -> ModeSolution:
        """Return which candidates hold.

        Gaps that are open whatever the efforts are take no part: a rope of length 0 has no direction.
        """
        opened = [self._open(k, openings) for k in range(len(self.names))]
        acting = [k for k, one in enumerate(opened) if not (one.kind == UNILATERAL and one.moves)]
        first = np.cumsum([0, *(one.rows for one in opened)])
        rows = [row for k in acting for row in range(first[k], first[k + 1])]
        found = decide([opened[k] for k in acting], self.responses.of_rows(rows))
        modes = np.full(len(opened), LOOSE)
        modes[acting] = found.modes
        efforts = np.zeros(first[-1])
        efforts[rows] = found.efforts
        accelerations = self.responses.offsets + self.responses.matrix[:, rows] @ found.efforts
        accelerations[rows] = found.accelerations
        return found._replace(modes=tuple(modes.tolist()), efforts=efforts, accelerations=accelerations)

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
    names = tuple(dict.fromkeys(law.element for law in laws))
    candidates, kept = [], list[int]()  # both directions of a contact read one reaction
    for name in names:
        own = [k for k, law in enumerate(laws) if law.element == name]
        slip, sliding, static = strengths[own[0]]
        one = ModeCandidate(
            CONE if len(own) > 1 else BOUNDED, units[own[0]], counts[own[0]], float(sliding), float(static),
            rounding=float(rounding[own].max()),
        )  # fmt: skip
        switches = laws[own[0]].switches
        candidates.append(one.with_slip(0.0 if switches else float(slip), moves=not switches))
        start = sum(counts[: own[0]])
        kept += range(start, start + counts[own[0]])
    responses = responses._replace(loads=responses.loads[kept], reactions=responses.reactions[kept])
    candidates += [
        ModeCandidate(UNILATERAL, unit, rounding=float(slight))
        for unit, slight in zip(units[len(laws) :], rounding[len(laws) :], strict=True)
    ]
    return ModeNumbers(names, tuple(lines), responses, tuple(candidates))
