"""The linear system for unknown inputs: ``Z^T B r = Z^T (M u' - F0)`` at each sample.

The columns of Z are the motions that the constraints allow, so multipliers drop out (García de Jalón & Bayo
1994, section 5.2); with friction, which reads reactions, Newton's method repeats it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.formulations.formulation import ProjectedDynamics
from symbody.errors import Problem, SimulationError, UsageError
from symbody.expr.calculus import derivative
from symbody.expr.expression import Expr
from symbody.expr.rewrite import symbols_of
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inverse.prescribed_motion import PrescribedMotion, PrescribedStates
from symbody.tolerances import AT_REST, BEARING, CANCELLED, DIFFERENCE, TINY

Floats = NDArray[np.float64]

_HELD: Final = 1e-7  # of the largest force: what is left over counts as rounding
_ROUNDS: Final = 30


@dataclass(frozen=True, slots=True, eq=False)
class InputSolver:
    """Solves for unknown inputs.

    Attributes
    ----------
    names : tuple of str
        The unknown inputs.
    columns : tuple of EquationSet
        The forcing of each is what a unit of one unknown adds.
    """

    path: PrescribedMotion
    eqs: EquationSet
    laws: InputLaws
    names: tuple[str, ...]
    columns: tuple[EquationSet, ...]
    _functions: list[CompiledFunction] = field(default_factory=list, repr=False)

    @property
    def free_inputs(self) -> tuple[str, ...]:
        """Inputs that are arguments of compiled functions, in order: unknown ones and callables."""
        return tuple(name for name in self.eqs.input_names if name not in self.laws.formulas)

    def arguments(self, samples: PrescribedStates, r: Floats) -> Floats:
        """Return the inputs of compiled functions (N, n), from unknowns (n, N)."""
        t, q, u, _ = samples
        others = self.laws.values(t, q, u)
        arguments = np.zeros((t.size, len(self.free_inputs)))
        for k, name in enumerate(self.free_inputs):
            if name in self.names:
                arguments[:, k] = r[self.names.index(name)]
            else:
                arguments[:, k] = others[:, list(self.laws.callbacks).index(name)]
        return arguments

    def solve(self, samples: PrescribedStates) -> tuple[Floats, bool]:
        """Return the unknown inputs of a motion (n, N), and whether others would give the same one.

        Raises SimulationError if no values of the unknowns give the motion, naming the time and what they
        cannot move.
        """
        count = samples.t.size
        sizes = self.path.continuation.speed_sizes
        mass = self._evaluate(self._compile()[0], samples, np.zeros((len(self.names), count)))
        needed = np.einsum("nij,jn->ni", mass, samples.udot) * sizes
        unit = [self._evaluate(f, samples, np.zeros((len(self.names), count))) * sizes
                for f in self._compile()[2:]]  # fmt: skip
        slopes = np.stack(unit, axis=-1) if unit else np.zeros((count, len(sizes), 0))
        follower, points = self.path.continuation, zip(samples.t, samples.q.T, samples.u.T, strict=True)
        jacobians = [follower.rows(float(t), q, u)[0] for t, q, u in points]
        bases = [follower.freedoms(jacobian[follower.own_rows]) for jacobian in jacobians]  # scaled speeds
        r = np.zeros((len(self.names), count))
        redundant = False
        for _ in range(_ROUNDS if self.eqs.formed.friction else 2):
            forcing = self._forcing(samples, r)
            columns = self._with_friction(samples, r, forcing, slopes) if self.eqs.formed.friction else slopes
            change = np.zeros_like(r)
            for k, basis in enumerate(bases):
                change[:, k], few = _least_inputs(basis.T @ columns[k], basis.T @ (needed[k] - forcing[k]))
                redundant |= few and np.abs(columns[k]).max(initial=0.0) > 0.0
            r += change
            if np.abs(change).max(initial=0.0) <= CANCELLED * np.abs(r).max(initial=0.0):
                break
        forcing = self._forcing(samples, r)
        terms = [np.abs(needed), np.abs(forcing), np.abs(slopes * r.T[:, np.newaxis]).sum(axis=-1)]
        size = np.sum([term.max(axis=1, initial=0.0) for term in terms], axis=0)
        still = AT_REST / _HELD / self.path.continuation.time**2
        size += still * np.abs(mass * sizes * sizes[:, np.newaxis]).max(axis=(1, 2), initial=0.0)
        for k, basis in enumerate(bases):
            missing = basis.T @ (needed - forcing)[k]
            if np.abs(missing).max(initial=0.0) > _HELD * size[k]:
                raise SimulationError(self._underactuated_problem(samples, k, basis, missing, slopes[k]))
        return r, redundant

    def _forcing(self, samples: PrescribedStates, r: Floats) -> Floats:
        forcing: Floats = self._evaluate(self._compile()[1], samples, r) * self.path.continuation.speed_sizes
        return forcing

    def _with_friction(self, samples: PrescribedStates, r: Floats, forcing: Floats, slopes: Floats) -> Floats:
        """Return the derivatives of the forcing by the unknowns, what friction makes of them included."""
        steepest = float(np.abs(slopes).max(initial=0.0))
        needed = float(np.abs(forcing).max(initial=0.0)) / steepest if steepest > 0.0 else 0.0
        scale = max(needed, float(np.abs(r).max(initial=0.0))) or 1.0
        columns = []
        for k in range(len(self.names)):
            beside = r.copy()
            beside[k] += DIFFERENCE * scale
            columns.append((self._forcing(samples, beside) - forcing) / (DIFFERENCE * scale))
        return np.stack(columns, axis=-1)

    def _compile(self) -> Sequence[CompiledFunction]:
        """Return functions of the mass matrix, the forcing, and each column of it."""
        if not self._functions:
            for eqs, name in [(self.eqs, "mass_matrix"), (self.eqs, "forcing"),
                              *((column, "forcing") for column in self.columns)]:  # fmt: skip
                self._functions.append(
                    bound_function(eqs, name, self.path.parameters, (), self.laws.formulas)
                )
        return self._functions

    def _evaluate(self, function: CompiledFunction, samples: PrescribedStates, r: Floats) -> Any:
        return function(samples.t, samples.q.T, samples.u.T, self.arguments(samples, r))

    def _underactuated_problem(
        self, samples: PrescribedStates, k: int, basis: Floats, left: Floats, slopes: Floats
    ) -> Problem:
        follower, t = self.path.continuation, float(samples.t[k])
        jacobian = follower.rows(t, samples.q[:, k], samples.u[:, k])[0]
        rows = follower.scaled_rows(jacobian)
        first = follower.n_h - len(follower.driven)
        shares = np.abs(rows[first : follower.n_h] @ (basis @ left))
        idle = [
            name for name, share in zip(follower.driven, shares, strict=True) if share > 0.01 * shares.max()
        ]
        reach = basis.T @ slopes
        rank = int(
            np.linalg.matrix_rank(reach, tol=BEARING * max(float(np.abs(slopes).max(initial=0.0)), TINY))
        )
        weak = [
            name for j, name in enumerate(self.names)
            if np.abs(reach[:, j]).max(initial=0.0) <= BEARING * max(np.abs(slopes).max(initial=0.0), TINY)
        ]  # fmt: skip
        listed = ", ".join(self.names) or "there are none"
        why = f"the unknowns ({listed}) drive {rank} of {basis.shape[1]} degrees of freedom"
        if weak:
            why += f"; {', '.join(weak)} cannot influence any motion here"
        return Problem("inverse.underactuated", f"motion {', '.join(idle)}",
                       f"at t = {t:.9g} s no values of the unknowns produce the prescribed "
                       f"{', '.join(idle)}", why,
                       "name further inputs as unknowns, add a drive to the model there, or prescribe a "
                       "coordinate that the unknowns move")  # fmt: skip


def _least_inputs(matrix: Floats, right: Floats) -> tuple[Floats, bool]:
    """Return the least solution, and whether there are others."""
    if not matrix.size:
        return np.zeros(matrix.shape[1]), bool(matrix.shape[1])
    solution = np.linalg.lstsq(matrix, right, rcond=BEARING)
    return np.asarray(solution[0], dtype=np.float64), bool(solution[2] < matrix.shape[1])


def influence(eqs: EquationSet, unknowns: Sequence[str]) -> tuple[EquationSet, ...]:
    """Return equations whose forcing is one column of B each, in the order of `unknowns`.

    Raises UsageError if an unknown enters otherwise than in first degree, naming it and where.
    """
    names = tuple(unknowns)
    columns: tuple[EquationSet, ...] = eqs.variants.get(("influence", names), lambda: _influence(eqs, names))
    return columns


def _influence(eqs: EquationSet, unknowns: Sequence[str]) -> tuple[EquationSet, ...]:
    formed, graph = eqs.formed, eqs.formed.graph
    forcing = [force.index for force in formed.dynamics.forcing]
    asked = {formed.names.value(name).index: name for name in unknowns}
    columns = [derivative(graph, forcing, node) for node in asked]
    problems = []
    for name, column in zip(unknowns, columns, strict=True):
        left = {asked[node] for node in symbols_of(graph, column) if node in asked}
        if left:
            places = [eqs.speed_names[k] for k, x in enumerate(column) if not asked.keys().isdisjoint(
                symbols_of(graph, [x]))]  # fmt: skip
            problems.append(
                Problem("inverse.not_affine", f"unknown {name}",
                        f"the equation of {', '.join(places)} is not linear in {name}",
                        f"its coefficient depends on {', '.join(sorted(left))}",
                        "use the force or torque itself as the input, and compute afterwards what produces "
                        "it")
            )  # fmt: skip
    if problems:
        raise UsageError(*problems)
    mass = formed.dynamics.mass_matrix
    equations = []
    for column in columns:
        shares = tuple(Expr(graph, node) for node in column)
        dynamics = ProjectedDynamics(mass, shares, formed.kinetic_energy, formed.potential_energy)
        plain = replace(formed, dynamics=dynamics, friction=())
        equations.append(EquationSet(eqs.model, plain.with_rows(formed.rows), eqs.notes))
    return tuple(equations)
