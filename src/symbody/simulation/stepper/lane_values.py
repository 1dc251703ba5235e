"""Values of many motions: for all lanes or for each, and what saves them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.codegen.formation.names import Value
from symbody.errors import Problem, SymbodyError, UsageError
from symbody.model.first_values import FirstValue
from symbody.simulation.stepper.numbers import unknown_name
from symbody.simulation.stepper.saved_stepper import not_saved, other_kind

Floats = NDArray[np.float64]
LaneValue = Value | Sequence[Value] | NDArray[np.float64]
FirstLaneValue = LaneValue | FirstValue | Sequence[FirstValue]

_FORMAT: Final = b"symbody lanes 1\n"
_SIZE: Final = 8  # bytes that say how long the next part is


def values_by_lane(what: str, values: Mapping[str, Any] | None, lanes: int) -> list[dict[str, Any]]:
    """Return the values of each lane; raises UsageError if there are neither one nor as many as lanes."""
    by_lane: list[dict[str, Any]] = [{} for _ in range(lanes)]
    if values is not None and not isinstance(values, Mapping):
        values = dict.fromkeys(("",), values)  # refused with the words of a single stepper
    for name, value in (values or {}).items():
        is_each = isinstance(value, list | tuple | np.ndarray) and np.ndim(value) > 0
        each = list(value) if is_each else [value] * lanes
        if len(each) != lanes:
            raise _wrong_count(f"{what}: {name}", f"{len(each)} values", lanes)
        for own, single in zip(by_lane, each, strict=True):
            own[name] = float(single) if isinstance(single, np.number) else single
    return by_lane


def input_columns(
    values: ArrayLike | None, named: Mapping[str, ArrayLike], places: Mapping[str, int], lanes: int
) -> list[tuple[int, Floats]]:
    """Return inputs by their places among the numbers, each (N,) or one for all.

    Raises UsageError with every name that is unknown, and every value that is no finite number or does not
    fit the lanes.
    """
    problems, columns = [], []
    if values is not None:
        table = _numbers("step", values, ((lanes, len(places)),))
        columns += list(zip(places.values(), table.T, strict=True))
    for name, value in named.items():
        if name not in places:
            problems.append(
                unknown_name("input", name, places, "step() accepts inputs without a formula only")
            )
            continue
        columns.append((places[name], _numbers(name, value, ((lanes,), ()))))
    if problems:
        raise UsageError(*problems)
    return columns


def in_lane(place: int, error: SymbodyError) -> SymbodyError:
    """Return the first problem of an error as one of a lane."""
    first = error.problems[0]
    return type(error)(replace(first, where=f"lane {place}, {first.where}"))


def chosen_lanes(only: ArrayLike | None, lanes: int) -> tuple[int, ...]:
    """Return the lanes that a caller means; raises UsageError if these are no lanes."""
    if only is None:
        return tuple(range(lanes))
    try:
        array = np.atleast_1d(np.asarray(only))
    except ValueError:  # lists of several lengths
        raise _no_lanes(only, lanes) from None
    if array.dtype == np.bool_ and array.shape == (lanes,):
        return tuple(np.flatnonzero(array).tolist())
    is_fit = array.ndim == 1 and (array.dtype.kind in "iu" or not array.size)
    if not is_fit or (array < -lanes).any() or (array >= lanes).any():
        raise _no_lanes(only, lanes)
    return tuple(dict.fromkeys(int(place) % lanes for place in array))


def chosen_lane(number: ArrayLike, lanes: int) -> int:
    """Return the one lane that a caller means; raises UsageError if this is no lane, or several."""
    if not isinstance(number, int | np.integer):
        raise UsageError(
            Problem("stepper.lanes", "lanes", f"{number!r} is not a lane",
            f"there are {lanes} lanes, counted from 0",
                    f"give a number below {lanes}")
        )  # fmt: skip
    (place,) = chosen_lanes(number, lanes)
    return place


def join_saved(parts: Sequence[bytes]) -> bytes:
    """Return what single steppers have saved as one."""
    return _FORMAT + b"".join(len(part).to_bytes(_SIZE, "little") + part for part in parts)


def split_saved(saved: bytes, lanes: int) -> list[bytes]:
    """Return the parts that `join_saved` put together.

    Raises UsageError if the bytes are not whole, or those of another number of lanes.
    """
    if not saved.startswith(_FORMAT):
        raise not_saved("these bytes do not come from save() of this version")
    parts = list(_parts(saved[len(_FORMAT) :]))
    if len(parts) != lanes:
        raise other_kind()
    return parts


def _parts(content: bytes) -> Iterator[bytes]:
    while content:
        end = _SIZE + int.from_bytes(content[:_SIZE], "little")
        if len(content) < end:
            raise not_saved("the bytes were cut or changed")
        yield content[_SIZE:end]
        content = content[end:]


def _numbers(name: str, value: ArrayLike, shapes: Sequence[tuple[int, ...]]) -> Floats:
    """Return finite numbers in one of some shapes, the first of which has the lanes first."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(shapes[0], np.nan)
    if array.shape not in shapes:
        raise _wrong_count(name, f"an array of shape {array.shape}", shapes[0][0], shapes[0])
    if not np.isfinite(array).all():
        raise UsageError(
            Problem("stepper.input_value", name, f"{name} is not finite in every lane", "",
                    f"give finite numbers, as step({name}=values)")
        )  # fmt: skip
    return array


def _no_lanes(only: ArrayLike, lanes: int) -> UsageError:
    return UsageError(
        Problem("stepper.lanes", "lanes", f"{only!r} is not a choice of lanes",
        f"there are {lanes} lanes, counted from 0",
                f"give numbers below {lanes}, or an array of {lanes} times True or False")
    )  # fmt: skip


def _wrong_count(where: str, what: str, lanes: int, shape: tuple[int, ...] = ()) -> UsageError:
    fits = f"an array of shape {shape}" if len(shape) > 1 else f"one value, or {lanes}"
    return UsageError(
        Problem("stepper.lane_values", where, f"{lanes} lanes do not accept {what}", "", f"give {fits}")
    )
