"""Gaps and friction moved by impulses, along a motion: `kernels.impulses` with its numbers and its record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import find_first_state
from symbody.analysis.configurations.closed_gaps import AT_LENGTH
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.equations.closing_equations import closing_equations
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.impulsive_equations import (
    GAPS,
    ImpulsePoint,
    ResponsePattern,
    friction_of_reactions,
    impulsive_equations,
)
from symbody.errors import Problem, UsageError
from symbody.expr.rewrite import symbols_of
from symbody.kernels.impulses.impulse_machine import ENTRY
from symbody.kernels.impulses.impulse_step import ImpulseStep
from symbody.kernels.pack import pack
from symbody.simulation.events.events import Event
from symbody.simulation.hybrid.rate_jumps import PlannedJumps
from symbody.simulation.inputs.held_law import HeldLaw
from symbody.simulation.motion import Motion
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import CLOSED

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

_FIRST_ROOM: Final = 256


class ImpulseRecord:
    """The efforts of all points along a motion: impulses over the length of their steps.

    They are the law of the inputs that hold them. In a step they are constant; at its end they are those of
    the step that ends there.

    Parameters
    ----------
    points : sequence of ImpulsePoint
    names : sequence of str
        Of the inputs, by point and row.

    Attributes
    ----------
    starts, entries : (room, 2), (room, 4) arrays
        What `kernels.impulses.impulse_machine.note_step` writes.
    """

    def __init__(self, points: Sequence[ImpulsePoint], names: Sequence[str]) -> None:
        rows = [(k, r) for k, point in enumerate(points) for r in range(_row_count(point))]
        self._places = dict(zip(names, rows, strict=True))
        self._points = len(points)
        self.starts: Floats = np.zeros((_FIRST_ROOM, 2))
        self.entries: Floats = np.zeros((max(_FIRST_ROOM, 2 * len(points)), ENTRY))
        self._steps = self._count = 0
        self._by_point: list[tuple[Places, Floats]] | None = None

    def grow(self) -> None:
        """Make room for as many more steps and entries."""
        self.starts = np.concatenate([self.starts, np.zeros_like(self.starts)])
        self.entries = np.concatenate([self.entries, np.zeros_like(self.entries)])

    def note(self, step: ImpulseStep) -> None:
        """Take over how much is recorded."""
        self._steps, self._count = step.steps, step.recorded
        self._by_point = None

    def cut(self, t: float, step: ImpulseStep) -> None:
        """Forget steps that begin at a time or behind it, from which a motion goes on."""
        kept = int(np.searchsorted(self.starts[: step.steps, 0], t))
        if kept < step.steps:
            step.recorded = int(self.starts[kept, 1])
            step.steps = kept
        self.note(step)

    def current(self, name: str) -> float:
        """Return an effort at present."""
        return float(self.values_at(name, np.array([np.inf]))[0])

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return an effort at times (N,)."""
        point, row = self._places[name]
        values = np.zeros(np.shape(t))
        if not self._steps:
            return values
        if self._by_point is None:
            self._by_point = self._sort()
        steps, efforts = self._by_point[point]
        if steps.size:
            wanted = np.maximum(np.searchsorted(self.starts[: self._steps, 0], t) - 1, 0)
            found = np.minimum(np.searchsorted(steps, wanted), steps.size - 1)
            values = np.where(steps[found] == wanted, efforts[found, row], 0.0)
        return values

    def _sort(self) -> list[tuple[Places, Floats]]:
        """Return the steps in which each point acts, and its efforts in these."""
        first = np.append(self.starts[: self._steps, 1], self._count).astype(np.intp)
        steps = np.repeat(np.arange(self._steps), np.diff(first))
        entries = self.entries[: self._count]
        order = np.argsort(entries[:, 0], kind="stable")
        ends = np.searchsorted(entries[order, 0], np.arange(self._points + 1))
        pairs = zip(ends[:-1], ends[1:], strict=True)
        return [(steps[order[a:b]], entries[order[a:b], 1:]) for a, b in pairs]


class ImpulsiveContacts:
    """Gaps and friction of one motion that impulses move.

    Parameters
    ----------
    problem : SimulationProblem
        What moves.

    Attributes
    ----------
    problem : SimulationProblem
        With the efforts as inputs, for outputs.
    record : ImpulseRecord
    """

    def __init__(self, problem: SimulationProblem) -> None:
        made = self._made = impulsive_equations(problem.eqs)
        self.record = ImpulseRecord(made.points, made.inputs)
        laws = problem.laws.with_held({name: HeldLaw(self.record, name) for name in made.inputs})
        free = replace(problem, eqs=made.free)
        self.problem = replace(problem, eqs=made.eqs, laws=laws, permanent=free)
        self._step: Floats | None = None

    def free_problem(self, problem: SimulationProblem) -> SimulationProblem:
        """Return a problem with inputs as they are at present, without efforts."""
        own = frozenset(self._made.inputs)
        kept = {name: law for name, law in problem.laws.callbacks.items() if name not in own}
        return replace(
            problem, eqs=self._made.free, laws=replace(problem.laws, callbacks=kept), permanent=None
        )

    @property
    def step(self) -> ImpulseStep:
        """What the kernels read and change."""
        if self._step is None:
            raise LookupError("no motion has begun")
        return ImpulseStep(self._step)

    @property
    def array(self) -> Floats:
        """The array of `step`."""
        return np.zeros(0) if self._step is None else self._step

    def begin(
        self, problem: SimulationProblem, functions: Sequence[CompiledFunction], tolerance: float, sweeps: int
    ) -> None:
        """Make what the kernels read, for functions of gaps, responses and rates of coordinates."""
        numbers = [function_numbers(problem.numbers(function)) for function in functions]
        array = impulse_array(problem, self._made.points, self._made.pattern, numbers, tolerance, sweeps)
        if self._step is not None:  # a motion goes on
            ImpulseStep(array).steps, ImpulseStep(array).recorded = self.step.steps, self.step.recorded
            for name in ("worst", "worst_time", "missed", "missed_time", "deepest", "deepest_time", "swept",
                         "most", "lowered"):  # fmt: skip
                setattr(ImpulseStep(array), name, getattr(self.step, name))
        self._step = array
        self.make_room()

    def make_room(self) -> None:
        """Make room for one more step."""
        step = self.step
        while step.steps + 1 > len(self.record.starts) or step.recorded + step.points > len(
            self.record.entries
        ):
            self.record.grow()
        step.step_room, step.entry_room = len(self.record.starts), len(self.record.entries)

    @property
    def notes(self) -> Iterator[str]:
        """What is to be told of all steps."""
        step = self.step
        if not step.most:
            return
        yield (
            f"impulses by Newton's law of impacts, all of a step at once; at most {step.most:g} points acted "
            f"in one, {step.swept / max(step.steps, 1):.3g} sweeps a step, greatest residual "
            f"{step.worst:.2g} of the fastest rate, at t = {step.worst_time:.6g} s"
        )
        if step.missed:
            yield (
                f"in {step.missed:g} steps, the first at t = {step.missed_time:.6g} s, the impulses miss "
                f"their laws by more than the tolerance, at most by {step.worst:.2g} of the fastest rate: "
                f"take shorter steps, or allow more sweeps"
            )
        if step.lowered:
            yield f"in {step.lowered:g} steps restitution was lowered so that impulses do no work"
        if step.deepest > _OVERLAP:
            yield (
                f"shapes overlap by up to {step.deepest * CLOSED:.2g} of the mechanism's size, at t = "
                f"{step.deepest_time:.6g} s: no displacement keeps all gaps open"
            )


# Overlaps that displacements leave, over what counts as closed, of which nothing is said.
_OVERLAP: Final = 10.0


def _row_count(point: ImpulsePoint) -> int:
    return (point.row is not None) + len(point.laws)


def impulse_array(
    problem: SimulationProblem, points: Sequence[ImpulsePoint], pattern: ResponsePattern,
    numbers: Sequence[Floats], tolerance: float, sweeps: int,
) -> Floats:  # fmt: skip
    """Return the array of an `ImpulseStep` along whose motion no step has been taken."""
    eqs = problem.eqs
    speeds = len(eqs.speed_names)
    sizes = [len(connected) for connected, _ in pattern.blocks]
    rows_of_blocks = [len(rows) for _, rows in pattern.blocks]
    block_lengths = [n * n + m * n for n, m in zip(sizes, rows_of_blocks, strict=True)]
    owners, local = np.zeros(speeds), np.zeros(speeds)
    for k, (connected, _) in enumerate(pattern.blocks):
        owners[list(connected)], local[list(connected)] = k, np.arange(len(connected))
    counts = [_row_count(point) for point in points]
    row_first = _starts(counts)
    slope_sizes = [len(each) for each in pattern.slopes]
    row_values = _starts([1 + size for size in slope_sizes]) + sum(block_lengths)
    laws_at = int(sum(block_lengths)) + sum(slope_sizes) + len(slope_sizes)
    shared = [_answering_speeds(pattern, owners, int(a), n) for a, n in zip(row_first, counts, strict=True)]
    gaps = [point for point in points if point.row is not None]
    widest = max(((n, m) for n, m in zip(sizes, rows_of_blocks, strict=True)), default=(0, 0), key=_room)
    answers = [n * len(each) for n, each in zip(counts, shared, strict=True)]
    angle = [eqs.units.get(f"gap {point.name}") == "rad" for point in gaps]
    return pack(
        ImpulseStep, states=len(eqs.state_names) + 1, speeds=speeds, coordinates=len(eqs.coordinate_names),
        points=len(points), gaps=len(gaps), rows=sum(counts), blocks=len(sizes), slopes=sum(slope_sizes),
        shared=sum(map(len, shared)), answers_size=sum(answers),
        values_size=laws_at + 3 * len(points), responses_size=sum(n * n for n in sizes),
        block_room=_room(widest), tolerance=tolerance, sweeps=sweeps,
        block_sizes=sizes, block_rows=rows_of_blocks,
        block_values=_starts(block_lengths), block_responses=_starts([n * n for n in sizes]),
        owners=owners, local_places=local,
        point_first=row_first, point_rows=counts, point_values=laws_at + 3 * np.arange(len(points)),
        shared_first=_starts(list(map(len, shared))), shared_sizes=list(map(len, shared)),
        shared_places=[k for each in shared for k in each], answer_first=_starts(answers),
        slope_first=_starts(slope_sizes), slope_sizes=slope_sizes,
        slope_places=[k for each in pattern.slopes for k in each], row_values=row_values,
        closed=np.where(angle, CLOSED, CLOSED * problem.scales.length),
        gap_numbers=numbers[0], response_numbers=numbers[1], rate_numbers=numbers[2],
    )  # fmt: skip


def _starts(sizes: Sequence[int]) -> Places:
    """Return where parts of some sizes begin that lie one behind the other."""
    return np.cumsum([0, *sizes])[:-1]


def _room(block: tuple[int, int]) -> int:
    """Return how many numbers of scratch a block of so many speeds and rows takes."""
    n, m = block
    return n * n + 8 * n + 6 * m + 2 + n * (m + n)


def _answering_speeds(pattern: ResponsePattern, owners: Floats, first: int, count: int) -> list[int]:
    """Return the speeds that answer to impulses along some rows, in order."""
    touched = {int(owners[k]) for each in pattern.slopes[first : first + count] for k in each}
    return sorted(k for block in touched for k in pattern.blocks[block][0])


def assemble_open(
    eqs: EquationSet, fixed: Mapping[str, Value], guess: Mapping[str, Value], **given: Any
) -> State:
    """Return a first state as `assemble`, with all gaps open where none is negative then.

    Speeds that would close a gap further are left to the first step.
    """
    if closing_equations(eqs) is not eqs:
        return find_first_state(eqs, fixed, guess, **given)
    made = impulsive_equations(eqs)
    state = find_first_state(made.free, fixed, guess, **given)
    if not any(point.row is not None for point in made.points):
        return state
    scales = mechanism_scales(eqs, given.get("parameters") or {}, given.get("scales"), state.q)
    width = bound_function(made.free, GAPS, given.get("parameters"), (), given.get("inputs"), quick=True)
    q, u = (np.array([*part.values()]) for part in (state.q, state.u))
    least = float(np.min(width(state.t, q, u, np.zeros(len(width.signature.r)))))
    return state if least >= -AT_LENGTH * scales.length else find_first_state(eqs, fixed, guess, **given)


def with_impulses(motion: Motion) -> Motion:
    """Return a motion whose gaps and friction are moved by impulses.

    Raises
    ------
    UsageError
        If it runs backwards, or has friction that reads reactions but is none of a contact that sticks.
    """
    formed, problems = motion.eqs.formed, []
    names = friction_of_reactions(formed)
    if motion.span[1] < motion.span[0]:
        problems.append(
            Problem("simulation.impulses_backwards", "t_end", "the motion runs backwards",
                    "impacts lose energy, and which there were does not follow from the state behind them",
                    "give a t_end after the start")
        )  # fmt: skip
    if names:
        problems.append(
            Problem("simulation.impulse_friction", "integrator",
                    f"sb.MoreauJean() cannot compute the friction of {', '.join(names)}",
                    "it depends on reactions, which impulses change, or is smooth in a rigid contact",
                    "give joints friction as a force, and rigid contacts friction without v0; or leave the "
                    "integrator out")
        )  # fmt: skip
    problems += [_effort_event(event) for event in motion.events if _reads_efforts(motion.eqs, event)]
    if problems:
        raise UsageError(*problems)
    impulses = ImpulsiveContacts(motion.problem)
    return replace(motion, problem=impulses.problem, impulses=impulses)


def _reads_efforts(eqs: EquationSet, event: Event) -> bool:
    """Return whether the value or the actions of an event depend on what impulses are over a step."""
    made = impulsive_equations(eqs)
    graph, own = made.eqs.formed.graph, frozenset(made.inputs)
    words = [str(event.expression), *map(str, event.mapping.values())]
    nodes = [node for word in words for node in made.eqs.roots(word).nodes]
    return any(graph.symbols[graph.left[node]].name in own for node in symbols_of(graph, nodes))


def _effort_event(event: Event) -> Problem:
    return Problem(
        "simulation.impulse_event", f"event {event.label!r}", "it depends on forces of gaps or of friction",
        "sb.MoreauJean() knows these as means over its steps alone, when a step has been taken",
        "watch gaps, positions or speeds; or look for it in the samples of the run",
    )  # fmt: skip


def check_jumps(jumps: PlannedJumps) -> None:
    """Refuse prescribed rates that jump.

    Raises
    ------
    UsageError
        See above.
    """
    if jumps.times:
        raise UsageError(
            Problem("simulation.impulse_jumps", "motion",
                    f"prescribed rates jump at t = {jumps.times[0]:.9g} s",
                    "sb.MoreauJean() has no impulses for these",
                    "prescribe a motion without corners, for instance with smoothstep; or leave the "
                    "integrator out")
        )  # fmt: skip
