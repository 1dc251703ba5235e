"""Outputs of all cases that are not stored, computed when they are first read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import Scales, mechanism_scales
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.simulation.hybrid.modes import HybridMechanism, Modes
from symbody.simulation.hybrid.switching import hybrid_mechanism, switches
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.results.measured_angles import count_turns
from symbody.simulation.results.piecewise import Piecewise, changing_shape
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
    _functions: SingleFlight[tuple[Modes, str | tuple[str, ...]], CompiledFunction] = field(
        default_factory=SingleFlight, repr=False
    )
    _mechanisms: SingleFlight[str, HybridMechanism] = field(default_factory=SingleFlight, repr=False)

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
        if len(plain) < 2 or self._has_modes(case):
            computed = {name: self._values(name, cases, t, q.T, u.T) for name in plain}
        else:
            function = self._function((), plain)
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
        return values

    def _held_values(self, case: int) -> HeldRecord | None:
        return self.details[case].held if case in self.details else None

    def _has_modes(self, case: int) -> bool:
        return case in self.details and bool(self.details[case].modes)

    def _values(self, name: str, cases: NDArray[np.intp], t: Floats, q: Floats, u: Floats) -> Floats:
        """Return an output with time first, each sample by the equations that held at its time."""
        whole: Floats | None = None
        for modes, inside in self._samples_by_modes(cases, t):
            given = t[inside], q[inside], u[inside]
            inputs = self._inputs(cases[inside], given[0], given[1].T, given[2].T)
            values = self._function(modes, name)(*given, inputs, self.table.parameters[cases[inside]])
            values = _repeat_constant(values, given[0])
            if whole is None:
                whole = np.empty((t.size, *values.shape[1:]))
            if values.shape[1:] != whole.shape[1:]:
                raise changing_shape(name)
            whole[inside] = values
        return np.empty(0) if whole is None else whole

    def _samples_by_modes(self, cases: NDArray[np.intp], t: Floats) -> Iterator[tuple[Modes, Flags]]:
        """Yield modes, and which samples lie in them; none where the equations stay the same."""
        modes: list[Modes] = [()] * t.size
        for case in filter(self._has_modes, np.unique(cases).tolist()):
            details = self.details[case]
            starts = np.array(details.starts)
            for k in np.flatnonzero(cases == case).tolist():
                modes[k] = details.modes[max(int(np.searchsorted(starts, t[k], side="right")) - 1, 0)]
        if not modes:
            yield (), np.zeros(0, dtype=np.bool_)
        for some in dict.fromkeys(modes):
            yield some, np.array([other == some for other in modes], dtype=np.bool_)

    def _function(self, modes: Modes, outputs: str | tuple[str, ...]) -> CompiledFunction:

        def compile_outputs() -> CompiledFunction:
            table = self.table
            return bound_function(
                self._equations(modes), outputs, table.fixed_parameters, table.parameter_names,
                self.laws.formulas, quick=True,
            )  # fmt: skip

        return self._functions.get((modes, outputs), compile_outputs)

    def _equations(self, modes: Modes) -> EquationSet:
        """Return the equations in some modes, which depend neither on values nor on scales."""
        if not modes:
            return self.eqs
        problem = SimulationProblem(self.eqs, self.table.fixed_parameters, self.laws, Scales())
        mechanism = self._mechanisms.get("mechanism", lambda: hybrid_mechanism(problem))
        return mechanism.problem_in(modes).eqs

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
        if not self._has_modes(case):
            return Evaluator(problem, None)(name, t, q, u)
        mechanism, details = hybrid_mechanism(problem), self.details[case]
        parts = tuple(Evaluator(mechanism.problem_in(modes), None) for modes in details.modes)
        return Piecewise(np.array(details.starts), parts, np.zeros(len(parts)))(name, t, q, u)


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
