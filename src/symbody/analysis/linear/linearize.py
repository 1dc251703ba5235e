"""`linearize`: the equations of small deviations from a state, for any mechanism.

With f the exact accelerations and rates, constraints and all, the motions near a state on the constraints
follow ``x' = L f(x(x_i))``; x_i = L x are the independent states, ``dx = R dx_i`` what they determine. Hence
``A = L df/dx R``, whatever f is off the constraints. The same matrices come from the differential-algebraic
equations by projection (Negrut & Ortiz, J. Comput. Nonlinear Dynam. 1 (2006), 230-239; Peterson, Gede &
Hubbard, Multibody Syst. Dyn. 33 (2015), 143-161).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import assemble
from symbody.analysis.linear.independence import Basis, basis
from symbody.analysis.linear.linearization import Linearization
from symbody.analysis.linear.slopes import Slopes, slopes
from symbody.analysis.linear.variations import rotations
from symbody.analysis.one_sided import settled
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.arguments import checked_arguments
from symbody.codegen.compile import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, nearest

Floats = NDArray[np.float64]

_ROUNDING: Final = 100.0 * float(np.finfo(float).eps)  # of the terms of a row
# Assembly closes to 1e-12 of the size as a rule, and equilibria are given with some digits.
_AT_REST: Final = 1e-8
_STILL: Final = 1e-12  # of accelerations and rates of the mechanism's own size
_INDEPENDENT_OF: Final = 1e-9  # of the largest terms of a column that should vanish


@checked_arguments
def linearize(
    eqs: EquationSet,
    at: Mapping[str, Value] | State | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    outputs: str | Sequence[str] = (),
    independent: Sequence[str] | None = None,
    cyclic: Sequence[str] = (),
    t: float = 0.0,
) -> Linearization:
    """Return the linear equations of small deviations from a state, with exact derivatives.

    Parameters
    ----------
    at : mapping of name to number or formula, or State
        Coordinates and speeds of the state; `assemble` completes it, from the model's initial values where
        nothing else is said. A State is taken as it is, with its parameters, inputs and time unless others
        are given.
    inputs : mapping of name to number or formula
        Values that r deviates from, by default 0. Formulas in states close a loop: these are no inputs then.
    outputs : str or sequence of str
        What y deviates of: any output names or expressions.
    independent : sequence of str, optional
        Coordinates, or coordinates and speeds, that make up the states; all others follow from them. By
        default those are dependent that have the largest pivots, and speeds go with the coordinates.
    cyclic : sequence of str
        Coordinates that nothing depends on; they leave the states, speeds stay. With them steady motions
        such as precession or a ride straight on have constant states.

    Raises
    ------
    AssemblyError
        If the loops do not close, the coordinates named are too few, too many or do not determine the others,
        or something depends on a coordinate named cyclic.
    CompileError, FormulationError
        If values are missing or names are unknown.
    """
    state = _state(eqs, at, parameters, inputs, t)
    listed = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    sides = settled(eqs, state)
    eqs, state = sides.eqs, sides.state
    found = slopes(eqs, state, listed)
    found = replace(found, kinks=(*sides.notes, *found.kinks))
    space = basis(eqs, state, found, independent, _checked(eqs, state, cyclic))
    point = _Point(eqs, state, found, space, tuple(cyclic))
    return point.linearization()


def _state(
    eqs: EquationSet,
    at: Mapping[str, Value] | State | None,
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
) -> State:
    if isinstance(at, State):
        if parameters is None and inputs is None and at.eqs is eqs:
            return at
        values = {**at.q, **at.u}
        own = at.inputs if inputs is None else inputs
        return assemble(eqs, values, None, at.parameters if parameters is None else parameters, own, at.t)
    return assemble(eqs, at, None, parameters, inputs, t)


def _checked(eqs: EquationSet, state: State, cyclic: Sequence[str]) -> tuple[str, ...]:
    names = rotations(eqs, np.array(list(state.q.values()))).names
    problems = [
        Problem("linearize.unknown_name", name, f"there is no coordinate {name!r} to be cyclic", "",
                nearest(name, names))
        for name in cyclic if name not in names
    ]  # fmt: skip
    if problems:
        raise AssemblyError(*problems)
    return tuple(cyclic)


@dataclass(frozen=True, slots=True)
class _Point:
    """The derivatives at a state, on what the constraints admit."""

    eqs: EquationSet
    state: State
    slopes: Slopes
    space: Basis
    cyclic: tuple[str, ...]

    def linearization(self) -> Linearization:
        """Return the linear equations, without cyclic coordinates."""
        found, space = self.slopes, self.space
        n = len(found.rates)
        rows = slice(n, n + len(found.outputs))
        full = space.back @ found.by_state[:n] @ space.out
        C = found.by_state[rows] @ space.out
        kept = [k for k, name in enumerate(space.names) if name not in self.cyclic]
        self._check_cyclic(full, C, kept)
        affine = (space.back @ found.rates)[kept]
        A = full[np.ix_(kept, kept)]
        moving = self._moving(A, affine, kept)
        B, D = space.back[kept] @ found.by_input[:n], found.by_input[rows].copy()
        C = C[:, kept]
        for matrix in (A, B, C, D, affine):
            matrix.flags.writeable = False
        names = tuple(space.names[k] for k in kept)
        return Linearization(
            A, B, C, D, names, found.inputs, found.outputs, affine, not moving, self.state,
            self._notes(moving, names, affine), space.all_names, space.recovery[:, kept],
            len(space.speeds), self._noise(),
        )  # fmt: skip

    def _check_cyclic(self, full: Floats, C: Floats, kept: list[int]) -> None:
        """Refuse cyclic coordinates that rates of other states, or outputs, depend on."""
        n = len(self.slopes.rates)
        terms = np.abs(self.space.back[kept]) @ np.abs(self.slopes.by_state[:n]) @ np.abs(self.space.out)
        terms *= self.space.sizes
        noise = _ROUNDING * self._noise() * terms.max(axis=1, initial=0.0)
        problems = []
        for k, name in enumerate(self.space.names):
            if name not in self.cyclic:
                continue
            bounds = _INDEPENDENT_OF * terms[:, k] + noise
            reads = np.abs(full[kept, k]) * self.space.sizes[k] > bounds
            reading = [self.space.names[j] for j, yes in zip(kept, reads, strict=True) if yes]
            bounds = _INDEPENDENT_OF * np.abs(C).max(axis=1, initial=0.0)
            watched = [y for y, c, b in zip(self.slopes.outputs, C[:, k], bounds, strict=True) if abs(c) > b]
            if reading or watched:
                problems.append(_not_cyclic(name, [f"the rate of {other}" for other in reading] + watched))
        if problems:
            raise AssemblyError(*problems)

    def _moving(self, A: Floats, affine: Floats, kept: list[int]) -> list[int]:
        """Return the states that change at the point itself, beyond rounding."""
        sizes = self.space.sizes[kept]
        rate = float(np.abs(np.linalg.eigvals(A)).max(initial=0.0)) if A.size else 0.0
        speeds = len(self.space.speeds)
        values = np.array(list(self.state.u.values()))[list(self.space.speeds)]
        reach = np.concatenate([np.abs(values), sizes[speeds:]])
        bounds = _AT_REST * (np.abs(A) @ reach)
        bounds[speeds:] = np.maximum(bounds[speeds:], _AT_REST * rate * sizes[speeds:])
        time = mechanism_scales(self.eqs, self.state.parameters, near=self.state.q).time
        least = _STILL * sizes / np.where(np.arange(sizes.size) < speeds, time**2, time)
        return [k for k in range(len(affine)) if abs(affine[k]) > bounds[k] + least[k]]

    def _notes(self, moving: list[int], names: tuple[str, ...], affine: Floats) -> tuple[str, ...]:
        notes = [*self.space.notes, *self.slopes.kinks]
        if moving:
            worst = max(moving, key=lambda k: abs(affine[k]))
            units = self.eqs.units
            own = units.get(names[worst], "")
            listed = ", ".join(f"{names[k]}' = {affine[k]:.6g}" for k in moving)
            notes.append(
                f"the state is neither an equilibrium nor a stationary motion: {listed} (largest for "
                f"{names[worst]}{f' [{own}]' if own else ''}, per second); x' = affine + A x + B r. "
                "find_equilibrium gives an equilibrium; coordinates that change steadily can be named cyclic"
            )
        if self.slopes.timed:
            notes.append(f"the equations depend on time: the matrices hold at t = {self.state.t:g} s")
        missing = [name for name in self.eqs.input_names if name not in self.state.inputs]
        if missing:
            notes.append(f"inputs without a value are 0 at the state: {', '.join(missing)}")
        return tuple(notes)

    def _noise(self) -> float:
        """Return the relative error of A in eps: the condition of M on the admissible speeds, scaled."""
        found, space = self.slopes, self.space
        admitted = space.out[: len(found.jacobian[0]) if len(found.jacobian) else len(found.mass_matrix)]
        mass = admitted[:, : len(space.speeds)]
        projected = mass.T @ found.mass_matrix @ mass
        if not projected.size:
            return 1.0
        scale = np.sqrt(np.abs(np.diag(projected)))
        scale[scale == 0.0] = 1.0
        return max(float(np.linalg.cond(projected / np.outer(scale, scale))), 1.0) * 10.0


def _not_cyclic(name: str, reading: list[str]) -> Problem:
    listed = ", ".join(reading)
    return Problem(
        "linearize.not_cyclic", f"coordinate {name}", f"{name} is not cyclic: {listed} changes with it",
        "only coordinates that nothing depends on can leave the states",
        "leave it among the states, or linearize about another state",
    )  # fmt: skip
