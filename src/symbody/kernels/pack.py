"""`pack`: the array of a record."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.record_layout import RecordLayout

Floats = NDArray[np.float64]


def pack(kind: type[RecordLayout], **values: Any) -> Floats:
    """Return the array of a record: its numbers, then what its fields store.

    Parameters
    ----------
    **values : numbers and arrays
        Of fields by their names. What is not given is zero, and a single record that is not given is nowhere.
    """
    numbers = [0.0] * kind.size
    for name, value in values.items():
        field = kind.fields[name]
        if field.pointer is None:
            numbers[field.place] = float(value)
    record, end = kind(numbers), kind.size
    arrays: list[tuple[int, Floats]] = []
    for field in kind.pointers:
        given = values.get(field.name)
        array = None if given is None else np.asarray(given, dtype=np.float64)
        size = field.count(record) * field.entry_size if array is None else array.size
        if size or field.sizes:
            numbers[field.place] = end
        if array is not None and size:
            arrays.append((end, array.ravel()))
        end += size
    block = np.zeros(end)
    block[: kind.size] = numbers
    for begin, array in arrays:
        block[begin : begin + array.size] = array
    return block
