"""The prescribed motion: its laws, positions by continuation, speeds and accelerations exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.kinematics.continuation import Continuation, Law
from symbody.analysis.kinematics.driven import element_of
from symbody.analysis.redundancy import redundancy
from symbody.analysis.scales import Scales, mechanism_scales
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, SimulationError, SymbodyError, UsageError, number_in_words
from symbody.expr.graph import Graph
from symbody.expr.language.formula import Formula
from symbody.expr.printing.text import to_text
from symbody.expr.sympy.sympy_bridge import from_sympy, is_expression
from symbody.model.declarations.arguments import plain_value
from symbody.simulation.inputs.tables import Table

Floats = NDArray[np.float64]

_CONSISTENT: Final = 1e-7  # of the largest term: positions are good to 1e-12 and times may be long


class PrescribedStates(NamedTuple):
    """A motion at times: q (n_q, N), u and udot (n_u, N)."""

    t: Floats
    q: Floats
    u: Floats
    udot: Floats


@dataclass(frozen=True, slots=True, eq=False)
class PrescribedMotion:
    """A mechanism with a motion of its driven coordinates, and its first position."""

    eqs: EquationSet
    continuation: Continuation
    parameters: Mapping[str, Value]
    scales: Scales
    first: Floats

    def samples(self, times: Floats) -> PrescribedStates:
        """Return the motion at times.

        Raises UsageError if the motion leaves freedoms; SimulationError if the motion contradicts the
        constraints, or leads out of reach, naming time and joint.
        """
        first = self.continuation.correct(float(times[0]), self.first)
        q = self.first if first is None else first
        states = []
        for k, t in enumerate(times.tolist()):
            if k:
                reached, q = self.continuation.follow(float(times[k - 1]), q, t)
                if reached != t:
                    raise SimulationError(self._reach_problem(reached, t, q))
            u, udot = self.motion(t, q)
            states.append((q, u, udot))
        columns = [np.array([one[k] for one in states]).T for k in range(3)]
        return PrescribedStates(times, *columns)

    def motion(self, t: float, q: Floats) -> tuple[Floats, Floats]:
        """Return speeds and accelerations at a position.

        Raises UsageError if the driven coordinates leave freedoms; SimulationError if they contradict the
        constraints, or each other.
        """
        follower = self.continuation
        still = np.zeros(len(self.eqs.speed_names))
        jacobian, rate, _ = follower.rows(t, q, still)
        basis = follower.freedoms(jacobian)
        if basis.shape[1]:
            raise UsageError(self._freedoms_left(t, q, basis))
        u, error = follower.solve(jacobian, rate)
        self._check(t, "speeds", error, rate)
        jacobian, _, acceleration = follower.rows(t, q, u)
        udot, error = follower.solve(jacobian, acceleration)
        self._check(t, "accelerations", error, acceleration)
        return u, udot

    def _check(self, t: float, what: str, error: float, demanded: Floats) -> None:
        largest = float(np.abs(demanded / self.continuation.scales).max(initial=0.0))
        natural = self.continuation.time ** (-2 if what == "accelerations" else -1)
        if error <= _CONSISTENT * (natural + largest):
            return
        driven = ", ".join(self.continuation.driven)
        raise SimulationError(
            Problem("inverse.motion_conflict", f"motion {driven}",
                    f"at t = {t:.9g} s no {what} of the mechanism satisfy the prescribed motion; the error "
                    f"is {error:.3g} of the mechanism's size",
                    "the driven coordinates depend on each other, or the mechanism is in a singular "
                    "position", "drive fewer coordinates, or prescribe motions consistent with the "
                                "constraints")
        )  # fmt: skip

    def _freedoms_left(self, t: float, q: Floats, basis: Floats) -> Problem:
        """Return the refusal of a motion that leaves freedoms, with their number and speeds."""
        speeds = self.continuation.free_speeds(basis)
        count, driven = basis.shape[1], ", ".join(self.continuation.driven) or "nothing"
        near = dict(zip(self.eqs.coordinate_names, q, strict=True))
        generic = redundancy(self.eqs, self.parameters, near, scales=self.scales.sizes)
        if len(self.continuation.driven) >= generic.degrees_of_freedom:
            why = (
                "the mechanism is in a singular position, in which the driven coordinates do not determine "
                "the motion"
            )
            fix = "choose times near it, or drive another coordinate"
        else:
            why = (
                f"it has {number_in_words(generic.degrees_of_freedom, 'degree of freedom')}; driven: {driven}"
            )
            fix = "prescribe motions of further coordinates, or use sb.simulate with the inputs"
        word = "degree of freedom is" if count == 1 else "degrees of freedom are"
        return Problem("inverse.freedoms_left", "motion",
                       f"at t = {t:.9g} s {count} {word} left: {', '.join(speeds)}", why, fix)  # fmt: skip

    def _reach_problem(self, reached: float, t: float, q: Floats) -> Problem:
        """Return the refusal of a motion that cannot go on, with time and joint."""
        joint = self.continuation.blocking_joint(reached, q)
        coordinates = dict(zip(self.eqs.coordinate_names, q.tolist(), strict=True))
        try:
            assemble(
                self.eqs,
                self.continuation.driven_values(t),
                coordinates,
                parameters=self.parameters,
                inputs=None,
                t=t,
            )
            why = "the mechanism can be assembled at the next time, but no motion connects the two positions"
        except AssemblyError as error:
            why = f"at t = {t:.9g} s {error.problems[0].what}"
        except SymbodyError:
            why = "no position at later times has these coordinates"
        asked = ", ".join(
            f"{name} = {value:.6g}" for name, value in self.continuation.driven_values(reached).items()
        )
        return Problem("inverse.out_of_reach", element_of(self.eqs, joint),
                       f"at t = {reached:.9g} s the motion cannot continue; there {asked}", why,
                       "end the motion before this time, or prescribe one within reach; "
                       "sb.trace_positions finds the limits")  # fmt: skip


def prescribe_motion(
    eqs: EquationSet,
    follower: Continuation,
    parameters: Mapping[str, Value],
    guess: Mapping[str, Value],
    scales: Mapping[str, float],
    times: Floats,
) -> PrescribedMotion:
    """Return the path of a motion, with scales of its own where the model has no length.

    Raises AssemblyError if the loops do not close at the first time.
    """
    t = float(times[0])
    state = assemble(
        eqs, follower.driven_values(t), guess, parameters=parameters, inputs=None, t=t, scales=scales
    )
    targets = [follower.driven_values(float(s)) for s in times]
    farthest = {name: max(abs(one[name]) for one in targets) for name in follower.driven}
    mechanism = mechanism_scales(eqs, parameters, scales, {**state.q, **farthest})
    return PrescribedMotion(
        eqs, follower.rescale(mechanism), parameters, mechanism, np.array(list(state.q.values()))
    )


# A function of time returns the coordinate, its rate and its acceleration. SymPy's expressions, which have no
# types, are taken too.
MotionLaw = Value | Table | tuple[ArrayLike, ArrayLike] | Callable[[float], tuple[float, float, float]]


def motion_laws(
    motion: Mapping[str, MotionLaw], span: tuple[float, float]
) -> tuple[dict[str, Value], dict[str, Law]]:
    """Return the motions that are formulas, and the others as functions of time with two derivatives.

    Raises UsageError if a table has corners, or ends within the span.
    """
    formulas: dict[str, Value] = {}
    laws: dict[str, Law] = {}
    problems = []
    for name, given in motion.items():
        table = Table(given[0], given[1], kind="cubic") if isinstance(given, tuple) else given
        if isinstance(table, Table):
            problems += _table_problems(name, table, span)
            laws[name] = _spline(replace(table, kind="cubic"))
        elif isinstance(table, str | int | float | Formula):
            formulas[name] = table
        elif is_expression(table):
            graph = Graph()
            formulas[name] = Formula.from_value(to_text(graph, from_sympy(table, graph)))
        elif callable(table):
            laws[name] = _wrap_function(name, table)
        else:
            formulas[name] = Formula.from_value(plain_value(table))
    if problems:
        raise UsageError(*problems)
    return formulas, laws


def _table_problems(name: str, table: Table, span: tuple[float, float]) -> list[Problem]:
    where, times = f"motion {name}", np.asarray(table.t, dtype=np.float64)
    problems = []
    if table.kind != "cubic":
        problems.append(
            Problem("inverse.table_corners", where, "a table of straight lines has infinite accelerations",
                    "its slope jumps at every point", 'write sb.Table(..., kind="cubic")')
        )  # fmt: skip
    if span[0] < times[0] or span[1] > times[-1]:
        problems.append(
            Problem("inverse.table_span", where,
                    f"the table covers {times[0]:g} s to {times[-1]:g} s, the times {span[0]:g} s to "
                    f"{span[1]:g} s", "",
                    "extend the table, or choose times within it")
        )  # fmt: skip
    return problems


def _spline(table: Table) -> Law:
    spline = scipy.interpolate.CubicSpline(np.asarray(table.t), np.asarray(table.values))

    def law(t: float) -> tuple[float, float, float]:
        return float(spline(t)), float(spline(t, 1)), float(spline(t, 2))

    return law


def _wrap_function(name: str, function: Callable[[float], tuple[float, float, float]]) -> Law:
    def law(t: float) -> tuple[float, float, float]:
        try:
            given = np.asarray(function(t), dtype=np.float64)
        except Exception as error:
            raise _function_problem(
                name, f"at t = {t:.9g} s it raised {type(error).__name__}: {error}"
            ) from error
        if given.shape != (3,) or not np.isfinite(given).all():
            raise _function_problem(name, f"at t = {t:.9g} s it returned {given.tolist()}")
        return float(given[0]), float(given[1]), float(given[2])

    return law


def _function_problem(name: str, what: str) -> UsageError:
    return UsageError(
        Problem("inverse.motion_function", f"motion {name}", what,
                "accelerations need the motion and its first two derivatives",
                "return three finite numbers: the coordinate, its rate and its acceleration")
    )  # fmt: skip
