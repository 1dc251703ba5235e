"""`integrate_motion`: a smooth motion by the method that is to compute it.

Without an integrator a motion starts explicitly. Where stability alone keeps the steps small, `Stiff` is
tried: it goes on where it takes far fewer steps, and explicit steps do where what is fast is hardly damped.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.output_roots import OF_STEPS
from symbody.errors import Problem, UsageError
from symbody.expr.canonical import ZERO
from symbody.expr.rewrite import substitute
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.methods.closed_loops.partition import ChartRun, Partition
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, Explicit, integrate
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.gear_gupta_leimkuhler import GGL, run_ggl
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha, run_generalized_alpha
from symbody.simulation.methods.implicit.stiff import Stiff, run_stiff
from symbody.simulation.methods.moreau_jean import MoreauJean, run_moreau_jean
from symbody.simulation.motion import Motion, StateProjector
from symbody.simulation.native.dense_output import DenseOutput, shorten
from symbody.simulation.native.description import steps_before
from symbody.simulation.native.run import RawRun
from symbody.simulation.sampling.sampled_loop import SampledLoop
from symbody.simulation.status import Status
from symbody.tolerances import CLOSED

Floats = NDArray[np.float64]
Integrator = Explicit | FixedStep | Stiff | GeneralizedAlpha | MoreauJean
Constraints = Projection | Baumgarte | GGL | Partition
Notes = tuple[str, ...]

DEFAULT: Final = Explicit()
_PROJECTION: Final = Projection()
# So many explicit steps take less than a second, and they are more exact than what `Stiff` does.
BEARABLE: Final = 20_000
# One step of `Stiff` takes as long as 30 explicit ones of a large mechanism, as some hundred of a small one.
# It is tried for so many steps, of which the last are compared: the first are short. Where it needs more in
# all than a thirtieth of the explicit ones that are left, explicit ones take less time.
_TRIAL: Final = 300
_LAST: Final = 100
_GAIN: Final = 30.0
_STIFF: Final = (
    "from t = {:.6g} s on the motion is stiff and sb.Stiff() integrates it: stability, not accuracy, limits "
    "explicit steps to {:.2g} s; sb.GeneralizedAlpha() is faster where low accuracy is enough"
)
_VIBRATES: Final = (
    "stability limits explicit steps to {:.2g} s, but sb.Stiff() takes too many steps, for instance because "
    "fast motions are hardly damped: sb.Explicit() integrates the motion; sb.GeneralizedAlpha() is faster "
    "where low accuracy is enough"
)


class Integration(NamedTuple):
    """The run of a motion, what to note about it, and what looked for events."""

    raw: RawRun
    notes: Notes
    watch: EventWatch | None


def integrate_motion(motion: Motion) -> Integration:
    """Return the run of a motion; constraints are held by `Projection` if that is left open.

    Raises
    ------
    UsageError
        If the integrator cannot hold the constraints as required.
    SimulationError
        If the law of an input fails.
    """
    motion.begin_modes()
    integrator = motion.integrator
    constraints = _fitting_constraints(motion)
    # Methods that do not project after steps, except `Baumgarte`, do so where samples are interpolated.
    projection = constraints if isinstance(constraints, Projection) else _PROJECTION
    closing = None if isinstance(constraints, Baumgarte) else motion.projection(projection)
    watch = motion.event_watch(projection, hands_over=not takes_steps_compiled(motion))
    raw, notes, watch = _run_method(motion, constraints, closing, watch)
    step = integrator.step if isinstance(integrator, FixedStep | GeneralizedAlpha | MoreauJean) else None
    return Integration(raw, (*notes, *motion.breakpoints.notes(step)), watch)


def takes_steps_compiled(motion: Motion) -> bool:
    """Return whether the loop computes a motion in which events act and modes change."""
    return not (isinstance(motion.integrator, Stiff) or isinstance(motion.constraints, GGL | Partition))


def _fitting_constraints(motion: Motion) -> Constraints:
    """Return how constraints are held: without any, all ways are `Projection`."""
    constraints = motion.constraints or _PROJECTION
    fits: tuple[type, ...]
    if isinstance(constraints, GGL):
        fits, name, why, fix = (Stiff,), "sb.GGL()", "are implicit equations", "sb.Stiff()"
    elif isinstance(constraints, Partition):
        fits, name, why, fix = (Explicit,), "sb.Partition()", "is integrated explicitly", "sb.Explicit()"
    elif isinstance(constraints, Baumgarte) and isinstance(motion.integrator, MoreauJean):
        fits, name, why, fix = (Explicit,), "sb.Baumgarte()", "forces loops shut", "sb.Projection()"
    else:
        return constraints
    if not (motion.integrator is None or isinstance(motion.integrator, fits)):
        what = f"this integrator cannot be combined with {name}"
        raise UsageError(Problem("simulation.combination", "integrator", what, f"{name} {why}", f"use {fix}"))
    return constraints if motion.rows else _PROJECTION


def _run_method(
    motion: Motion,
    constraints: Constraints,
    closing: StateProjector | None,
    watch: EventWatch | None,
) -> tuple[RawRun, Notes, EventWatch | None]:
    """Return the run by a method that can hold the constraints, what to note, and what looked for events."""
    integrator = motion.integrator
    if isinstance(constraints, GGL):
        stiff = integrator if isinstance(integrator, Stiff) else Stiff()
        return *run_ggl(motion, stiff, watch), watch
    if isinstance(constraints, Partition):
        explicit = integrator if isinstance(integrator, Explicit) else DEFAULT
        charts = ChartRun(motion, constraints)
        return run_explicit(motion, explicit, closing, watch, charts=charts), charts.notes, watch
    if isinstance(integrator, MoreauJean):
        return *run_moreau_jean(motion, integrator, closing, watch), watch
    if isinstance(integrator, Stiff):
        return run_stiff(motion, integrator, constraints, watch), (), watch
    if isinstance(integrator, GeneralizedAlpha):
        tolerance = work_tolerance(motion)
        return *run_generalized_alpha(motion, integrator, closing, watch, tolerance), watch
    if integrator is not None or motion.problem.sampler is not None:
        return run_explicit(motion, integrator or DEFAULT, closing, watch), (), watch
    return _choose_method(motion, constraints, closing, watch)


def _choose_method(
    motion: Motion,
    constraints: Projection | Baumgarte,
    closing: StateProjector | None,
    watch: EventWatch | None,
) -> tuple[RawRun, Notes, EventWatch | None]:
    """Return a run by explicit steps, carried on by `Stiff` where a first part of it shows that this pays."""
    raw = run_explicit(motion, DEFAULT, closing, watch, stop_when_stiff=True)
    if raw.status is not Status.STIFF or raw.dense_output is None:
        return raw, (), watch
    length, steps = _steps_left(raw.dense_output, motion.span[1])
    if watch is None and steps < BEARABLE:
        return run_explicit(motion, DEFAULT, closing, watch), (), watch  # events would be noted twice
    remainder = _remainder(motion, raw, raw.dense_output(raw.reached))
    note = _STIFF.format(raw.reached, length)
    most = max(_TRIAL, math.ceil(steps / _GAIN))
    try:
        trial = _run_some(remainder, constraints, _TRIAL, None)
        is_over = trial.status is not Status.TOO_MANY_STEPS or remainder.max_steps <= _TRIAL
        if watch is None and is_over:
            return trial, (note,), watch
        if is_over or _gains(trial, length):
            if watch is not None:
                watch.hand_over()
            run = _run_some(remainder, constraints, most, watch)
            if run.status is not Status.TOO_MANY_STEPS or remainder.max_steps <= most:
                return run, (note,), watch
    except KeyboardInterrupt:  # while it compiled: what came before is kept
        return replace(raw, status=Status.INTERRUPTED), (), watch
    motion.begin_modes()
    again = motion.event_watch(constraints if isinstance(constraints, Projection) else _PROJECTION)
    return run_explicit(motion, DEFAULT, closing, again), (_VIBRATES.format(length),), again


def _run_some(
    remainder: Motion, constraints: Projection | Baumgarte, steps: int, watch: EventWatch | None
) -> RawRun:
    """Return a run by `Stiff` of at most so many steps."""
    part = replace(remainder, max_steps=min(steps, remainder.max_steps))
    return run_stiff(part, Stiff(), constraints, watch)


def _gains(trial: RawRun, length: float) -> bool:
    """Return whether the last implicit steps of a trial are so much longer that they take less time."""
    dense = trial.dense_output
    if dense is None or dense.breaks.size <= _LAST:
        return True
    return float(abs(dense.breaks[-1] - dense.breaks[-1 - _LAST])) > _GAIN * _LAST * length


def run_explicit(
    motion: Motion,
    method: Explicit | FixedStep,
    closing: StateProjector | None,
    watch: EventWatch | None,
    *,
    stop_when_stiff: bool = False,
    charts: ChartRun | None = None,
) -> RawRun:
    """Return the run of the compiled loop, on charts if given; the compiled functions live until it ends.

    Raises
    ------
    SimulationError
        If the law of an input fails.
    """
    problem, laws = motion.problem, motion.problem.laws
    # The work is one more state: the function writes its rate, the power, behind xdot.
    function = problem.compile_outputs(OF_STEPS)
    python_laws = CallbackFunction(function, laws) if laws.need_python else None
    projector = NOTHING_TO_PROJECT if closing is None else closing.projector
    if isinstance(method, FixedStep):  # its steps never become shorter, however far one went
        projector = projector._replace(limit=math.inf)
    run = partial(
        integrate,
        function.address if python_laws is None else python_laws.address,
        function.work_size,
        motion.n_u,
        motion.x0.size - motion.n_u,
        motion.x0,
        motion.span,
        method=method,
        inputs=laws.held_now(),
        tables=laws.table_numbers(),
        constants=function.constants(),
        times=motion.times,
        rtol=motion.rtol,
        atol=[*motion.tolerances, work_tolerance(motion)],
        max_steps=motion.max_steps,
        stop_when_stiff=stop_when_stiff,
        progress=motion.progress,
        projector=projector,
        watch=watch,
        breakpoints=motion.breakpoints,
        held=None if problem.sampler is None else SampledLoop(problem, problem.sampler),
        make_run=None if charts is None else charts.start,
        jumps=motion.passed_jumps(watch),
    )
    if charts is not None:
        with charts.interruptible():
            return run()
    if python_laws is None:
        return run()
    with python_laws.interruptible():
        raw = run()
    if python_laws.error is None:
        return raw
    if isinstance(python_laws.error, KeyboardInterrupt):
        return replace(raw, status=Status.INTERRUPTED, kernel=None, state=None)
    raise python_laws.error


def work_tolerance(motion: Motion) -> float:
    """Return how large a local error of the work may be.

    Work starts at zero, but energies are known to `rtol` at best: `atol` alone for work done on a mechanism
    in fast motion would need steps without end.
    """
    energy = CLOSED * motion.problem.scales.energy
    usual = energy if motion.atol is None else motion.atol
    return min(max(usual, motion.rtol * _first_kinetic_energy(motion)), sys.float_info.max)


def _first_kinetic_energy(motion: Motion) -> float:
    problem, t, n_u, x = motion.problem, motion.span[0], motion.n_u, motion.state
    first = problem.first_numbers(t, x)
    if first is not None and first.kinetic_energy is not None:
        return first.kinetic_energy
    if not x[:n_u].any() and problem.eqs.plans.get("rests", partial(_rests, problem.eqs)):
        return 0.0
    return problem.value("kinetic_energy", t, x[n_u:], x[:n_u])


def _rests(eqs: EquationSet) -> bool:
    """Return whether the kinetic energy is identically zero where all speeds are zero."""
    graph = eqs.formed.graph
    still = {graph.symbol(speed): ZERO for speed in eqs.formed.u}
    return substitute(graph, [eqs.formed.kinetic_energy.index], still) == [ZERO]


def _steps_left(dense: DenseOutput, end: float) -> tuple[float, float]:
    """Return the length of the last step, and how many like it lead to the end."""
    last, reached = dense.breaks[-2:]
    return float(abs(reached - last)), float((end - reached) / (reached - last))


def _remainder(motion: Motion, first: RawRun, x: Floats) -> Motion:
    """Return what an explicit run that was broken off in a state `x` leaves to another method."""
    start, end = first.reached, motion.span[1]
    times = None
    if motion.times is not None:
        samples = np.asarray(motion.times)
        times = samples[(samples - start) * np.sign(end - start) > 0.0]
    return replace(
        motion,
        x0=x,
        span=(start, end),
        times=times,
        max_steps=motion.max_steps - first.statistics.accepted - (first.statistics.rejected or 0),
        before=first,
    )


def end_run(run: Integration, t: float | None, note: str) -> Integration:
    """Return a run that ends at a time, or as it does if that is None, with the reason."""
    raw = run.raw
    run = run._replace(notes=(*run.notes, note))
    dense = raw.dense_output
    if t is None or dense is None:
        return run
    steps = max(steps_before(dense.breaks, dense.pieces.shape[0], t), 1)
    breaks, pieces = dense.breaks[: steps + 1].copy(), dense.pieces[:steps].copy()
    share = (t - breaks[-2]) / (breaks[-1] - breaks[-2])
    breaks[-1], pieces[-1] = t, shorten(pieces[-1], float(share))
    direction = 1.0 if dense.breaks[-1] >= dense.breaks[0] else -1.0
    kept = direction * (raw.t - t) <= 0.0
    cut = replace(
        raw, t=raw.t[kept], x=raw.x[:, kept], status=Status.SINGULAR, reached=t, state=None, kernel=None,
        dense_output=DenseOutput(breaks, pieces),
    )  # fmt: skip
    return run._replace(raw=cut)
