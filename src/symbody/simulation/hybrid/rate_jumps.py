"""Jumps of prescribed rates: the speeds jump as well, by what the joints and constraints transmit.

Where a prescribed rate jumps from one value to another, the mechanism is struck: of all speeds that fit the
new rates, those are taken to which the momenta of the free directions do not change,
``M u' + b' - (M u + b) = J^T P`` [Pars, A treatise on analytical dynamics, chapter 14], b the momenta that
prescribed rates give. A jump of a prescribed position is refused: at once, or where a constraint reads
coordinates as well, at the state in which the motion comes to it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.derivatives import partial_derivatives, with_outputs
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, UsageError
from symbody.expr import opcodes as op
from symbody.expr.graph import TIME, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.saddle import solve_saddle
from symbody.simulation.execution import execute
from symbody.simulation.hybrid.concatenate import at_times_asked, concatenate
from symbody.simulation.hybrid.modes import evaluate_outputs
from symbody.simulation.methods.integration import MotionPlan
from symbody.simulation.methods.integration_problem import IntegrationProblem
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import Evaluator, SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import AT_REST

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Nor where it is less, of the mechanism's size: rows that always hold are zero but for rounding.
_ROUNDED: Final = 1e-12
_TORN: Final = 1e-5  # of the mechanism's size, and of its speeds: more than a motion has drifted by then
_ELSEWHERE: Final = 0.137  # of coordinates and speeds, by which they are others
_SAMPLES: Final = 33  # of a motion, for the size of what is prescribed
_BESIDE: Final = 1e-9  # of times, in which jumps at its ends are looked for
_MOST_NOTES: Final = 20
_MOMENTA: Final = "momenta of the speeds"
_WITH_CORNERS: Final = frozenset(
    {op.LT, op.LE, op.EQ, op.MIN, op.MAX, op.ABS, op.SIGN, op.FLOOR, op.ATAN2, op.SELECT}
)


def may_jump(eqs: EquationSet) -> bool:
    """Return whether prescribed rates may jump: conditions, or the like, in time alone stand in them."""
    graph, names = eqs.formed.graph, eqs.formed.names
    nodes = [names.value(f"{name}{end}").index for name in _prescribed_names(eqs) for end in ("", "_dot")]
    nodes += [expression.index for row in eqs.formed.rows for expression in (row.value, row.drift)]
    cornered = [node for node in graph.reachable(nodes) if graph.ops[node] in _WITH_CORNERS]
    moving = {SymbolKind.COORDINATE, SymbolKind.SPEED}
    for node in cornered:
        symbols = {graph.symbols[graph.left[place]] for place in symbols_of(graph, [node])}
        if TIME in symbols and not any(symbol.kind in moving for symbol in symbols):
            return True
    return False


def run_with_jumps(plan: MotionPlan) -> Trajectory:
    """Return a motion in parts, between the times at which prescribed rates jump; see `jump_times`.

    Raises
    ------
    UsageError
        If a prescribed position jumps.
    """
    integration = plan.integration
    problem, span = integration.problem, integration.span
    times, margin = jump_times(problem, integration.state, span)
    if not times:
        return execute(plan)
    step = float(np.copysign(margin, span[1] - span[0]))
    edges = times if step > 0.0 else [math.nextafter(t, -math.inf) for t in times]
    starts = [span[0], *(min(t + step, span[1], key=lambda end: end * step) for t in times)]
    ends = [*(max(t - step, span[0], key=lambda end: end * step) for t in times), span[1]]
    parts: list[Trajectory] = []
    jumps: dict[int, float] = {}
    struck: list[int] = []  # of the jumps, those that change a speed
    x = integration.state
    for k, part_span in enumerate(zip(starts, ends, strict=True)):
        jump = None if k == len(times) else times[k]
        part = execute(replace(plan, integration=_part(integration, x, parts, part_span, jump)))
        is_over = part.status is not Status.SUCCESS or jump is None
        parts.append(_stretch(part, edges[k - 1] if k else None, None if is_over else edges[k]))
        if part.status is not Status.SUCCESS or jump is None:
            break
        before = _end_of(part)
        _check_positions(problem, before, (jump - step, jump + step))
        x, jumps[k + 1] = _jump(problem, before, jump - step, jump + step)
        if (
            np.abs(x - before).max(initial=0.0)
            > _TORN * min(1.0, problem.scales.length) / problem.scales.time
        ):
            struck.append(k + 1)
    run = concatenate(parts, [event for part in parts for event in part.events], jumps)
    if starts[-1] == span[1] and run.status is Status.SUCCESS:  # the last part takes no time
        run = replace(run, sides=parts[-2].sides)  # a motion that goes on sees what passed zero
    if integration.times is not None:  # one at a jump was computed beside it
        run = at_times_asked(run, np.asarray(integration.times), 2.0 * margin)
    return replace(run, notes=(*run.notes, *_jump_notes(times, {k: jumps[k] for k in struck})))


def _stretch(part: Trajectory, first: float | None, last: float | None) -> Trajectory:
    """Return a part of a motion that begins and ends at the jumps, beside which it was computed."""
    dense = part.dense_output
    if dense is None:
        return part
    breaks = dense.breaks.copy()
    if first is not None:
        breaks[0] = first
    if last is not None:
        breaks[-1] = last
    evaluate = part.evaluate
    if isinstance(evaluate, Evaluator) and evaluate.work is not None:
        evaluate = replace(evaluate, work=replace(evaluate.work, breaks=breaks))
    return replace(part, dense_output=replace(dense, breaks=breaks), evaluate=evaluate)


def _jump_notes(times: list[float], jumps: dict[int, float]) -> Iterator[str]:
    """Yield what to note about the jumps that happened."""
    for k, change in list(jumps.items())[:_MOST_NOTES]:
        yield (
            f"at t = {times[k - 1]:.9g} s prescribed rates jump: the speeds jump with them, and the energy "
            f"by {change:.6g} J"
        )
    if len(jumps) > _MOST_NOTES:
        last = times[max(jumps) - 1]
        yield f"{len(jumps) - _MOST_NOTES} more jumps of prescribed rates until t = {last:.9g} s"


def jump_times(problem: SimulationProblem, x: Floats, span: tuple[float, float]) -> tuple[list[float], float]:
    """Return when prescribed rates jump in a span, in its order, and how far beside it sides are clear.

    A jump is the first time at which formulas have the values of later times: motions forward pass it where
    they come to it, motions backward where they leave it. So one that goes on from an end misses none.

    Raises
    ------
    UsageError
        If a prescribed position jumps.
    """
    (start, end) = span
    times, margin = _jumps(problem, x, (start, end))
    low, high = min(span), max(span)
    return [t for t in times if low < t <= high], margin


def _jumps(problem: SimulationProblem, x: Floats, span: tuple[float, float]) -> tuple[list[float], float]:
    """Return the jumps in a span and beside it, in its order; see `jump_times`."""
    eqs = problem.eqs
    if not eqs.plans.get("may jump", lambda: may_jump(eqs)) or span[0] == span[1]:
        return [], 0.0
    names = _prescribed_names(eqs)
    closed = ("constraints", "velocity_constraints") if eqs.multiplier_names else ()
    low, high = min(span), max(span)
    beside = _BESIDE * max(high - low, abs(low), abs(high))  # a search keeps away from the ends
    bounds = problem.breakpoints(
        (low - beside, high + beside), (*names, *(f"{name}_dot" for name in names), *closed)
    )
    margin = float(bounds.margins.max(initial=0.0))
    inside = (bounds.times > low - margin) & (bounds.times < high + margin) & bounds.jumps
    times = bounds.times[inside]
    if not times.size:
        return [], 0.0
    prescribed = _PrescribedMotions(problem, x, np.linspace(*span, _SAMPLES), times, margin)
    rates, fastest = prescribed.changes((*(f"{name}_dot" for name in names), *closed[1:]))
    positions, largest = prescribed.changes((*names, *closed[:1]))
    turning = [eqs.units.get(name) == "rad" for name in names]
    positions[: len(names)] = remove_turns(positions[: len(names)], np.array(turning, dtype=np.bool_))
    width = 4.0 * margin * (fastest[: len(largest)] + np.abs(rates[: len(largest)]).max(axis=1, initial=0.0))
    rounded = _ROUNDED * _sizes(problem, names)
    limits = (AT_REST * largest + width + rounded[: len(largest)])[:, np.newaxis]
    torn = np.abs(positions) > limits
    # One that changes nothing at this state may tear at another.
    by_state = np.abs(positions - _changes_elsewhere(prescribed, names, closed)) > limits
    if (torn & ~by_state).any():
        row, k = np.argwhere(torn & ~by_state)[0]
        raise UsageError(_jump_problem(_row_name(eqs, names, int(row)), float(times[k])))
    least = (AT_REST * fastest + rounded / problem.scales.time)[:, np.newaxis]
    is_jump = np.abs(rates) > least
    places = np.flatnonzero(is_jump.any(axis=0) | by_state.any(axis=0))
    outputs = (*(f"{name}_dot" for name in names), *closed[1:])
    found = [prescribed.first_behind(outputs, float(times[k]), is_jump[:, k]) for k in places]
    return found if span[1] >= span[0] else found[::-1], margin


def _changes_elsewhere(
    prescribed: _PrescribedMotions, names: tuple[str, ...], closed: tuple[str, ...]
) -> Floats:
    """Return how much positions change at the times if all states are others: the same, if by time alone."""
    shifted = prescribed.x + _ELSEWHERE * (1.0 + np.arange(prescribed.x.size) % 7)
    changes, _ = replace(prescribed, x=shifted).changes((*names, *closed[:1]))
    turning = [prescribed.problem.eqs.units.get(name) == "rad" for name in names]
    changes[: len(names)] = remove_turns(changes[: len(names)], np.array(turning, dtype=np.bool_))
    return changes


def _row_name(eqs: EquationSet, names: tuple[str, ...], row: int) -> str:
    """Return the prescribed coordinate, or the constraint, of a row of changes."""
    return [*names, *(each.coordinate or each.name for each in eqs.formed.rows)][row]


def _check_positions(problem: SimulationProblem, x: Floats, times: tuple[float, float]) -> None:
    """Refuse a constraint that the state before a jump does not fulfil behind it.

    Raises
    ------
    UsageError
        See above.
    """
    eqs = problem.eqs
    if not eqs.multiplier_names or not x.size:
        return
    before, behind = (np.ravel(evaluate_outputs(problem, ("constraints",), t, x)[0]) for t in times)
    torn = np.abs(behind - before) > _TORN * problem.scales.constraints(eqs)[: len(behind)]
    if torn.any():
        raise UsageError(_jump_problem(_row_name(eqs, (), int(np.flatnonzero(torn)[0])), times[1]))


def _sizes(problem: SimulationProblem, names: tuple[str, ...]) -> Floats:
    """Return what counts as large for prescribed coordinates, and for constraints."""
    scales, eqs = problem.scales, problem.eqs
    own = [scales.length if eqs.units.get(name) == "m" else 1.0 for name in names]
    return np.concatenate([own, scales.constraints(eqs)])


def _prescribed_names(eqs: EquationSet) -> tuple[str, ...]:
    """Return the names of the prescribed coordinates that are functions of time."""
    return tuple(name for role in eqs.formed.joint_roles for name in role.prescribed_coordinates)


@dataclass(frozen=True, slots=True, eq=False)
class _PrescribedMotions:
    """What prescribed motions say of positions and of rates; those that are constraints about one state."""

    problem: SimulationProblem
    x: Floats
    samples: Floats
    times: Floats
    margin: float

    def changes(self, outputs: tuple[str, ...]) -> tuple[Floats, Floats]:
        """Return how much outputs change at the times, (n, N), and how large they are otherwise, (n,)."""
        if not outputs:
            return np.zeros((0, self.times.size)), np.zeros(0)
        before, behind = (
            self._values(outputs, self.times - self.margin),
            self._values(outputs, self.times + self.margin),
        )
        return behind - before, np.abs(self._values(outputs, self.samples)).max(axis=1)

    def first_behind(self, outputs: tuple[str, ...], t: float, jumping: Flags) -> float:
        """Return the first time, as a number, at which outputs that jump have the values behind the jump."""
        low, high = t - self.margin, t + self.margin
        ends = self._values(outputs, np.array([low, high]))[jumping]
        while jumping.any() and math.nextafter(low, high) < high:
            middle = low + 0.5 * (high - low)
            here = self._values(outputs, np.array([middle]))[jumping, 0]
            passed = (here - ends[:, 0]) / (ends[:, 1] - ends[:, 0])
            low, high = (low, middle) if passed.mean() > 0.5 else (middle, high)
        return high if jumping.any() else t

    def _values(self, outputs: tuple[str, ...], t: Floats) -> Floats:
        columns = []
        for time in t.tolist():
            values = evaluate_outputs(self.problem, outputs, time, self.x)
            columns.append(np.concatenate([np.ravel(value) for value in values]))
        return np.array(columns).T


def remove_turns(changes: Floats, is_angle: Flags) -> Floats:
    """Return changes without the whole turns of angles."""
    turns = 2.0 * np.pi * np.round(changes / (2.0 * np.pi))
    found: Floats = np.where(is_angle[:, np.newaxis], changes - turns, changes)
    return found


def _jump_problem(name: str, t: float) -> Problem:
    return Problem(
        "simulation.torn_motion", f"motion {name}", f"the prescribed position jumps at t = {t:.9g} s",
        "a position cannot change instantly",
        "use a transition from one value to the other, such as smoothstep(t, t1, t2)",
    )  # fmt: skip


def _part(
    integration: IntegrationProblem,
    x: Floats,
    before: list[Trajectory],
    span: tuple[float, float],
    jump: float | None,
) -> IntegrationProblem:
    """Return one part of a motion; a sample at a jump belongs to the part at later times, as formulas do.

    Parameters
    ----------
    jump : float or None
        The jump behind the part; None of the last one.
    """
    steps = sum(part.statistics.accepted + (part.statistics.rejected or 0) for part in before)
    times = None
    if integration.times is not None:
        samples = np.asarray(integration.times)
        first, last = sum(part.t.size for part in before), samples.size
        if jump is not None:
            is_forward = integration.span[1] >= integration.span[0]
            is_before = samples < jump if is_forward else samples >= jump
            last = int(np.count_nonzero(is_before))
        times = np.clip(samples[first:last], min(span), max(span))
    part = integration.part(x, span, times, steps)
    # An event that passes zero inside the jump happens behind it.
    return replace(part, sides=before[-1].sides[: len(part.events)]) if before else part


def _end_of(part: Trajectory) -> Floats:
    """Return the state at the end of a part."""
    dense = part.dense_output
    return np.zeros(0) if dense is None else np.array(dense(dense.breaks[-1:])[:, 0])


def _jump(problem: SimulationProblem, state: Floats, before: float, behind: float) -> tuple[Floats, float]:
    """Return the state after prescribed rates have jumped, and by how much the energy has changed.

    Raises
    ------
    SimulationError
        If no speeds fit the new rates.
    """
    n_u, x = len(problem.eqs.speed_names), state.copy()
    energy = float(evaluate_outputs(problem, ("energy",), before, x)[0])
    if n_u:
        x[:n_u] += _speed_change(problem, x, before, behind)
    return x, float(evaluate_outputs(problem, ("energy",), behind, x)[0]) - energy


def _speed_change(problem: SimulationProblem, x: Floats, before: float, behind: float) -> Floats:
    """Return by how much the speeds jump between two times."""
    formed = problem.eqs.formed
    momenta = partial_derivatives(problem.eqs, _MOMENTA, [formed.kinetic_energy.index], formed.u)
    with_momenta = replace(problem, eqs=with_outputs(problem.eqs, [momenta]))
    given = [np.ravel(evaluate_outputs(with_momenta, (_MOMENTA,), t, x)[0]) for t in (before, behind)]
    names = (
        ("mass_matrix", "jacobian", "velocity_constraints")
        if problem.eqs.multiplier_names
        else ("mass_matrix",)
    )
    mass, *closed = evaluate_outputs(problem, names, behind, x)
    rows, rates = closed if closed else (np.zeros((0, len(mass))), np.zeros(0))
    solution = solve_saddle(
        mass.ravel().tolist(), rows.ravel().tolist(), (given[0] - given[1]).tolist(), (-rates).tolist()
    )
    if not solution.ok:
        raise SimulationError(
            Problem("simulation.impulse", "motion",
                    f"no speeds satisfy the prescribed rates after t = {behind:.9g} s",
                    "the constraints do not allow them, or the mass matrix is singular",
                    "prescribe a motion without corners")
        )  # fmt: skip
    return np.array(solution.udot)
