"""The numbers of a stepper: time, state and inputs as callers give them, at places that stay."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Final, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.state import State
from symbody.errors import Problem, UsageError, nearest
from symbody.kernels import stepping as at

Floats = NDArray[np.float64]


class StepNumbers:
    """One array, see `symbody.kernels.stepping`, and what lies where in it.

    Attributes
    ----------
    array : array
        All numbers.
    x : (n,) array
        The state (u, q, work), a view.
    inputs : (n_r,) array
        The inputs that are arguments of the right-hand side, a view; NaN where none was given yet.
    places, state_places : mappings of name to int
        Where the inputs that steps give, and time and states, stand in the array.
    """

    __slots__ = ("array", "inputs", "places", "state_places", "x")

    def __init__(
        self, array: Floats, n: int, places: Mapping[str, int], state_places: Mapping[str, int]
    ) -> None:
        self.places, self.state_places = places, state_places
        self.array, self.x, self.inputs = array, array[at.STATE_AT :][:n], array[at.STATE_AT + n :]

    @classmethod
    def fresh(cls, states: Sequence[str], inputs: Sequence[str], of_steps: Container[str]) -> StepNumbers:
        """Return numbers of states and inputs, none of which has a value; steps give some of these."""
        names = (*states, "work")
        first = at.STATE_AT + len(names)
        state_places = {name: at.STATE_AT + names.index(name) for name in names}  # the first of equal ones
        places = {name: first + k for k, name in enumerate(inputs) if name in of_steps}
        array = np.zeros(first + len(inputs))
        numbers = cls(array, len(names), places, {**state_places, "t": at.NOW})
        numbers.inputs[:] = np.nan
        return numbers

    @property
    def unset_inputs(self) -> list[str]:
        """The inputs that steps give, but have not given yet."""
        return [name for name, place in self.places.items() if np.isnan(self.array[place])]

    @property
    def t(self) -> float:
        """Time [s]."""
        return self.array.item(at.NOW)

    def move_to(self, row: Floats) -> None:
        """Keep the numbers in another array of the same size from now on."""
        row[:] = self.array
        self.array, n = row, self.x.size
        self.x, self.inputs = row[at.STATE_AT :][:n], row[at.STATE_AT + n :]

    def copy(self) -> StepNumbers:
        """Return the same numbers at another place."""
        return StepNumbers(self.array.copy(), self.x.size, self.places, self.state_places)

    def next_end(self) -> float:
        """Begin a step outside the compiled loop; return its end [s]."""
        array = self.array
        array[at.COUNT] += 1.0
        return float(array[at.START] + array[at.COUNT] * array[at.DURATION])

    def arrive(self, t: float, x: Floats, *, at_end: bool) -> None:
        """Set time and state after a step; later ones are counted from there if it was not its end."""
        self.array[at.NOW], self.x[:] = t, x
        if not at_end:
            self.count_from(t)

    def count_from(self, t: float) -> None:
        """Count steps from a time on."""
        self.array[at.START], self.array[at.COUNT] = t, 0.0
        self.array[at.UNDER_WAY] = 0.0

    def set_duration(self, duration: float) -> None:
        """Set how long each step is [s]; one that was interrupted ends where it came to."""
        if duration != self.array[at.DURATION]:
            self.count_from(self.t)
            self.array[at.DURATION] = duration

    def begin(self, t: float, duration: float, x: Floats) -> None:
        """Begin at a time [s] and a state (u, q), without inputs and without work done."""
        inputs = self.array[at.INPUTS]
        self.array[:] = 0.0
        self.array[[at.NOW, at.DURATION, at.INPUTS]] = t, duration, inputs
        self.x[:-1] = x
        self.inputs[:] = np.nan
        self.count_from(t)

    def take(self, array: Floats) -> None:
        """Take over all numbers but how long steps are, and how many inputs there are: there memory ends."""
        inputs, duration = self.array[at.INPUTS], self.array.item(at.DURATION)
        self.array[:] = array
        self.array[at.INPUTS] = inputs
        self.set_duration(duration)

    @contextmanager
    def unless_it_fails(self) -> Iterator[None]:
        """Give all numbers their values of before if what follows raises."""
        before = self.array.copy()
        try:
            yield
        except BaseException:
            self.array[:] = before
            raise


def read_only(array: Floats) -> Floats:
    """Return a view through which nothing can be changed."""
    view = array.view()
    view.flags.writeable = False
    return view


def state_values(state: State) -> Floats:
    """Return (u, q) of a state."""
    return np.array([*state.u.values(), *state.q.values(), *state.s.values()])


_INFINITY: Final = math.inf


def set_inputs(array: Floats, places: Mapping[str, int], given: Mapping[str, Any]) -> None:
    """Set inputs at their places of an array, all or none; raises UsageError as `checked_inputs`."""
    for name, value in given.items():
        if name not in places or not isinstance(value, float) or not -_INFINITY < value < _INFINITY:
            for place, number in checked_inputs(given, places).items():
                array[place] = number
            return
    for name, value in given.items():
        array[places[name]] = value


def checked_inputs(given: Mapping[str, object], places: Mapping[str, int]) -> dict[int, float]:
    """Return values by their places.

    Raises UsageError with every name that is unknown, and every value that is not one finite number.
    """
    problems, values = [], {}
    for name, value in given.items():
        if name not in places:
            problems.append(
                unknown_name("input", name, places, "step() accepts inputs without a formula only")
            )
            continue
        what = _fault(value)
        if what:
            fix = f"give one number, as step({name}=float(VALUE))"
            problems.append(Problem("stepper.input_value", name, f"{name} is {what}", "", fix))
        elif isinstance(value, SupportsFloat):
            values[places[name]] = float(value)
    if problems:
        raise UsageError(*problems)
    return values


def missing_values(names: Iterable[str]) -> UsageError:
    """Return what to say about inputs without a value."""
    first, *others = sorted(names)
    listed = ", ".join([first, *others])
    return UsageError(
        Problem("stepper.input_without_value", "step", f"no value was given for {listed}",
                "inputs without a formula hold the value of the last step, and have no value before the "
                "first",
                f'call step({first}=0.0), or create the stepper with inputs={{"{first}": 0}}')
    )  # fmt: skip


def _fault(value: object) -> str:
    """Return what is wrong with a value, empty if it is a finite number."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiu":
        return f"{value!r}, not a number"
    if array.ndim:
        return f"an array of shape {array.shape}"
    return "" if math.isfinite(float(array)) else f"{float(array)}, not a finite number"


def unknown_name(kind: str, name: str, names: Iterable[str], why: str = "") -> Problem:
    """Return what to say about a name that a stepper does not have."""
    return Problem("stepper.unknown_name", name, f"there is no {kind} {name!r}", why, nearest(name, names))
