"""When prescribed rates jump in an FMU, and which parameters decide that."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.errors import UsageError
from symbody.expr import opcodes as op
from symbody.expr.graph import SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.fmu.parameters import Floats, FmuParameters
from symbody.simulation.hybrid.rate_jumps import corners_in_time, jump_times, neglect_note
from symbody.simulation.hybrid.switching import check_strike
from symbody.simulation.programs.motion_request import PosedMotion
from symbody.simulation.simulation_problem import SimulationProblem

_MOVED: Final = 0.37  # a value by a share of it, and as much of 1, is another; the next one by more
# Up to so long after the start jumps are looked for, one span after the other [s]: how fast prescribed
# motions are is known of spans in which they move. An FMU holds so many jumps; it ends where the next one is.
_ENDS: Final = (6.0, 60.0, 600.0, 3600.0)
_MOST_JUMPS: Final = 2000


Times = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class FmuJumps:
    """Jumps of prescribed rates.

    Attributes
    ----------
    times : tuple of (float, float)
        When they happen, and how far beside it sides are clear [s].
    are_more : bool
        Whether rates jump more often: the last time is then that of a jump at which the motion ends.
    decisive : tuple of str
        Parameters that decide when and whether rates jump: no arguments.
    notes : tuple of str
        What to say of them.
    """

    times: Times = ()
    are_more: bool = False
    decisive: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def find_jumps(motion: PosedMotion, parameters: FmuParameters) -> FmuJumps:
    """Return the jumps of prescribed rates.

    Raises UsageError if a prescribed position jumps, or dry friction depends on reactions, which are infinite
    then.
    """
    eqs, problem, start = motion.eqs, motion.integration.problem, motion.span[0]
    corners = corners_in_time(eqs)
    if not corners:
        return FmuJumps()
    times, are_more = _find_times(problem, motion.integration.state, start)
    if times:
        check_strike(eqs.formed, times[0][0])
    graph = eqs.formed.graph
    decisive = _parameters_of(eqs, [node for node in corners if graph.ops[node] != op.SELECT])
    others = _parameters_of(eqs, corners) - decisive
    if others and not _are_times(motion, parameters, others, times):
        decisive |= others
    names = tuple(name for name in parameters.arguments if name in decisive)
    notes = [
        f"{name}: prescribed rates jump at other times with another value, so it is a number in the FMU; "
        f"write an FMU for each value, with parameters="
        for name in names
    ]
    return FmuJumps(times, are_more, names, (*notes, *(neglect_note(eqs.formed) if times else ())))


def _find_times(problem: SimulationProblem, x: Floats, start: float) -> tuple[Times, bool]:
    """Return the jumps of `FmuJumps`, and whether they end where knowledge does."""
    found: list[tuple[float, float]] = []
    for first, last in pairwise((0.0, *_ENDS, 2.0 * _ENDS[-1])):
        times, margin = jump_times(problem, x, (start + first, start + last))
        most = _MOST_JUMPS if last <= _ENDS[-1] else len(found)
        # a jump where two spans meet may be found in both
        found += [(t, margin) for t in times if not found or t > found[-1][0] + found[-1][1] + margin]
        if len(found) > most:
            return tuple(found[: most + 1]), True
    return tuple(found), False


def _parameters_of(eqs: EquationSet, nodes: Iterable[int]) -> set[str]:
    """Return the parameters that formulas depend on, without those that are formulas of others."""
    graph, formulas = eqs.formed.graph, eqs.model.parameters
    symbols = [graph.symbols[graph.left[place]] for place in symbols_of(graph, list(nodes))]
    waiting = [symbol.label for symbol in symbols if symbol.kind == SymbolKind.PARAMETER]
    found: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            formula = formulas.get(name)
            waiting += [] if formula is None else list(set(formula.names) - {"pi"})
    return found


def _are_times(motion: PosedMotion, parameters: FmuParameters, moved: Iterable[str], times: Times) -> bool:
    """Return whether rates jump at these times with other values of parameters, too."""
    problem, values = motion.integration.problem, dict(motion.integration.problem.parameters)
    for k, (name, value) in enumerate(zip(parameters.arguments, parameters.values.tolist(), strict=True)):
        if name in moved:
            values[name] = value + _MOVED * (1.0 + k) * (value + 1.0)
    other = SimulationProblem(problem.eqs, values, problem.laws, problem.scales)
    try:
        found, _ = _find_times(other, motion.integration.state, motion.span[0])
    except UsageError:  # only these values keep positions from jumping
        return False
    return found == times
