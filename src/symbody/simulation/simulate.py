"""`simulate`: from equations and initial values to a trajectory."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from symbody.analysis.assembly import assemble
from symbody.analysis.redundancy import undetermined_at
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.arguments import checked_arguments
from symbody.codegen.compile import Value
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.undetermined import identically_undetermined, share_notes
from symbody.simulation.events.events import Event, checked_events
from symbody.simulation.events.watching import EventWatch
from symbody.simulation.inputs.input_laws import AskingFunction, InputLaws, Law, input_laws
from symbody.simulation.methods.change_point import run_held
from symbody.simulation.methods.choice import Constraints, Integrator, run_chosen
from symbody.simulation.methods.constraints import PROJECTED, Baumgarte, Projection, projector_of
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, Explicit, Progress, RawRun, integrate
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.question import checked_question
from symbody.simulation.methods.request import Request
from symbody.simulation.modes.dependent_speeds import pivot_events, pivots_judged
from symbody.simulation.modes.impulses import run_struck
from symbody.simulation.modes.painleve import judged
from symbody.simulation.modes.switching import run_switching, switches
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.interface import Projector
from symbody.simulation.progress import told
from symbody.simulation.results.provenance import provenance_of
from symbody.simulation.results.singular_angles import singular_passages
from symbody.simulation.results.start_notes import start_notes
from symbody.simulation.results.stop_note import stop_note
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.status import Status
from symbody.simulation.task import Evaluator, EventFunctions, Task
from symbody.tolerances import CLOSED


@checked_arguments
def simulate(
    eqs: EquationSet, t_end: float | tuple[float, float], initial: Mapping[str, Value] | None = None,
    guess: Mapping[str, Value] | None = None, parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Law] | None = None, times: ArrayLike | None = None,
    integrator: Integrator | None = None, constraints: Constraints | None = None,
    events: Event | Sequence[Event] = (), *, rtol: float = 1e-8, atol: float | None = None,
    scales: Mapping[str, float] | None = None, max_steps: int = 1_000_000,
    progress: Progress | bool | None = None,
) -> Trajectory:  # fmt: skip
    """Return the motion of a mechanism from its initial values.

    Parameters
    ----------
    t_end : float or (t0, t_end)
        End time [s], or both ends; initial values hold at the first.
    initial : mapping of name to number or formula in parameters
        Coordinates, speeds, ``_dot`` names and any named joint coordinate that have these values at first.
    guess : mapping of name to number or formula in parameters
        Where the others are looked for, see `assemble`; by default the model's initial values, then 0.
    parameters : mapping of name to number or formula
        Overrides values of the model.
    inputs : mapping of name to expression, table or callable
        In t, states and parameters, as ``{"F": "sin(omega*t)"}``; a `Table` or (times, values); a slow
        function f(t, q, u) that returns a number. Others are 0.
    times : array, optional
        Exactly the samples to store; by default every step.
    integrator, constraints : optional
        ``Explicit(order=8)``, with a change to `Stiff` where it pays, or `FixedStep`; ``Projection()`` holds
        closed loops.
    events : Event or sequence of Event
        Where one changes the state, both states are samples, of `times` only the one after.
    rtol, atol : float
        Tolerances of the local error, relative and absolute; by default atol is 1e-10 of the mechanism's
        largest length or of 1 rad, for speeds over its time; see `analysis.scales.Scales`.
    scales : mapping of "length", "time", "mass" to float, optional
        What counts as large [m, s, kg] where it shall not follow from the model.
    progress : bool or callable, optional
        True shows a bar, also of the loop's compilation; a callable takes the share that is done, and ends
        the motion by returning False.

    Raises
    ------
    CompileError, FormulationError, UsageError, AssemblyError, SimulationError
        If names, values, times, tables or events make no sense, initial values do not fit, or a function
        given as input fails. Other failures on the way stand in `status`.
    """
    checked_question(eqs, t_end, integrator, constraints, initial=initial, inputs=inputs)
    span = t_end if isinstance(t_end, tuple) else (0.0, t_end)
    chosen, laws = checked_events(events, eqs), input_laws(eqs.input_names, inputs or {}, span)
    held = constraints.applied(eqs) if isinstance(constraints, Baumgarte) else eqs
    first = assemble(eqs, initial, guess, parameters, laws.formulas, span[0], scales=scales)
    known = mechanism_scales(eqs, dict(parameters or {}), scales, first.q).over(*span)
    task = Task(held, dict(parameters or {}), laws, known)
    notes = (*_notes(eqs, inputs or {}, laws), *known.notes(eqs, atol), *start_notes(task, first))
    move = partial(_moved, integrator=integrator, constraints=constraints, notes=notes)
    go = partial(run_switching if switches(eqs.formed) else run_struck, move=move)
    with told(progress, "motion") as tell:
        wanted = partial(Request, times=times, rtol=rtol, atol=atol, max_steps=max_steps, progress=tell)
        run = go(task, first, span, wanted, chosen)
    return _annotate(run, eqs, task, first)


def _annotate(run: Trajectory, eqs: EquationSet, task: Task, first: State) -> Trajectory:
    """Return a run with what it was computed from, and what is noted of its reactions."""
    source = provenance_of(eqs, task.parameters, task.laws, switches=switches(eqs.formed))
    further = _undetermined(eqs, first, run) if run.t.size else ()
    return replace(run, notes=(*run.notes, *further), provenance=source)


def _undetermined(eqs: EquationSet, first: State, run: Trajectory) -> tuple[str, ...]:
    """Return what is noted of reactions that do not follow from a motion with these values of parameters."""
    if not (first.has_dependent_constraints or eqs.formed.friction):
        return ()
    always = identically_undetermined(eqs.formed)
    if not first.has_dependent_constraints:
        return share_notes(eqs.formed, always)[1:]
    places = sorted({0, len(run.t) // 2, len(run.t) - 1})
    names = undetermined_at(eqs, first.parameters, [(float(run.t[k]), run.q[:, k]) for k in places])
    return share_notes(eqs.formed, [name for name in names if name not in always], " in this motion")


def _moved(
    task: Task,
    first: State,
    span: tuple[float, float],
    wanted: Callable[..., Request],
    events: tuple[Event, ...],
    *,
    integrator: Integrator | None,
    constraints: Constraints | None,
    notes: tuple[str, ...],
) -> Trajectory:
    """Return the motion of equations that stay the same."""
    pivots = pivot_events(task, first, span[0])
    run = partial(_run, task, first, span, wanted, integrator, events=(*events, *pivots))
    raw, found, watch = run_held(task, first, span[0], integrator, constraints, run)
    raw, blamed = judged(task, raw)
    raw, lost = pivots_judged(raw, watch, pivots)
    return _trajectory(task, raw, (*notes, *found, *blamed, *lost), watch)


def _run(
    task: Task,
    first: State,
    span: tuple[float, float],
    wanted: Callable[..., Request],
    integrator: Integrator | None,
    constraints: Constraints,
    events: tuple[Event, ...],
) -> tuple[RawRun, tuple[str, ...], EventWatch | None]:
    """Return the run by the integrator chosen, what to note about it, and what looked for events."""
    x = np.array([*first.u.values(), *first.q.values(), 0.0])
    bounds = task.breakpoints(span, [str(event.expression) for event in events])
    request = wanted(task=task, x0=x, span=span, watch=None, breakpoints=bounds)
    projector, closing = _projector(task, constraints, request.atol)
    if isinstance(integrator, FixedStep):  # however far a step went, there is no shorter one
        projector = projector._replace(limit=math.inf)
    watch = _watch(task, events, projector if closing else None, abs(span[1] - span[0]))
    request = replace(request, watch=watch)
    run = partial(integrate, t_span=span, times=request.times, projector=projector, watch=watch)
    atol = [*request.tolerances, _work_tolerance(task, first, span[0], request)]
    run = partial(run, rtol=request.rtol, atol=atol, max_steps=request.max_steps, breakpoints=bounds)

    def explicit(method: Explicit | FixedStep, stop: bool) -> RawRun:
        return _integrated(
            task, partial(run, method=method, stop_when_stiff=stop, progress=request.progress), first
        )

    raw, notes = run_chosen(request, integrator, constraints, explicit)
    del closing  # it had to live as long as the loop that calls it
    return raw, (*notes, *bounds.notes(integrator.step if isinstance(integrator, FixedStep) else None)), watch


def _work_tolerance(task: Task, first: State, t: float, request: Request) -> float:
    """Return how large a local error of the work may be.

    Work starts at zero, but energies are known to `rtol` at best: to ask for `atol` alone of work done on a
    mechanism in fast motion would ask for steps without end.
    """
    kinetic = task.interpreted("kinetic_energy", t, first.q.values(), first.u.values())
    own = CLOSED * task.scales.energy if request.atol is None else request.atol
    return min(max(own, request.rtol * kinetic), sys.float_info.max)


def _watch(
    task: Task, events: tuple[Event, ...], projector: Projector | None, length: float
) -> EventWatch | None:
    """Return what looks for events, if there are any."""
    if not events:
        return None
    functions = EventFunctions(task, events, None if projector is None else projector.scales)
    return EventWatch(events, functions, functions.wrapping, length)


def _notes(eqs: EquationSet, inputs: Mapping[str, Law], laws: InputLaws) -> tuple[str, ...]:
    silent = sorted(set(eqs.input_names).difference(inputs))
    notes = [f"input {name} has no value and is 0" for name in silent]
    if not eqs.speed_names:
        notes.append("every coordinate is prescribed: only efforts and reactions are computed")
    return (*notes, *laws.notes)


def _projector(
    task: Task, constraints: Constraints, atol: float | None
) -> tuple[Projector, CompiledFunction | None]:
    """Return what projects, and the function it calls by address."""
    if isinstance(constraints, Baumgarte) or not task.is_closed:
        return NOTHING_TO_PROJECT, None
    # Other ways to hold constraints project only after events.
    method = constraints if isinstance(constraints, Projection) else Projection()
    closing = task.compiled(PROJECTED)
    return projector_of(closing, task.eqs, task.scales, method, atol), closing


def _integrated(task: Task, run: Callable[..., RawRun], first: State) -> RawRun:
    """Return the run from a state; the compiled functions live until it ends.

    Raises
    ------
    SimulationError
        If the law of an input fails.
    """
    n_u, n_q = len(task.eqs.speed_names), len(task.eqs.coordinate_names)
    # The work is one more state: the function writes its rate, the power, behind xdot.
    function = task.compiled(("xdot", "power"))
    asking = AskingFunction(function, task.laws) if task.laws.asked else None
    call = partial(
        run,
        function.address if asking is None else asking.address,
        function.work_size,
        n_u,
        n_q + 1,
        [*first.u.values(), *first.q.values(), 0.0],
        inputs=np.zeros(len(task.laws.asked)),
        constants=function.constants(),
    )
    if asking is None:
        return call()
    with asking.interruptible():
        raw = call()
    if asking.error is None:
        return raw
    if isinstance(asking.error, KeyboardInterrupt):
        return replace(raw, status=Status.INTERRUPTED, kernel=None, state=None)
    raise asking.error


def _trajectory(task: Task, raw: RawRun, notes: tuple[str, ...], watch: EventWatch | None) -> Trajectory:
    """Return the run with its names."""
    eqs = task.eqs
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    states, work = _divided(raw.dense_output, n)
    passages = [] if states is None else list(singular_passages(eqs, states))
    notes = (*notes, *(told for _, told in passages))
    stop = stop_note(task, raw)
    if raw.status is Status.CHATTERING and watch is not None:
        stop += f"; there event {watch.chattering!r} happens again and again"
    return Trajectory(
        t=raw.t,
        q=raw.x[n_u:n],
        u=raw.x[:n_u],
        coordinate_names=eqs.coordinate_names,
        speed_names=eqs.speed_names,
        status=raw.status,
        statistics=raw.statistics,
        evaluate=Evaluator(task, work),
        dense_output=states,
        stored={"work": raw.x[-1]},
        units=eqs.units,
        notes=(*notes, stop) if stop else notes,
        name=eqs.model.name,
        events=(*(() if watch is None else watch.occurrences), *(event for event, _ in passages)),
    )


def _divided(dense: DenseOutput | None, n: int) -> tuple[DenseOutput | None, DenseOutput | None]:
    """Return the dense output of the first `n` states, and of the rest."""
    if dense is None:
        return None, None
    first, rest = dense.pieces[:, :, :n], dense.pieces[:, :, n:]
    return DenseOutput(dense.breaks, first), DenseOutput(dense.breaks, rest)
