"""Jumps of prescribed rates: the speeds jump as well, by what the joints and constraints transmit.

Where a prescribed rate jumps from one value to another, the mechanism is struck: of all speeds that fit the
new rates, those are taken to which the momenta of the free directions do not change,
``M u' + b' - (M u + b) = J^T P`` [Pars, A treatise on analytical dynamics, chapter 14], b the momenta that
prescribed rates give. A jump of a prescribed position is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.derivatives import partial_derivatives, with_outputs
from symbody.analysis.state import State
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, UsageError
from symbody.expr import opcodes as op
from symbody.expr.graph import TIME, Kind
from symbody.expr.rewrite import symbols_of
from symbody.expr.saddle import solve_saddle
from symbody.simulation.events.events import Event
from symbody.simulation.methods.request import Request
from symbody.simulation.modes.joined import joined
from symbody.simulation.modes.modes import outputs_at
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.status import Status
from symbody.simulation.task import Task
from symbody.tolerances import AT_REST

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
# From a task, a first state, a span, what makes a request, and events to a motion.
Move = Callable[[Task, State, tuple[float, float], "partial[Request]", tuple[Event, ...]], Trajectory]

# Nor where it is less, of the mechanism's size: rows that always hold are zero but for rounding.
_ROUNDED: Final = 1e-12
_SAMPLES: Final = 33  # of a motion, for the size of what is prescribed
_MOST_TOLD: Final = 20
_MOMENTA: Final = "momenta of the speeds"
_CORNERED: Final = frozenset(
    {op.LT, op.LE, op.EQ, op.MIN, op.MAX, op.ABS, op.SIGN, op.FLOOR, op.ATAN2, op.SELECT}
)


def may_be_struck(eqs: EquationSet) -> bool:
    """Return whether prescribed rates may jump: conditions, or the like, in time alone stand in them."""
    graph, names = eqs.formed.graph, eqs.formed.names
    nodes = [names.value(f"{name}{end}").index for name in _prescribed(eqs) for end in ("", "_dot")]
    nodes += [expression.index for row in eqs.formed.rows for expression in (row.value, row.rest)]
    cornered = [node for node in graph.reachable(nodes) if graph.ops[node] in _CORNERED]
    moving = {Kind.COORDINATE, Kind.SPEED}
    for node in cornered:
        symbols = {graph.symbols[graph.left[place]] for place in symbols_of(graph, [node])}
        if TIME in symbols and not any(symbol.kind in moving for symbol in symbols):
            return True
    return False


def run_struck(
    task: Task, first: State, span: tuple[float, float], wanted: partial[Request],
    events: tuple[Event, ...], *, move: Move,
) -> Trajectory:  # fmt: skip
    """Return a motion in parts, between the times at which prescribed rates jump.

    Raises
    ------
    UsageError
        If a prescribed position jumps.
    """
    times, margin = struck_times(task, first, span)
    if not times:
        return move(task, first, span, wanted, events)
    step = float(np.copysign(margin, span[1] - span[0]))
    spans = zip([span[0], *(t + step for t in times)], [*(t - step for t in times), span[1]], strict=True)
    parts: list[Trajectory] = []
    jumps: dict[int, float] = {}
    state = first
    for k, (start, end) in enumerate(spans):
        part = move(task, state, (start, end), _share(wanted, parts, span, (start, end)), events)
        parts.append(part)
        if part.status is not Status.SUCCESS or k == len(times):
            break
        state, jumps[k + 1] = _struck(task, part, end, end + 2.0 * step)
    run = joined(parts, [event for part in parts for event in part.events], jumps)
    if wanted.keywords["times"] is not None:  # one at a jump was computed behind it
        run = replace(run, t=np.array(wanted.keywords["times"], dtype=np.float64)[: run.t.size])
    return replace(run, notes=(*run.notes, *_told(times, jumps)))


def _told(times: list[float], jumps: dict[int, float]) -> Iterator[str]:
    """Yield what to note about the jumps that happened."""
    for k, change in list(jumps.items())[:_MOST_TOLD]:
        yield (
            f"at t = {times[k - 1]:.9g} s prescribed rates jump: the speeds jump with them, and the energy "
            f"by {change:.6g} J"
        )
    if len(jumps) > _MOST_TOLD:
        last = times[len(jumps) - 1]
        yield f"{len(jumps) - _MOST_TOLD} more jumps of prescribed rates until t = {last:.9g} s"


def struck_times(task: Task, first: State, span: tuple[float, float]) -> tuple[list[float], float]:
    """Return the times at which prescribed rates jump, in the order of the motion, and how exact they are.

    Raises
    ------
    UsageError
        If a prescribed position jumps.
    """
    eqs = task.eqs
    if not may_be_struck(eqs) or span[0] == span[1]:
        return [], 0.0
    names = _prescribed(eqs)
    closed = ("constraints", "velocity_constraints") if eqs.multiplier_names else ()
    bounds = task.breakpoints(span, (*names, *(f"{name}_dot" for name in names), *closed))
    inside = (bounds.times > min(span)) & (bounds.times < max(span)) & bounds.jumps
    times = bounds.times[inside]
    margin = float(bounds.margins.max(initial=0.0))
    if not times.size:
        return [], 0.0
    seen = _Prescribed(task, first, np.linspace(*span, _SAMPLES), times, margin)
    rates, fastest = seen.changes((*(f"{name}_dot" for name in names), *closed[1:]))
    positions, largest = seen.changes((*names, *closed[:1]))
    turning = [eqs.units.get(name) == "rad" for name in names]
    positions[: len(names)] = _without_turns(positions[: len(names)], np.array(turning, dtype=np.bool_))
    width = 4.0 * margin * (fastest[: len(largest)] + np.abs(rates[: len(largest)]).max(axis=1, initial=0.0))
    rounded = _ROUNDED * _sizes(task, names)
    torn = np.abs(positions) > (AT_REST * largest + width + rounded[: len(largest)])[:, np.newaxis]
    if torn.any():
        row, k = np.argwhere(torn)[0]
        raise UsageError(
            _torn([*names, *(row.coordinate or row.name for row in eqs.formed.rows)][row], float(times[k]))
        )
    least = (AT_REST * fastest + rounded / task.scales.time)[:, np.newaxis]
    found: list[float] = times[(np.abs(rates) > least).any(axis=0)].tolist()
    return found if span[1] >= span[0] else found[::-1], margin


def _sizes(task: Task, names: tuple[str, ...]) -> Floats:
    """Return what counts as large for prescribed coordinates, and for constraints."""
    scales, eqs = task.scales, task.eqs
    own = [scales.length if eqs.units.get(name) == "m" else 1.0 for name in names]
    return np.concatenate([own, scales.constraints(eqs)])


def _prescribed(eqs: EquationSet) -> tuple[str, ...]:
    """Return the names of the prescribed coordinates that are functions of time."""
    return tuple(name for use in eqs.formed.uses for name in use.prescribed)


@dataclass(frozen=True, slots=True, eq=False)
class _Prescribed:
    """What prescribed motions say of positions and of rates; those that are constraints about one state."""

    task: Task
    first: State
    samples: Floats
    times: Floats
    margin: float

    def changes(self, outputs: tuple[str, ...]) -> tuple[Floats, Floats]:
        """Return how much outputs change at the times, (n, N), and how large they are otherwise, (n,)."""
        if not outputs:
            return np.zeros((0, self.times.size)), np.zeros(0)
        before, behind = (
            self._at(outputs, self.times - self.margin),
            self._at(outputs, self.times + self.margin),
        )
        return behind - before, np.abs(self._at(outputs, self.samples)).max(axis=1)

    def _at(self, outputs: tuple[str, ...], t: Floats) -> Floats:
        u, q = (np.array(list(values.values())) for values in (self.first.u, self.first.q))
        columns = []
        for time in t.tolist():
            found = outputs_at(self.task, outputs, time, np.concatenate([u, q]))
            columns.append(np.concatenate([np.ravel(value) for value in found]))
        return np.array(columns).T


def _without_turns(changes: Floats, is_angle: Flags) -> Floats:
    """Return changes without the whole turns of angles."""
    turns = 2.0 * np.pi * np.round(changes / (2.0 * np.pi))
    found: Floats = np.where(is_angle[:, np.newaxis], changes - turns, changes)
    return found


def _torn(name: str, t: float) -> Problem:
    return Problem(
        "simulation.torn_motion", f"motion {name}", f"the prescribed position jumps at t = {t:.9g} s",
        "nothing moves by a distance in no time",
        "let it pass from one value to the other, as smoothstep(t, t1, t2) does",
    )  # fmt: skip


def _share(
    wanted: partial[Request], parts: list[Trajectory], span: tuple[float, float], own: tuple[float, float]
) -> partial[Request]:
    """Return what is wanted of one part of a motion; a sample at a jump belongs to the part behind."""
    times, tell = wanted.keywords["times"], wanted.keywords["progress"]
    spent = sum(part.statistics.accepted + (part.statistics.rejected or 0) for part in parts)
    way, is_last = float(np.sign(span[1] - span[0])), own[1] == span[1]
    if times is not None:
        times = np.asarray(times, dtype=np.float64)
        if times.ndim == 1:
            seen = sum(part.t.size for part in parts)
            until = times.size if is_last else int(np.searchsorted(way * times, way * own[1], side="right"))
            times = times[seen:until]
            times = np.where(way * (times - own[0]) < 0.0, own[0], times) if parts else times
    first, length = (own[0] - span[0]) / (span[1] - span[0]), (own[1] - own[0]) / (span[1] - span[0])

    def told(share: float) -> bool | None:
        answer: bool | None = tell(first + share * length)
        return answer

    left = wanted.keywords["max_steps"] - spent
    return partial(wanted, times=times, max_steps=left, progress=None if tell is None else told)


def _struck(task: Task, part: Trajectory, before: float, behind: float) -> tuple[State, float]:
    """Return the state after prescribed rates have jumped, and by how much the energy has changed.

    Raises
    ------
    SimulationError
        If no speeds fit the new rates.
    """
    eqs, dense = task.eqs, part.dense_output
    n_u = len(eqs.speed_names)
    x = np.zeros(0) if dense is None else np.array(dense(dense.breaks[-1:])[:, 0])
    energy = float(outputs_at(task, ("energy",), before, x)[0])
    if n_u:
        x[:n_u] += _change(task, x, before, behind)
    change = float(outputs_at(task, ("energy",), behind, x)[0]) - energy
    u = dict(zip(eqs.speed_names, x[:n_u].tolist(), strict=True))
    q = dict(zip(eqs.coordinate_names, x[n_u:].tolist(), strict=True))
    return State(eqs, q, u, {}, {}, 0.0, {}, behind), change


def _change(task: Task, x: Floats, before: float, behind: float) -> Floats:
    """Return by how much the speeds jump between two times."""
    formed = task.eqs.formed
    momenta = partial_derivatives(task.eqs, _MOMENTA, [formed.kinetic_energy.index], formed.u)
    with_momenta = replace(task, eqs=with_outputs(task.eqs, [momenta]))
    given = [np.ravel(outputs_at(with_momenta, (_MOMENTA,), t, x)[0]) for t in (before, behind)]
    names = (
        ("mass_matrix", "jacobian", "velocity_constraints") if task.eqs.multiplier_names else ("mass_matrix",)
    )
    mass, *closed = outputs_at(task, names, behind, x)
    rows, rates = closed if closed else (np.zeros((0, len(mass))), np.zeros(0))
    solution = solve_saddle(
        mass.ravel().tolist(), rows.ravel().tolist(), (given[0] - given[1]).tolist(), (-rates).tolist()
    )
    if not solution.ok:
        raise SimulationError(
            Problem("simulation.impulse", "motion",
                    f"no speeds fit the rates prescribed from t = {behind:.9g} s on",
                    "the constraints do not allow them, or the mass matrix is singular",
                    "prescribe a motion without corners")
        )  # fmt: skip
    return np.array(solution.udot)
