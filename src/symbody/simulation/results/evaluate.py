"""Outputs of a motion that are not stored: by equations that may change on the way, by turns, by formulas."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.codegen.signature import Signature
from symbody.equations.outputs.output_roots import OF_MOTIONS
from symbody.errors import ExpressionError, Problem, UsageError
from symbody.expr.graph import TIME, Graph, Symbol, SymbolKind
from symbody.expr.language.formula import Formula, build
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.simulation.native.dense_output import DenseOutput

Floats = NDArray[np.float64]
Evaluate = Callable[[str, Floats, Floats, Floats], Floats]  # of a name, t, q and u; see `OutputEvaluator`


class OutputEvaluator(ABC):
    """Computes outputs that are not stored; several by one function, which is compiled once."""

    __slots__ = ()

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Angles of cut joints, which are given within half a turn."""
        return ()

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last, from t (N,), q (n_q, N) and u (n_u, N)."""
        return self.together((name,), t, q, u)[0]

    @abstractmethod
    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return the outputs with time last."""


@dataclass(frozen=True, slots=True, eq=False)
class Piecewise(OutputEvaluator):
    """Computes outputs by the equations that hold at each time.

    Attributes
    ----------
    starts : (parts,) array
        When each part begins [s].
    parts : tuple of callable
        What computes in each.
    work : (parts,) array
        Done before each [J].
    """

    starts: Floats
    parts: tuple[OutputEvaluator, ...]
    work: Floats

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Angles of cut joints, which are given within half a turn."""
        return self.parts[0].wrapped_angles if self.parts else ()

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last; of two samples at a change the first is of the part before."""
        way = -1.0 if self.starts[-1] < self.starts[0] else 1.0
        starts, along = way * self.starts, way * t
        place = np.maximum(np.searchsorted(starts, along, side="right") - 1, 0)
        before = np.flatnonzero((t[:-1] == t[1:]) & np.isin(t[:-1], self.starts[1:]))
        place[before] = np.maximum(np.searchsorted(starts, along[before], side="left") - 1, 0)
        whole: dict[str, Floats] = {}
        for k in np.unique(place):
            inside = place == k
            computed = self.parts[k].together(names, t[inside], q[:, inside], u[:, inside])
            for name, values in zip(names, computed, strict=True):
                shape = values.shape[:-1]
                array = whole.setdefault(name, np.empty((*shape, t.size)))
                array[..., inside] = values + self.work[k] if name == "work" else values
        return [whole.get(name, np.empty((0,))) for name in names]


# Points within a step: between two of them the angle and its rate change little, however long the step is.
_INSIDE: Final = 16


def count_turns(
    evaluate: Evaluate, name: str, values: Floats, t: Floats, positions: Floats, speeds: Floats,
    dense: DenseOutput | None = None,
) -> Floats:  # fmt: skip
    """Return the values of an output; the angle of a cut joint goes on from turn to turn.

    Raises UsageError if the angle turns by more than half a turn between two samples, which then do not tell
    by how much.

    Parameters
    ----------
    dense : DenseOutput, optional
        The motion, by which turns are counted from its start; else they are counted from sample to sample.
    """
    symbol = name[1:-1] if name.startswith("(") and name.endswith(")") else name
    if symbol not in getattr(evaluate, "wrapped_angles", ()):
        return values
    angle = evaluate(f"({symbol})", t, positions, speeds)
    if angle.shape != values.shape or not np.array_equal(angle, values, equal_nan=True):
        return values  # a word of outputs, such as "B", that an angle has for a name
    if dense is not None:
        return _turns_along(evaluate, symbol, values, t, dense, len(speeds))
    if t.size < 2:
        return values
    rates = evaluate(f"{symbol}_dot", t, positions, speeds)
    if (np.maximum(np.abs(rates[1:]), np.abs(rates[:-1])) * np.abs(np.diff(t)) > np.pi).any():
        raise UsageError(
            Problem("trajectory.turns", repr(name), f"{name} turns by more than half a turn between samples",
                    "the joint is cut: its angle is measured within half a turn, and counted from sample to "
                    "sample", "request more times, or use `simulate`, whose motion is also known between "
                              "samples")
        )  # fmt: skip
    return _count(values, rates, t)


def _turns_along(
    evaluate: Evaluate, name: str, values: Floats, t: Floats, dense: DenseOutput, n_u: int
) -> Floats:
    """Return a measured angle counted from the start of the motion, whatever its samples are."""
    shares = np.arange(_INSIDE) / _INSIDE
    starts, lengths = dense.breaks[:-1, np.newaxis], np.diff(dense.breaks)[:, np.newaxis]
    times = np.append(starts + shares * lengths, dense.breaks[-1])
    x = dense(times)
    between, rates = (evaluate(each, times, x[n_u:], x[:n_u]) for each in (f"({name})", f"{name}_dot"))
    way = 1.0 if times[-1] >= times[0] else -1.0
    near = np.interp(way * t, way * times, _count(between, rates, times))
    return np.asarray(values + _turns(near - values))


def _count(values: Floats, rates: Floats, t: Floats) -> Floats:
    """Return values to which whole turns are added, so that they change as their rates say."""
    steps = np.diff(values)
    expected = 0.5 * np.diff(t) * (rates[1:] + rates[:-1])
    expected = np.where(np.isfinite(expected), expected, 0.0)  # where the angles themselves are singular
    return np.append(values[:1], values[0] + np.cumsum(steps + _turns(expected - steps)))


def _turns(angle: Floats) -> Floats:
    return np.asarray(2.0 * np.pi * np.round(angle / (2.0 * np.pi)))


def formula_of_samples(text: str, stored: Collection[str]) -> Formula | None:
    """Return a formula that has to be computed from samples: in quotes it reads work, or what is stored."""
    if "'" not in text:
        return None
    try:
        formula = Formula.from_value(text, has_outputs=True)
    except ExpressionError:  # the equations say what is wrong with it
        return None
    read = {*formula.outputs}
    return formula if read & {*OF_MOTIONS} or (read and read <= {*stored}) else None


def evaluate_samples(
    formula: Formula, values: Callable[[str], Floats], t: Floats, shape: tuple[int, ...]
) -> Floats:
    """Return a formula's value at each sample.

    Raises UsageError if what it reads is not a number at each sample.

    Parameters
    ----------
    values : callable
        Takes a name or an output, returns its samples.
    t : array
        Times, the last axis of the result.
    shape : tuple of int
        Of the result, to which all samples are broadcast.
    """
    graph, columns = Graph(), dict[str, Floats]()

    def look_up(name: str, column: int) -> int:
        if name == "pi":
            return graph.pi()
        columns[name] = np.asarray(t if name == "t" else values(name), dtype=np.float64)
        if not _fits(columns[name].shape, shape):
            raise _not_a_number(formula, name, columns[name])
        return graph.symbol(Symbol(name, SymbolKind.INPUT))

    node = build(formula, graph, look_up)
    names = tuple(columns)
    places = {
        graph.symbol(Symbol(name, SymbolKind.INPUT)): Input(name, "r", k) for k, name in enumerate(names)
    }
    places[graph.symbol(TIME)] = Input("t", "t", 0)
    sequence = build_sequence(graph, [Roots("formula", (), (node,))], places)
    function = CompiledFunction(sequence, Signature((), (), names, ()), quick=True)
    r = np.stack([np.broadcast_to(column, shape) for column in columns.values()], axis=-1)
    nothing = np.zeros((*shape, 0))
    found: Floats = np.asarray(function(np.broadcast_to(t, shape), nothing, nothing, r), dtype=np.float64)
    return found


def _fits(inner: tuple[int, ...], outer: tuple[int, ...]) -> bool:
    sizes = zip(reversed(inner), reversed(outer), strict=False)
    return len(inner) <= len(outer) and all(size in (1, whole) for size, whole in sizes)


def _not_a_number(formula: Formula, name: str, values: Floats) -> UsageError:
    what = f"{name!r} is not a number: its samples have shape {values.shape}"
    fix = "name one component, such as 'reaction A Fx'"
    return UsageError(Problem("trajectory.formula", formula.text, what, fix=fix))
