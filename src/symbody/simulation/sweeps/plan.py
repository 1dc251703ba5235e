"""What a sweep is to compute, before anything is computed: code and first states, or cases one by one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.scales import checked_scales
from symbody.analysis.state import State
from symbody.codegen.compile import Value, form_sequence, form_values
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, UsageError
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, find_breakpoints
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inputs.time_functions import time_functions
from symbody.simulation.methods.constraints import (
    PROJECTED,
    ROUNDED_PER_COORDINATE,
    Baumgarte,
    Projection,
    closed_share,
)
from symbody.simulation.methods.explicit import Explicit, checked_rtol, checked_single_atol, checked_times
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import DEFAULT, Constraints, Integrator
from symbody.simulation.native.loop import EPSILON
from symbody.simulation.native.places import COUNTS
from symbody.simulation.native.run import memory_limit
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.simulation.sweeps.first_states import first_states
from symbody.simulation.sweeps.job import Job, Part

Floats = NDArray[np.float64]

# Samples where no times are given.
USUAL_SAMPLES: Final = 101
# Cases from which on several are computed side by side.
CASES_THAT_PAY: Final = 256


@dataclass(frozen=True, slots=True, eq=False)
class Wish:
    """What was asked for.

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
    def checked(
        cls,
        span: tuple[float, float],
        times: ArrayLike | None,
        integrator: Integrator | None,
        constraints: Constraints | None,
        tolerances: tuple[float, float | None],
        max_steps: int,
        lanes: bool | None,
        scales: Mapping[str, float] | None,
    ) -> Wish:
        """Return what was asked for, with usual times where none are given.

        Raises
        ------
        UsageError
            If times, tolerances or lanes make no sense.
        """
        usual = np.linspace(*span, USUAL_SAMPLES) if span[0] != span[1] else np.array(span[:1])
        wanted = checked_times(usual if times is None else times, *span)
        rtol, atol = tolerances
        return cls(
            span,
            usual if wanted is None else wanted,
            integrator,
            constraints,
            checked_rtol(rtol),
            checked_single_atol(atol),
            int(max_steps),
            _checked_lanes(lanes),
            checked_scales(scales),
        )


def _checked_lanes(lanes: bool | None) -> bool | None:
    """Return whether lanes were asked for.

    Raises
    ------
    UsageError
        Anything but True, False and None: a number of lanes would be taken for a wish to have them.
    """
    if lanes is None:
        return None
    if isinstance(lanes, bool | np.bool_):
        return bool(lanes)
    raise UsageError(
        Problem("sweep.lanes", "lanes", f"lanes = {lanes!r} is neither True, False nor None",
                "how many lanes there are is up to the processor",
                "give lanes=True or lanes=False, or leave it out")
    )  # fmt: skip


def check_memory(cases: int, varied: int, samples: int, states: int) -> None:
    """Refuse what does not fit into memory, by counts alone.

    Raises
    ------
    SimulationError
        With the number of samples, or of cases, that would fit.
    """
    # Each case has its samples, what is known of how it ended, its first state, and its values: in the table,
    # beside the states, and by name in the result.
    rest = COUNTS + 3 * states + 4 * varied + 8
    each, limit = 8 * (samples * states + rest), memory_limit()
    if cases * each <= limit:
        return
    fitting = (limit // (8 * cases) - rest) // states if states else 0
    largest = limit // (8 * (states + rest))
    fix = (
        f"ask for at most {fitting} times, such as times=[t_end] for final values"
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


def planned(
    eqs: EquationSet, table: CaseTable, guess: Mapping[str, Value], laws: InputLaws, wish: Wish
) -> tuple[Job, Part, dict[int, str]]:
    """Return code and numbers for the loop over many cases, and why some cannot start.

    Raises
    ------
    CompileError, AssemblyError
        If parameters have no value, or names are unknown.
    """
    held = wish.constraints.stabilize(eqs) if isinstance(wish.constraints, Baumgarte) else eqs
    first = first_states(eqs, table, guess, laws.formulas, wish.span, wish.scales)
    values = table.fixed_parameters, table.parameter_names, laws.formulas
    function = CompiledFunction(*form_sequence(held, "xdot", *values))
    method = wish.integrator if isinstance(wish.integrator, Explicit | FixedStep) else DEFAULT
    job = Job(
        function,
        None,
        wish.span,
        wish.times,
        method,
        wish.rtol,
        wish.max_steps,
        stop_when_stiff=wish.integrator is None,
        lanes=_in_lanes(wish, table),
        breakpoints=_breakpoints(function, method, wish.span),
    )
    nothing, tolerances = np.zeros((table.count, 0)), first.scales.tolerances(first.states, wish.atol)
    is_closed = bool(eqs.multiplier_names or eqs.quaternions)
    if not is_closed or isinstance(wish.constraints, Baumgarte):
        part = Part(0, first.states, table.parameters, nothing, nothing, tolerances)
        return job, part, dict(first.notes)
    projection = wish.constraints if isinstance(wish.constraints, Projection) else Projection()
    closing = CompiledFunction(*form_sequence(eqs, PROJECTED, *values))
    scales, tolerance = first.scales.constraints(), closed_share(projection, wish.atol)
    padded = np.ones((table.count, closing.sequence.outputs[0].shape[0]))  # norms of quaternions come last
    padded[:, : scales.shape[1]] = scales
    closed = Job(
        function,
        closing,
        wish.span,
        wish.times,
        method,
        wish.rtol,
        wish.max_steps,
        wish.integrator is None,
        job.lanes,
        job.breakpoints,
        ROUNDED_PER_COORDINATE * len(eqs.coordinate_names) * EPSILON / tolerance,
        np.inf if isinstance(method, FixedStep) else projection.limit,
    )
    part = Part(0, first.states, table.parameters, tolerance * padded, first.scales.coordinates(), tolerances)
    return closed, part, dict(first.notes)


def _breakpoints(
    function: CompiledFunction, method: Explicit | FixedStep, span: tuple[float, float]
) -> tuple[Breakpoints, ...] | None:
    """Return the breakpoints of all cases, None if they follow from what varies; see `Job`."""
    if isinstance(method, FixedStep):
        return (NO_BREAKPOINTS,)
    varied = time_functions(function.sequence, {}, with_parameters=True)
    if varied is not None and varied.needs_parameters():
        return None
    functions = time_functions(function.sequence, {})
    return (NO_BREAKPOINTS,) if functions is None else tuple(find_breakpoints(functions, span))


def _in_lanes(wish: Wish, table: CaseTable) -> bool:
    """Return whether compiling for lanes, about as long as for one case, pays."""
    return table.count >= CASES_THAT_PAY if wish.lanes is None else wish.lanes


def cases_apart(eqs: EquationSet, table: CaseTable) -> list[int]:
    """Return the cases whose values fulfil constraints that others do not; `simulate` knows these.

    A constraint that is zero but for rounding at some values of the parameters would be taken for one.
    """
    if not (eqs.multiplier_names and table.parameter_names):
        return []
    names = eqs.parameter_names
    sequence = form_values(eqs, {name: name for name in names}, table.fixed_parameters, table.parameter_names)
    found = CompiledFunction(*sequence, quick=True)(0.0, (), (), (), table.parameters)
    columns = found if len(names) > 1 else (found,)
    rows = np.stack([np.broadcast_to(column, (table.count,)) for column in columns], axis=1)
    varied = {name for k, name in enumerate(names) if (rows[:, k] != rows[0, k]).any()}
    known = {name: float(rows[0, k]) for k, name in enumerate(names) if name not in varied}
    usual = _rows(eqs.for_values(known))
    different, place = np.unique(rows, axis=0, return_inverse=True)
    is_apart = [
        _rows(eqs.for_values(dict(zip(names, row, strict=True)))) != usual for row in different.tolist()
    ]
    return np.flatnonzero(np.array(is_apart)[np.ravel(place)]).tolist()


def _rows(eqs: EquationSet) -> list[tuple[int, ...]]:
    """Return the nodes of all constraints."""
    return [(row.value.index, row.gamma.index, *row.slopes) for row in eqs.formed.rows]


def state_of(eqs: EquationSet, part: Part) -> tuple[int, State] | None:
    """Return the first case that has a first state, and that state without accelerations."""
    started = np.flatnonzero(np.isfinite(part.states).all(axis=1))
    if not started.size:
        return None
    n_u = len(eqs.speed_names)
    x = part.states[started[0]].tolist()
    q = dict(zip(eqs.coordinate_names, x[n_u:], strict=True))
    u = dict(zip(eqs.speed_names, x[:n_u], strict=True))
    return int(started[0]), State(eqs, q, u, {}, {}, 0.0, {})
