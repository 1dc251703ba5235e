"""`simulate`: from equations and initial values to a trajectory."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.codegen.compile import Value, constant_values, form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, nearest
from symbody.simulation.dense_output import DenseOutput
from symbody.simulation.explicit import Explicit, Progress, RawRun, integrate
from symbody.simulation.trajectory import Trajectory

Floats = NDArray[np.float64]


def simulate(
    eqs: EquationSet,
    t_end: float | tuple[float, float],
    initial: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    times: ArrayLike | None = None,
    integrator: Explicit | None = None,
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
        Coordinates and their ``_dot`` names; they override the model's. Those given nowhere are 0.
    parameters : mapping of name to number or formula
        Overrides values of the model.
    inputs : mapping of name to expression
        In t, states and parameters, for instance ``{"F": "sin(omega*t)"}``; inputs not named are 0.
    times : array, optional
        Exactly the samples to store; by default every step.
    integrator : Explicit, optional
        ``Explicit(order=8)`` by default.
    rtol, atol : float
        Relative and absolute tolerance of the local error.

    Raises
    ------
    CompileError
        If a parameter has no value, or a name is unknown.
    SimulationError
        If initial values or times make no sense. Failures on the way do not raise: `status` tells.
    """
    task = _Task(_tree(eqs), dict(parameters or {}), dict.fromkeys(eqs.input_names, 0) | dict(inputs or {}))
    # The work is one more state: the function writes its rate, the power, behind xdot.
    function = task.compiled(("xdot", "power"))
    raw = integrate(
        function.address,
        function.work_size,
        len(eqs.speed_names),
        len(eqs.coordinate_names) + 1,
        np.append(_initial_state(task, initial or {}), 0.0),
        t_end if isinstance(t_end, tuple) else (0.0, t_end),
        constants=function.constants(),
        method=Explicit() if integrator is None else integrator,
        times=times,
        rtol=rtol,
        atol=atol,
        max_steps=max_steps,
        progress=progress,
    )
    silent = sorted(set(eqs.input_names).difference(inputs or {}))
    return _trajectory(task, raw, tuple(f"input {name} has no value and is 0" for name in silent))


@dataclass(frozen=True, slots=True)
class _Task:
    """Equations with the values of parameters and the laws of all inputs."""

    eqs: EquationSet
    parameters: Mapping[str, Value]
    inputs: Mapping[str, Value]

    def compiled(self, outputs: str | Sequence[str]) -> CompiledFunction:
        """Return a function of t, q and u alone."""
        return CompiledFunction(*form_sequence(self.eqs, outputs, self.parameters, (), self.inputs))


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
        if name == "constraint_violation":  # a tree has no constraints
            return np.zeros_like(t)
        values: Floats = self.task.compiled(name)(t, q.T, u.T)
        return np.moveaxis(values, 0, -1)


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


def _initial_state(task: _Task, initial: Mapping[str, Value]) -> Floats:
    """Return the first state (speeds, then coordinates)."""
    eqs = task.eqs
    names = eqs.state_names
    unknown = [name for name in initial if name not in names]
    if unknown:
        raise SimulationError(*(_unknown_state(name, names) for name in unknown))
    chosen = {**eqs.model.initial, **initial}
    values = constant_values(eqs, {name: chosen[name] for name in names if name in chosen}, task.parameters)
    for quaternion in eqs.quaternions:
        _normalize(values, quaternion)
    return np.array([values.get(name, 0.0) for name in names])


def _normalize(values: dict[str, float], quaternion: Sequence[str]) -> None:
    """Give a quaternion unit norm; one of which nothing is said is 1, 0, 0, 0."""
    found = [values.get(name, 0.0) for name in quaternion]
    norm = math.hypot(*found)
    if norm == 0:
        found, norm = [1.0, 0.0, 0.0, 0.0], 1.0
    values.update((name, x / norm) for name, x in zip(quaternion, found, strict=True))


def _tree(eqs: EquationSet) -> EquationSet:
    """Return equations without constraints, as they are."""
    if not eqs.multiplier_names:
        return eqs
    problem = Problem(
        "simulation.constraints", eqs.model.name, f"there are {len(eqs.multiplier_names)} constraints",
        "motions of closed loops are not covered by this version",
        "use the equations by compile(eqs, ['udot', 'lambda']), or open the loops",
    )  # fmt: skip
    raise SimulationError(problem)


def _unknown_state(name: str, names: tuple[str, ...]) -> Problem:
    return Problem(
        "simulation.unknown_initial",
        name,
        f"there is no coordinate or speed {name!r}",
        "",
        nearest(name, names),
    )
