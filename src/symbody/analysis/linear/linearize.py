"""`linearize`: the equations of small deviations from a state, for any mechanism.

With f the exact accelerations and rates, constraints and all, the motions near a state on the constraints
follow ``x' = f(x)``; ``dx_i = L dx`` are deviations of the independent states, ``dx = R dx_i`` what they
determine. Hence ``A = (L df/dx + L') R``, whatever f is off the constraints; L' is the rate of L, which is
not 0 where axes of rotation vectors turn. At rest the same matrices come from the differential-algebraic
equations by projection (Negrut & Ortiz, J. Comput. Nonlinear Dynam. 1 (2006), 230-239; Peterson, Gede &
Hubbard, Multibody Syst. Dyn. 33 (2015), 143-161).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.configurations.one_sided import settle
from symbody.analysis.held_inputs import refuse_held
from symbody.analysis.linear.cyclic import check_cyclic
from symbody.analysis.linear.independence import Basis, Selection, basis, select
from symbody.analysis.linear.linearization import Linearization
from symbody.analysis.linear.matrices import matrices, relative_error
from symbody.analysis.linear.slopes import SlopeFunction, Slopes, slope_function
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet

Floats = NDArray[np.float64]

# Assembly closes to 1e-12 of the size as a rule, and equilibria are given with some digits.
_AT_REST: Final = 1e-8
_STILL: Final = 1e-12  # of accelerations and rates of the mechanism's own size


@named_after(3)
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
    *,
    scales: Mapping[str, float] | None = None,
) -> Linearization:
    """Return the linear equations of small deviations from the motion through a state, exactly derived.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    at : mapping of name to number or formula, or State
        Coordinates and speeds of the state; `assemble` completes it, from the model's initial values where
        nothing else is given. A State is taken as it is, with its parameters, inputs and time unless others
        are given.
    parameters : mapping of name to number or formula, optional
        Overrides values of the model.
    inputs : mapping of name to number or formula
        Values that r deviates from, by default 0. Formulas in states close a loop: these are not inputs then.
    outputs : str or sequence of str
        Quantities that y has the deviations of: any output names or expressions.
    independent : sequence of str, optional
        Coordinates, or coordinates and speeds, that make up the states; all others follow from them. By
        default those are dependent that have the largest pivots, and speeds go with the coordinates.
    cyclic : sequence of str
        Coordinates that nothing depends on, which is checked by the formulas, or along the motion; they leave
        the states, speeds stay. With them steady motions such as precession or riding straight ahead have
        constant states.
    t : float
        Time at which what depends on it is taken [s].
    scales : mapping of "length", "time", "mass" to float, optional
        Sizes of the mechanism [m, s, kg], to which rest is relative, too; by default they follow from the
        model, and without any length there from the state.

    Returns
    -------
    Linearization
        ``x' = A x + B r``, ``y = C x + D r`` of the deviations in SI units: arrays ``A`` (n, n), ``B``
        (n, inputs), ``C`` (outputs, n) and ``D`` (outputs, inputs), also by ``A, B, C, D = ...``. Rows and
        columns are in the order of ``state_names``: speeds, then coordinates; of ``input_names``; of
        ``output_names``. ``modes`` has frequencies and shapes, ``verdict`` says whether it is stable.

    Raises
    ------
    AssemblyError
        If the loops do not close, the coordinates named are too few, too many or do not determine the others,
        or something depends on a coordinate named cyclic.
    CompileError, FormulationError
        If values are missing or names are unknown.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> linear = sb.linearize(eqs)
    >>> linear.state_names
    ('x_dot', 'x')
    >>> linear.A
    array([[ 0., -4.],
           [ 1.,  0.]])
    """
    refuse_held(eqs, "a linear model", {**(at.inputs if isinstance(at, State) else {}), **(inputs or {})})
    state = _state(eqs, at, parameters, inputs, t, scales)
    listed = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    sides = settle(eqs, state)
    eqs, state = sides.eqs, sides.state
    mechanism = mechanism_scales(eqs, state.parameters, scales, state.q)
    function = slope_function(eqs, state, listed, mechanism)
    q, u = np.array(list(state.q.values())), np.array(list(state.u.values()))
    slopes = function.evaluate_finite(q, u)
    selection = select(eqs, state, slopes, independent, cyclic, mechanism)
    notes = (*sides.notes, *check_cyclic(function, q, u, selection, cyclic))
    point = _Point(state, function, slopes, selection, basis(eqs, q, slopes, selection), mechanism.time)
    return point.linearization(cyclic, notes)


def _state(
    eqs: EquationSet,
    at: Mapping[str, Value] | State | None,
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
    scales: Mapping[str, float] | None,
) -> State:
    if isinstance(at, State):
        if parameters is None and inputs is None and at.eqs is eqs:
            return at
        values = {**at.q, **at.u, **at.s}
        inputs_there = at.inputs if inputs is None else inputs
        chosen = at.parameters if parameters is None else parameters
        return assemble(eqs, values, None, parameters=chosen, inputs=inputs_there, t=at.t, scales=scales)
    return assemble(eqs, at, None, parameters=parameters, inputs=inputs, t=t, scales=scales)


@dataclass(frozen=True, slots=True)
class _Point:
    """The derivatives at a state, on what the constraints admit, and the mechanism's own time."""

    state: State
    function: SlopeFunction
    slopes: Slopes
    selection: Selection
    space: Basis
    time: float

    def linearization(self, cyclic: Sequence[str], notes: tuple[str, ...]) -> Linearization:
        """Return the linear equations, without cyclic coordinates."""
        space, function = self.space, self.function
        full = matrices(self.slopes, space)
        kept = [k for k, name in enumerate(self.selection.names) if name not in cyclic]
        A, B, C, D = full.A[np.ix_(kept, kept)], full.B[kept], full.C[:, kept], full.D
        affine = full.affine[kept]
        moving = self._moving_states(A, affine, kept)
        for matrix in (A, B, C, D, affine):
            matrix.flags.writeable = False
        names = tuple(self.selection.names[k] for k in kept)
        return Linearization(
            A, B, C, D, names, function.inputs, function.outputs, affine, not moving, self.state,
            self._notes(moving, names, affine) + notes, space.all_names, space.recovery[:, kept],
            len(self.selection.speeds.independent), relative_error(self.slopes, space, self.selection),
        )  # fmt: skip

    def _moving_states(self, A: Floats, affine: Floats, kept: list[int]) -> list[int]:
        """Return the states that change at the point itself, beyond rounding."""
        sizes, independent = self.selection.sizes[kept], self.selection.speeds.independent
        speeds = len(independent)
        values = np.array(list(self.state.u.values()))[list(independent)]
        reach = np.concatenate([np.abs(values), sizes[speeds:]])
        bounds = _AT_REST * (np.abs(A) @ reach)
        least = _STILL * sizes / np.where(np.arange(sizes.size) < speeds, self.time**2, self.time)
        moving = np.flatnonzero(np.abs(affine) > bounds + least)
        if (
            moving < speeds
        ).all():  # all eigenvalues are needed for coordinates that change, and nothing else
            return [int(k) for k in moving]
        rate = float(np.abs(np.linalg.eigvals(A)).max(initial=0.0))
        bounds[speeds:] = np.maximum(bounds[speeds:], _AT_REST * rate * sizes[speeds:])
        return [int(k) for k in moving if abs(affine[k]) > bounds[k] + least[k]]

    def _notes(self, moving: list[int], names: tuple[str, ...], affine: Floats) -> tuple[str, ...]:
        notes = [*self.selection.notes, *self.function.nonsmooth_notes(self.slopes)]
        eqs = self.function.eqs
        if moving:
            worst = max(moving, key=lambda k: abs(affine[k]))
            unit = eqs.units.get(names[worst], "")
            listed = ", ".join(f"{names[k]}' = {affine[k]:.6g}" for k in moving)
            notes.append(
                f"the state is neither an equilibrium nor a stationary motion: {listed} (largest for "
                f"{names[worst]}{f' [{unit}]' if unit else ''}, per second); x' = A x + B r describes "
                f"deviations from the motion through this state, at this instant only: eigenvalues do not "
                f"show whether that motion is stable. Use find_equilibrium to find an equilibrium, or name "
                f"steadily changing coordinates as cyclic"
            )
        if self.function.timed:
            notes.append(
                f"the equations depend on time: the matrices are valid at t = {self.state.t:g} s only"
            )
        missing = [name for name in eqs.input_names if name not in self.state.inputs]
        if missing:
            notes.append(f"inputs without a value are set to 0: {', '.join(missing)}")
        return tuple(notes)
