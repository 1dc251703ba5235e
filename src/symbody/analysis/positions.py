"""Configurations without velocities and accelerations: what a picture of a mechanism needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import assemble, consistent_start
from symbody.analysis.closure import Closure, closure
from symbody.analysis.named_values import named_values
from symbody.analysis.scales import mechanism_scales
from symbody.codegen.compile import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.ropes import ropes


@dataclass(frozen=True, slots=True, eq=False)
class PositionSolver:
    """Closes the loops of one mechanism again and again, with its own values of the parameters.

    Attributes
    ----------
    evaluator : Closure or None
        None where ropes decide what is closed.
    """

    eqs: EquationSet
    evaluator: Closure | None

    def positions(self, fixed: Mapping[str, Value], guess: Mapping[str, Value]) -> dict[str, float]:
        """Return all coordinates q where the loops close, as `assemble` finds them.

        Raises
        ------
        AssemblyError
            As `assemble`; but accelerations need not exist.
        """
        if self.evaluator is None:
            return dict(assemble(self.eqs, fixed, guess).q)
        model = self.eqs.model.initial
        guessed: dict[str, Value] = {
            **guess,
            **{name: value for name, value in model.items() if name not in guess},
        }
        near = named_values(self.eqs, guessed, None, strict=set(guess))
        values = named_values(self.eqs, fixed, None, strict=set(fixed))
        q, _ = consistent_start(self.evaluator, values, near)
        return dict(zip(self.eqs.coordinate_names, q.tolist(), strict=True))

    def nearest(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coordinates (n_q,) nearest to others at which the loops close.

        The initial values of the model have no part in it.

        Raises
        ------
        AssemblyError
            If they close nowhere near.
        """
        guess = dict(zip(self.eqs.coordinate_names, q.tolist(), strict=True))
        if self.evaluator is None:
            return np.array(list(assemble(self.eqs, None, guess).q.values()))
        closed, _ = consistent_start(self.evaluator, {}, guess)
        return closed


def position_solver(eqs: EquationSet) -> PositionSolver:
    """Return a solver that closes the loops of a mechanism.

    Raises
    ------
    ModelError, CompileError
        If parameters have no values.
    """
    if ropes(eqs.formed):
        return PositionSolver(eqs, None)
    near = named_values(eqs, dict(eqs.model.initial), None, strict=set())
    return PositionSolver(eqs, closure(eqs, {}, {}, 0.0, mechanism_scales(eqs, {}, None, near)))
