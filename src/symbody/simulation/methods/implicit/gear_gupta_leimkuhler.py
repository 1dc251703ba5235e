"""Closed loops as differential-algebraic equations of index 2, integrated by IDA: `GGL`.

Positions are held by multipliers of their own: ``q' = N (u + D^2 J^T mu) + nu``, ``M u' = F + J^T lambda``,
``Phi = 0``, ``J u + b = 0``; mu is 0 in every exact motion, and D has the sizes of displacements along the
speeds, so that metres and radians are pushed alike in all units. Gear, Leimkuhler and Gupta, Automatic
integration of Euler-Lagrange equations with constraints, J. Comput. Appl. Math. 12-13 (1985).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.derivatives import partial_derivatives, with_laws, with_outputs
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.drift_correction import velocity_residual
from symbody.equations.solving.solution import substitute_solution
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.rewrite import substitute
from symbody.expr.sequences.sequence import Roots
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.methods.closed_loops.partition_states import independent_rows, without_other_rows
from symbody.simulation.methods.implicit.state_jacobian import drop_idle_rows, input_symbols
from symbody.simulation.methods.implicit.stiff import SHARE_OF_PIECE, Stiff
from symbody.simulation.methods.implicit.sundials import (
    MonitoredFunction,
    SundialsStepper,
    print_as_usual,
    solver_class,
)
from symbody.simulation.methods.stepping import march
from symbody.simulation.motion import Motion, StateFunction
from symbody.simulation.native.run import RawRun

Floats = NDArray[np.float64]

# Multipliers take no part in the error test: their errors are one and two orders larger in the step. Of what
# counts as large for each.
FREE: Final = 1e10
# How fast a quaternion returns to unit norm, in the time of the mechanism.
_NORMING: Final = 3.0
_RESIDUAL, _SLOPES, _MASS = "ggl residual", "ggl slopes", "mass_matrix"
_BY_CALLBACKS: Final = "ggl slopes by callbacks"


@dataclass(frozen=True, slots=True)
class GGL:
    """Constraints on positions and on velocities both hold at each step, with a multiplier each.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> run = sb.simulate(sb.form_equations(ladder), 1.0, {"x_dot": 1}, constraints=sb.GGL())
    >>> run.success, bool(run.constraint_violation.max() < 1e-6)
    (True, True)
    """


def run_ggl(motion: Motion, method: Stiff, events: EventWatch | None) -> tuple[RawRun, tuple[str, ...]]:
    """Integrate the equations of index 2 by IDA, with their Jacobian from the graph; return run and notes.

    Raises
    ------
    SimulationError, EnvironmentFault
        If the solver does not start, or is not installed.
    """
    eqs = drop_idle_rows(_with_rows(motion.eqs, motion.rows), motion.problem.parameters)
    eqs, notes = _independent(motion, eqs)
    system = _GGLSystem(motion, _with_residual(eqs, motion))
    n, size = motion.state.size, motion.state.size + system.m + system.m_positions
    watch = MonitoredFunction(system.residual)

    @print_as_usual
    def residual(t: float, y: Floats, rate: Floats, out: Floats) -> None:
        out[:] = watch(t, np.concatenate([y, rate]))

    @print_as_usual
    def slopes(t: float, y: Floats, rate: Floats, value: Floats, share: float, out: Floats) -> None:
        out[:] = system.slopes(t, y, rate, share)

    scales = motion.problem.scales
    sizes = scales.constraints(eqs)
    pushes = 1.0 / (sizes[: system.m_positions] * scales.time)
    tolerances = np.concatenate([motion.tolerances, FREE * scales.energy / sizes, FREE * pushes])
    solver = solver_class("IDA")(
        residual, jacfn=slopes, rtol=motion.rtol, atol=tolerances,
        algebraic_idx=list(range(n, size)), **method.options(),
    )  # fmt: skip

    def begin(t: float, x: Floats) -> None:
        solver.init_step(t, *system.consistent(t, x))

    stepper = SundialsStepper(
        solver, begin, lambda t, x: (x, False), watch, motion.state, motion.span,
        motion.step_ends(SHARE_OF_PIECE),
    )  # fmt: skip
    return march(stepper, motion.course(None, events), events), notes


def _with_rows(eqs: EquationSet, names: Collection[str]) -> EquationSet:
    """Return equations with those constraints alone that hold."""
    if len(names) == len(eqs.formed.rows):
        return eqs
    kept = tuple(row for row in eqs.formed.rows if row.name in names)
    zero = number(eqs.formed.graph, 0)
    known = eqs.formed.names.with_values({row.name: zero for row in eqs.formed.rows if row.name not in names})
    made: EquationSet = eqs.plans.get(
        ("rows", tuple(names)),
        lambda: EquationSet(eqs.model, replace(eqs.formed.with_rows(kept), names=known), eqs.notes),
    )
    return made


def _independent(motion: Motion, eqs: EquationSet) -> tuple[EquationSet, tuple[str, ...]]:
    """Return the equations without constraints that follow from the others on the branch of the motion."""
    kept = independent_rows(replace(motion.problem, eqs=eqs), motion.span[0], motion.state)
    dropped = [name for k, name in enumerate(eqs.multiplier_names) if k not in kept]
    if not dropped:
        return eqs, ()
    return without_other_rows(eqs, kept), (
        f"GGL: {', '.join(dropped)} follow from the other constraints and are ignored",
    )


def _with_residual(eqs: EquationSet, motion: Motion) -> EquationSet:
    """Return the equations with the residual and its derivatives; udot, lambda and mu become inputs."""
    formed, graph = eqs.formed, eqs.formed.graph
    m, m_positions = len(formed.rows), len(formed.holonomic)
    udot = {f"ggl udot {k}": Symbol(f"ggl udot {k}", SymbolKind.INPUT) for k in range(len(formed.u))}
    first = {f"ggl lambda {k}": Symbol(f"ggl lambda {k}", SymbolKind.INPUT) for k in range(m)}
    second = {f"ggl mu {k}": Symbol(f"ggl mu {k}", SymbolKind.INPUT) for k in range(m_positions)}
    accelerations, pulls, pushes = (formed.expressions(tuple(g.values())) for g in (udot, first, second))
    rows = formed.jacobian
    values = []
    for i, force in enumerate(substitute_solution(formed, formed.dynamics.forcing)):
        total = -force
        for j, acceleration in enumerate(accelerations):
            total = total + formed.dynamics.mass_matrix[i][j] * acceleration
        for k, pull in enumerate(pulls):
            total = total - rows[k][i] * pull
        values.append(total)
    moved = {}
    squares = motion.problem.scales.displacements(eqs) ** 2
    for i, u in enumerate(formed.kinematics.speeds):
        speed = Expr(graph, u)
        for k, push in enumerate(pushes):
            speed = speed + rows[k][i] * push * float(squares[i])
        moved[u] = speed.index
    rates = substitute(graph, eqs.roots("qdot").nodes, moved)
    values += [
        -(Expr(graph, node) + pull)
        for node, pull in zip(rates, _norm_pulls(eqs, _NORMING / motion.problem.scales.time), strict=True)
    ]
    values += [-Expr(graph, node) for node in eqs.roots("signal_rates").nodes]
    values += [*(row.value for row in formed.holonomic), *velocity_residual(formed)]
    nodes = with_laws(eqs, [value.index for value in values], motion.problem.laws.formulas)
    by = (*formed.u, *formed.q, *formed.signal_states, *first.values(), *second.values())
    callbacks = input_symbols(eqs, motion.problem.laws.callbacks)
    outputs = [
        Roots(_RESIDUAL, (len(nodes),), tuple(nodes)),
        partial_derivatives(eqs, _SLOPES, nodes, by),
        partial_derivatives(eqs, _BY_CALLBACKS, nodes, callbacks),
    ]
    return with_outputs(eqs, outputs, {**udot, **first, **second})


def _norm_pulls(eqs: EquationSet, rate: float) -> list[Expr]:
    """Return what brings quaternions back to unit norm at a rate [1/s], by coordinate; 0 on the sphere."""
    formed = eqs.formed
    pulls = {q.index: q * 0 for q in formed.expressions(formed.q)}
    for four in formed.variables.quaternions:
        entries = [Expr(formed.graph, node) for node in four]
        excess = sum((entry**2 for entry in entries), entries[0] * 0 - 1)
        pulls |= {entry.index: -(entry * excess * rate) for entry in entries}
    return list(pulls.values())


class _GGLSystem:
    """The residual ``R(t, y, y')`` with y = (u, q, s, lambda, mu), and its derivatives, as numbers."""

    def __init__(self, motion: Motion, eqs: EquationSet) -> None:
        self.m, self.m_positions = len(eqs.formed.rows), len(eqs.formed.holonomic)
        self._n_u, self._n = motion.n_u, motion.state.size
        self._residual = motion.compile_outputs(_RESIDUAL, eqs)
        self._slopes = motion.compile_outputs((_SLOPES, _MASS, _BY_CALLBACKS), eqs)
        self._laws = motion.problem.laws
        scales = motion.problem.scales
        weight = np.sqrt(scales.mass) * scales.length  # with it entries of M and J are of order 1
        self._sizes = np.concatenate([scales.displacements(eqs) / weight, weight / scales.constraints(eqs)])
        self._start = motion.compile_outputs(
            (_MASS, "forcing", "jacobian", "gamma", "qdot", "signal_rates"), eqs
        )

    def residual(self, t: float, both: Floats) -> Floats:
        """Return R at y followed by y'."""
        y, rate = np.split(both, 2)
        value: Floats = self._evaluate(self._residual, t, y, rate)
        value[self._n_u : self._n] += rate[self._n_u : self._n]
        return value

    def slopes(self, t: float, y: Floats, rate: Floats, share: float) -> Floats:
        """Return dR/dy + share dR/dy'."""
        found = self._evaluate(self._slopes, t, y, rate)
        result: Floats = found[0].copy()
        n_u, n = self._n_u, self._n
        if self._laws.callbacks:
            result[:, :n] += found[2] @ self._laws.slopes(t, y[:n], n_u)
        result[:n_u, :n_u] += share * found[1]
        result[range(n_u, n), range(n_u, n)] += share
        return result

    def consistent(self, t: float, x: Floats) -> tuple[Floats, Floats]:
        """Return y and y' that fulfil the equations at a state on the constraints."""
        mass, force, rows, gamma, rates, signals = self._start(
            t, x, np.zeros(self._n_u + self.m + self.m_positions)
        )
        saddle = np.block([[mass, -rows.T], [rows, np.zeros((self.m, self.m))]])
        sizes, right = self._sizes, np.concatenate([force, gamma])
        solution = sizes * np.linalg.lstsq(saddle * np.outer(sizes, sizes), right * sizes, rcond=None)[0]
        udot, multipliers = np.split(solution, [self._n_u])
        still, pushes = np.zeros(self.m), np.zeros(self.m_positions)
        return np.concatenate([x, multipliers, pushes]), np.concatenate([udot, rates, signals, still, pushes])

    def _evaluate(self, function: StateFunction, t: float, y: Floats, rate: Floats) -> Any:
        return function(t, y[: self._n], np.concatenate([rate[: self._n_u], y[self._n :]]))
