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
    magnitude_program,
    negligible_rows,
    random_point,
)
from symbody.expr.sequences.sequence import Sequence
from symbody.single_flight import SingleFlight
from symbody.tolerances import TYPED

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
        self._points = [random_point(eqs.formed, {}, random) for _ in range(POINTS)]
        self._kept: dict[tuple[float | None, ...], tuple[bool, ...]] = {}
        self._native: SingleFlight[None, NativeCall] = SingleFlight()
        read = {entry.name for entry in self._program.inputs if entry.group == "p"}
        self._names = [symbol.name for symbol in eqs.formed.parameters]
        self._read = [name for name in self._names if name in read]

    def __call__(self, values: Mapping[str, float]) -> tuple[bool, ...]:
        """Return for each constraint whether it is only rounding with these values."""
        key = tuple([values.get(name) for name in self._read])
        rows = self._kept.get(key)
        if rows is None:
            few = not self._kept or self._program.operation_count > _MOST_OPERATIONS
            rows = self._interpret(values) if few else self._compute(values)
            if len(self._kept) < 2:  # the model's own values come again and again
                self._kept[key] = rows
        return rows

    def _interpret(self, values: Mapping[str, float]) -> tuple[bool, ...]:
        return tuple(negligible_rows(self._formed, values, self._program))

    def _compute(self, values: Mapping[str, float]) -> tuple[bool, ...]:
        native = self._native.get(None, lambda: NativeCall(self._program, quick=True, lanes=False))
        given = {group: np.array([point[group] for point in self._points]) for group in "tqr"}
        given["p"] = np.array([
            [values.get(name, usual) for name, usual in zip(self._names, point["p"], strict=True)]
            for point in self._points
        ])  # fmt: skip
        entries = native(given, (POINTS,))
        silent, start = [], 0
        for slopes, _ in zip(self._program.outputs[::2], self._program.outputs[1::2], strict=True):
            middle = start + len(slopes.values)
            end = middle + len(slopes.values)
            limits = TYPED * np.sqrt(np.maximum(entries[:, middle:end], 0.0))
            silent.append(bool((np.abs(entries[:, start:middle]) <= limits).all()))
            start = end
        return tuple(silent)
