"""Values of inputs as callers of a stepper give them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from symbody.errors import Problem, UsageError
from symbody.simulation.stepper.settings import unknown_name

Floats = NDArray[np.float64]
_INFINITY: Final = math.inf


def set_inputs(array: Floats, places: Mapping[str, int], given: Mapping[str, Any]) -> None:
    """Set inputs at their places of an array, all or none.

    Raises
    ------
    UsageError
        As `checked_inputs`.
    """
    for name, value in given.items():
        if name not in places or not isinstance(value, float) or not -_INFINITY < value < _INFINITY:
            for place, number in checked_inputs(given, places).items():
                array[place] = number
            return
    for name, value in given.items():
        array[places[name]] = value


def checked_inputs(given: Mapping[str, object], places: Mapping[str, int]) -> dict[int, float]:
    """Return values by their places.

    Raises
    ------
    UsageError
        With every name that is unknown, and every value that is not one finite number.
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
