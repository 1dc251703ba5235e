"""Whether the end of a step by CVODE solves its equations: `SolvedSteps`.

CVODE keeps derivatives for up to fifty steps, whatever their length, and takes small corrections by them for
a sign of convergence. Where the equations were far stiffer when the derivatives were computed, as beside a
place where angles do not determine a rotation, corrections are small however wrong a state is, and so is the
estimate of its error, which is the sum of the corrections. IDA needs no such look: it computes derivatives
anew whenever its step changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.methods.stepping import NODES, SHARES

Floats = NDArray[np.float64]

# Iterations end within one or two tolerated errors, and a few are left where derivatives change much. Ten are
# what `Projection` takes for too much as well.
WRONG: Final = 10.0
# Formulas of order 1 to 5 are y' = (y - what is known) / (beta h) with beta from 1 down to 137/300, if steps
# have one length. By that factor the correction may differ at most.
SHARE_OF_STEP: Final = 2.0


def _end_slope() -> Floats:
    """Return what, times values at all `SHARES` but the first, is the slope at 1 of their polynomial.

    The first is left out: there a state may have been brought onto the constraints. The others are enough for
    the solver's polynomials, of degree 5 at most.
    """
    degrees = np.arange(NODES - 1)
    found = np.linalg.solve(np.vander(SHARES[1:], NODES - 1, increasing=True).T, degrees)
    return np.asarray(found, dtype=np.float64)


_END_SLOPE: Final = _end_slope()
_ROUNDED: Final = float(np.abs(_END_SLOPE).sum()) * EPSILON


@dataclass(frozen=True, slots=True, eq=False)
class SolvedSteps:
    """Looks at steps by the correction of Newton's method with the derivatives at their very end.

    Attributes
    ----------
    rates, jacobian : callable
        From t and x to x', and to dx'/dx.
    """

    rates: Callable[[float, Floats], Floats]
    jacobian: Callable[[float, Floats], Floats]
    rtol: float
    atol: float | Floats

    def __call__(self, t: float, length: float, nodes: Floats) -> bool:
        """Return whether the correction is small at the end t of a step with states at all `SHARES`."""
        x, slope = nodes[-1], _END_SLOPE @ nodes[1:] / length
        wrong = slope - self.rates(t, x)
        if not np.isfinite(wrong).all():
            return True  # whatever is wrong there shows in the next step
        rounded = np.abs(nodes).max(axis=0) + np.abs(t * slope)  # states, and the times they belong to
        weights = self.rtol * np.abs(x) + self.atol + _ROUNDED * rounded
        matrix = SHARE_OF_STEP / length * np.eye(x.size) - self.jacobian(t, x)
        try:
            correction = np.linalg.solve(matrix, wrong)
        except np.linalg.LinAlgError:
            return True  # the solver's own matrix could be solved
        return not float(np.sqrt(np.mean((correction / weights) ** 2))) > WRONG
