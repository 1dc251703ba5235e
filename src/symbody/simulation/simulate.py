"""`simulate`: from equations and initial values to a trajectory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Real
from typing import Any, Final, get_args

from numpy.typing import ArrayLike

from symbody.analysis.configurations.assembly import find_first_state
from symbody.analysis.named_values import check_mappings
from symbody.analysis.redundancy import undetermined_outputs
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import switches
from symbody.equations.solving.undetermined import find_identically_undetermined, share_notes
from symbody.errors import Problem, UsageError
from symbody.model.first_values import FirstValue, by_priority
from symbody.simulation.drive import drive
from symbody.simulation.events.events import Event, check_events
from symbody.simulation.hybrid.impulsive_contacts import assemble_open
from symbody.simulation.inputs.input_laws import InputLaws, Law, input_laws, laws_of_tables, silent_input_note
from symbody.simulation.methods.constraints import Baumgarte
from symbody.simulation.methods.integration import Constraints, Integrator
from symbody.simulation.methods.moreau_jean import MoreauJean
from symbody.simulation.motion import Motion, first_numbers
from symbody.simulation.native.run import Progress
from symbody.simulation.progress import show_progress
from symbody.simulation.results.checks import start_notes
from symbody.simulation.results.provenance import provenance_of
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.sampling.held_signals import HeldSignals, held_signals, sample_later
from symbody.simulation.simulation_problem import SimulationProblem

_INTEGRATORS: Final = get_args(Integrator)
_CONSTRAINTS: Final = get_args(Constraints)


@named_after(3)
@checked_arguments
def simulate(
    eqs: EquationSet, t_end: float | tuple[float, float], initial: Mapping[str, FirstValue] | None = None,
    guess: Mapping[str, FirstValue] | None = None, parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Law] | None = None, times: ArrayLike | None = None,
    integrator: Integrator | None = None, constraints: Constraints | None = None,
    events: Event | Sequence[Event] = (), *, rtol: float = 1e-8, atol: float | None = None,
    scales: Mapping[str, float] | None = None, max_steps: int = 1_000_000,
    progress: Progress | bool | None = None,
) -> Trajectory:  # fmt: skip
    """Return the motion of a mechanism from its initial values.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    t_end : float or (t0, t_end)
        End time [s], or both ends; initial values hold at the first.
    initial : mapping of name to number or formula in parameters, or `Initial`
        Coordinates, speeds, ``_dot`` names, joint coordinates and signals that have these values at first, in
        SI units [m, rad, m/s, rad/s]; of an angle also ``"30 deg"``.
    guess : mapping of name to number or formula in parameters, or `Initial`
        Where the others are looked for, see `assemble`; by default the model's initial values, then 0.
    parameters : mapping of name to number or formula
        Overrides values of the model.
    inputs : mapping of name to expression, table or callable
        In t, states and parameters, as ``{"F": "sin(omega*t)"}``; a `Table` or (times, values); a slow
        function f(t, q, u) that returns a number; an `FmuInput`. Others are 0.
    times : array, optional
        Exactly the samples to store; by default every step.
    integrator, constraints : optional
        ``Explicit(order=8)``, changed to `Stiff` where it pays, or `FixedStep`, `Stiff`, `GeneralizedAlpha`,
        `MoreauJean`; ``Projection()`` holds closed loops, or `Baumgarte`, `GGL`, `Partition`.
    events : Event or sequence of Event
        Where one changes the state, both states are samples, of `times` only the one after.
    rtol, atol : float
        Tolerances of the local error, relative and absolute; by default atol is 1e-10 of the mechanism's
        largest length or of 1 rad, for speeds over its time: docs/notation.md, "Scales and tolerances".
    scales : mapping of "length", "time", "mass", or state of a signal, to float, optional
        What counts as large [m, s, kg] where it should not follow from the model, or from an initial value.
    max_steps : int
        After so many steps the motion ends, which `status` says.
    progress : bool or callable, optional
        True shows stages and a bar; a callable takes the share that is done, and returns False to end it.

    Returns
    -------
    Trajectory
        The motion: ``run["x"]`` are the samples (N,) of any output by its name, of vectors (3, N), of
        matrices (rows, columns, N), in ``run.units["x"]``; ``run.outputs()`` lists all;
        ``run.t`` the times [s]; ``run.q`` (n_q, N) and ``run.u`` (n_u, N) coordinates and speeds in the order
        of ``run.coordinate_names`` and ``run.speed_names``; ``run.at(t)`` the motion between the samples.
        ``run.success`` is True if the end was reached, ``run.status`` says how it ended and what to try,
        ``run.notes`` what was assumed; ``run.events`` what happened when; ``run.statistics`` what it cost.
        `energy_drift` and `constraint_violation` measure errors; ``run.save(path)`` keeps it.

    Raises
    ------
    CompileError, FormulationError, UsageError, AssemblyError, SimulationError
        If arguments make no sense, initial values do not fit, or a law fails; else `status` says what failed.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> run = sb.simulate(eqs, 10.0, {"x": 0.2}, inputs={"F": "0.1*sin(t)"}, times=[0, 5, 10])
    >>> run.success, run.t, run["x"].shape, run["x"][0]
    (True, array([ 0.,  5., 10.]), (3,), np.float64(0.2))
    >>> run.units["x_dot"], abs(run.energy_drift) < 1e-8
    ('m/s', True)
    """
    by_name = {"initial": initial, "guess": guess, "inputs": inputs, "parameters": parameters}
    check_arguments(eqs, t_end, integrator, constraints, **by_name)
    exact, near = by_priority(initial or {}, guess or {})
    span = t_end if isinstance(t_end, tuple) else (0.0, t_end)
    watched, inputs = check_events(events, eqs), {**laws_of_tables(eqs), **(inputs or {})}
    held = held_signals(eqs, span, parameters, exact, inputs)
    inputs, exact = {**inputs, **held.laws}, held.others(exact)
    laws = input_laws(eqs.input_names, inputs, span, len(eqs.coordinate_names), has_fmus=True)
    with show_progress(progress, "motion") as show:
        given: Any = {"parameters": parameters, "inputs": laws.formulas, "t": span[0], "scales": scales}
        find = assemble_open if isinstance(integrator, MoreauJean) else find_first_state
        first = find(eqs, exact, near, **given)
        problem = pose_problem(eqs, span, parameters or {}, laws, scales, constraints, first)
        problem = held.pose(problem, watched)
        notes = _input_notes(problem, inputs, atol, rtol) + start_notes(problem, first, {**near, **exact})
        run, problem, _ = drive(Motion(
            problem, first_numbers(first), span, times, rtol, atol, max_steps, show, watched, integrator,
            constraints,
        ), inputs)  # fmt: skip
    return _annotate(run, problem, first, notes, held)


def _annotate(
    run: Trajectory, problem: SimulationProblem, first: State, notes: tuple[str, ...], held: HeldSignals
) -> Trajectory:
    """Return a run with notes on its start and its reactions, and with what it was computed from."""
    eqs, laws = first.eqs, problem.laws
    further = _undetermined_notes(eqs, first, run) if run.t.size else ()
    sample_later(held, problem, run.dense_output)
    source = provenance_of(eqs, problem.parameters, laws, held=held.record, switches=switches(eqs.formed))
    return replace(run, notes=(*notes, *run.notes, *further), provenance=source)


def pose_problem(
    eqs: EquationSet,
    span: tuple[float, float],
    parameters: Mapping[str, Value],
    laws: InputLaws,
    scales: Mapping[str, float] | None,
    constraints: Constraints | None,
    first: State,
) -> SimulationProblem:
    """Return the equations to integrate, with all that they depend on besides the state."""
    sizes = mechanism_scales(eqs, dict(parameters), scales, first.q).fit_span(*span)
    stabilized = constraints.applied(eqs) if isinstance(constraints, Baumgarte) else eqs
    return SimulationProblem(stabilized, dict(parameters), laws, sizes, first)


def _input_notes(
    problem: SimulationProblem, inputs: Mapping[str, Law], atol: float | None, rtol: float
) -> tuple[str, ...]:
    """Return notes on inputs, on motions that are prescribed whole, and on what counts as large."""
    eqs = problem.eqs
    silent = sorted(set(eqs.input_names).difference(inputs))
    notes = [silent_input_note(eqs.units, name) for name in silent]
    if not (eqs.speed_names or eqs.formed.light_balances):
        notes.append("every coordinate is prescribed: only driving forces and reactions are computed")
    return (*notes, *problem.laws.notes, *problem.scales.notes(eqs, atol, rtol))


def _undetermined_notes(eqs: EquationSet, first: State, run: Trajectory) -> tuple[str, ...]:
    """Return notes on reactions that do not follow from a motion with these values of parameters."""
    if not (first.has_dependent_constraints or eqs.formed.friction):
        return ()
    always = find_identically_undetermined(eqs.formed)
    if not first.has_dependent_constraints:
        return share_notes(eqs.formed, always)[1:]
    places = sorted({0, len(run.t) // 2, len(run.t) - 1})
    names = undetermined_outputs(eqs, first.parameters, [(float(run.t[k]), run.q[:, k]) for k in places])
    return share_notes(eqs.formed, [name for name in names if name not in always], " in this motion")


def check_arguments(
    eqs: object, t_end: object, integrator: object, constraints: object, **by_name: object
) -> None:
    """Refuse arguments of `simulate` of other kinds than it takes; those `by_name` are mappings.

    Raises
    ------
    UsageError
        With every such argument.
    """
    problems = []
    if not isinstance(eqs, EquationSet):
        what = f"{type(eqs).__name__} is not a set of equations"
        problems.append(Problem("simulation.not_equations", "eqs", what, "", "write form_equations(model)"))
    ends = t_end if isinstance(t_end, tuple) and len(t_end) == 2 else (t_end,)
    if not all(isinstance(end, Real) for end in ends):
        what = f"{t_end!r} is not a valid time"
        problems.append(
            Problem("simulation.not_a_time", "t_end", what, "", "give seconds: 10.0, or (2.0, 10.0)")
        )
    for name, given, kinds in [
        ("integrator", integrator, _INTEGRATORS),
        ("constraints", constraints, _CONSTRAINTS),
    ]:
        if given is not None and not isinstance(given, kinds):
            known = ", ".join(f"{kind.__name__}(..)" for kind in kinds)
            what = f"{given!r} is not a valid choice"
            problems.append(Problem("simulation.not_a_method", name, what, "", f"write one of {known}"))
    if problems:
        raise UsageError(*problems)
    check_mappings(**by_name)
