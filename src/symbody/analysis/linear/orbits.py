"""States that differ in cyclic coordinates alone, reached along the motion in which these change."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.linear.independence import Selection, basis
from symbody.analysis.linear.matrices import Matrices, matrices, relative_error, scale_matrices, term_sizes
from symbody.analysis.linear.slopes import SlopeFunction, Slopes
from symbody.analysis.linear.tangent_space import displace, rotations, solve_dependent
from symbody.errors import AssemblyError, Problem
from symbody.expr.rewrite import symbols_of
from symbody.manifold import LinearConstraints, correct
from symbody.tolerances import ASSEMBLED, AT_REST

Floats = NDArray[np.float64]

ROUNDING: Final = 100.0 * float(np.finfo(float).eps)  # of the terms of a row
# Three turns and a half, or 22 times the size, in steps that no fraction of a turn is a multiple of.
PLACES: Final = 60
_PACE: Final = 0.37


def symbol_node(function: SlopeFunction, name: str) -> int:
    """Return the node of a coordinate."""
    eqs = function.eqs
    return eqs.formed.graph.symbol(eqs.formed.q[eqs.coordinate_names.index(name)])


@dataclass(frozen=True, slots=True, eq=False)
class OrbitPlace:
    """A state with its linear equations, in units of the sizes of states, and the terms they are sums of.

    Attributes
    ----------
    follow : (n, independent) array
        Matrix from steps of the independent coordinates to steps of all.
    noise : float
        Rounding relative to the terms.
    """

    q: Floats
    u: Floats
    slopes: Slopes
    follow: Floats
    matrices: Matrices
    terms: Matrices
    noise: float


@dataclass(frozen=True, slots=True, eq=False)
class Orbit:
    """States that differ in cyclic coordinates alone, and in what follows from them.

    Attributes
    ----------
    cyclic, shown : tuple of str
        All coordinates named, and those that have to be shown to be cyclic.
    """

    function: SlopeFunction
    selection: Selection
    cyclic: tuple[str, ...]
    shown: tuple[str, ...]

    @property
    def kept_states(self) -> list[int]:
        """Places of the states that are not cyclic."""
        return [k for k, name in enumerate(self.selection.names) if name not in self.cyclic]

    def place(self, q: Floats, u: Floats) -> OrbitPlace:
        """Return the linear equations at a state."""
        slopes = self.function.evaluate(q, u)
        space = basis(self.function.eqs, q, slopes, self.selection)
        at = len(self.selection.speeds.independent)
        coordinates = slice(at, at + len(self.selection.coordinates.independent))
        rows = slice(len(u), len(u) + len(self.selection.q_sizes))
        return OrbitPlace(
            q, u, slopes, space.recovery[rows, coordinates],
            scale_matrices(matrices(slopes, space), self.selection),
            scale_matrices(term_sizes(slopes, space), self.selection),
            ROUNDING * relative_error(slopes, space, self.selection),
        )  # fmt: skip

    def directions(self, start: OrbitPlace) -> Iterator[tuple[list[str], Floats]]:
        """Return steps of the independent coordinates to move along, with the cyclic ones that change.

        First the motion itself; then each coordinate that no constraint couples to others. A rotation vector
        is moved along by the motion alone: what is resolved in other axes than its own changes with it.
        """
        names = self.selection.names
        at = len(self.selection.speeds.independent)
        end = at + len(self.selection.coordinates.independent)
        rates = start.matrices.affine.copy()
        rates[[k for k, name in enumerate(names) if name not in self.cyclic]] = 0.0
        rates[np.abs(rates) <= AT_REST * natural_rate(start, self.selection)] = 0.0
        running = [name for name, rate in zip(names, rates, strict=True) if rate]
        if not set(running).isdisjoint(self.shown):
            yield running, (rates / np.abs(rates).max() * self.selection.sizes)[at:end]
        for name in self.shown:
            if [name] != running and self._is_alone(name):
                k = names.index(name)
                yield [name], (np.eye(len(names))[k] * self.selection.sizes)[at:end]

    def _is_alone(self, name: str) -> bool:
        """Return whether no constraint reads a coordinate."""
        function = self.function
        eqs, graph = function.eqs, function.eqs.formed.graph
        if name not in eqs.coordinate_names:
            return False
        constrained = len(eqs.state_names) + len(function.outputs)
        return symbol_node(function, name) not in symbols_of(graph, function.nodes[constrained:])

    def places(self, start: OrbitPlace, names: Sequence[str], step: Floats) -> Iterator[OrbitPlace]:
        """Return places along a direction.

        Raises
        ------
        AssemblyError
            If the constraints stop it.
        """
        here = start
        for _ in range(PLACES):
            by = here.follow @ (_PACE * step)
            closed = self.correct(displace(self.function.eqs, here.q, by), here.u)
            if closed is None:
                raise AssemblyError(not_cyclic(names, ["what the constraints allow"]))
            here = self.place(*closed)
            yield here

    def correct(self, q: Floats, u: Floats) -> tuple[Floats, Floats] | None:
        """Return the nearby state on the constraints with the same independent coordinates and speeds."""
        eqs, chosen = self.function.eqs, self.selection
        dependent = list(chosen.coordinates.dependent)

        def evaluate(q: Floats) -> LinearConstraints:
            slopes = self.function.evaluate(q, u)
            turned = rotations(eqs, q, slopes.rates[len(u) : len(u) + len(q)])
            rows = slopes.position_jacobian @ turned.out * chosen.q_sizes
            lengths = np.linalg.norm(rows, axis=1)
            lengths[lengths == 0.0] = 1.0
            columns = rows[:, dependent] / lengths[:, np.newaxis]
            return LinearConstraints(q, slopes.constraints / lengths, columns)

        def move(point: LinearConstraints, step: Floats) -> LinearConstraints:
            by = np.zeros(len(chosen.q_sizes))
            by[dependent] = step * chosen.q_sizes[dependent]
            return evaluate(displace(eqs, point.q, by))

        end = correct(evaluate(q), move, ASSEMBLED)
        if end is None:
            return None
        q = end.q
        rows = self.function.evaluate(q, u).jacobian * chosen.u_sizes
        u = u.copy()
        dependent_speeds = list(chosen.speeds.dependent)
        for _ in range(2 if dependent_speeds else 0):
            missing = self.function.evaluate(q, u).velocity_constraints
            u[dependent_speeds] -= (
                solve_dependent(rows, chosen.speeds, missing[:, np.newaxis])[:, 0]
                * chosen.u_sizes[dependent_speeds]
            )
        return q, u


def natural_rate(place: OrbitPlace, selection: Selection) -> float:
    """Return the fastest rate that terms have alone [1/s]; those of all columns, as some may vanish."""
    n = len(selection.speeds.independent)
    size = n + len(selection.coordinates.independent)  # signals are in other units
    A = place.terms.A[:size, :size]
    quickest = np.abs(place.u / selection.u_sizes).max(initial=0.0)
    diagonal = max(A[:n, :n].max(initial=0.0), A[n:, n:].max(initial=0.0))
    return float(max(quickest, diagonal, math.sqrt(A[:n, n:].max(initial=0.0))))


def not_cyclic(names: Sequence[str], reading: Sequence[str]) -> Problem:
    """Return the refusal of coordinates with which something changes."""
    listed = " and ".join(names)
    verb = "are" if len(names) > 1 else "is"
    return Problem(
        "linearize.not_cyclic", f"coordinate {listed}",
        f"{listed} {verb} not cyclic: {', '.join(reading)} changes with {listed}",
        "only coordinates that nothing depends on can be removed from the states",
        "keep it among the states, or linearize about another state; for deviations of attitude use angular "
        "velocities in end axes, speeds='end'",
    )  # fmt: skip
