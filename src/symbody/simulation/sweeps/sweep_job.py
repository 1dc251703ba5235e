"""`SweepJob`: a sweep to compute, and how one of its cases is simulated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

import symbody
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, UsageError
from symbody.kernels.block import Counts
from symbody.simulation.events.events import Event
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.input_laws import InputLaws, Law
from symbody.simulation.methods.explicit import check_rtol, check_single_atol, check_times
from symbody.simulation.methods.integration import Constraints, Integrator
from symbody.simulation.motion_identity import NoIdentityError, content_hash
from symbody.simulation.native.run import memory_limit
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulate import simulate
from symbody.simulation.sweeps.case_table import CaseTable

Floats = NDArray[np.float64]

# Samples where no times are given.
USUAL_SAMPLES: Final = 101


@dataclass(frozen=True, slots=True, eq=False)
class MotionOptions:
    """How the motions are computed.

    Attributes
    ----------
    span : (t0, t_end)
        Ends of all motions [s].
    times : (N,) array
        The samples to store.
    """

    span: tuple[float, float]
    times: Floats
    integrator: Integrator | None
    constraints: Constraints | None
    rtol: float
    atol: float | None
    max_steps: int
    lanes: bool | None
    scales: Mapping[str, float]

    @classmethod
    def check(
        cls,
        span: tuple[float, float],
        times: ArrayLike | None,
        integrator: Integrator | None,
        constraints: Constraints | None,
        tolerances: tuple[float, float | None],
        max_steps: int,
        lanes: bool | None,
        scales: Mapping[str, float],
    ) -> MotionOptions:
        """Return checked options, with usual times where none are given.

        Raises
        ------
        UsageError
            If times, tolerances or lanes make no sense.
        """
        usual = np.linspace(*span, USUAL_SAMPLES) if span[0] != span[1] else np.array(span[:1])
        samples = check_times(usual if times is None else times, *span)
        rtol, atol = tolerances
        return cls(
            span,
            usual if samples is None else samples,
            integrator,
            constraints,
            check_rtol(rtol),
            check_single_atol(atol),
            int(max_steps),
            _check_lanes(lanes),
            scales,
        )


def _check_lanes(lanes: bool | None) -> bool | None:
    """Return whether lanes are wanted.

    Raises
    ------
    UsageError
        Anything but True, False and None: a number of lanes would be taken for True.
    """
    if lanes is None:
        return None
    if isinstance(lanes, bool | np.bool_):
        return bool(lanes)
    raise UsageError(
        Problem("sweep.lanes", "lanes", f"lanes = {lanes!r} is neither True, False nor None",
                "the processor determines the number of lanes",
                "give lanes=True or lanes=False, or leave it out")
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class SweepJob:
    """A sweep to compute; workers that `simulate` its cases receive it whole."""

    eqs: EquationSet
    table: CaseTable
    guess: Mapping[str, Value]
    inputs: Mapping[str, Law]
    laws: InputLaws
    options: MotionOptions
    events: tuple[Event, ...]

    def simulate_case(self, case: int) -> Trajectory:
        """Return the motion of one case."""
        options = self.options
        parameters, initial = self.table.values(case)
        return simulate(
            self.eqs,
            options.span,
            initial,
            self.guess,
            parameters,
            self.inputs,
            options.times,
            options.integrator,
            options.constraints,
            self.events,
            rtol=options.rtol,
            atol=options.atol,
            scales=options.scales,
            max_steps=options.max_steps,
        )

    def digest(self) -> str:
        """Return what stands for all that results depend on.

        Raises
        ------
        UsageError
            If a law has no content that could be compared with that of another call.
        """
        problems = [
            Problem("sweep.store_function", f"input {name}", f"a store cannot identify this input: {fault}",
                    "its results could be returned for a sweep with another input",
                    "let it use only numbers, strings, arrays and functions, or leave store out")
            for name, law in self.inputs.items() if (fault := _missing_content(law))
        ]  # fmt: skip
        if problems:
            raise UsageError(*problems)
        options = self.options
        choices = (
            options.span, options.times, options.integrator, options.constraints, options.rtol, options.atol,
            options.max_steps, options.scales,
        )  # fmt: skip
        fmus = {Path(law.path) for law in self.inputs.values() if isinstance(law, FmuInput)}
        files = [path.read_bytes() for path in sorted(fmus)]
        return content_hash(
            symbody.__version__, self.eqs, self.table, self.guess, self.inputs, self.events, choices, files
        )


def _missing_content(law: Law) -> str:
    """Return what in a law cannot be compared, empty if all can."""
    try:
        content_hash(law)
    except NoIdentityError as error:
        return f"{error} has no content that can be compared"
    return ""


def check_memory(cases: int, varied: int, samples: int, states: int) -> None:
    """Refuse what does not fit into memory, by counts alone.

    Raises
    ------
    SimulationError
        With the number of samples, or of cases, that would fit.
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
