"""Minimal coordinates by partition: `Partition` integrates independent ones, the others follow from Phi.

Wehage and Haug, Generalized coordinate partitioning for dimension reduction in analysis of constrained
dynamic systems, J. Mech. Design 104 (1982). The independent ones are integrated by SciPy's DOP853. It carries
the others along: to choose the step by them too, which alone do it where all motion is prescribed, and to
start Newton's method from them, so that it stays on the branch of the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.linalg import qr

from symbody.analysis.closure import constraint_scales
from symbody.analysis.redundancy import redundancy
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, UsageError
from symbody.simulation.methods.constraints import Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.request import Called, Request
from symbody.simulation.methods.state_jacobian import without_idle_rows
from symbody.simulation.methods.stepping import NODES, SHARES, Failure, Step, march
from symbody.simulation.methods.sundials import Watch
from symbody.simulation.native.loop import EPSILON
from symbody.simulation.native.run import RawRun
from symbody.simulation.status import Status

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

NOTE: Final = "independent coordinates are integrated by SciPy's DOP853 in Python: slower than Projection"
_OPEN: Final = (
    "the start is a change point, where constraints become dependent: sb.Partition() cannot tell which "
    "follow from others; use sb.Projection(), or start a little beside it"
)
# Rows whose part independent of the others is smaller than this share are redundant.
_INDEPENDENT: Final = 1e-8
_ROUNDS: Final = 12
# Newton's method has arrived when a step is this small, in the units of the coordinates' sizes.
_ARRIVED: Final = 1e-13
_STALLED: Final = 1e-9
_CONTRACTION: Final = 0.5
# A step of so few roundings of the time: near a lock-up what is solved for is rounding, too.
_SHORTEST: Final = 1000.0
# A step whose inside is out of reach is tried again, shorter, so often.
_TRIALS: Final = 30


@dataclass(frozen=True, slots=True)
class Partition:
    """Only independent coordinates and speeds are integrated; constraints hold to rounding at every stage.

    Attributes
    ----------
    worst : float
        Other coordinates are chosen when the pivots of the dependent ones have shrunk to this share of the
        best choice, between 0 and 1.
    """

    worst: float = 0.1

    def __post_init__(self) -> None:
        if not 0.0 < self.worst < 1.0:
            what = f"worst = {self.worst!r} is not between 0 and 1"
            raise UsageError(Problem("simulation.constraints", "worst", what, "", "leave it out"))


def run_partition(request: Request, method: Partition, explicit: Explicit) -> tuple[RawRun, tuple[str, ...]]:
    """Integrate a set of independent coordinates and speeds; return run and notes."""
    stepper = _PartitionStepper(request, method, explicit)
    raw = march(stepper, request.course(request.projection(Projection())))
    changes = stepper.changes
    more = (f"other independent coordinates were chosen {changes} times",) if changes else ()
    return raw, (NOTE, *more, *((_OPEN,) if stepper.is_open else ()))


@dataclass(frozen=True, slots=True, eq=False)
class _Choice:
    """Which columns of a matrix follow from the others, by which rows, and how well."""

    rows: Places
    dependent: Places
    independent: Places
    pivot: float


def _choice(matrix: Floats, least: int = 0) -> _Choice:
    """Return the dependent columns by pivoting, after the independent rows; `least` of these count anyway.

    At a lock-up, as at a change point, rows become dependent that are not so elsewhere on the motion. Without
    them it would go on, but as that of another mechanism.
    """
    columns = np.arange(matrix.shape[1])
    triangle, order = qr(matrix.T, mode="r", pivoting=True)
    sizes = np.abs(np.diagonal(triangle))
    rank = max(least, int((sizes > _INDEPENDENT * sizes.max(initial=0.0)).sum()))
    rows = np.sort(order[:rank])
    order = qr(matrix[rows], mode="r", pivoting=True)[1]
    dependent = np.sort(order[:rank])
    return _Choice(rows, dependent, np.setdiff1d(columns, dependent), _pivot(matrix, rows, dependent))


def _pivot(matrix: Floats, rows: Places, dependent: Places) -> float:
    """Return the smallest singular value of a dependent block."""
    block = matrix[np.ix_(rows, dependent)]
    return float(np.linalg.svd(block, compute_uv=False).min(initial=np.inf))


class _Mechanism:
    """Complete states from independent parts, for one choice of positions and one of speeds."""

    def __init__(self, request: Request) -> None:
        eqs = without_idle_rows(request.eqs, request.task.parameters)
        names = ("constraints", "position_jacobian", "jacobian", "velocity_constraints")
        self._closing = request.compiled(names, eqs)
        self._request, self._eqs = request, eqs
        self._rates: dict[tuple[int, ...], Called] = {}
        self._scales = constraint_scales(eqs, request.task.parameters)
        self._quaternions = request.quaternions()
        self.n_u, self.n_q = request.n_u, request.n_q

    def residual(self, t: float, q: Floats) -> tuple[Floats, Floats]:
        """Return all conditions on positions, scaled, and their derivatives."""
        found = self._closing(t, np.concatenate([np.zeros(self.n_u), q]))
        scales = self._scales[: found[0].size]
        values = [found[0] / scales]
        slopes = [found[1] / scales[:, np.newaxis]]
        for four in self._quaternions:
            values.append(np.array([(q[four] @ q[four] - 1.0) / 2.0]))
            row = np.zeros((1, self.n_q))
            row[0, four] = q[four]
            slopes.append(row)
        return np.concatenate(values), np.vstack(slopes)

    def choose(self, t: float, q: Floats, least: tuple[int, int] = (0, 0)) -> tuple[_Choice, _Choice]:
        """Return the best choice of positions and of speeds, with so many rows of each at least."""
        return _choice(self.residual(t, q)[1], least[0]), _choice(self.jacobian(t, q)[0], least[1])

    def lacks_rows(self, q: Floats, speeds: _Choice) -> bool:
        """Return whether a start is a change point: rows follow from others there, and nowhere else."""
        if speeds.rows.size == len(self._eqs.formed.rows):
            return False
        here = dict(zip(self._eqs.coordinate_names, q.tolist(), strict=True))
        kept = redundancy(self._eqs, self._request.task.parameters, here).kept
        return speeds.rows.size < len(kept)

    def jacobian(self, t: float, q: Floats) -> tuple[Floats, Floats]:
        """Return J and b of the conditions on speeds ``J u + b = 0``, scaled."""
        found = self._closing(t, np.concatenate([np.zeros(self.n_u), q]))
        return found[2] / self._scales[:, np.newaxis], found[3] / self._scales

    def state(self, t: float, y: Floats, positions: _Choice, speeds: _Choice) -> Floats:
        """Return x = (u, q) from the independent speeds and coordinates in y, near the others in it.

        Raises
        ------
        SimulationError
            If Newton's method finds no configuration.
        """
        u = y[: self.n_u].copy()
        try:
            q = self._closed(t, y[self.n_u :].copy(), positions)
            rows, rest = self.jacobian(t, q)
            rows, rest = rows[speeds.rows], rest[speeds.rows]
            u[speeds.dependent] -= np.linalg.solve(rows[:, speeds.dependent], rest + rows @ u)
        except np.linalg.LinAlgError as error:
            raise SimulationError(_lost(t)) from error
        return np.concatenate([u, q])

    def _closed(self, t: float, q: Floats, positions: _Choice) -> Floats:
        size = np.inf
        for _ in range(_ROUNDS):
            values, slopes = self.residual(t, q)
            block = slopes[np.ix_(positions.rows, positions.dependent)]
            step = np.linalg.solve(block, -values[positions.rows])
            q[positions.dependent] += step
            size, before = float(np.abs(step).max(initial=0.0)), size
            if size < _ARRIVED or before <= size < _STALLED:
                return q
            if not size <= _CONTRACTION * before and not size < _STALLED:
                break  # it may be on its way to another assembly
        raise SimulationError(_lost(t))

    def rates(self, t: float, x: Floats, speeds: _Choice) -> Floats:
        """Return x' of a complete state.

        Rows that follow from others once all loops are closed, as in Bennett's linkage, are left out: they
        are independent in a state that is closed to rounding only, and then nothing could move.
        """
        key = tuple(speeds.rows.tolist())
        if key not in self._rates:
            formed = self._eqs.formed
            if len(key) == len(formed.rows):
                self._rates[key] = self._request.compiled("xdot")
            else:
                chosen = formed.with_rows(tuple(formed.rows[k] for k in key))
                eqs = EquationSet(self._eqs.model, chosen, self._eqs.notes)
                self._rates[key] = self._request.compiled("xdot", eqs)
        found: Floats = self._rates[key](t, x)
        return found


def _lost(t: float) -> Problem:
    return Problem(
        "simulation.partition", "constraints", f"no configuration was found at t = {t:.9g} s",
        "the independent coordinates do not determine the others here", "use sb.Projection()",
    )  # fmt: skip


class _PartitionStepper:
    """DOP853 over the independent coordinates, begun anew when they are chosen anew."""

    def __init__(self, request: Request, method: Partition, explicit: Explicit) -> None:
        self._request, self._worst, self._explicit = request, method.worst, explicit
        self._mechanism = _Mechanism(request)
        self._x, (self._t, self._end) = request.state, request.span
        self._ends = request.step_ends()
        self._watch = Watch(self._derivative)
        self.changes, self.rejected = 0, 0
        self._positions, self._speeds = self._mechanism.choose(self._t, self._x[request.n_u :])
        self.is_open = self._mechanism.lacks_rows(self._x[request.n_u :], self._speeds)
        self._begin(None if explicit.first_step is None else float(explicit.first_step))

    @property
    def evaluations(self) -> int:
        """How often the accelerations were computed."""
        return self._watch.evaluations

    def advance(self) -> Step | Failure:
        """Take one step; the dependent coordinates inside it are solved for."""
        if self.is_open:
            return Failure(Status.SINGULAR)
        begin, stop, end = self._ends(self._t)
        if begin != self._t:  # what depends on time has jumped
            self._begin(None)
        for _ in range(_TRIALS):
            solver, before = self._solver, self._watch.evaluations
            if not np.isfinite(solver.f).all():
                return self._watch.failure(0)
            solver.max_step = min(self._longest, max(abs(stop - solver.t), _SHORTEST * EPSILON * abs(stop)))
            solver.step()
            self.rejected += (self._watch.evaluations - before) // solver.n_stages
            if solver.status == "failed":
                return self._watch.failure(0)
            nodes = self._nodes(solver)
            if nodes is not None:
                self.rejected -= 1
                length = abs(solver.t - self._t)
                self._accept(solver, nodes[-1])
                if length <= _SHORTEST * EPSILON * abs(self._t) and self._t != self._end:
                    return Failure(Status.STEP_COLLAPSE)
                if abs(self._t - stop) < abs(end - stop):  # before a jump
                    self._t = end
                return Step(self._t, nodes)
            self._begin(0.25 * abs(solver.t - self._t))
        return Failure(Status.STEP_COLLAPSE)

    def restart(self, t: float, x: Floats) -> None:
        """Go on from another state."""
        self._t, self._x = t, x
        self._choose(None)

    def _accept(self, solver: DOP853, x: Floats) -> None:
        """Go on from the end of a step; what was carried along is brought onto the constraints."""
        self._x, self._t = x, float(solver.t)
        solver.y = x.copy()
        self._watch.accept()
        if self._t != self._end and self._is_worn():
            self._choose(abs(solver.h_abs))

    def _nodes(self, solver: DOP853) -> Floats | None:
        """Return the states inside the step; None if they are out of reach."""
        inside = solver.dense_output()
        nodes = np.empty((NODES, self._x.size))
        nodes[0] = self._x
        for k in range(1, NODES):
            t = self._t + SHARES[k] * (solver.t - self._t) if k < NODES - 1 else float(solver.t)
            try:
                nodes[k] = self._mechanism.state(t, inside(t), self._positions, self._speeds)
            except SimulationError:
                return None
        return nodes

    def _is_worn(self) -> bool:
        q = self._x[self._mechanism.n_u :]
        matrices = self._mechanism.residual(self._t, q)[1], self._mechanism.jacobian(self._t, q)[0]
        for matrix, choice in zip(matrices, (self._positions, self._speeds), strict=True):
            pivot = _pivot(matrix, choice.rows, choice.dependent)
            if pivot < self._worst * choice.pivot:
                best = _choice(matrix, choice.rows.size)
                if pivot < self._worst * best.pivot:
                    return True
        return False

    def _choose(self, first_step: float | None) -> None:
        """Choose the independent coordinates of the present state and begin with them."""
        least = self._positions.rows.size, self._speeds.rows.size
        found = self._mechanism.choose(self._t, self._x[self._mechanism.n_u :], least)
        self._positions, self._speeds = found
        self.changes += 1
        self._begin(first_step)

    def _begin(self, first_step: float | None) -> None:
        """Start DOP853 from the present state."""
        longest = self._longest
        begin, _, _ = self._ends(self._t)
        rest = abs(self._end - self._t)
        self._solver = DOP853(
            self._watch, begin, self._x.copy(), self._end, max_step=longest, rtol=self._request.rtol,
            atol=self._request.atol, first_step=None if first_step is None else min(first_step, rest),
        )  # fmt: skip

    @property
    def _longest(self) -> float:
        return np.inf if self._explicit.max_step is None else float(self._explicit.max_step)

    def _derivative(self, t: float, y: Floats) -> Floats:
        x = self._mechanism.state(t, y, self._positions, self._speeds)
        return self._mechanism.rates(t, x, self._speeds)
