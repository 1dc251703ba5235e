"""`Scales`: length, time and mass of a mechanism, and the size of every quantity that follows from them.

Tolerances are shares of these sizes, so that a mechanism of a nanometre is computed to the same digits as one
of a kilometre. All sizes are maxima, products and quotients of numbers of the model: units that differ by
powers of two change no digit of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.signal_sizes import signal_sizes
from symbody.codegen.formation.bound_function import evaluate_once
from symbody.codegen.formation.formula_values import FormulaValues
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import ParameterSet, parameter_set
from symbody.codegen.formation.quantities import Quantities
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError, nearest
from symbody.model.constraints.couplings import Constraint, Stop
from symbody.model.constraints.points import PointOnSurface
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.lengths import model_lengths
from symbody.tolerances import CLOSED

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Sizes of coordinates and speeds are at least this share of the largest first value in the same unit: the
# rounding of that value, 1e-16 of it, is a hundredth of what is tolerated then.
RESOLVED: Final = 1e-4
# Motions without gravity are taken to last ten times as long as what happens in them.
TIME_OF_SPAN: Final = 0.1
# Where equations without a unit are looked at: this share of the mechanism's size from zero.
_SPREAD: Final = 0.5
_UNITS: Final = {"length": "m", "time": "s", "mass": "kg"}


@dataclass(frozen=True, slots=True)
class Scales:
    """The sizes of a mechanism; those of N motions are arrays (N,), and what follows has the motions first.

    Attributes
    ----------
    length : float
        The largest length of its geometry [m]: offsets of frames, distances, radii, pitches, free lengths of
        springs, places of curves; without any the largest displacement at first; else 1.
    time : float
        ``sqrt(length / gravity)`` [s]; without gravity a tenth of the span of a motion, else 1.
    mass : float
        The largest mass of a body [kg], or moment of inertia over the square of the length; 1 without any.
    equations : mapping of name to float
        Size of a constraint with a unit of its own, by the name of its multiplier.
    signals : mapping of name to float
        Size of the state of a signal where the caller chooses it.
    numbers : mapping of name to float
        Values of parameters, from which sizes of states of signals follow; empty where there are none.
    has_length, has_time : bool
        Whether these were given or found in the model.
    """

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0
    equations: Mapping[str, float] = field(default_factory=FrozenMapping)
    has_length: bool = False
    has_time: bool = False
    signals: Mapping[str, float] = field(default_factory=FrozenMapping)
    numbers: Mapping[str, float] = field(default_factory=FrozenMapping)

    @property
    def sizes(self) -> dict[str, float]:
        """Length, time and mass by name, as analyses take them."""
        return {"length": self.length, "time": self.time, "mass": self.mass, **self.signals}

    @property
    def energy(self) -> float:
        """Size of energies [J]."""
        return self.mass * (self.length / self.time) ** 2

    def coordinates(self, eqs: EquationSet) -> Floats:
        """Return the sizes of the coordinates (n_q,): 1 rad, or the length."""
        return self._sizes(_unit_plan(eqs).lengths_of_coordinates)

    def displacements(self, eqs: EquationSet) -> Floats:
        """Return the sizes of displacements along the speeds (n_u,): 1 rad, or the length."""
        return self._sizes(_unit_plan(eqs).lengths_of_speeds)

    def constraints(self, eqs: EquationSet) -> Floats:
        """Return the sizes of the constraints (n_c,): the length, or 1 for angles.

        Those on positions come first, as in ``eqs.formed.holonomic``.
        """
        sizes = self._sizes(_unit_plan(eqs).lengths_of_constraints)
        for k, name in enumerate(eqs.multiplier_names if self.equations else ()):
            sizes[..., k] = self.equations.get(name, sizes[..., k])
        return sizes

    def gap(self, eqs: EquationSet, element: str) -> float:
        """Return the size of the gap of a rope or stop: the length, or 1 for an angle."""
        return 1.0 if eqs.units.get(f"gap {element}") == "rad" else float(self.length)

    def _sizes(self, are_lengths: Flags) -> Floats:
        """Return the length where a mask says so, else 1."""
        return np.where(are_lengths, np.asarray(self.length)[..., np.newaxis], 1.0)

    def tolerances(self, eqs: EquationSet, x: Floats, atol: float | None = None) -> Floats:
        """Return the absolute tolerance of each state (n_u + n_q + n_s,); `atol` if it is given.

        Parameters
        ----------
        x : (n_u + n_q + n_s,) array, or (N, n_u + n_q + n_s)
            The first state.
        """
        if atol is not None:
            return np.full_like(x, atol)
        lengths, times = np.atleast_1d(self.length), np.atleast_1d(self.time)
        driven = self._sizes_of_signals(eqs, lengths, times)
        return state_tolerances(eqs, lengths, times, np.atleast_2d(x), driven, self.signals).reshape(x.shape)

    def _sizes_of_signals(self, eqs: EquationSet, lengths: Floats, times: Floats) -> Floats:
        """Return the sizes of the states of signals by what goes into them, (N, n_s)."""
        if not eqs.signal_state_names:
            return np.zeros((lengths.size, 0))
        find = partial(signal_sizes, eqs, self.numbers, lengths, times, np.atleast_1d(self.mass))
        if np.ndim(self.length):
            return find()
        key = "sizes of signals", self.length, self.time, self.mass, tuple(self.numbers.items())
        sizes: Floats = eqs.plans.get(key, find)
        return sizes

    def of_motion(self, k: int | NDArray[np.intp]) -> Scales:
        """Return the scales of one of N motions, or of some, without the values of their parameters."""
        names = "length", "time", "mass"
        sizes: dict[str, Any] = {name: np.asarray(getattr(self, name))[k] for name in names}
        sizes["equations"] = {name: np.asarray(size)[k] for name, size in self.equations.items()}
        return replace(self, **sizes, numbers={})

    def fit_span(self, start: float, end: float) -> Scales:
        """Return the scales of a motion between two times."""
        span, are_many = abs(end - start), isinstance(self.time, np.ndarray)
        if span == 0.0 or (not are_many and self.has_time):
            return self
        time: Any = TIME_OF_SPAN * span
        time = np.where(self.has_time, self.time, time) if are_many else time
        return replace(self, time=time)

    def notes(
        self, eqs: EquationSet, atol: float | None = None, rtol: float | None = None
    ) -> tuple[str, ...]:
        """Return notes on assumptions that matter: none where an absolute tolerance was given."""
        if atol is not None:
            return ()
        notes = []
        if not self.has_length and "m" in {eqs.units.get(name) for name in eqs.coordinate_names}:
            notes.append(
                "the model has no length to derive tolerances from, so they assume a mechanism of size "
                '1 m; scales={"length": ...} [m] sets another'
            )
        # An error may be atol + rtol |x|: of states as large as the mechanism the first is the greater part.
        if rtol is not None and rtol < CLOSED:
            notes.append(
                f"rtol = {rtol:g} has little effect, because the default of atol is {CLOSED:g} of the "
                f"mechanism's size; give both, such as atol={rtol * self.length:.1g}"
            )
        return tuple(notes)


def mechanism_scales(
    eqs: EquationSet,
    parameters: Mapping[str, Value],
    given: Mapping[str, float] | None = None,
    near: Mapping[str, float] | None = None,
) -> Scales:
    """Return the scales of a mechanism.

    Parameters
    ----------
    given : mapping of "length", "time", "mass" to float
        Those that the caller chooses [m, s, kg]; sizes of states of signals by their names.
    near : mapping of name to float
        A configuration, by default the model's initial values: its displacements count where the model has no
        other length.

    Raises
    ------
    UsageError
        If a name in `given` is unknown, or a value is not positive.
    """
    signals = checked_sizes(eqs, given)
    chosen = checked_scales({name: x for name, x in (given or {}).items() if name not in signals})
    values = parameter_set(eqs, parameters)
    length = chosen.get("length", largest_magnitude(values.quantities.lengths))
    if not length and near is None:
        initial = {name: value for name, value in eqs.model.initial.items() if _is_length(eqs, name)}
        length = largest_magnitude(values_at_start(eqs, initial, parameters).values())
    elif not length and near is not None:
        length = largest_magnitude(x for name, x in near.items() if _is_length(eqs, name))
    key = "scales", length, *chosen.items(), *signals.items()
    scales: Scales = values.note(key, lambda: _scales_of_length(values, length, chosen, signals))
    return scales


def _scales_of_length(
    values: ParameterSet, length: float, chosen: Mapping[str, float], signals: Mapping[str, float]
) -> Scales:
    """Return the scales of a mechanism of a length, 0 if it has none."""
    eqs = values.original
    scales = scales_of_quantities(values.quantities, length, chosen, signals)
    numbers = values.floats if eqs.signal_state_names else scales.numbers
    equations = _equations(eqs, values.given, scales)
    return replace(scales, has_length=bool(length), equations=equations, numbers=numbers)


def scales_of_quantities(
    quantities: Quantities, length: float, chosen: Mapping[str, float], signals: Mapping[str, float]
) -> Scales:
    """Return the scales of a mechanism of a length, 0 if it has none, without its constraints.

    Of N motions the length and all quantities are arrays (N,).
    """
    _, pulls, masses, moments = quantities
    length, gravity = _or(length, 1.0), _norm(pulls)
    fallen = _or(_root(length / _or(gravity, math.inf)), 1.0)
    mass = chosen.get("mass", _or(largest_magnitude(masses), largest_magnitude(moments) / length**2))
    has_time = ("time" in chosen) | (gravity > 0.0)
    time = chosen.get("time", fallen)
    return Scales(length, time, _or(mass, 1.0), has_time=has_time, signals=signals)


def _or(first: Any, second: Any) -> Any:
    """Return the first of two sizes unless it is 0, then the second; of N motions arrays (N,)."""
    return np.where(first > 0.0, first, second) if isinstance(first, np.ndarray) else first or second


def _root(x: Any) -> Any:
    return np.sqrt(x) if isinstance(x, np.ndarray) else math.sqrt(x)


def _norm(vector: Sequence[Any]) -> Any:
    return np.sqrt(sum(x**2 for x in vector)) if _are_arrays(vector) else math.hypot(*vector)


def _are_arrays(sizes: Sequence[Any]) -> bool:
    """Return whether sizes are those of several motions: all are, or none."""
    return isinstance(sizes[0], np.ndarray)


def state_tolerances(
    eqs: EquationSet, lengths: Floats, times: Floats, x: Floats, driven: Floats, signals: Mapping[str, float]
) -> Floats:
    """Return the absolute tolerances of all states where none is given.

    Parameters
    ----------
    lengths, times : (N,) arrays
        Length and time of the `Scales` of N motions.
    x : (N, n_u + n_q + n_s) array
        Their first states.
    driven : (N, n_s) array
        Sizes of states of signals by what goes into them; where they are nan the first value counts, or 1
        where that is 0.
    signals : mapping of name to float
        Sizes of states of signals that the caller chose.
    """
    sizes = np.ones_like(x)
    plan, n_u = _unit_plan(eqs), len(eqs.speed_names)
    for k, name in enumerate(eqs.signal_state_names):
        place = n_u + len(eqs.coordinate_names) + k
        first = np.abs(x[:, place])
        open_size = np.where(first == 0.0, 1.0, first)
        size = np.where(np.isnan(driven[:, k]), open_size, np.maximum(driven[:, k], RESOLVED * first))
        sizes[:, place] = signals.get(name, size)
    sizes[:, :n_u] /= times[:, np.newaxis]
    sizes[:, plan.lengths_of_states] *= lengths[:, np.newaxis]
    for places in plan.alike:
        resolved = RESOLVED * np.abs(x[:, places]).max(axis=1, initial=0.0)
        sizes[:, places] = np.maximum(sizes[:, places], resolved[:, np.newaxis])
    return np.asarray(CLOSED * sizes)


def checked_scales(given: Mapping[str, float] | None) -> dict[str, float]:
    """Return the scales that the caller chose.

    Raises
    ------
    UsageError
        If a name is unknown, or a value is not a positive number.
    """
    problems, chosen = [], {}
    for name, value in (given or {}).items():
        if name not in _UNITS:
            problems.append(
                Problem("simulation.scales", f"scales[{name!r}]", f"there is no scale {name!r}",
                        "scales are length [m], time [s] and mass [kg]", nearest(name, _UNITS))
            )  # fmt: skip
        elif isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
            problems.append(
                Problem("simulation.scales", f"scales[{name!r}]",
                        f"{name} = {value!r} is not a positive number", "",
                        f"give a positive finite number [{_UNITS[name]}], or leave it out")
            )  # fmt: skip
        else:
            chosen[name] = float(value)
    if problems:
        raise UsageError(*problems)
    return chosen


def checked_sizes(eqs: EquationSet, given: Mapping[str, float] | None) -> dict[str, float]:
    """Return the sizes of states of signals that the caller chose.

    Raises
    ------
    UsageError
        If one is not a positive number.
    """
    sizes = {name: x for name, x in (given or {}).items() if name in eqs.signal_state_names}
    problems = [
        Problem("simulation.scales", f"scales[{name!r}]", f"{name} = {value!r} is not a positive number", "",
                "give a positive finite number, or leave it out")
        for name, value in sizes.items()
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return {name: float(value) for name, value in sizes.items()}


def scales_by_name(eqs: EquationSet, given: Mapping[str, float] | None) -> dict[str, float]:
    """Return the scales and the sizes of states of signals that the caller chose.

    Raises
    ------
    UsageError
        If a name is unknown, or a value is not a positive number.
    """
    sizes = checked_sizes(eqs, given)
    return checked_scales({name: x for name, x in (given or {}).items() if name not in sizes}) | sizes


def geometry(eqs: EquationSet) -> dict[str, Value]:
    """Return the formulas of all lengths of the model [m], by number."""
    return number_formulas(model_lengths(eqs.model))


def are_lengths(eqs: EquationSet) -> list[bool]:
    """Return a mask of the constraints that are lengths; the others are angles."""
    units = eqs.units
    return [
        not row.force.is_zero or units.get(row.coordinate) == "m" or units.get(row.name) == "N"
        for row in eqs.formed.rows
    ]


def values_at_start(
    eqs: EquationSet, formulas: Mapping[str, Value], parameters: Mapping[str, Value]
) -> dict[str, float]:
    """Return the values of formulas in parameters and t, at t = 0."""
    texts = tuple([str(formula) for formula in formulas.values()])
    plan = partial(FormulaValues, eqs, tuple(formulas.values()), timed=True)
    values: FormulaValues = eqs.plans.get(("values at the start", texts), plan)
    return dict(zip(formulas, values.numbers(parameter_set(eqs, parameters).floats), strict=True))


class _UnitPlan(NamedTuple):
    """Masks of what is a length, or one over a time, and of states in the same unit, where there are any."""

    lengths_of_coordinates: Flags
    lengths_of_speeds: Flags
    lengths_of_constraints: Flags
    lengths_of_states: Flags
    alike: tuple[Flags, ...]


def _unit_plan(eqs: EquationSet) -> _UnitPlan:
    def make() -> _UnitPlan:
        units = np.array([eqs.units.get(name, "") for name in eqs.state_names], dtype=np.str_)
        n_u = len(eqs.speed_names)
        n = n_u + len(eqs.coordinate_names)
        units[n:] = ""  # signals have sizes of their own
        alike = [units == unit for unit in ("m/s", "rad/s", "m", "rad")]
        return _UnitPlan(
            units[n_u:n] == "m", units[:n_u] == "m/s", np.array(are_lengths(eqs), dtype=np.bool_),
            (units == "m/s") | (units == "m"), tuple(places for places in alike if places.any()),
        )  # fmt: skip

    plan: _UnitPlan = eqs.plans.get("units of sizes", make)
    return plan


def largest_magnitude(values: Iterable[Any]) -> Any:
    """Return the largest absolute value, 0 if there is none; of arrays (N,) that of each motion."""
    sizes = list(map(abs, values))
    return np.maximum.reduce(sizes) if sizes and _are_arrays(sizes) else max(sizes, default=0.0)


def _equations(eqs: EquationSet, parameters: Mapping[str, Value], scales: Scales) -> dict[str, float]:
    """Return the change of each constraint with a unit of its own in motions as large as the mechanism.

    That is the largest of its derivatives times the displacements, at `pose_share` of the sizes.
    """
    written = own_equations(eqs)
    if not written:
        return {}
    silent = dict.fromkeys(eqs.input_names, 0)
    q = (pose_share(eqs) * scales.coordinates(eqs)).tolist()
    point = {"t": [0.0], "q": q, "u": [0.0] * len(eqs.speed_names), "r": []}
    entries = evaluate_once(eqs, "jacobian", parameters, silent, point)[0]
    rows = np.array([float(x) for x in entries]).reshape(len(eqs.formed.rows), -1)
    return equation_sizes(eqs, rows, scales)


def equation_sizes(eqs: EquationSet, rows: Floats, scales: Scales) -> dict[str, Any]:
    """Return the sizes of constraints with units of their own, from J (n_c, n_u) or (N, n_c, n_u)."""
    changes = np.abs(rows * scales.displacements(eqs)[..., np.newaxis, :]).max(axis=-1, initial=0.0)
    sizes = np.where((changes > 0.0) & (changes < math.inf), changes, scales.constraints(eqs))
    return {eqs.multiplier_names[k]: sizes.T[k] for k in own_equations(eqs)}


def own_equations(eqs: EquationSet) -> list[int]:
    """Return the places of constraints with units of their own: equations of users, balances of forces."""
    own = Constraint | Stop | PointOnSurface
    written = {part.name for part in eqs.model.constraints if isinstance(part, own)}
    return [k for k, row in enumerate(eqs.formed.rows) if row.element in written or row.is_balance]


def pose_share(eqs: EquationSet) -> Floats:
    """Return a configuration without symmetry, over the sizes of coordinates, at which they are evaluated."""
    return np.array([_SPREAD * math.cos(k + 1.0) for k in range(len(eqs.coordinate_names))])


def number_formulas(formulas: Iterable[Value]) -> dict[str, Value]:
    """Return formulas by their numbers."""
    return {str(k): formula for k, formula in enumerate(formulas)}


def _is_length(eqs: EquationSet, name: str) -> bool:
    return eqs.units.get(name) == "m"
