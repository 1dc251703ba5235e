"""`simulate`: from equations and initial values to a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.assembly import assemble
from symbody.analysis.closure import constraint_scales
from symbody.analysis.state import State
from symbody.codegen.compile import Value, form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.simulation.constraints import PROJECTED, Baumgarte, Projection, projector_of
from symbody.simulation.dense_output import DenseOutput
from symbody.simulation.explicit import NOTHING_TO_PROJECT, Explicit, Progress, RawRun, integrate
from symbody.simulation.trajectory import Trajectory

Floats = NDArray[np.float64]


def simulate(
    eqs: EquationSet,
    t_end: float | tuple[float, float],
    initial: Mapping[str, Value] | None = None,
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    times: ArrayLike | None = None,
    integrator: Explicit | None = None,
    constraints: Projection | Baumgarte | None = None,
    *,
    rtol: float = 1e-8,
    atol: float = 1e-10,
    max_steps: int = 1_000_000,
    progress: Progress | None = None,
) -> Trajectory:
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
    inputs : mapping of name to expression
        In t, states and parameters, for instance ``{"F": "sin(omega*t)"}``; inputs not named are 0.
    times : array, optional
        Exactly the samples to store; by default every step.
    integrator, constraints : optional
        ``Explicit(order=8)``, and ``Projection()`` to hold closed loops.
    rtol, atol : float
        Relative and absolute tolerance of the local error.

    Raises
    ------
    CompileError, AssemblyError, SimulationError
        If a name or a value is missing, initial values do not fit the constraints or each other, or times
        make no sense. Failures on the way do not raise: `status` tells.
    """
    laws = dict.fromkeys(eqs.input_names, 0) | dict(inputs or {})
    held = constraints.applied(eqs) if isinstance(constraints, Baumgarte) else eqs
    task = _Task(held, dict(parameters or {}), laws)
    span = t_end if isinstance(t_end, tuple) else (0.0, t_end)
    first = assemble(eqs, initial, guess, parameters, inputs, span[0])
    run = partial(
        integrate,
        t_span=span,
        method=Explicit() if integrator is None else integrator,
        times=times,
        rtol=rtol,
        atol=atol,
        max_steps=max_steps,
        progress=progress,
    )
    raw = task.integrated(run, first, Projection() if constraints is None else constraints, atol)
    return _trajectory(task, raw, _notes(eqs, inputs or {}))


def _notes(eqs: EquationSet, inputs: Mapping[str, Value]) -> tuple[str, ...]:
    silent = sorted(set(eqs.input_names).difference(inputs))
    notes = [f"input {name} has no value and is 0" for name in silent]
    if not eqs.speed_names:
        notes.append("every coordinate is prescribed: only efforts and reactions are computed")
    return tuple(notes)


@dataclass(frozen=True, slots=True)
class _Task:
    """Equations with the values of parameters and the laws of all inputs."""

    eqs: EquationSet
    parameters: Mapping[str, Value]
    inputs: Mapping[str, Value]

    def compiled(self, outputs: str | Sequence[str]) -> CompiledFunction:
        """Return a function of t, q and u alone."""
        return CompiledFunction(*form_sequence(self.eqs, outputs, self.parameters, (), self.inputs))

    def integrated(
        self, run: Callable[..., RawRun], first: State, method: Projection | Baumgarte, atol: float
    ) -> RawRun:
        """Return the run from a state; the compiled functions live until it ends."""
        n_u, n_q = len(self.eqs.speed_names), len(self.eqs.coordinate_names)
        # The work is one more state: the function writes its rate, the power, behind xdot.
        function = self.compiled(("xdot", "power"))
        closing, projector = None, NOTHING_TO_PROJECT
        if isinstance(method, Projection) and (self.eqs.multiplier_names or self.eqs.quaternions):
            closing = self.compiled(PROJECTED)
            scales = constraint_scales(self.eqs, self.parameters)
            projector = projector_of(closing, n_u, n_q, scales, method, atol)
        return run(
            function.address,
            function.work_size,
            n_u,
            n_q + 1,
            [*first.u.values(), *first.q.values(), 0.0],
            constants=function.constants(),
            projector=projector,
        )


@dataclass(frozen=True, slots=True)
class _Evaluator:
    """Computes outputs that are not stored, each compiled when it is first asked for."""

    task: _Task
    work: DenseOutput | None

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last; q is (n_q, N), u is (n_u, N)."""
        if name == "work" and self.work is not None:
            done: Floats = self.work(t)[0]
            return done
        if name == "constraint_violation":
            return self._violation(t, q, u)
        values: Floats = self.task.compiled(name)(t, q.T, u.T)
        if name in self.task.eqs.measured_angles:  # measured within half a turn, but motions go on
            return np.unwrap(values)
        return np.moveaxis(values, 0, -1)

    def _violation(self, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the largest constraint over its scale at each time."""
        eqs = self.task.eqs
        if not eqs.multiplier_names:
            return np.zeros_like(t)
        values = self.task.compiled("constraints")(t, q.T, u.T)
        largest: Floats = np.abs(values / constraint_scales(eqs, self.task.parameters)).max(axis=-1)
        return largest


def _trajectory(task: _Task, raw: RawRun, notes: tuple[str, ...]) -> Trajectory:
    """Return the run with its names."""
    eqs = task.eqs
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    states, work = _divided(raw.dense_output, n)
    stop = raw.stop_note((*eqs.state_names, "work"))
    return Trajectory(
        t=raw.t,
        q=raw.x[n_u:n],
        u=raw.x[:n_u],
        coordinate_names=eqs.coordinate_names,
        speed_names=eqs.speed_names,
        status=raw.status,
        statistics=raw.statistics,
        evaluate=_Evaluator(task, work),
        dense_output=states,
        stored={"work": raw.x[-1]},
        units=eqs.units,
        notes=(*notes, stop) if stop else notes,
        name=eqs.model.name,
    )


def _divided(dense: DenseOutput | None, n: int) -> tuple[DenseOutput | None, DenseOutput | None]:
    """Return the dense output of the first `n` states, and of the rest."""
    if dense is None:
        return None, None
    first, rest = dense.pieces[:, :, :n], dense.pieces[:, :, n:]
    return DenseOutput(dense.breaks, first), DenseOutput(dense.breaks, rest)
