"""`pack`: the array of a record."""

from __future__ import annotations

from collections.abc import Mapping
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

    Raises
    ------
    ValueError
        More reals than a field has room for.
    """
    numbers: list[tuple[int, float]] = []
    arrays: list[tuple[int, Floats]] = []
    inner, end = _place_in_line(kind, values, numbers, arrays)
    for field in kind.pointers:
        given = values.get(field.name)
        if given is None:
            size = _count(field, values) * field.entry_size
        else:
            array = np.asarray(given, dtype=np.float64).ravel()
            arrays.append((end, array))
            size = array.size
        if size or field.sizes:
            numbers.append((field.place, end))
            end = kind.round_up(end + size)
    block = np.zeros(end)
    for begin, array in arrays:
        block[begin : begin + array.size] = array
    for place, number in numbers:
        block[place] = number
    for field, begin in inner:
        for place in field.kind.stores:
            if block[field.place + place] != 0.0:
                block[field.place + place] += begin - field.place - field.size
    return block


def _place_in_line(
    kind: type[RecordLayout],
    values: Mapping[str, Any],
    numbers: list[tuple[int, float]],
    arrays: list[tuple[int, Floats]],
) -> tuple[list[tuple[RecordField, int]], int]:
    """Place numbers, and arrays and records in line; return where what these store begins, and the end."""
    inner: list[tuple[RecordField, int]] = []
    end = kind.round_up(kind.size)
    for name, value in values.items():
        field = kind.fields[name]
        if field.pointer is not None:
            continue
        if not (field.is_record or field.inline):
            numbers.append((field.place, value))
            continue
        entries = np.asarray(value, dtype=np.float64).ravel()
        arrays.append((field.place, entries[: field.size]))
        if field.is_record:  # what it stores lies behind the whole record
            inner.append((field, end))
            arrays.append((end, entries[field.size :]))
            end = kind.round_up(end + entries.size - field.size)
        elif entries.size > field.size:
            raise ValueError(f"{name} has room for {field.size} reals, not for {entries.size}")
    return inner, end


def _count(field: RecordField, values: Mapping[str, Any]) -> int:
    """Return how many reals or records a field points to, by the values of the fields that say so."""
    count = int(bool(field.sizes))
    for factor in field.sizes:
        count *= int(values.get(factor, 0)) if isinstance(factor, str) else factor
    return count
