"""`State`: one configuration of a mechanism with its motion, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symbody.analysis.configurations.plain_assembly import PlainState
from symbody.analysis.value_lines import values_line
from symbody.arguments import checked_arguments
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.notebook import Displayed
from symbody.single_flight import SingleFlight


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class State(Displayed):
    """Positions, velocities, accelerations and multipliers that fit together.

    Attributes
    ----------
    eqs : EquationSet
        The equations that it is a state of.
    q, u, udot, multipliers, s : mapping of name to float
        Each in the order of the equations; s are the states of signals.
    residual : float
        Largest absolute constraint, of lengths [m] and dot products of unit vectors.
    moved : mapping of name to float
        How far each coordinate is from the guess it was assembled from, by default 0, and each speed or
        ``_dot`` name from the value guessed for it, where it moved; the model's initial values are guesses.
    t : float
        Time [s].
    parameters, inputs : mapping of name to number or formula
        What was given for them.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> state = sb.assemble(sb.form_equations(sb.Model("cart", [rail])), {"x": 3, "x_dot": 1})
    >>> state.q, state["x_dot"], state.udot
    ({'x': 3.0}, 1.0, {'x_ddot': 0.0})
    """

    eqs: EquationSet = field(repr=False)
    q: Mapping[str, float]
    u: Mapping[str, float]
    udot: Mapping[str, float]
    multipliers: Mapping[str, float]
    residual: float
    moved: Mapping[str, float]
    t: float = 0.0
    parameters: Mapping[str, Value] = field(default_factory=dict, repr=False)
    inputs: Mapping[str, Value] = field(default_factory=dict, repr=False)
    s: Mapping[str, float] = field(default_factory=dict, kw_only=True)
    # Finds the branches; they are looked for on first request.
    _others: Callable[[], Iterable[State]] = field(default=tuple, repr=False)
    _branches: SingleFlight[None, tuple[State, ...]] = field(default_factory=SingleFlight, repr=False)
    # Compiled functions of these equations, parameters and inputs: branches that have the same share them.
    _functions: SingleFlight[str | tuple[str, ...], CompiledFunction] = field(
        default_factory=SingleFlight, repr=False
    )
    # How many constraints follow from the others here.
    _dependent: int = field(default=0, repr=False)
    # What one call of compiled code has given, if it did.
    _plain: PlainState | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        return f"{type(self).__name__} at t = {self.t:.6g} s: {self._values()}"

    def _values(self) -> str:
        """Return positions and speeds in one line."""
        parts = [values_line(values, self.eqs.units) for values in (self.q, self.u, self.s)]
        return "; ".join(filter(None, parts)) or "nothing moves"

    @property
    def has_dependent_constraints(self) -> bool:
        """Whether constraints follow from the others here, beside those that hold identically."""
        return self._dependent > 0

    @property
    def plain(self) -> PlainState | None:
        """The state as numbers, where constraints are independent by a wide margin."""
        return self._plain

    @property
    def branches(self) -> tuple[State, ...]:
        """Other assemblies with the same fixed values, nearest to the guess first; there may be more."""
        return self._branches.get(
            None, lambda: tuple(self._share_functions(other) for other in self._others())
        )

    def _share_functions(self, other: State) -> State:
        """Return a branch with the functions compiled here, unless its closed gaps or inputs are others."""
        if other.eqs is not self.eqs or (other.parameters, other.inputs) != (self.parameters, self.inputs):
            return other
        return replace(other, _functions=self._functions)

    @checked_arguments
    def __getitem__(self, name: str) -> float | np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Return a coordinate, a speed, or any output or expression.

        Raises
        ------
        FormulationError
            If the name is neither an output nor an expression.
        """
        return self.values_of([name])[name]

    def _ipython_key_completions_(self) -> list[str]:
        """Return what notebooks offer behind ``state["``: all outputs by their kinds."""
        return [each.name for each in self.eqs.listed_outputs]

    def values_of(
        self, names: Sequence[str]
    ) -> dict[str, float | np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
        """Return several values of ``state[name]`` by their names; the outputs are compiled together.

        Raises
        ------
        FormulationError
            If a name is neither an output nor an expression.
        """
        groups = (self.q, self.u, self.udot, self.multipliers, self.s)
        values: dict[str, Any] = {
            name: next((group[name] for group in groups if name in group), None) for name in names
        }
        outputs = tuple(name for name, value in values.items() if value is None)
        if outputs:
            values |= dict(zip(outputs, self._evaluate(outputs), strict=True))
        return values

    def _evaluate(self, outputs: tuple[str, ...]) -> list[Any]:
        """Return numbers and arrays of outputs."""

        def compile_outputs() -> CompiledFunction:
            inputs = dict.fromkeys(self.eqs.input_names, 0) | dict(self.inputs)
            return bound_function(self.eqs, outputs, self.parameters, (), inputs, quick=True)

        function = self._functions.get(outputs, compile_outputs)
        q, u, s = (list(values.values()) for values in (self.q, self.u, self.s))
        results = function(self.t, q, u, s=s)
        arrays = [np.asarray(each) for each in (results if len(outputs) > 1 else (results,))]
        return [float(array) if array.ndim == 0 else array for array in arrays]
