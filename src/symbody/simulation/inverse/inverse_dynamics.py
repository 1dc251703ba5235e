"""`inverse_dynamics`: the inputs that make a mechanism move as prescribed.

Positions by continuation along the times, speeds and accelerations from the differentiated constraints, then
one linear system in the unknown inputs at each time (García de Jalón & Bayo 1994, section 5.2; Haug 1989,
section 6.4). Multipliers, reactions and energies are those of the equations of motion with these inputs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.held_inputs import refuse_held
from symbody.analysis.kinematics.continuation import continuation
from symbody.analysis.scales import checked_scales
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import element_words, gap_place, unilateral_elements
from symbody.errors import Problem, UsageError, nearest
from symbody.simulation.inputs.input_laws import InputLaws, Law, input_laws, laws_of_tables, silent_input_note
from symbody.simulation.inputs.tables import Table
from symbody.simulation.inverse.prescribed_motion import (
    MotionLaw,
    PrescribedStates,
    motion_laws,
    prescribe_motion,
)
from symbody.simulation.inverse.unknowns import InputSolver, influence
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.provenance import provenance_of
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import Evaluator, SimulationProblem
from symbody.simulation.status import Status

Floats = NDArray[np.float64]


@named_after(4)
@checked_arguments
def inverse_dynamics(
    eqs: EquationSet,
    motion: Mapping[str, MotionLaw],
    unknowns: str | Sequence[str],
    times: ArrayLike,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Law] | None = None,
    guess: Mapping[str, Value] | None = None,
    *,
    scales: Mapping[str, float] | None = None,
) -> Trajectory:
    """Return the prescribed motion with the inputs that make it.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    motion : mapping of coordinate to expression, table or callable
        One coordinate per degree of freedom, including those of cut joints: expressions in t and
        parameters, ``{"theta": "pi*t**2"}``; (times, values) or a cubic `Table`, splined; a function of
        time that returns the coordinate, its rate and its acceleration.
    unknowns : str or sequence of str
        Inputs to find; if there are more than degrees of freedom, the minimum-norm solution, with a note.
    times : (N,) array
        Increasing times [s]; positions are followed from each to the next. One number gives one sample.
    parameters, inputs : mapping
        As for `simulate`; inputs without a law are 0.
    guess : mapping of name to number or formula in parameters
        Near which the loops close at the first time.
    scales : mapping of "length", "time", "mass" to float, optional
        Sizes of the mechanism [m, s, kg]; by default they follow from the model, and without any length there
        from the prescribed motion and the first position.

    Returns
    -------
    Trajectory
        ``result["F"]`` are the values (N,) of an unknown at `times`, in ``result.units["F"]``, beside all
        that a simulated motion has: coordinates, multipliers, reactions, energy, work, constraint violation.
        Between its samples nothing is known.

    Raises
    ------
    UsageError
        If names make no sense, an unknown does not enter linearly, or degrees of freedom are left.
    AssemblyError
        If the loops do not close at the first time.
    SimulationError
        If the motion leads out of reach, contradicts the constraints, or cannot be made by the unknowns,
        with time and joint.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> run = sb.inverse_dynamics(eqs, {"x": "0.5*t^2"}, "F", [0.0, 1.0])
    >>> print(run["F"].round(9))
    [2. 6.]
    """
    started = perf_counter()
    names = (unknowns,) if isinstance(unknowns, str) else tuple(unknowns)
    t, given, others = _times(times), dict(parameters or {}), dict(inputs or {})
    _check_questions(eqs, names, motion, others)
    span = (float(t[0]), float(t[-1]))
    driven = continuation(eqs, *motion_laws(motion, span), given)
    path = prescribe_motion(eqs, driven, given, dict(guess or {}), checked_scales(scales), t)
    others = {**{name: law for name, law in laws_of_tables(eqs).items() if name not in names}, **others}
    laws = input_laws([name for name in eqs.input_names if name not in names], others, span)
    solver = InputSolver(path, eqs, laws, names, influence(eqs, names))
    values, redundant = solver.solve(samples := path.samples(t))
    notes = (*_notes(eqs, names, others, laws, redundant=redundant), *_single_time(times))
    return _trajectory(solver, samples, values, notes, started)


def _trajectory(
    solver: InputSolver, samples: PrescribedStates, r: Floats, notes: tuple[str, ...], started: float
) -> Trajectory:
    """Return the motion with the inputs found, and what follows from both."""
    eqs, given = solver.eqs, solver.laws
    laws = SolvedInputLaws(
        given.formulas, given.callbacks, given.notes, given.tables, solver, {_key(samples): r}
    )
    evaluate = Evaluator(SimulationProblem(eqs, solver.path.parameters, laws, solver.path.scales), None)
    power = evaluate("power", samples.t, samples.q, samples.u)
    count, work = samples.t.size, np.zeros_like(samples.t)
    if count > 1:
        work = scipy.interpolate.CubicSpline(samples.t, power).antiderivative()(samples.t)
    tables = {name: Table(samples.t, row) for name, row in zip(solver.names, r, strict=True) if count > 1}
    return Trajectory(
        t=samples.t,
        q=samples.q,
        u=samples.u,
        coordinate_names=eqs.coordinate_names,
        speed_names=eqs.speed_names,
        status=Status.SUCCESS,
        statistics=Statistics(count - 1, None, count, perf_counter() - started),
        evaluate=evaluate,
        stored=dict(zip(solver.names, r, strict=True)) | {"work": work},
        units=eqs.units,
        notes=notes,
        name=eqs.model.name,
        provenance=provenance_of(eqs, solver.path.parameters, given, tables),
    )


@dataclass(frozen=True, slots=True)
class SolvedInputLaws(InputLaws):
    """Laws of inputs, of which the unknown ones are solved for at each evaluation."""

    solver: InputSolver
    # Solved so far, by times and states.
    found: dict[bytes, Floats] = field(repr=False)

    def values(self, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the inputs at times (N,) with q (n_q, N) and u (n_u, N): (N, n)."""
        udot = np.zeros_like(u)
        samples = PrescribedStates(t, q, u, udot)
        key = _key(samples)
        if key not in self.found:
            columns = [self.solver.path.motion(float(s), x)[1] for s, x in zip(t, q.T, strict=True)]
            samples = samples._replace(udot=np.array(columns).T)
            self.found[key] = self.solver.solve(samples)[0]
        return self.solver.arguments(samples, self.found[key])


def _key(samples: PrescribedStates) -> bytes:
    return samples.t.tobytes() + samples.q.tobytes() + samples.u.tobytes()


def _times(times: ArrayLike) -> Floats:
    try:
        rising = np.atleast_1d(np.array(times, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise _wrong_times(f"{times!r} are not numbers") from error
    if rising.ndim != 1 or not rising.size or not np.isfinite(rising).all():
        raise _wrong_times(f"they have shape {rising.shape}, or are not finite")
    if (np.diff(rising) <= 0.0).any():
        raise _wrong_times("they do not increase")
    return rising


def _wrong_times(what: str) -> UsageError:
    return UsageError(
        Problem("inverse.times", "times", what, "", "give increasing numbers, such as linspace(0, 1, 101)")
    )


def _check_questions(
    eqs: EquationSet, unknowns: Sequence[str], motion: Mapping[str, Any], inputs: Mapping[str, Any]
) -> None:
    """Refuse names that mean nothing, and questions without an answer, all at once.

    Raises UsageError naming each.
    """
    problems = []
    for name in dict.fromkeys(unknowns):
        if name not in eqs.input_names:
            problems.append(_no_input(eqs, name))
        elif name in inputs:
            problems.append(
                Problem("inverse.known_unknown", f"unknown {name}", f"{name} is also in inputs=", "",
                        "remove it from one of them")
            )  # fmt: skip
    if len(set(unknowns)) < len(unknowns):
        problems.append(
            Problem("inverse.repeated", "unknowns", "a name is listed twice", "", "name each once")
        )
    if not motion and eqs.speed_names:
        problems.append(
            Problem("inverse.no_motion", "motion", "no motion is given",
                    "inverse dynamics needs a prescribed motion",
                    f'write motion={{"{eqs.coordinate_names[0]}": "sin(t)"}}')
        )  # fmt: skip
    problems += [_one_sided(eqs, name) for name in unilateral_elements(eqs.formed)]
    if eqs.signal_state_names:
        problems.append(
            Problem("inverse.signals", f"signal {eqs.signal_state_names[0]}",
                    "the motion of the mechanism does not determine the states of signals "
                    f"{', '.join(eqs.signal_state_names)}",
                    "they have their own rates, which may depend on the unknown inputs",
                    "replace the signals by an input and solve for it, or simulate with the signals")
        )  # fmt: skip
    if eqs.formed.light_balances:
        names = [speed.label for speed in eqs.formed.light_balances]
        problems.append(
            Problem("inverse.first_order", f"speed {names[0]}",
                    f"{', '.join(names)} has no mass: dampers determine how fast it moves, and its position "
                    f"depends on its history",
                    "forces determine it, so it cannot be prescribed",
                    "give mass to what moves there, or simulate with known inputs")
        )  # fmt: skip
    elif eqs.formed.dependent_names:
        problems.append(
            Problem("inverse.dependent_speeds", "eqs",
                    f"the speeds {', '.join(eqs.formed.dependent_names)} are eliminated from these equations",
                    "prescribed motions are constraints on all speeds",
                    "form the equations without dependent_speeds: motion, forces and torques are the same")
        )  # fmt: skip
    if problems:
        raise UsageError(*problems)
    refuse_held(eqs, "inverse dynamics", {*unknowns, *inputs})


def _one_sided(eqs: EquationSet, name: str) -> Problem:
    """Return the problem of a rope, a stop or a contact."""
    kind, _ = element_words(eqs.formed, name)
    if kind == "rope":
        what = "a prescribed motion does not determine whether a rope is slack or taut"
        fix = "use a Distance without rope=True where it is taut, or leave it out where it is slack"
    else:
        what = f"a prescribed motion does not determine whether a {kind} is open or closed"
        fix = f"give limits, backlash and contacts a stiffness instead of rigid, or leave the {kind} out"
    return Problem("inverse.rope", gap_place(eqs.formed, name), what, "", fix)


def _no_input(eqs: EquationSet, name: str) -> Problem:
    if name in eqs.multiplier_names or name.startswith(("reaction ", "effort ")):
        return Problem(
            "inverse.always_known", f"unknown {name}", f"{name} is not an input of the model",
            "multipliers, reactions and drive forces are always computed",
            f"leave it out here and read run[{name!r}] from the result",
        )  # fmt: skip
    return Problem(
        "inverse.unknown_input", f"unknown {name}", f"the model has no input {name!r}",
        'an unknown is an input of the model, such as T in sb.Drive(applied="T") at a joint',
        nearest(name, eqs.input_names),
    )  # fmt: skip


def _notes(
    eqs: EquationSet, unknowns: Sequence[str], inputs: Mapping[str, Any], laws: InputLaws, *, redundant: bool
) -> list[str]:
    silent = [name for name in eqs.input_names if name not in inputs and name not in unknowns]
    notes = [silent_input_note(eqs.units, name) for name in silent]
    if redundant:
        notes.append(
            f"{', '.join(unknowns)} are more unknowns than the motion determines: the result is the "
            f"minimum-norm solution (least sum of squares)"
        )
    return [*notes, *laws.notes]


def _single_time(times: ArrayLike) -> tuple[str, ...]:
    """Return a note where a number was given for the times, as an end time is in `simulate`."""
    if np.ndim(times):
        return ()
    end = float(np.asarray(times, dtype=np.float64))
    return (f"times={end:g} is a single time; use np.linspace(0, {end:g}, 101) for the motion up to it",)
