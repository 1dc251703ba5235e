"""Values that coordinates are led through: numbers, angles such as ``"30 deg"``, formulas in parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.named_values import read_value
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.values import constant_values
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError

Floats = NDArray[np.float64]
LedValues: TypeAlias = ArrayLike | Value | Sequence[Value]


def led_numbers(
    eqs: EquationSet, over: Mapping[str, Any], parameters: Mapping[str, Value] | None
) -> dict[str, Any]:
    """Return `over` with a number in the place of each formula; tuples stay tuples.

    Raises
    ------
    CompileError, ExpressionError
        If a formula cannot be read, or has no value.
    """
    return {name: _numbers(eqs, name, value, parameters) for name, value in over.items()}


def _numbers(eqs: EquationSet, name: str, value: Any, parameters: Mapping[str, Value] | None) -> Any:
    several = isinstance(value, list | tuple)
    entries = list(value) if several else [value]
    if all(isinstance(entry, int | float | np.ndarray | np.generic | list | tuple) for entry in entries):
        return value
    where = f"over {name}"
    read = {f"{where}[{k}]": read_value(eqs, name, entry, where) for k, entry in enumerate(entries)}
    numbers = list(constant_values(eqs, read, parameters).values())
    return (tuple(numbers) if isinstance(value, tuple) else numbers) if several else numbers[0]


def read_range(over: Mapping[str, Any]) -> tuple[str, tuple[float, float], dict[str, float]]:
    """Return the coordinate that has a range, the range, and what is held.

    Raises
    ------
    UsageError
        If there is not one range of rising numbers.
    """
    ranges = {name: value for name, value in over.items() if isinstance(value, tuple)}
    held = {name: float(value) for name, value in over.items() if not isinstance(value, tuple)}
    (name, ends), *others = ranges.items() or [("", (0.0, 0.0))]
    if others or len(ends) != 2 or not float(ends[0]) < float(ends[1]):
        raise UsageError(
            Problem("kinematics.range", "over", f"{dict(over)} needs exactly one range (a, b) with a < b",
                    "the search runs along one coordinate",
                    'give one range, and numbers for coordinates that are held fixed: over={"theta": (0, '
                    '"90 deg"), "phi": 0.2}')
        )  # fmt: skip
    return name, (float(ends[0]), float(ends[1])), held


def read_values(over: Mapping[str, Any]) -> dict[str, Floats]:
    """Return the values of all coordinates, equally many.

    Raises
    ------
    UsageError
        If there are none, or they are not finite numbers of equal count.
    """
    given = {name: np.atleast_1d(np.asarray(values, dtype=np.float64)) for name, values in over.items()}
    count = max((x.size for x in given.values()), default=0)
    bad = [name for name, x in given.items()
           if x.ndim != 1 or x.size not in (1, count) or not np.isfinite(x).all()]  # fmt: skip
    if not over:
        raise UsageError(
            Problem("kinematics.values", "over", "no coordinate is driven",
            "positions are computed from the values of driven coordinates",
                    'give a coordinate its values: over={"theta": [0.1, 0.2, "30 deg"]}')
        )  # fmt: skip
    if bad or not count:
        raise UsageError(
            Problem("kinematics.values", f"over {', '.join(bad)}",
                    "these are not lists of numbers of equal length",
                    "", "give as many finite numbers for each coordinate, or a single number to hold it "
                        "fixed")
        )  # fmt: skip
    return {name: np.broadcast_to(x, count) for name, x in given.items()}
