"""`passage_balance`: whether T + V - W goes on where a method decided how a motion goes on.

Every step leaves an error in the balance of kinetic and potential energy and work. Where a motion went on
along another branch, or in another mode, than its equations allow, the balance jumps by far more than the
steps beside the passage make. It is asked there alone: other motions are judged by the errors of their steps.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]

# What a passage may be worse than the steps beside it.
_WORSE: Final = 1e3
_STEPS: Final = 5  # on either side
_OUTPUTS: Final = ("kinetic_energy", "potential_energy")


class PassageBalance(NamedTuple):
    """How T + V - W changes across a passage [J].

    Attributes
    ----------
    change : float
        Across the passage.
    usual : float
        In a step beside it, or by the tolerance of one, whichever is more.
    """

    change: float
    usual: float

    @property
    def holds(self) -> bool:
        """Whether the passage is no worse than what decides nothing."""
        return bool(self.change <= _WORSE * self.usual)


def passage_balance(
    problem: SimulationProblem, dense: DenseOutput, before: float, after: float, rtol: float
) -> PassageBalance:
    """Return how the balance of a motion changes between two times about a passage.

    Parameters
    ----------
    dense : DenseOutput
        The motion, the work behind its state.
    rtol : float
        Relative tolerance of a step: of the energies it may leave as much.
    """
    breaks, way = dense.breaks, 1.0 if dense.breaks[-1] >= dense.breaks[0] else -1.0
    first = breaks[way * (breaks - before) < 0.0][-_STEPS:]
    last = breaks[way * (breaks - after) > 0.0][:_STEPS]
    t = np.concatenate([first, [before, after], last])
    n_u, n = len(problem.eqs.speed_names), len(problem.eqs.state_names)
    x = dense(t)
    function = problem.compile_outputs(_OUTPUTS)
    kinetic, potential = problem.evaluate(function, t, x[n_u:n], x[:n_u])
    balance = kinetic + potential - x[-1]
    largest = max(float(np.abs(part).max()) for part in (kinetic, x[-1] - x[-1, 0], potential - potential[0]))
    rounding = EPSILON * float(np.abs(potential).max() + np.abs(x[-1]).max())
    changes = np.abs(np.diff(balance))
    usual = np.delete(changes, first.size).max(initial=rtol * largest + rounding)
    return PassageBalance(float(changes[first.size]), float(usual))
