"""`assemble`: a configuration and a motion that satisfy all constraints, from fixed values and guesses.

Positions by Newton steps of least length from the guess (Gauss-Newton, Nocedal & Wright 2006, section 10.3),
with fixed values never moved; then velocities, then accelerations and multipliers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.closure import Closure, closure
from symbody.analysis.least_open import least_open
from symbody.analysis.named_values import checked_mappings, checked_pairs, named_values
from symbody.analysis.quaternions import unit_quaternions
from symbody.analysis.ranges import (
    Ranges,
    checked_ranges,
    into_ranges,
    measured_in_ranges,
    nearest_in_ranges,
    out_of_range,
    starts_in_ranges,
)
from symbody.analysis.ropes import assembled_with_ropes
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.analysis.velocities import consistent_speeds
from symbody.arguments import checked_arguments
from symbody.codegen.compile import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.ropes import ropes
from symbody.errors import AssemblyError, Problem

Floats = NDArray[np.float64]

NO_RANGES: Final[Ranges] = MappingProxyType({})
CLOSED: Final = 1e-9  # of the size of the mechanism: closer than any loop is built
_FAR: Final = 1e-6  # the rounding of a coordinate so many sizes away is a fifth of what counts as closed
_STARTS: Final = 24
_STEPS: Final = 80
# A step is halved until it gains a share of what it promises; one so short that this never happens ends where
# gaps are least, or where all conditions hold to rounding.
_HALVINGS: Final = 12
_DECREASE: Final = 1e-3  # Nocedal & Wright 2006, equation 3.4
# The nearest of all ends from which the least gaps are looked for, and gaps too small to tell.
_LEAST_OPEN: Final = 3
_TOLD: Final = 1e-6


@checked_arguments
def assemble(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None = None,
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    t: float = 0.0,
    ranges: Mapping[str, tuple[Value, Value]] | None = None,
    *,
    scales: Mapping[str, float] | None = None,
) -> State:
    """Return a state in which all constraints hold.

    Parameters
    ----------
    fixed : mapping of name to number or formula in parameters
        Coordinates, speeds, ``_dot`` names, or any named joint coordinate, that must have these values; of an
        angle also ``"30 deg"``.
    guess : mapping of name to number or formula in parameters
        Where to look for the others; by default the model's initial values, then 0. Among several
        assemblies the nearest to the guess is taken; speeds and rates take their guesses exactly, in their
        order, those of the model last, as long as they are independent. `State.moved` tells which are not.
    parameters, inputs : mapping
        As for `simulate`; they matter for explicit time, accelerations and multipliers.
    t : float
        Time [s].
    ranges : mapping of name to (lower, upper), numbers or formulas in parameters
        Positions that must lie between these; angles are turned by whole turns into their ranges. Starts
        are spread over the ranges too.
    scales : mapping of "length", "time", "mass" to float, optional
        What counts as large [m, s, kg]; by default it follows from the model. Constraints are closed to 1e-9
        of the length, or rad.

    Ropes are closed where the guess would have them longer than they are, and where their ends would move
    apart although they are taut, unless fixed speeds ask for that; those that are shorter are left alone.

    Raises
    ------
    AssemblyError
        If the loops do not close, naming the joint that stays farthest open where the sum of squares of all
        gaps is least, and the others open there; or they close outside the ranges only; or fixed values
        contradict each other, naming the smallest set that does; or if a name is unknown.
    """
    checked_mappings(fixed=fixed, guess=guess, parameters=parameters, inputs=inputs, ranges=ranges)
    checked_pairs(ranges or {})
    if not ropes(eqs.formed):
        return assemble_taut(eqs, fixed, guess, parameters, inputs, t, ranges, scales)

    def attempt(equations: EquationSet, values: Mapping[str, float]) -> State:
        return assemble_taut(equations, values, guess, parameters, inputs, t, ranges, scales)

    known = named_values(eqs, _guessed(eqs, guess), parameters, strict=set(guess or ()))
    wanted = named_values(eqs, fixed or {}, parameters, strict=set(fixed or ()))
    values = dict(parameters or {}), dict(inputs or {})
    own = mechanism_scales(eqs, values[0], scales, {**known, **wanted})
    return assembled_with_ropes(eqs, wanted, known, attempt, lambda held: closure(held, *values, t, own))


def assemble_taut(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None,
    guess: Mapping[str, Value] | None,
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None = None,
    t: float = 0.0,
    ranges: Mapping[str, tuple[Value, Value]] | None = None,
    scales: Mapping[str, float] | None = None,
) -> State:
    """Return a state in which all constraints hold, those of ropes too; otherwise as `assemble`."""
    known = named_values(eqs, _guessed(eqs, guess), parameters, strict=set(guess or ()))
    wanted = named_values(eqs, fixed or {}, parameters, strict=set(fixed or ()))
    own = mechanism_scales(eqs, dict(parameters or {}), scales, {**known, **wanted})
    task = closure(eqs, dict(parameters or {}), dict(inputs or {}), t, own)
    positions, rates = task.parted(wanted)
    positions, known = unit_quaternions(eqs.quaternions, positions, known)
    lower, upper = (
        named_values(
            eqs, {name: pair[k] for name, pair in (ranges or {}).items()}, parameters, set(ranges or ())
        )
        for k in (0, 1)
    )
    within = checked_ranges(task, lower, upper)
    start = nearest_in_ranges(task, task.start({**known, **positions}), within, positions)
    found = _closed(task, _near_measured(task, start, positions, known), positions, within)
    if found is None:
        raise AssemblyError(_why_open(task, task.start(known), start, positions, within))
    q = found.q
    guessed = {name: value for name, value in known.items() if name not in positions and name not in rates}
    u = consistent_speeds(task, q, rates, guessed)
    others = partial(_other_states, task, start, positions, q, within, rates, guessed)
    return task.state(q, u, start, guessed, others)


def _other_states(
    task: Closure,
    start: Floats,
    fixed: Mapping[str, float],
    q: Floats,
    ranges: Ranges,
    rates: Mapping[str, float],
    guess: Mapping[str, float],
) -> list[State]:
    attempts = _others(task, start, fixed, q, ranges)
    return [task.state(b.q, consistent_speeds(task, b.q, rates, guess), start, guess) for b in attempts]


def _guessed(eqs: EquationSet, guess: Mapping[str, Value] | None) -> dict[str, Value]:
    """Return the guesses, and behind them what only the model says of the start."""
    given = dict(guess or {})
    return given | {name: value for name, value in eqs.model.initial.items() if name not in given}


def consistent_start(
    task: Closure, fixed: Mapping[str, float], known: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Return q and u in which all constraints hold, as `assemble` does with values instead of formulas.

    Raises
    ------
    AssemblyError
        As `assemble`.
    """
    positions, rates = task.parted(fixed)
    positions, known = unit_quaternions(task.eqs.quaternions, positions, known)
    q = consistent_positions(task, positions, known)
    guess = {name: value for name, value in known.items() if name not in positions and name not in rates}
    return q, consistent_speeds(task, q, rates, guess)


def consistent_positions(task: Closure, fixed: Mapping[str, float], known: Mapping[str, float]) -> Floats:
    """Return coordinates (n_q,) in which all constraints hold; of what is fixed the positions count.

    Raises
    ------
    AssemblyError
        As `assemble`.
    """
    positions, known = unit_quaternions(task.eqs.quaternions, task.parted(fixed)[0], known)
    start = task.start({**known, **positions})
    closed = _closed(task, _near_measured(task, start, positions, known), positions)
    if closed is None:
        raise AssemblyError(_why_open(task, task.start(known), start, positions, NO_RANGES))
    return closed.q


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


def assembled_configuration(
    task: Closure, guess: Mapping[str, Value], parameters: Mapping[str, Value] | None
) -> Floats | None:
    """Return the configuration nearest to a guess that closes the loops, or None."""
    eqs = task.eqs
    known = named_values(eqs, _guessed(eqs, guess), parameters, strict=set(guess))
    found = _closed(task, _near_measured(task, task.start(known), {}, known), {})
    return None if found is None else found.q


@dataclass(frozen=True, slots=True, eq=False)
class _Attempt:
    """Where Newton's method ended."""

    q: Floats
    residual: float
    is_closed: bool


def _closed(
    task: Closure, start: Floats, fixed: Mapping[str, float], ranges: Ranges = NO_RANGES
) -> _Attempt | None:
    """Return the assembly nearest to the start, trying starts farther and farther away; or None."""
    starts = _starts(task, start, fixed, ranges)
    for guess in starts:
        attempt = _ranged(task, _newton(task, guess, fixed), ranges)
        if attempt.is_closed:
            return attempt
        if task.is_tree:
            return None
    for guess, inside in zip(starts, measured_in_ranges(task, ranges, fixed, _STARTS), strict=False):
        attempt = _ranged(task, _newton(task, guess, {**fixed, **inside}), ranges)
        if attempt.is_closed:
            return attempt
    return None


def _ranged(task: Closure, attempt: _Attempt, ranges: Ranges) -> _Attempt:
    """Return where Newton's method ended, with angles in their ranges; not closed outside of these."""
    if not attempt.is_closed or not ranges:
        return attempt
    q = into_ranges(task, attempt.q, ranges)
    return replace(attempt, is_closed=False) if q is None else replace(attempt, q=q)


def _starts(
    task: Closure, start: Floats, fixed: Mapping[str, float], ranges: Ranges = NO_RANGES
) -> list[Floats]:
    """Return the start and starts about it, and in the ranges, the same at every call."""
    random = np.random.default_rng(1)
    free = task.free(fixed)
    starts = [start]
    for k in range(1, _STARTS):
        spread = 0.1 * 1.25**k
        moved = start.copy()
        moved[free] += spread * random.standard_normal(int(free.sum())) * task.sizes[free]
        starts.append(task.normalized(moved))
    return [*starts, *starts_in_ranges(task, start, ranges, fixed, _STARTS)]


def _newton(task: Closure, q: Floats, fixed: Mapping[str, float]) -> _Attempt:
    """Return where steps of least length lead."""
    free = task.free(fixed)
    values, slopes = task.residuals(q, fixed)
    norm = float(np.linalg.norm(values))
    for _ in range(_STEPS):
        if not (np.isfinite(norm) and np.isfinite(slopes).all()) or norm < 1e-15 * task.size:
            break
        columns = slopes[:, free] * task.sizes[free]
        step = np.linalg.lstsq(columns, -values, rcond=1e-10)[0] * task.sizes[free]
        share = min(1.0, 1.0 / max(float(np.abs(step / task.sizes[free]).max(initial=0.0)), 1e-300))
        for _ in range(_HALVINGS):
            tried = q.copy()
            tried[free] += share * step
            new_values, new_slopes = task.residuals(tried, fixed)
            new_norm = float(np.linalg.norm(new_values))
            if new_norm < (1.0 - _DECREASE * share) * norm:
                break
            share /= 2.0
        else:
            break
        q, values, slopes, norm = tried, new_values, new_slopes, new_norm
    residual = float(np.abs(values).max(initial=0.0))
    # Residuals are known to the rounding of the largest coordinate, which may exceed the mechanism by far.
    closed = CLOSED * max(1.0, _FAR * float(np.abs(q / task.sizes).max(initial=0.0)))
    return _Attempt(q, residual, residual <= closed * task.size and task.is_aligned(q))


def _others(
    task: Closure, start: Floats, fixed: Mapping[str, float], q: Floats, ranges: Ranges
) -> list[_Attempt]:
    """Return further assemblies, nearest to the start first."""
    if task.is_tree:
        return []
    found = [q]
    others = []
    for guess in _starts(task, start, fixed, ranges)[1:]:
        attempt = _ranged(task, _newton(task, guess, fixed), ranges)
        if attempt.is_closed and all(task.differs(attempt.q, other) for other in found):
            if task.is_isolated(attempt.q, fixed):
                found.append(attempt.q)
                others.append(attempt)
    return sorted(others, key=lambda attempt: float(np.abs((attempt.q - start) / task.sizes).max()))


def _why_open(
    task: Closure, guess: Floats, start: Floats, fixed: Mapping[str, float], ranges: Ranges
) -> Problem:
    """Say which fixed values contradict each other, which joint stays open, or what is out of range."""
    if ranges:
        outside = _closed(task, start, fixed)
        if outside is not None:
            others = _others(task, start, fixed, outside.q, NO_RANGES)
            return out_of_range(task, [outside.q, *(other.q for other in others)], ranges)
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
    attempts = sorted((_newton(task, guess, fixed) for guess in _starts(task, start, fixed)),
                      key=lambda attempt: np.nan_to_num(attempt.residual, nan=np.inf))  # fmt: skip
    return _open_joints(task, attempts, fixed)


def _open_joints(task: Closure, attempts: Sequence[_Attempt], fixed: Mapping[str, float]) -> Problem:
    """Say by how much joints stay open, from where Newton's method came nearest to closing them."""
    best = attempts[0]
    told = f"{_STARTS} starts about the guess were tried"
    if not task.is_aligned(best.q) and best.residual <= CLOSED * task.size:
        joint = next(iter(task.gaps(best.q)), "")
        what = f"joint {joint} closes only with its axes opposite to each other"
    else:
        finite = [attempt.q for attempt in attempts if np.isfinite(attempt.residual)][:_LEAST_OPEN]
        trials = [(best.q, np.inf), *(least_open(task, task.normalized(q), fixed) for q in finite)]
        q, _ = min(trials, key=lambda trial: trial[1])
        (joint, gap), *others = task.gaps(q).items() or [("", (0.0, 0.0))]
        size = task.mechanism.length
        what = f"joint {joint} stays open by {_width(gap, size)}"
        wide = [(name, gap) for name, gap in others if gap[0] > _TOLD * size or gap[1] > _TOLD]
        if wide:
            listed = ", ".join(f"joint {name} by {_width(gap, size)}" for name, gap in wide)
            told += f"; with the least squares of all gaps {listed}"
    return Problem(
        "assembly.open", f"joint {joint}", what, told,
        "check lengths and frames of the loop, or give guess= values nearer to a configuration that closes",
    )  # fmt: skip


def _width(gap: tuple[float, float], size: float) -> str:
    """Return a distance and an angle in words, without the rounding of what is closed."""
    distance, angle = (
        value if value > _TOLD * unit else 0.0 for value, unit in zip(gap, (size, 1.0), strict=True)
    )
    return f"{distance:.3g} m and {np.degrees(angle):.3g} deg"
