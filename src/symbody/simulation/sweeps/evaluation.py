"""Outputs of all cases that are not stored, computed when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.compile import form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Equations with the cases they are computed for."""

    eqs: EquationSet
    table: CaseTable
    laws: InputLaws
    _functions: SingleFlight[str, CompiledFunction] = field(default_factory=SingleFlight, repr=False)

    def of(self, name: str, t: Floats, x: Floats) -> Floats:
        """Return an output with cases first and time last; x is (cases, n, N)."""
        n_u = len(self.eqs.speed_names)
        known = np.isfinite(x).all(axis=1)
        case, sample = np.nonzero(known)
        rows = x[case, :, sample]
        values = self._at(name, t[sample], rows[:, n_u:], rows[:, :n_u], self.table.parameters[case])
        whole: Floats = np.full((*known.shape, *values.shape[1:]), np.nan)
        whole[case, sample] = values
        if name in self.eqs.measured_angles:
            return np.unwrap(whole, axis=1)
        return np.moveaxis(whole, 1, -1)

    def of_case(self, case: int, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return an output of one case with time last; q is (n_q, N), u is (n_u, N)."""
        values = self._at(name, t, q.T, u.T, self.table.parameters[case])
        return np.unwrap(values) if name in self.eqs.measured_angles else np.moveaxis(values, 0, -1)

    def _at(self, name: str, t: Floats, q: Floats, u: Floats, p: Floats) -> Floats:

        def compiled() -> CompiledFunction:
            table = self.table
            sequence = form_sequence(
                self.eqs, name, table.fixed_parameters, table.parameter_names, self.laws.formulas
            )
            return CompiledFunction(*sequence, quick=True)

        function = self._functions.get(name, compiled)
        found: Floats = function(t, q, u, self.laws.values(t, q.T, u.T), p)
        return np.broadcast_to(found, (t.size, *found.shape[1:])) if found.ndim else np.full(t.size, found)
