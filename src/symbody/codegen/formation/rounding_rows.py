"""Which constraints are only rounding, for one set of values of the parameters after the other."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from random import Random
from typing import Final

import numpy as np

from symbody.codegen.native_call import NativeCall
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.negligible_constraints import (
    POINTS,
    SEED,
    is_rounding,
    magnitude_program,
    negligible_rows,
    random_point,
)
from symbody.expr.sequences.sequence import Sequence
from symbody.single_flight import SingleFlight

# Operations up to which it pays to compile what is done anew for each set of values.
_MOST_OPERATIONS: Final = 20_000


class RoundingRows:
    """``rows(values)`` gives for each constraint whether it is 0 up to rounding.

    The first set of values is looked at without compiling anything; most equations have one.

    Parameters
    ----------
    eqs : EquationSet
        Equations with constraints.
    """

    def __init__(self, eqs: EquationSet) -> None:
        self._formed = eqs.formed
        self._program: Sequence = eqs.plans.get("noise program", partial(magnitude_program, eqs.formed))
        random = Random(SEED)
        self._points = [
            {group: np.array(numbers) for group, numbers in random_point(eqs.formed, {}, random).items()}
            for _ in range(POINTS)
        ]
        self._kept: dict[tuple[float | None, ...], tuple[bool, ...]] = {}
        self._native: SingleFlight[None, NativeCall] = SingleFlight()
        self._is_large = self._program.operation_count > _MOST_OPERATIONS
        read = {entry.name for entry in self._program.inputs if entry.group == "p"}
        names = [symbol.name for symbol in eqs.formed.parameters]
        self._read = [name for name in names if name in read]
        self._places = {name: place for place, name in enumerate(names)}
        sizes = [len(output.values) for output in self._program.outputs]
        ends = np.cumsum([0, *sizes]).tolist()
        # Of each constraint: where its slopes begin, then their squares, and where these end.
        self._parts = list(zip(ends[::2], ends[1::2], ends[2::2], strict=False))

    def __call__(self, values: Mapping[str, float]) -> tuple[bool, ...]:
        """Return for each constraint whether it is only rounding with these values."""
        key = tuple([values.get(name) for name in self._read])
        rows = self._kept.get(key)
        if rows is None:
            few = not self._kept or self._is_large
            rows = self._interpret(values) if few else self._compute(values)
            if len(self._kept) < 2:  # the model's own values come again and again
                self._kept[key] = rows
        return rows

    def _interpret(self, values: Mapping[str, float]) -> tuple[bool, ...]:
        return tuple(negligible_rows(self._formed, values, self._program))

    def _compute(self, values: Mapping[str, float]) -> tuple[bool, ...]:
        native = self._native.get(None, lambda: NativeCall(self._program, quick=True, lanes=False))
        left = [True] * len(self._parts)
        for point in self._points:
            p = point["p"].copy()
            for name, place in self._places.items():
                if name in values:
                    p[place] = values[name]
            entries = native.at_point(**{**point, "p": p}).tolist()
            for k, (start, middle, end) in enumerate(self._parts):
                left[k] = left[k] and is_rounding(entries[start:middle], entries[middle:end])
            if not any(left):
                break
        return tuple(left)
