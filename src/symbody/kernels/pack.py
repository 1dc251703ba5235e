"""`pack`: the array of a record."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.kernels.record import Record

Floats = NDArray[np.float64]


def pack(kind: type[Record], **values: ArrayLike) -> Floats:
    """Return the array of a record: its numbers, then what its fields store.

    Parameters
    ----------
    **values : numbers and arrays
        Of fields by their names. What is not given is zero, and a single record that is not given is nowhere.
    """
    head, parts = np.zeros(kind.size), list[Floats]()
    for name, value in values.items():
        if kind.fields[name].stored is None:
            head[kind.fields[name].place] = value
    record, end = kind(head), kind.size
    for name, field in kind.fields.items():
        if field.stored is not None:
            part = np.ravel(values.get(name, np.zeros(field.count(record) * field.entry_size)))
            if part.size or field.stored.factors:
                head[field.place] = end
            parts.append(part)
            end += part.size
    return np.concatenate([head, *parts])
