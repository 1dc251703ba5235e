"""`continued`: whether equilibria go on from one of them, or its linear stiffness only vanishes there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.equilibrium.balance import Rest
from symbody.analysis.equilibrium.search import Search

Floats = NDArray[np.float64]

_STEP: Final = 0.05  # in sizes: finite, so that terms of higher order show
_STAYED: Final = 0.5  # of the step: equilibria go on where Newton's method leads back by less
_LISTED: Final = 1e-6  # of the largest component


@dataclass(frozen=True, slots=True)
class Continuation:
    """What lies about an equilibrium.

    Attributes
    ----------
    doubt : str
        "critical" where the stiffness vanishes without further equilibria, "undecided" where branches cross,
        else empty.
    notes : tuple of str
        The same in sentences.
    """

    doubt: str
    notes: tuple[str, ...]


def continued(search: Search, equilibrium: Rest) -> Continuation:
    """Return whether other equilibria lie about one."""
    if search.is_crossing(equilibrium):
        note = (
            "branches of the motion cross at this configuration: forces do no work along any of them, and "
            "linear equations do not show whether it is stable"
        )
        return Continuation("undecided", (note,))
    flat = search.flat_directions(equilibrium)
    if not flat.shape[1]:
        return Continuation("", ())
    going, left = _split_directions(search, equilibrium, flat)
    notes = []
    if going.shape[1]:
        notes.append(
            f"equilibria form a continuum of {going.shape[1]} dimension(s) along "
            f"{_names(search, going)}: the one nearest to the guess by the shortest steps is given"
        )
    if left.shape[1]:
        notes.append(
            f"the equilibrium is critical: its stiffness vanishes along {_names(search, left)}, but no "
            "equilibria lie beside it, and terms of higher order decide whether it is stable"
        )
    return Continuation("critical" if left.shape[1] else "", tuple(notes))


def _split_directions(search: Search, equilibrium: Rest, flat: Floats) -> tuple[Floats, Floats]:
    """Return the flat directions in which equilibria go on, and the others.

    From a step along each, Newton steps of least length lead to an equilibrium; across equilibria that go on
    they leave the step as it is, and back along directions in which a force of higher order stands.
    """
    free, sizes = search.free, search.evaluator.sizes
    moves = []
    for direction in flat.T:
        q = equilibrium.q.copy()
        q[free] += _STEP * direction * sizes[free]
        end = search.newton(search.evaluator.normalized(q), equilibrium.bearing)
        move = (end.q - equilibrium.q)[free] / sizes[free] / _STEP
        moves.append(flat.T @ move if search.is_good(end) else np.zeros(flat.shape[1]))
    left, singular, _ = np.linalg.svd(np.array(moves).T)
    count = int((singular > _STAYED).sum())
    return flat @ left[:, :count], flat @ left[:, count:]


def _names(search: Search, directions: Floats) -> str:
    free = [name for name in search.evaluator.eqs.coordinate_names if name not in search.fixed]
    shares = np.abs(directions).max(axis=1)
    return ", ".join(n for n, share in zip(free, shares, strict=True) if share > _LISTED * shares.max())
