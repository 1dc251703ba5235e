"""Outputs of all cases that are not stored, computed when they are first read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import Scales
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import modal_equations, switches
from symbody.simulation.inputs.held_law import HeldLaw, HeldRecord
from symbody.simulation.results.measured_angles import count_turns
from symbody.simulation.results.provenance import Provenance, provenance_of
from symbody.simulation.simulation_problem import VIOLATIONS, Evaluator
from symbody.simulation.sweeps.case_scales import scales_of_cases
from symbody.simulation.sweeps.records import CaseDetails
from symbody.simulation.sweeps.sweep_job import SweepJob
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Places = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class _HeldAlong:
    """Held values at samples of several cases: the record of each, and which samples are its own."""

    records: tuple[tuple[HeldRecord, slice], ...]

    def current(self, name: str) -> float:
        """Return the last value."""
        return self.records[-1][0].current(name)

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a value at the times of the samples."""
        return np.concatenate([record.values_at(name, t[own]) for record, own in self.records])


@dataclass(frozen=True, slots=True, eq=False)
class CaseOutputs:
    """What computes the outputs of all cases of a sweep.

    Attributes
    ----------
    details : mapping of case to CaseDetails
        Of cases whose equations or held values changed on the way, among others.
    x : (cases, n, N) array
        The samples.
    """

    job: SweepJob
    details: Mapping[int, CaseDetails]
    x: Floats
    _scales: SingleFlight[None, Scales] = field(default_factory=SingleFlight, repr=False)

    @property
    def eqs(self) -> EquationSet:
        """The equations."""
        return self.job.eqs

    def _find_scales(self) -> Scales:
        places = enumerate(self.eqs.coordinate_names, len(self.eqs.speed_names))
        near = {name: np.nan_to_num(self.x[:, k, 0]) for k, name in places}
        job = self.job
        return scales_of_cases(self.eqs, job.table, near, job.motion.span, job.scales)

    def of_case(self, case: int) -> Evaluator:
        """Return what computes the outputs of one case at any times."""
        return self._evaluator(case, has_scales=True)

    def _evaluator(self, case: int | Places, *, has_scales: bool) -> Evaluator:
        """Return what computes the outputs of one case, or of one for each of some samples, in order.

        Along all of them modes change or none, and values are held or none; see `_kind`.
        """
        numbers, starts = np.unique(np.atleast_1d(case), return_index=True)
        eqs, laws, own = self.eqs, self.job.laws, list[CaseDetails]()
        if any(self._kind(int(numbers[0])) if numbers.size else ()):
            own = [self.details[k] for k in numbers.tolist()]
        places = [slice(*ends) for ends in zip(starts, [*starts[1:], None], strict=True)]
        for kind in ("held", "modes"):
            records = [record for each in own if (record := getattr(each, kind)) is not None]
            if records:
                source = _HeldAlong(tuple(zip(records, places, strict=True)))
                names = [n for n in records[0].names if kind == "modes" or n in laws.callbacks]
                laws = laws.with_held({name: HeldLaw(source, name) for name in names})
                eqs = modal_equations(eqs).eqs if kind == "modes" else eqs
        problem = replace(self.job.motion.problem, eqs=eqs, laws=laws, p=self.job.table.parameters[case])
        if has_scales:
            problem = replace(problem, scales=self._scales.get(None, self._find_scales).of_motion(case))
        return Evaluator(problem, None)

    def _kind(self, case: int) -> tuple[bool, bool]:
        """Return whether modes changed along a case, and whether values were held."""
        details = self.details.get(case)
        return details is not None and details.modes is not None, bool(details and details.held)

    def evaluate(self, name: str) -> Floats:
        """Return an output with cases first and time last."""
        x, t, n_u = self.x, self.job.times, len(self.eqs.speed_names)
        is_known: Flags = np.asarray(np.isfinite(x).all(axis=1))
        if name == "work" and {*np.nonzero(is_known)[0].tolist()} <= {*self.details}:
            return self._work(is_known)
        groups: dict[tuple[bool, bool, int], list[int]] = {}
        is_counted = name in self.eqs.wrapped_angles  # from sample to sample of each case
        for case in np.flatnonzero(is_known.any(axis=1)).tolist():
            groups.setdefault((*self._kind(case), case if is_counted else -1), []).append(case)
        whole: Floats | None = None
        for cases in groups.values() or [[]]:
            own, sample = np.nonzero(is_known[cases])
            every = np.array(cases, dtype=np.intp)[own]
            rows, at = x[every, :, sample].T, t[sample]
            evaluate = self._evaluator(every, has_scales=name in VIOLATIONS)
            values = evaluate(name, at, rows[n_u:], rows[:n_u])
            if is_counted:
                values = count_turns(evaluate, name, values, at, rows[n_u:], rows[:n_u])
            whole = np.full((len(x), *values.shape[:-1], t.size), np.nan) if whole is None else whole
            np.moveaxis(whole, -1, 1)[every, sample] = np.moveaxis(values, -1, 0)
        assert whole is not None
        return whole

    def provenance(self, case: int) -> Provenance | None:
        """Return what one case was computed from."""
        held: HeldRecord | None = self.details[case].held if case in self.details else None
        values = self.job.table.values(case)[0]
        return provenance_of(self.eqs, values, self.job.laws, held=held, switches=switches(self.eqs.formed))

    def _work(self, known: Flags) -> Floats:
        whole: Floats = np.full(known.shape, np.nan)
        for case, details in self.details.items():
            if details.work is not None:
                whole[case, : details.work.size] = details.work
        return whole
