"""Complete states of a mechanism from its independent coordinates and speeds, for `Partition`.

At a change point constraints become dependent for an instant, and the dependent coordinates are not
determined; beside it they are known the less the closer it is. On the branch of the motion they, and the
accelerations, are smooth functions of the independent ones. So near a change point they are interpolated
between states on both sides, reached along the branch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.output_roots import OF_STEPS
from symbody.errors import Problem, SimulationError
from symbody.manifold import LinearConstraints, correct, pivot_order, square_step
from symbody.simulation.methods.closed_loops.crossing import find_crossing
from symbody.simulation.methods.closed_loops.loop_constraints import NEAR, LoopConstraints, motion_branch
from symbody.simulation.motion import Motion, StateFunction
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import TRACED

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

# Places to interpolate between, in units of a displacement to either side. What the polynomial through them
# leaves is (2 x 3 x 4 x 5 x 6)^2 / 10! = 0.14 times the displacement to the tenth power and the tenth
# derivative: of a function that is analytic as far as 1 rad, some 5e-11 with the first displacement.
_ASIDE: Final = np.arange(2.0, 7.0)
_WEIGHTS: Final = np.array(
    [0.5 * np.prod([y**2 / (y**2 - x**2) for y in _ASIDE if y != x]) for x in _ASIDE]
)  # fmt: skip
# Displacements that are tried, in radians or sizes; the shortest whose places are all far enough is taken.
_DISPLACEMENTS: Final = (0.025, 0.05)
# Rows stay where others would be farther from dependent by less than this.
_ROWS_STAY: Final = 0.3
# What share of `NEAR` is far enough.
_FAR_ENOUGH: Final = 1.0
# What was found about a crossing holds this far about where it was asked, in radians or sizes: far more than
# `NEAR`, where it is asked, and far less than from one crossing to another.
_SAME_CROSSING: Final = 0.1
# How far the velocities of a start may be from those of one branch, relative to the fastest.
_SAME: Final = 1e-6
# A mechanism moves in a direction if its rates are larger than this share of the fastest so far.
_MOVES: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class PartitionChoice:
    """Which columns of a matrix follow from the others, by which rows.

    Attributes
    ----------
    row_share : float
        The least singular value of the rows over that of all rows: 1 at best.
    """

    rows: Places
    dependent: Places
    independent: Places
    row_share: float


def partition_columns(matrix: Floats, rank: int, rows: Places | None = None) -> PartitionChoice:
    """Return the columns along which the null space extends farthest, and rows that span the others."""
    _, sizes, right = np.linalg.svd(matrix)
    free = right[rank:]
    if rows is None:
        rows = np.sort(pivot_order(matrix.T)[0][:rank])
    independent = np.sort(pivot_order(free)[0][: len(free)])
    dependent = np.setdiff1d(np.arange(matrix.shape[1]), independent)
    least = np.linalg.svd(matrix[rows], compute_uv=False).min() / sizes[rank - 1] if rows.size else 1.0
    return PartitionChoice(rows, dependent, independent, float(least))


Choices = tuple[PartitionChoice, PartitionChoice]


class PartitionStates:
    """Complete states x = (u, q, s, work) and their rates from independent parts, on the branch of a start.

    States s of signals, and the work behind them, take part in no constraint: they are independent.

    Attributes
    ----------
    branch : MotionBranch
    positions, speeds : PartitionChoice
        What follows from what.
    """

    def __init__(self, motion: Motion) -> None:
        self.loops = LoopConstraints(motion.problem)
        self._integration, self._eqs, self._n_u = motion, motion.eqs, motion.n_u
        self._places = self.loops.places
        self._functions: dict[tuple[int, ...], StateFunction] = {}
        t, x = motion.span[0], motion.state
        self.branch = motion_branch(self.loops, t, x)
        self._reference, self._regular = self.branch.reference, (self.branch.t, self.branch.q)
        self._aside_choice: Choices | None = None
        self._fastest = float(np.abs(self.loops.rates(t, x)).max(initial=0.0))
        self._crossing: tuple[Floats, bool] | None = None
        self.positions, self.speeds = self._choose_columns(self.branch.t, self.branch.q)

    def choose(self, t: float, q: Floats) -> bool:
        """Choose what is independent at a configuration; return whether that is another choice."""
        before = self.positions, self.speeds
        self.positions, self.speeds = self._choose_columns(t, q)
        now = self.positions, self.speeds
        return not all(
            np.array_equal(a.rows, b.rows) and np.array_equal(a.dependent, b.dependent)
            for a, b in zip(before, now, strict=True)
        )

    def _choose_columns(self, t: float, q: Floats) -> Choices:
        """Return a new choice; rows that do stay, as accelerations have to be compiled for others."""
        matrices = self.loops.positions(t, q)[1], self.loops.speeds(t, q)[0]
        positions = partition_columns(matrices[0], self.branch.positions)
        speeds = partition_columns(matrices[1], self.branch.speeds)
        for rows in map(np.array, self._functions):
            kept = partition_columns(matrices[1], self.branch.speeds, rows)
            if kept.row_share >= _ROWS_STAY * speeds.row_share:
                return positions, kept
        return positions, speeds

    def is_near_change_point(self, t: float, q: Floats) -> bool:
        """Return whether a configuration is near one where branches of the mechanism meet."""
        if not self.share(t, q) < NEAR:
            return False
        known = self._crossing
        if known is None or np.abs((q - known[0]) / self.loops.sizes).max() > _SAME_CROSSING:
            crossing = find_crossing(self.loops, self.branch, t, q, 1.0 / (self._fastest or 1.0))
            known = self._crossing = q.copy(), crossing is not None and crossing.meets
        return known[1]

    def accept(self, t: float, x: Floats) -> None:
        """Learn from a state of the motion what is fast, what is regular, and where the branch leads."""
        self._fastest = max(self._fastest, float(np.abs(self.loops.rates(t, x)).max(initial=0.0)))
        share = self.share(t, x[self._places])
        self._reference *= max(share, 1.0) if np.isfinite(share) else 1.0
        if share >= NEAR:
            self._regular, self._aside_choice = (t, x[self._places].copy()), None

    def state(self, t: float, y: Floats) -> Floats:
        """Return x from the independent speeds and coordinates in y, near the others in it.

        Raises
        ------
        SimulationError
            If Newton's method finds no configuration.
        """
        between = self._interpolate(t, y)
        return self._solve(t, y, (self.positions, self.speeds)) if between is None else between[0]

    def rates(self, t: float, y: Floats) -> Floats:
        """Return x' at the state that belongs to y.

        Raises
        ------
        SimulationError
            As `state`.
        """
        between = self._interpolate(t, y, are_rates=True)
        if between is not None:
            return between[1]
        return self._state_rates(t, self._solve(t, y, (self.positions, self.speeds)), self.speeds)

    def is_on_branch(self, t: float, x: Floats) -> bool:
        """Return whether a state near a change point moves along one branch that can be recognized."""
        if not self.is_near_change_point(t, x[self._places]):
            return True
        speed = float(np.abs(self.loops.rates(t, x)).max(initial=0.0))
        between = self._interpolate(t, x) if speed > 0.0 else None
        if between is None:
            return False
        moved = between[0] - x
        u, q = moved[: self._n_u], moved[self._places]
        apart = np.abs(u / self.loops.speed_sizes).max(initial=0.0) / speed
        return bool(max(apart, np.abs(q / self.loops.sizes).max(initial=0.0)) < _SAME)

    def share(self, t: float, q: Floats) -> float:
        """Return the least singular value that counts, as a share of that at regular configurations."""
        if not self.branch.speeds:
            return np.inf
        sizes = self.loops.singular_values(t, q)
        return float(sizes[self.branch.speeds - 1] / self._reference)

    def _solve(self, t: float, y: Floats, choices: Choices) -> Floats:
        """Return the state by Newton's method."""
        (positions, speeds), sizes, u = choices, self.loops.speed_sizes, y[: self._n_u].copy()
        try:
            q = self._close_loops(t, y[self._places].copy(), positions)
            rows, drift = self.loops.speeds(t, q)
            rows, drift = rows[speeds.rows], drift[speeds.rows]
            change = np.linalg.solve(rows[:, speeds.dependent], drift + rows @ (u / sizes))
            u[speeds.dependent] -= change * sizes[speeds.dependent]
        except np.linalg.LinAlgError as error:
            raise SimulationError(_no_configuration(t)) from error
        return np.concatenate([u, q, y[self._places.stop :]])

    def _close_loops(self, t: float, q: Floats, choice: PartitionChoice) -> Floats:
        """Return coordinates of which the dependent ones fulfil the rows of a choice."""
        manifold, dependent = self.loops.manifold(t), choice.dependent
        block = np.ix_(choice.rows, dependent)

        def evaluate(q: Floats) -> LinearConstraints:
            _, values, slopes = manifold.constraints(q)
            return LinearConstraints(q, values[choice.rows], slopes[block])

        def move(point: LinearConstraints, step: Floats) -> LinearConstraints:
            moved = point.q.copy()
            moved[dependent] += step * self.loops.sizes[dependent]
            return evaluate(moved)

        end = correct(evaluate(q), move, TRACED, square_step)
        if end is None:  # it may have been on its way to another assembly
            raise SimulationError(_no_configuration(t))
        return end.q

    def function(self, speeds: PartitionChoice) -> CompiledFunction:
        """Return what computes rates and power from the constraints that are independent."""
        return self._function(speeds).function

    def _function(self, speeds: PartitionChoice) -> StateFunction:
        key = tuple(speeds.rows.tolist())
        if key not in self._functions:
            eqs, formed = self._eqs, self._eqs.formed
            if len(key) < len(formed.rows):
                eqs = EquationSet(eqs.model, formed.with_independent(key), eqs.notes)
            self._functions[key] = self._integration.compile_outputs(OF_STEPS, eqs)
        return self._functions[key]

    def _state_rates(self, t: float, x: Floats, speeds: PartitionChoice) -> Floats:
        """Return the rates of a complete state with the work."""
        return np.append(*self._function(speeds)(t, x[:-1]))

    def _interpolate(self, t: float, y: Floats, *, are_rates: bool = False) -> tuple[Floats, Floats] | None:
        """Return state and rates near a change point, interpolated; None elsewhere, or if that fails."""
        if not self.is_near_change_point(t, y[self._places]):
            return None
        if self._aside_choice is None:
            self._aside_choice = self._choose_columns(*self._regular)
        for way, time in self._ways(t, y):
            for displacement in _DISPLACEMENTS:
                try:
                    places = list(
                        self._aside(t, y, displacement * way, displacement * time, self._aside_choice)
                    )
                except SimulationError:
                    break
                if len(places) == 2 * _ASIDE.size:
                    weights = np.tile(_WEIGHTS, 2)
                    x = weights @ np.array([x for _, x in places])
                    if not are_rates:
                        return x, x
                    rates = [self._state_rates(*place, self._aside_choice[1]) for place in places]
                    return x, weights @ np.array(rates)
        return None

    def _ways(self, t: float, y: Floats) -> Iterator[tuple[Floats, float]]:
        """Yield directions along the branch, in sizes, and the time that passes: that of the motion first."""
        rate = self.loops.rates(t, y)
        speed = float(np.abs(rate).max(initial=0.0))
        if _MOVES * self._fastest < speed < np.inf:
            yield rate / speed, 1.0 / speed if self.loops.is_driven else 0.0
        slopes = self.loops.positions(*self._regular)[1]
        for tangent in np.linalg.svd(slopes)[2][self.branch.positions :]:
            yield tangent / float(np.abs(tangent).max()), 0.0

    def _aside(
        self, t: float, y: Floats, way: Floats, time: float, choices: Choices
    ) -> Iterator[tuple[float, Floats]]:
        """Yield times and states along the branch on both sides, as long as they are far enough."""
        part, sizes, own = self._places, self.loops.sizes, choices[0].independent
        for side in (1.0, -1.0):
            before, last, slope = 0.0, y[part], way
            for place in side * _ASIDE:
                guess = y.copy()
                guess[part] = last + (place - before) * slope * sizes
                guess[part.start + own] = y[part.start + own] + place * way[own] * sizes[own]
                x = self._solve(t + place * time, guess, choices)
                if self.share(t + place * time, x[part]) < _FAR_ENOUGH * NEAR:
                    return
                yield t + place * time, x
                slope = (x[part] - last) / sizes / (place - before)
                before, last = place, x[part]


def _no_configuration(t: float) -> Problem:
    return Problem(
        "simulation.partition", "constraints", f"no configuration was found at t = {t:.9g} s",
        "the independent coordinates do not determine the others here", "use sb.Projection()",
    )  # fmt: skip


def independent_rows(problem: SimulationProblem, t: float, x: Floats) -> list[int]:
    """Return the places of as many constraints as are independent on the branch of a state.

    They are the farthest from dependent at a regular configuration of the branch.
    """
    loops = LoopConstraints(problem)
    branch = motion_branch(loops, t, x)
    count = len(problem.eqs.formed.rows)
    if branch.speeds == count:
        return list(range(count))
    kept: list[int] = partition_columns(loops.speeds(branch.t, branch.q)[0], branch.speeds).rows.tolist()
    return kept


def without_other_rows(eqs: EquationSet, kept: Sequence[int]) -> EquationSet:
    """Return the equations with these constraints alone."""
    return EquationSet(eqs.model, eqs.formed.with_independent(kept), eqs.notes)
