"""symbody: graph, sequence, machine code."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import reduce
from operator import add, mul
from typing import Final

import numpy as np

from benchmarks.engines.algebra import Compiled, Floats, Scalar
from symbody.codegen.llvm.native import NativeFunction, compile_sequence
from symbody.expr import calculus
from symbody.expr.expression import Expr, cos, number, sin, symbol
from symbody.expr.graph import Graph, Symbol
from symbody.expr.sequences.sequence import Input, Roots, build_sequence

Rows = list[list[Scalar]]

_GROUPS: Final = 6  # of inputs; all ours go into the one for coordinates
_POINTER: Final = ctypes.c_void_p
_LONG: Final = ctypes.c_int64
_ONE: Final = ctypes.CFUNCTYPE(ctypes.c_int, *[_POINTER] * (_GROUPS + 2))
_MANY: Final = ctypes.CFUNCTYPE(ctypes.c_int, _LONG, *[_POINTER, _LONG] * (_GROUPS + 1), _POINTER)


class Engine:
    """A new graph."""

    def __init__(self) -> None:
        self.graph = Graph()
        self.places: dict[int, Input] = {}

    def inputs(self, count: int) -> list[Scalar]:
        """Return the variables."""
        made = [symbol(self.graph, Symbol(f"x{k}")) for k in range(count)]
        self.places = {x.index: Input(f"x{k}", "q", k) for k, x in enumerate(made)}
        return list(made)

    def sin(self, x: Expr) -> Expr:
        """Return the sine."""
        return sin(x)

    def cos(self, x: Expr) -> Expr:
        """Return the cosine."""
        return cos(x)

    def matrix(self, rows: Sequence[Sequence[Scalar]]) -> Rows:
        """Return a matrix as a list of rows."""
        return [[self._expression(x) for x in row] for row in rows]

    def product(self, a: Rows, b: Rows) -> Rows:
        """Return the product of two matrices."""
        columns = list(zip(*b, strict=True))
        return [[_dot(row, column) for column in columns] for row in a]

    def rows(self, a: Rows) -> Rows:
        """Return the entries."""
        return a

    def jacobian(self, roots: Sequence[Scalar], by: Sequence[Scalar]) -> Rows:
        """Return the derivatives of `roots`, one row a root."""
        rows = calculus.jacobian(self.graph, self._nodes(roots), self._nodes(by))
        return [[Expr(self.graph, node) for node in row] for row in rows]

    def compile(self, outputs: Sequence[Scalar]) -> Compiled:
        """Return machine code."""
        nodes = tuple(self._nodes(outputs))
        sequence = build_sequence(self.graph, [Roots("all", (len(nodes),), nodes)], self.places)
        native = compile_sequence(sequence)
        size = (len(self.places), len(nodes))
        return Compiled(_one(native, *size), _many(native, *size), lambda: sequence.operation_count)

    def _nodes(self, values: Sequence[Scalar]) -> list[int]:
        return [self._expression(x).index for x in values]

    def _expression(self, value: Scalar) -> Expr:
        return value if isinstance(value, Expr) else number(self.graph, value)


def _dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    total: Expr = reduce(add, map(mul, a, b))
    return total


def _one(native: NativeFunction, inputs: int, outputs: int) -> Callable[[Floats], Floats]:
    function = _ONE(native.address)
    q, out, work = np.empty(inputs), np.empty(outputs), np.empty(native.work_size)
    at_q, at_out, at_work = q.ctypes.data, out.ctypes.data, work.ctypes.data

    def call(point: Floats, _alive: object = (native, work)) -> Floats:
        q[:] = point
        function(None, at_q, None, None, None, None, at_out, at_work)
        return out

    return call


def _many(native: NativeFunction, inputs: int, outputs: int) -> Callable[[Floats], Floats]:
    function = _MANY(native.batch_address)
    work = np.empty(native.work_size)
    unread = [None, 0] * (_GROUPS - 2)

    def call(points: Floats, _alive: object = native) -> Floats:
        out = np.empty((len(points), outputs))
        data = np.ascontiguousarray(points)
        groups = [None, 0, data.ctypes.data, inputs, *unread]
        function(len(points), *groups, out.ctypes.data, outputs, work.ctypes.data)
        return out

    return call
