"""Sizes of the states of signals, from the sizes of what goes into them.

A state of a filter, a delay or a controller is as large as its input makes it. Rates are read as
``s' = A s + B z``: A and B have the numbers of the model, z are coordinates, speeds and outputs, whose sizes
follow from their units. The size of a state is the most that A makes of B z at any frequency, within the time
of the mechanism. A rate that is not linear in the states leaves its size open, and so does an input, because
the model does not say how large it is. Bristles of friction are shares: their size is 1.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.dimensions import read_unit
from symbody.expr.language.formula import Formula
from symbody.model.numbers import as_float

Floats = NDArray[np.float64]

# Frequencies begin below one over the time of the mechanism and double up to the fastest rate.
_SLOWEST: Final = 0.125
_MOST_FREQUENCIES: Final = 64
_MOST_NUMBERS: Final = 1 << 20  # in memory at once
_NUMERIC: Final[Mapping[str, Callable[..., Any]]] = {
    "add": operator.add, "sub": operator.sub, "mul": operator.mul, "div": operator.truediv,
    "neg": operator.neg, "abs": operator.abs, "power": np.power, "sqrt": np.sqrt, "sign": np.sign,
    "min": np.minimum, "max": np.maximum, "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp,
    "log": np.log, "tanh": np.tanh,
}  # fmt: skip
_ONE: Final = ""  # stands where a name does, of what is constant
Number = float | Floats  # of one motion or of several
# A formula as far as it is linear: its derivatives by states and by what goes in.
_Term = dict[str, Number]


def signal_sizes(
    eqs: EquationSet, numbers: Mapping[str, Any], lengths: Floats, times: Floats, masses: Floats
) -> Floats:
    """Return the sizes of the states of signals (N, n_s), powers of two; nan where nothing decides them.

    Parameters
    ----------
    numbers : mapping of name to number, (N,) array or formula
        Values of parameters; those that are missing follow from the formulas of the model.
    lengths, times, masses : (N,) arrays
        As in `Scales`.
    """
    names = eqs.signal_state_names
    rates = {signal.name: signal.rate for signal in eqs.model.signals if signal.rate is not None}
    n, count = len(names), times.size
    # One motion is computed with plain numbers, which takes a fifth of the time.
    sizes = [values if count > 1 else float(values[0]) for values in (masses, lengths, times)]
    terms = _Terms(eqs, numbers, sizes)
    matrix, inflow = np.zeros((count, n, n)), np.zeros((count, n))
    with np.errstate(all="ignore"):
        for row, name in enumerate(names):
            term = terms.of_formula(rates[name])
            for column, other in enumerate(names):
                matrix[:, row, column] = term.pop(other, 0.0)
            inflow[:, row] = terms.size(term)
        is_open = ~np.isfinite(inflow) | ~np.isfinite(matrix).all(axis=2)
        matrix[is_open], inflow[is_open] = 0.0, 0.0
        found = _responses(matrix, inflow, is_open, times)
        driven = np.where((found > 0.0) & np.isfinite(found), np.exp2(np.ceil(np.log2(found))), math.nan)
    loads = (element for element in eqs.model.elements if element.kind not in ("signal", "block"))
    bristles = {signal.name for element in loads for signal in element.signals}
    driven[:, [name in bristles for name in names]] = 1.0
    return driven


def _responses(matrix: Floats, inflow: Floats, is_open: NDArray[np.bool_], times: Floats) -> Floats:
    """Return the largest response of each state (N, n), nan where an open one reaches it."""
    count, n = inflow.shape
    fastest = np.abs(matrix).sum(axis=2).max(axis=1, initial=0.0) * times
    octaves = min(
        math.ceil(math.log2(max(float(fastest.max(initial=0.0)), 1.0) / _SLOWEST)) + 1, _MOST_FREQUENCIES
    )
    frequencies = _SLOWEST * 2.0 ** np.arange(octaves)
    sizes = np.zeros((count, n))
    block = max(_MOST_NUMBERS // (octaves * n * n), 1)
    for first in range(0, count, block):
        part = slice(first, first + block)
        scaled = matrix[part] * times[part, np.newaxis, np.newaxis]
        # beyond the fastest rate of a case responses fall: there the slowest frequency stands once more
        beyond = frequencies > 2.0 * np.maximum(fastest[part, np.newaxis], 1.0)
        s = 1.0 + 1j * np.where(beyond, _SLOWEST, frequencies)
        try:
            inverse = np.linalg.inv(s[:, :, np.newaxis, np.newaxis] * np.eye(n) - scaled[:, np.newaxis])
        except np.linalg.LinAlgError:  # a growing oscillation of just that rate
            sizes[part] = math.nan
            continue
        gains = np.abs(inverse)
        driven = (inflow[part] * times[part, np.newaxis])[:, np.newaxis, :, np.newaxis]
        reached = (gains @ is_open[part].astype(np.float64)[:, np.newaxis, :, np.newaxis]).max(axis=1)[
            :, :, 0
        ]
        sizes[part] = np.where(reached > 0.0, math.nan, (gains @ driven).max(axis=1)[:, :, 0])
    return sizes


class _Terms:
    """Terms of formulas and names of a model."""

    def __init__(self, eqs: EquationSet, numbers: Mapping[str, Any], sizes: Sequence[Number]) -> None:
        self._eqs, self._numbers, self._units = eqs, numbers, sizes
        self._signals = {signal.name: signal for signal in (*eqs.model.signals, *eqs.model.held_signals)}
        self._known: dict[str, _Term] = {}
        # Sizes of what goes in; nan of an input, as large as what it is added to, inf of what is open.
        self._sizes: dict[str, Number] = {_ONE: 1.0}

    def size(self, term: _Term) -> Number:
        """Return the size of a sum without states; what is open in it is taken to be as large as the rest."""
        total: Number = 0.0
        for name, slope in term.items():
            part = np.abs(slope) * self._sizes[name]
            total = total + np.where(np.isnan(self._sizes[name]), 0.0, part)
        is_open = any(np.any(np.isnan(self._sizes[name])) for name in term)
        return np.where(total > 0.0, total, math.nan) if is_open else total

    def of_formula(self, formula: Formula) -> _Term:
        """Return the term of a formula, which may be changed."""
        stack: list[_Term] = []
        for step in formula.program:
            if step.kind == "apply":
                operands = stack[-step.arity :]
                del stack[-step.arity :]
                try:
                    stack.append(self._apply(str(step.payload), operands))
                except ArithmeticError:  # a division by 0
                    stack.append(self._source(math.inf))
            elif isinstance(step.payload, str):
                stack.append(dict(self._term_of(step.payload)))
            else:
                stack.append({_ONE: as_float(step.payload)})
        return stack[0]

    def _term_of(self, name: str) -> _Term:
        if name not in self._known:
            self._known[name] = self._source(math.nan)  # what a held value finds that reads itself
            self._known[name] = self._find(name)
        return self._known[name]

    def _find(self, name: str) -> _Term:
        signal, model = self._signals.get(name), self._eqs.model
        if signal is not None and signal.rate is not None:
            return {name: 1.0}
        if signal is not None:
            return (
                self._of_unit(signal.output or "") if signal.value is None else self.of_formula(signal.value)
            )
        value = self._numbers.get(name, model.parameters.get(name, math.pi if name == "pi" else None))
        if value is not None:
            return self.of_formula(value) if isinstance(value, Formula) else {_ONE: value}
        return self._source(math.nan) if name in model.inputs else self._of_unit(name)

    def _of_unit(self, name: str) -> _Term:
        unit = self._eqs.units.get(name, "" if name in self._eqs.coordinate_names else None)
        dimension = None if unit is None else read_unit(unit)
        if dimension is None:
            return self._source(math.inf)
        size: Number = 1.0
        exponents = dimension.kg, dimension.m, dimension.s
        for base, exponent in zip(self._units, exponents, strict=True):
            size = size * base ** float(exponent)
        return self._source(size)

    def _source(self, size: Number) -> _Term:
        name = f" {len(self._sizes)}"  # no symbol begins with a blank
        self._sizes[name] = size
        return {name: 1.0}

    def _apply(self, name: str, operands: list[_Term]) -> _Term:
        first, last = operands[0], operands[-1]
        numbers = [operand.keys() == {_ONE} for operand in operands]
        if all(numbers) and name in _NUMERIC:
            return {_ONE: _NUMERIC[name](*(operand[_ONE] for operand in operands))}
        if name in ("add", "sub"):
            return _add(first, last if name == "add" else _scale(last, -1.0))
        if name == "neg":
            return _scale(first, -1.0)
        if name in ("mul", "div") and numbers[-1]:
            return _scale(first, last[_ONE] if name == "mul" else 1.0 / last[_ONE])
        if name == "mul" and numbers[0]:
            return _scale(last, first[_ONE])
        if name == "if":
            operands = operands[1:]
        has_state = [not term.keys() <= self._sizes.keys() for term in operands]
        if name in ("min", "max", "if") and sum(has_state) == 1:
            return operands[has_state.index(True)]  # where no limit is reached
        if any(has_state):
            return self._source(math.inf)
        sizes = [self.size(term) for term in operands]
        return self._source(_size_of_function(name, sizes, last.get(_ONE) if numbers[-1] else None))


def _scale(term: _Term, factor: Number) -> _Term:
    return {name: slope * factor for name, slope in term.items()}


def _add(a: _Term, b: _Term) -> _Term:
    total = dict(a)
    for name, slope in b.items():
        total[name] = total[name] + slope if name in total else slope
    return total


def _size_of_function(name: str, sizes: list[Number], exponent: Number | None) -> Number:
    """Return the size of a function of what contains no state; inf of one that may be of any size."""
    first, last = sizes[0], sizes[-1]
    if name in ("mul", "div"):
        return first * last if name == "mul" else first / last
    if name in ("abs", "sqrt"):
        return first if name == "abs" else np.sqrt(first)
    if name == "power" and exponent is not None:
        return np.power(first, exponent)
    if name in ("min", "max", "if"):  # the smallest, for the greatest may be a limit that is never reached
        sizes = [np.where(np.greater(size, 0.0), size, math.nan) for size in sizes]
        return np.asarray(np.fmin.reduce(np.broadcast_arrays(*sizes)))
    if name in ("sin", "tanh", "atan", "asin"):
        return np.fmin(first, 1.0)
    return 1.0 if name in ("cos", "sign", "atan2", "smoothstep") else math.inf
