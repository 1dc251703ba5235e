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
from symbody.simulation.results.evaluate import EvaluateTogether
from symbody.simulation.results.measured_angles import count_turns
from symbody.simulation.results.provenance import Provenance, provenance_of
from symbody.simulation.simulation_problem import VIOLATIONS, Evaluator
from symbody.simulation.sweeps.case_scales import scales_of_cases
from symbody.simulation.sweeps.records import CaseDetails
from symbody.simulation.sweeps.sweep_job import SweepJob
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


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

    def of_case(self, case: int) -> EvaluateTogether:
        """Return what computes the outputs of one case."""
        job, details = self.job, self.details.get(case)
        problem, scales = job.motion.problem, self._scales.get(None, self._find_scales).of_motion(case)
        laws, p = job.laws, job.table.parameters[case]
        if details is not None and details.held is not None:
            held = {name: HeldLaw(details.held, name) for name in details.held.names}
            laws = replace(
                laws, callbacks={name: held.get(name, law) for name, law in laws.callbacks.items()}
            )
        eqs = self.eqs
        if details is not None and details.modes is not None:
            laws = laws.with_held({name: HeldLaw(details.modes, name) for name in details.modes.names})
            eqs = modal_equations(eqs).eqs
        return Evaluator(replace(problem, eqs=eqs, laws=laws, scales=scales, p=p), None)

    def evaluate(self, name: str) -> Floats:
        """Return an output with cases first and time last."""
        x, t = self.x, self.job.times
        is_known: Flags = np.asarray(np.isfinite(x).all(axis=1))
        if name == "work" and {*np.nonzero(is_known)[0].tolist()} <= {*self.details}:
            return self._work(is_known)
        is_serial = np.full(len(x), name in (*VIOLATIONS, *self.eqs.wrapped_angles))
        is_serial[[case for case, details in self.details.items() if details.modes or details.held]] = True
        case, sample = np.nonzero(is_known & ~is_serial[:, np.newaxis])
        n_u, p = len(self.eqs.speed_names), self.job.table.parameters[case]
        problem = replace(self.job.motion.problem, p=p)
        rows = x[case, :, sample].T
        parts = []
        if case.size or not (is_known.any(axis=1) & is_serial).any():
            parts.append((case, sample, Evaluator(problem, None)(name, t[sample], rows[n_u:], rows[:n_u])))
        for k in np.flatnonzero(is_known.any(axis=1) & is_serial).tolist():
            at, states = t[is_known[k]], x[k][:, is_known[k]]
            q, u, evaluate = states[n_u:], states[:n_u], self.of_case(k)
            values = count_turns(evaluate, name, evaluate(name, at, q, u), at, q, u)
            parts.append((np.full(at.size, k), np.flatnonzero(is_known[k]), values))
        whole = np.full((len(x), *parts[0][2].shape[:-1], t.size), np.nan)
        for case, sample, values in parts:
            np.moveaxis(whole, -1, 1)[case, sample] = np.moveaxis(values, -1, 0)
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
