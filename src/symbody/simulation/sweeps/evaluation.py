"""Outputs of all cases that are not stored, computed when they are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.compile import form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.simulation.hybrid.switching import switches
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.results.provenance import Provenance, provenance_of
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Equations with the cases they are computed for."""

    eqs: EquationSet
    table: CaseTable
    laws: InputLaws
    _functions: SingleFlight[str | tuple[str, ...], CompiledFunction] = field(
        default_factory=SingleFlight, repr=False
    )

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

    def of_case(self, case: int, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs of one case with time last; q is (n_q, N), u is (n_u, N)."""
        p = self.table.parameters[case]
        if len(names) == 1:
            computed = [self._at(names[0], t, q.T, u.T, p)]
        else:
            arrays = self._function(tuple(names))(t, q.T, u.T, self.laws.values(t, q, u), p)
            computed = [_at_all_times(array, t) for array in arrays]
        angles = self.eqs.measured_angles
        return [
            np.unwrap(values) if name in angles else np.moveaxis(values, 0, -1)
            for name, values in zip(names, computed, strict=True)
        ]

    def provenance(self, case: int) -> Provenance | None:
        """Return what one case was computed from."""
        return provenance_of(
            self.eqs, self.table.values(case)[0], self.laws, switches=switches(self.eqs.formed)
        )

    def _at(self, name: str, t: Floats, q: Floats, u: Floats, p: Floats) -> Floats:
        return _at_all_times(self._function(name)(t, q, u, self.laws.values(t, q.T, u.T), p), t)

    def _function(self, outputs: str | tuple[str, ...]) -> CompiledFunction:

        def compiled() -> CompiledFunction:
            table = self.table
            sequence = form_sequence(
                self.eqs, outputs, table.fixed_parameters, table.parameter_names, self.laws.formulas
            )
            return CompiledFunction(*sequence, quick=True)

        return self._functions.get(outputs, compiled)


def _at_all_times(values: Floats, t: Floats) -> Floats:
    return np.broadcast_to(values, (t.size, *values.shape[1:])) if values.ndim else np.full(t.size, values)


@dataclass(frozen=True, slots=True, eq=False)
class CaseEvaluator:
    """Computes outputs of one case that are not stored."""

    evaluation: Evaluation
    case: int

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last; q is (n_q, N), u is (n_u, N)."""
        return self.together((name,), t, q, u)[0]

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last, by one compiled function."""
        return self.evaluation.of_case(self.case, names, t, q, u)
