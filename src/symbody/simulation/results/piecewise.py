"""`Piecewise`: outputs of a motion whose equations change on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.simulation.results.evaluate import Evaluate, EvaluateTogether

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Piecewise:
    """Computes outputs by the equations that hold at each time.

    Attributes
    ----------
    starts : (parts,) array
        When each part begins [s].
    parts : tuple of callable
        What computes in each.
    work : (parts,) array
        Done before each [J].
    """

    starts: Floats
    parts: tuple[Evaluate, ...]
    work: Floats

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Angles of cut joints, which are given within half a turn."""
        found: tuple[str, ...] = getattr(self.parts[0], "wrapped_angles", ()) if self.parts else ()
        return found

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last; of two samples at a change the first is of the part before."""
        return self.together((name,), t, q, u)[0]

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last, by one function a part; see `__call__`."""
        way = -1.0 if self.starts[-1] < self.starts[0] else 1.0
        starts, along = way * self.starts, way * t
        place = np.maximum(np.searchsorted(starts, along, side="right") - 1, 0)
        before = np.flatnonzero((t[:-1] == t[1:]) & np.isin(t[:-1], self.starts[1:]))
        place[before] = np.maximum(np.searchsorted(starts, along[before], side="left") - 1, 0)
        whole: dict[str, Floats] = {}
        for k in np.unique(place):
            inside = place == k
            computed = _outputs(self.parts[k], names, t[inside], q[:, inside], u[:, inside])
            for name, values in zip(names, computed, strict=True):
                shape = values.shape[:-1]
                array = whole.setdefault(name, np.empty((*shape, t.size)))
                array[..., inside] = values + self.work[k] if name == "work" else values
        return [whole.get(name, np.empty((0,))) for name in names]


def _outputs(part: Evaluate, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
    if isinstance(part, EvaluateTogether):
        return part.together(names, t, q, u)
    return [part(name, t, q, u) for name in names]
