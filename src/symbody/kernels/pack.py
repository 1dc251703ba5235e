"""`pack`: the array of a record."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.record_layout import RecordField, RecordLayout

Floats = NDArray[np.float64]


def pack(kind: type[RecordLayout], **values: Any) -> Floats:
    """Return the array of a record: its numbers, then what its fields store.

    Parameters
    ----------
    **values : numbers and arrays
        Of fields by their names. What is not given is zero, and a single record that is not given is nowhere.
        A record in line is the array that `pack` returns for it.
    """
    numbers, inner = _in_line(kind, values)
    record, end = kind(numbers), kind.round_up(kind.size)
    arrays: list[tuple[int, Floats]] = []
    for field, rest in inner:  # what it stores lies behind the whole record
        for place in _pointer_places(field.kind, field.place):
            numbers[place] += (numbers[place] != 0.0) * (end - field.place - field.size)
        arrays.append((end, rest))
        end = kind.round_up(end + rest.size)
    for field in kind.pointers:
        given = values.get(field.name)
        array = None if given is None else np.asarray(given, dtype=np.float64)
        size = field.count(record) * field.entry_size if array is None else array.size
        if size or field.sizes:
            numbers[field.place] = end
        if array is not None and size:
            arrays.append((end, array.ravel()))
        end = kind.round_up(end + size)
    block = np.zeros(end)
    block[: kind.size] = numbers
    for begin, array in arrays:
        block[begin : begin + array.size] = array
    return block


def _in_line(
    kind: type[RecordLayout], values: dict[str, Any]
) -> tuple[list[float], list[tuple[RecordField, Floats]]]:
    """Return the numbers of a record, and what records in line with it store, each with its field.

    Raises
    ------
    ValueError
        More reals than a field has room for.
    """
    numbers = [0.0] * kind.size
    inner: list[tuple[RecordField, Floats]] = []
    for name, value in values.items():
        field = kind.fields[name]
        if field.pointer is not None:
            continue
        if not (field.is_record or field.inline):
            numbers[field.place] = float(value)
            continue
        entries = np.asarray(value, dtype=np.float64).ravel()
        own = entries[: field.size]
        numbers[field.place : field.place + own.size] = own.tolist()
        if field.is_record:
            inner.append((field, entries[field.size :]))
        elif entries.size > field.size:
            raise ValueError(f"{name} has room for {field.size} reals, not for {entries.size}")
    return numbers, inner


def _pointer_places(kind: type[RecordLayout], begin: int) -> list[int]:
    """Return where a record that begins somewhere, and those in line with it, keep where something lies."""
    places: list[int] = []
    for field in kind.fields.values():
        if field.pointer is not None:
            places.append(begin + field.place)
        elif field.is_record:
            places += _pointer_places(field.kind, begin + field.place)
    return places
