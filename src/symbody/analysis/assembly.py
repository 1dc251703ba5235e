"""`assemble`: a configuration and a motion that satisfy all constraints, from fixed values and guesses.

Positions by Newton steps of least length from the guess (Gauss-Newton, Nocedal & Wright 2006, section 10.3),
with fixed values never moved; then velocities, then accelerations and multipliers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from symbody.analysis.closure import Closure, closure
from symbody.analysis.quaternions import unit_quaternions
from symbody.analysis.state import State
from symbody.analysis.velocities import consistent_speeds
from symbody.codegen.compile import Value, constant_values
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, nearest

Floats = NDArray[np.float64]

CLOSED: Final = 1e-9  # of the size of the mechanism: closer than any loop is built
_STARTS: Final = 24
_STEPS: Final = 80


def assemble(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None = None,
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    t: float = 0.0,
) -> State:
    """Return a state in which all constraints hold.

    Parameters
    ----------
    fixed : mapping of name to number or formula in parameters
        Coordinates, speeds, ``_dot`` names, or any named joint coordinate, that must have these values.
    guess : mapping of name to number or formula in parameters
        Where to look for the others; by default the model's initial values, then 0. Among several
        assemblies the nearest to the guess is taken; independent speeds take their guess exactly.
    parameters, inputs : mapping
        As for `simulate`; they matter for explicit time, accelerations and multipliers.
    t : float
        Time [s].

    Raises
    ------
    AssemblyError
        If the loops do not close, naming the joint that stays farthest open, or fixed values contradict
        each other, naming the smallest set that does; or if a name is unknown.
    """
    task = closure(eqs, dict(parameters or {}), dict(inputs or {}), t)
    known = _values(eqs, {**eqs.model.initial, **(guess or {})}, parameters, strict=set(guess or ()))
    wanted = _values(eqs, fixed or {}, parameters, strict=set(fixed or ()))
    positions, rates = task.parted(wanted)
    positions, known = unit_quaternions(eqs.quaternions, positions, known)
    start = task.start({**known, **positions})
    found = _closed(task, _near_measured(task, start, positions, known), positions)
    if found is None:
        raise AssemblyError(_why_open(task, task.start(known), start, positions))
    q = found.q
    u = consistent_speeds(task, q, rates, {name: known[name] for name in known if name not in positions})

    def others() -> list[State]:
        attempts = _others(task, start, positions, q)
        return [task.state(b.q, consistent_speeds(task, b.q, rates, known), start) for b in attempts]

    return task.state(q, u, start, others)


def _near_measured(
    task: Closure, start: Floats, fixed: Mapping[str, float], known: Mapping[str, float]
) -> Floats:
    """Return a start at which coordinates of cut joints have the values guessed for them, if there is one."""
    guessed = {name: known[name] for name in task.parted(known)[0] if name not in task.eqs.coordinate_names}
    measured = {name: value for name, value in guessed.items() if name not in fixed}
    if not measured:
        return start
    attempt = _newton(task, start, {**fixed, **measured})
    return attempt.q if attempt.is_closed else start


def assembled_configurations(
    task: Closure, guess: Mapping[str, Value], parameters: Mapping[str, Value] | None, count: int
) -> list[Floats]:
    """Return up to `count` different configurations that close the loops, the nearest to the guess first."""
    eqs = task.eqs
    known = _values(eqs, {**eqs.model.initial, **guess}, parameters, strict=set(guess))
    found: list[Floats] = []
    for start in _starts(task, task.start(known), {}):
        attempt = _newton(task, start, {})
        if attempt.is_closed and all(task.differs(attempt.q, other) for other in found):
            found.append(attempt.q)
        if len(found) == count:
            break
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Attempt:
    """Where Newton's method ended."""

    q: Floats
    residual: float
    is_closed: bool


def _closed(task: Closure, start: Floats, fixed: Mapping[str, float]) -> _Attempt | None:
    """Return the assembly nearest to the start, trying starts farther and farther away; or None."""
    for guess in _starts(task, start, fixed):
        attempt = _newton(task, guess, fixed)
        if attempt.is_closed:
            return attempt
        if task.is_tree:
            return None
    return None


def _starts(task: Closure, start: Floats, fixed: Mapping[str, float]) -> list[Floats]:
    """Return the start and starts about it, the same at every call."""
    random = np.random.default_rng(1)
    free = task.free(fixed)
    starts = [start]
    for k in range(1, _STARTS):
        spread = 0.1 * 1.25**k
        moved = start.copy()
        moved[free] += spread * random.standard_normal(int(free.sum())) * task.sizes[free]
        starts.append(task.normalized(moved))
    return starts


def _newton(task: Closure, q: Floats, fixed: Mapping[str, float]) -> _Attempt:
    """Return where steps of least length lead."""
    free = task.free(fixed)
    values, slopes = task.residuals(q, fixed)
    norm = float(np.linalg.norm(values))
    for _ in range(_STEPS):
        if not np.isfinite(norm) or norm < 1e-15 * task.size:
            break
        columns = slopes[:, free] * task.sizes[free]
        step = np.linalg.lstsq(columns, -values, rcond=1e-10)[0] * task.sizes[free]
        share = min(1.0, 1.0 / max(float(np.abs(step / task.sizes[free]).max(initial=0.0)), 1e-300))
        for _ in range(30):
            tried = q.copy()
            tried[free] += share * step
            new_values, new_slopes = task.residuals(tried, fixed)
            new_norm = float(np.linalg.norm(new_values))
            if new_norm < norm:
                break
            share /= 2.0
        else:
            break
        q, values, slopes, norm = tried, new_values, new_slopes, new_norm
    residual = float(np.abs(values).max(initial=0.0))
    return _Attempt(q, residual, residual <= CLOSED * task.size and task.is_aligned(q))


def _others(task: Closure, start: Floats, fixed: Mapping[str, float], q: Floats) -> list[_Attempt]:
    """Return further assemblies, nearest to the start first."""
    if task.is_tree:
        return []
    found = [q]
    others = []
    for guess in _starts(task, start, fixed)[1:]:
        attempt = _newton(task, guess, fixed)
        if attempt.is_closed and all(task.differs(attempt.q, other) for other in found):
            if task.is_isolated(attempt.q, fixed):
                found.append(attempt.q)
                others.append(attempt)
    return sorted(others, key=lambda attempt: float(np.abs((attempt.q - start) / task.sizes).max()))


def _why_open(task: Closure, guess: Floats, start: Floats, fixed: Mapping[str, float]) -> Problem:
    """Say which fixed values contradict each other, or which joint stays open."""
    if fixed and _closed(task, guess, {}) is not None:
        conflict = dict(fixed)
        for name in fixed:
            rest = {key: value for key, value in conflict.items() if key != name}
            if (
                _closed(
                    task,
                    task.start({**dict(zip(task.eqs.coordinate_names, guess, strict=True)), **rest}),
                    rest,
                )
                is None
            ):
                conflict = rest
        listed = ", ".join(f"{name} = {value:g}" for name, value in conflict.items())
        return Problem(
            "assembly.conflict", "fixed", f"no configuration has {listed}",
            "the loops close without these values, but not with them", "leave one of them to guess=",
        )  # fmt: skip
    best = min(
        (_newton(task, guess, fixed) for guess in _starts(task, start, fixed)), key=lambda a: a.residual
    )
    q = _least_open(task, best.q, fixed)
    joint, distance, angle = task.widest(q)
    if not task.is_aligned(best.q) and best.residual <= CLOSED * task.size:
        what = f"joint {joint} closes only with its axes opposite to each other"
    else:
        what = f"joint {joint} stays open by {distance:.3g} m and {np.degrees(angle):.3g} deg"
    return Problem(
        "assembly.open", f"joint {joint}", what, f"{_STARTS} starts about the guess were tried",
        "check lengths and frames of the loop, or give guess= values nearer to a configuration that closes",
    )  # fmt: skip


def _least_open(task: Closure, q: Floats, fixed: Mapping[str, float]) -> Floats:
    """Return coordinates near q at which the constraints are least open, in the sum of squares."""
    free = task.free(fixed)

    def moved(x: Floats) -> Floats:
        result = q.copy()
        result[free] = x
        return result

    found = least_squares(
        lambda x: task.residuals(moved(x), fixed)[0],
        q[free],
        jac=lambda x: task.residuals(moved(x), fixed)[1][:, free],
    )
    return moved(found.x)


def _values(
    eqs: EquationSet,
    formulas: Mapping[str, Value],
    parameters: Mapping[str, Value] | None,
    strict: set[str],
) -> dict[str, float]:
    """Return the values of named formulas; names that mean nothing are refused where the user gave them.

    Raises
    ------
    AssemblyError
        Naming each unknown name, with the nearest ones.
    """
    names = eqs.formed.readable_names
    known = {*names.symbols, *names.values}
    problems = [
        Problem("assembly.unknown_name", name, f"there is no coordinate or speed {name!r}", "",
                nearest(name, (*eqs.coordinate_names, *eqs.speed_names)))
        for name in formulas if name in strict and name not in known
    ]  # fmt: skip
    if problems:
        raise AssemblyError(*problems)
    return constant_values(eqs, {k: v for k, v in formulas.items() if k in known}, parameters)
