"""`SweepJob`: a sweep to compute, and its cases by `simulate`, which the loop over many cannot compute."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, SymbodyError, UsageError
from symbody.kernels.block import Counts
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.held_law import HeldRecord, join_records
from symbody.simulation.inputs.input_laws import InputLaws, Law
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit, check_times
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.motion import Motion
from symbody.simulation.motion_identity import missing_content, motion_digest
from symbody.simulation.native.run import memory_limit
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulate import simulate
from symbody.simulation.status import Status
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.simulation.sweeps.records import CODES, CaseDetails, Records

Floats = NDArray[np.float64]

# Samples where no times are given.
USUAL_SAMPLES: Final = 101


@dataclass(frozen=True, slots=True, eq=False)
class SweepJob:
    """A sweep to compute; workers that `simulate` its cases receive it whole.

    Attributes
    ----------
    motion : Motion
        Of all cases: what varies is free in its equations, and it has no first state.
    guess : mapping of name to number or formula
        Near which first states are looked for.
    inputs : mapping of name to law
        As they were given.
    lanes : bool, optional
        Whether cases are computed side by side.
    scales : mapping of name to float
        Those that were given.
    """

    motion: Motion
    table: CaseTable
    guess: Mapping[str, Value]
    inputs: Mapping[str, Law]
    lanes: bool | None
    scales: Mapping[str, float]

    @property
    def eqs(self) -> EquationSet:
        """The equations."""
        return self.motion.eqs

    @property
    def laws(self) -> InputLaws:
        """The laws of inputs; what each case samples for itself is not known yet."""
        return self.motion.problem.laws

    @property
    def times(self) -> Floats:
        """The samples to store (N,)."""
        return np.asarray(self.motion.times, dtype=np.float64)

    @property
    def state_size(self) -> int:
        """Number of speeds, coordinates and states of signals."""
        return len(self.eqs.state_names)

    def simulate_case(self, case: int) -> Trajectory:
        """Return the motion of one case."""
        motion, (parameters, initial) = self.motion, self.table.values(case)
        return simulate(
            self.eqs, motion.span, initial, guess=self.guess, parameters=parameters, inputs=self.inputs,
            times=motion.times, integrator=motion.integrator, constraints=motion.constraints,
            events=motion.events, rtol=motion.rtol, atol=motion.atol, scales=self.scales,
            max_steps=motion.max_steps,
        )  # fmt: skip

    def digest(self, key: str | None) -> str:
        """Return what stands for all that results depend on; `key` for laws that have no content.

        Raises UsageError if a law has no content that could be compared with that of another call, and there
        is no key.
        """
        problems = [
            Problem("sweep.store_function", f"input {name}",
                    f"a store cannot identify this input: {fault} has no content that can be compared",
                    "its results could be returned for a sweep with another input",
                    "let it use only numbers, strings, arrays and functions, or give key='...', a text that "
                    "you change whenever it changes")
            for name, law in self.inputs.items() if key is None and (fault := missing_content(law))
        ]  # fmt: skip
        if problems:
            raise UsageError(*problems)
        motion = self.motion
        choices = motion.span, motion.times, motion.rtol, motion.atol, motion.max_steps, motion.events
        method = motion.integrator, motion.constraints, self.scales
        return motion_digest(self.eqs, self.inputs, self.table, self.guess, choices, method, key=key)


def sample_times(times: ArrayLike | None, span: tuple[float, float]) -> Floats:
    """Return the samples to store, the usual ones where none are given."""
    usual = np.linspace(*span, USUAL_SAMPLES) if span[0] != span[1] else np.array(span[:1])
    checked = check_times(usual if times is None else times, *span)
    return usual if checked is None else checked


def check_lanes(lanes: bool | None) -> bool | None:
    """Return whether lanes are wanted.

    Raises UsageError: a number of lanes would be taken for True.
    """
    if lanes is None or isinstance(lanes, bool | np.bool_):
        return None if lanes is None else bool(lanes)
    raise UsageError(
        Problem("sweep.lanes", "lanes", f"lanes = {lanes!r} is neither True, False nor None",
                "the processor determines the number of lanes",
                "give lanes=True or lanes=False, or leave it out")
    )  # fmt: skip


def check_memory(cases: int, varied: int, samples: int, states: int) -> None:
    """Refuse what does not fit into memory, by counts alone.

    Raises SimulationError with the number of samples, or of cases, that would fit.
    """
    # Each case has its samples, what is known of how it ended, its first state, and its values: in the table,
    # beside the states, and by name in the result.
    rest = Counts.size + 3 * states + 4 * varied + 8
    each, limit = 8 * (samples * states + rest), memory_limit()
    if cases * each <= limit:
        return
    fitting = (limit // (8 * cases) - rest) // states if states else 0
    largest = limit // (8 * (states + rest))
    fix = (
        f"give at most {fitting} times, such as times=[t_end] for final values"
        if fitting >= 1
        else f"give at most {largest:,} cases at once with times=[t_end]: fewer values, fewer samples=, or "
        "the sweep in parts, each saved before the next"
    )
    count = f"{cases:,}" if cases < 10**15 else f"{Decimal(cases):.2e}"
    what = (
        f"{count} cases of {samples} samples of {states} states take "
        f"{Decimal(cases * each) / 10**9:.1f} GB, more than half of this computer's memory"
    )
    raise SimulationError(Problem("sweep.memory", "times" if fitting >= 1 else "parameters", what, fix=fix))


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
    statistics = run.statistics
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
        run.mode_inputs,
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
