"""What computes outputs of a motion that are not stored."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Evaluate(Protocol):
    """Computes an output that is not stored."""

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last, from t (N,), q (n_q, N) and u (n_u, N)."""
        ...


@runtime_checkable
class EvaluateTogether(Evaluate, Protocol):
    """Computes several outputs by one function, which is compiled once."""

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return the outputs with time last."""
        ...
