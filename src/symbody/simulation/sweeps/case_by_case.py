"""Cases that are computed by `simulate`: whatever the loop over many cases cannot do."""

from __future__ import annotations

import numpy as np

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import modal_equations
from symbody.errors import SymbodyError
from symbody.kernels.block import Counts
from symbody.simulation.hybrid.mode_record import held_modes
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.held_law import HeldRecord, join_records
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.status import Status
from symbody.simulation.sweeps.records import CODES, CaseDetails, Records
from symbody.simulation.sweeps.sweep_job import SweepJob


def reason_for_simulate(eqs: EquationSet, laws: InputLaws, integrator: object, constraints: object) -> str:
    """Return why `simulate` has to compute the cases, empty if the loop over many cases can."""
    held = ", ".join(law.name for law in laws.held_laws.values())
    reasons = {
        f"values are sampled ({held})": bool(held),
        reason_for_python(eqs, laws, integrator, constraints): True,
        "prescribed rates may jump": may_jump(eqs),
    }
    return "; ".join(reason for reason, holds in reasons.items() if reason and holds)


def reason_for_python(eqs: EquationSet, laws: InputLaws, integrator: object, constraints: object) -> str:
    """Return why a motion is computed in part by Python, empty if it is not."""
    reasons = {
        f"inputs {', '.join(laws.callbacks)} are computed in Python": laws.need_python,
        f"{type(integrator).__name__} is not an explicit method": not isinstance(
            integrator, Explicit | FixedStep | None
        ),
        f"{type(constraints).__name__} runs in Python": not isinstance(
            constraints, Projection | Baumgarte | None
        ),
        "pivots of dependent speeds are monitored": bool(
            eqs.formed.elimination is not None and eqs.formed.elimination.pivots
        ),
    }
    return "; ".join(reason for reason, holds in reasons.items() if holds)


def compute_case(job: SweepJob, case: int, records: Records) -> None:
    """Compute one case and write down how it ended; a fault of one case does not end the sweep."""
    row = case - records.first
    try:
        run = job.simulate_case(case)
    except SymbodyError as error:
        records.codes[row] = CODES[Status.NOT_STARTED]
        records.details[case] = CaseDetails(str(error))
        return
    samples = run.t.size
    samples = min(samples, records.x.shape[1])  # without the last one of a motion that stops behind all times
    records.x[row] = np.nan
    records.x[row, :samples] = np.concatenate([run.u, run.q, run.s]).T[:samples]
    records.codes[row] = CODES[run.status]
    statistics, modal = run.statistics, modal_equations(job.eqs)
    counts = {
        "accepted": statistics.accepted,
        "rejected": statistics.rejected or 0,
        "evaluations": statistics.evaluations,
        "samples": samples,
    }
    records.counts[row] = [counts.get(name, 0) for name in Counts.fields]
    records.reached[row] = run.t[-1] if samples else np.nan
    names = tuple(dict.fromkeys(event.name for event in run.events))
    happened = [(names.index(event.name), event.t, *event.state.values()) for event in run.events]
    records.details[case] = CaseDetails(
        "; ".join(run.notes),
        names,
        np.array(happened, dtype=np.float64),
        run.stored["work"][:samples],
        held_modes(modal.modes, modal.names, run.modes),
        _held_values(job, run),
    )


def _held_values(job: SweepJob, run: Trajectory) -> HeldRecord | None:
    """Return what was sampled in a case, and what FMUs computed."""
    records = [] if run.held_values is None else [run.held_values]
    tables = {} if run.provenance is None else run.provenance.tables
    for name, law in job.inputs.items():
        if isinstance(law, FmuInput) and name in tables:  # two points a sample
            t, values = np.asarray(tables[name].t)[::2], np.asarray(tables[name].values)[::2]
            records.append(HeldRecord((name,), t, values[np.newaxis]))
    return join_records(records, [name for record in records for name in record.names])
