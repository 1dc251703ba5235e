"""Outputs of all cases that are not stored, computed when they are first read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import mechanism_scales
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import ModalEquations, modal_equations, switches
from symbody.simulation.inputs.held_law import HeldLaw, HeldRecord
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.results.measured_angles import count_turns
from symbody.simulation.results.provenance import Provenance, provenance_of
from symbody.simulation.simulation_problem import VIOLATIONS, Evaluator, SimulationProblem
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.simulation.sweeps.records import CaseDetails
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Equations with the cases they are computed for.

    Attributes
    ----------
    details : mapping of case to CaseDetails
        Of cases whose equations changed on the way, among others.
    scales : mapping of name to float
        As in `sweep`.
    """

    eqs: EquationSet
    table: CaseTable
    laws: InputLaws
    span: tuple[float, float]
    details: Mapping[int, CaseDetails]
    scales: Mapping[str, float]
    _functions: SingleFlight[str | tuple[str, ...], CompiledFunction] = field(
        default_factory=SingleFlight, repr=False
    )

    def evaluate(self, name: str, t: Floats, x: Floats) -> Floats:
        """Return an output with cases first and time last; x is (cases, n, N)."""
        is_known: Flags = np.asarray(np.isfinite(x).all(axis=1))
        if name == "work" and {*np.nonzero(is_known)[0].tolist()} <= {*self.details}:
            return self._work(is_known)
        if name in VIOLATIONS:
            return self._violations(name, t, x)
        n_u = len(self.eqs.speed_names)
        case, sample = np.nonzero(is_known)
        rows = x[case, :, sample]
        values = self._values(name, case, t[sample], rows[:, n_u:], rows[:, :n_u])
        whole: Floats = np.full((*is_known.shape, *values.shape[1:]), np.nan)
        whole[case, sample] = values
        for k, known in enumerate(is_known if name in self.eqs.wrapped_angles else ()):
            own, at_k, states = CaseEvaluator(self, k), whole[k, known], x[k][:, known]
            whole[k, known] = count_turns(own, name, at_k, t[known], states[n_u:], states[:n_u])
        return np.moveaxis(whole, 1, -1)

    def evaluate_case(self, case: int, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs of one case with time last; q is (n_q, N), u is (n_u, N)."""
        plain = tuple(name for name in names if name not in VIOLATIONS)
        cases = np.full(t.size, case)
        if len(plain) < 2:
            computed = {name: self._values(name, cases, t, q.T, u.T) for name in plain}
        else:
            function = self._function(plain)
            arrays = function(t, q.T, u.T, self._inputs(cases, t, q, u), self.table.parameters[case])
            computed = {name: _repeat_constant(array, t) for name, array in zip(plain, arrays, strict=True)}
        shown = {name: np.moveaxis(values, 0, -1) for name, values in computed.items()}
        return [shown[name] if name in shown else self._violation(case, name, t, q, u) for name in names]

    def provenance(self, case: int) -> Provenance | None:
        """Return what one case was computed from."""
        return provenance_of(
            self.eqs, self.table.values(case)[0], self.laws, held=self._held_values(case),
            switches=switches(self.eqs.formed),
        )  # fmt: skip

    def _inputs(self, cases: NDArray[np.intp], t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the inputs of each sample (N, n), held values as each case had them."""
        values = self.laws.values(t, q, u)
        for case in np.unique(cases).tolist() if self.laws.held_laws else ():
            held, inside = self._held_values(case), cases == case
            for place, law in self.laws.held_laws.items():
                values[inside, place] = np.nan if held is None else held.values_at(law.name, t[inside])
        names = self._modal.modes
        modes = np.full((t.size, len(names)), np.nan)
        for case in np.unique(cases).tolist() if names else ():
            record, inside = self._modes(case), cases == case
            for place, name in enumerate(names if record is not None else ()):
                modes[inside, place] = record.values_at(name, t[inside])
        return np.concatenate([values, modes], axis=1)

    def _held_values(self, case: int) -> HeldRecord | None:
        return self.details[case].held if case in self.details else None

    def _modes(self, case: int) -> HeldRecord | None:
        return self.details[case].modes if case in self.details else None

    def _values(self, name: str, cases: NDArray[np.intp], t: Floats, q: Floats, u: Floats) -> Floats:
        """Return an output with time first."""
        if not t.size:
            return np.empty(0)
        inputs = self._inputs(cases, t, q.T, u.T)
        values = self._function(name)(t, q, u, inputs, self.table.parameters[cases])
        return _repeat_constant(values, t)

    def _function(self, outputs: str | tuple[str, ...]) -> CompiledFunction:

        def compile_outputs() -> CompiledFunction:
            table = self.table
            return bound_function(
                self._modal.eqs, outputs, table.fixed_parameters, table.parameter_names, self.laws.formulas,
                quick=True,
            )  # fmt: skip

        return self._functions.get(outputs, compile_outputs)

    @property
    def _modal(self) -> ModalEquations:
        return modal_equations(self.eqs)

    def _work(self, known: Flags) -> Floats:
        whole: Floats = np.full(known.shape, np.nan)
        for case, details in self.details.items():
            if details.work is not None:
                whole[case, : details.work.size] = details.work
        return whole

    def _violations(self, name: str, t: Floats, x: Floats) -> Floats:
        """Return how far constraints are open in all cases, (cases, N)."""
        n_u = len(self.eqs.speed_names)
        whole: Floats = np.full((len(x), t.size), np.nan)
        for case, states in enumerate(x):
            known = np.isfinite(states).all(axis=0)
            u, q = states[:n_u, known], states[n_u:, known]
            whole[case, known] = self._violation(case, name, t[known], q, u)
        return whole

    def _violation(self, case: int, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        parameters, near = self.table.values(case)[0], dict.fromkeys(self.eqs.coordinate_names, 0.0)
        if t.size:
            near = dict(zip(self.eqs.coordinate_names, q[:, 0].tolist(), strict=False))
        scales = mechanism_scales(self.eqs, parameters, self.scales, near).fit_span(*self.span)
        problem = SimulationProblem(self.eqs, parameters, self.laws, scales)
        record = self._modes(case)
        if record is not None:
            laws = self.laws.with_held({each: HeldLaw(record, each) for each in record.names})
            problem = replace(problem, eqs=self._modal.eqs, laws=laws)
        return Evaluator(problem, None)(name, t, q, u)


def _repeat_constant(values: Floats, t: Floats) -> Floats:
    return np.broadcast_to(values, (t.size, *values.shape[1:])) if values.ndim else np.full(t.size, values)


@dataclass(frozen=True, slots=True, eq=False)
class CaseEvaluator:
    """Computes outputs of one case that are not stored."""

    evaluation: Evaluation
    case: int

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Angles of cut joints, which are given within half a turn."""
        return self.evaluation.eqs.wrapped_angles

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last; q is (n_q, N), u is (n_u, N)."""
        return self.together((name,), t, q, u)[0]

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last, by one compiled function."""
        return self.evaluation.evaluate_case(self.case, names, t, q, u)
