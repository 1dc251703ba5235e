"""CasADi's SX: sparse matrices, Function with cse, called through buffers and mapped over points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, Final

import casadi
import numpy as np

from benchmarks.engines.algebra import Compiled, Floats, Matrix, Scalar

_FREE: Final = frozenset({casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST, casadi.OP_PARAMETER, casadi.OP_NEG})

Function = Any  # CasADi has no types


class Engine:
    """CasADi, which keeps nothing from run to run."""

    def __init__(self) -> None:
        self._inputs: Scalar = None

    def inputs(self, count: int) -> list[Scalar]:
        """Return the variables."""
        self._inputs = casadi.SX.sym("x", count)
        return [self._inputs[k] for k in range(count)]

    def sin(self, x: Scalar) -> Scalar:
        """Return the sine."""
        return casadi.sin(x)

    def cos(self, x: Scalar) -> Scalar:
        """Return the cosine."""
        return casadi.cos(x)

    def matrix(self, rows: Sequence[Sequence[Scalar]]) -> Matrix:
        """Return a matrix."""
        return casadi.vertcat(*[casadi.horzcat(*row) for row in rows])

    def product(self, a: Matrix, b: Matrix) -> Matrix:
        """Return the product of two matrices."""
        return casadi.mtimes(a, b)

    def rows(self, a: Matrix) -> list[list[Scalar]]:
        """Return the entries."""
        return [[a[i, j] for j in range(a.shape[1])] for i in range(a.shape[0])]

    def jacobian(self, roots: Sequence[Scalar], by: Sequence[Scalar]) -> Matrix:
        """Return the derivatives of `roots`, one row a root."""
        return casadi.jacobian(casadi.vertcat(*roots), casadi.vertcat(*by))

    def compile(self, outputs: Sequence[Scalar]) -> Compiled:
        """Return CasADi's interpreter of the expressions."""
        function = self.function(outputs)
        return compiled(function, function)

    def function(self, outputs: Sequence[Scalar]) -> Function:
        """Return the function from all inputs to `outputs`."""
        column = casadi.densify(casadi.SX(casadi.vertcat(*outputs)))
        return casadi.Function("f", [self._inputs], [column], {"cse": True})


def compiled(function: Function, counted: Function, *kept: object) -> Compiled:
    """Return `function`, called through buffers; `counted` holds its operations, `kept` has to live as long."""

    @cache
    def over(count: int) -> Callable[[Floats], Floats]:
        return _buffered(function.map(count), count)

    def many(points: Floats) -> Floats:
        return over(len(points))(points)

    one = _buffered(function, 1)

    def alone(point: Floats, _alive: object = kept) -> Floats:
        return one(point)[0]

    return Compiled(alone, many, lambda: _count(counted))


def _buffered(function: Function, count: int) -> Callable[[Floats], Floats]:
    """Return a call without conversions: CasADi reads columns, which are our rows."""
    buffer, trigger = function.buffer()
    given = np.empty((count, function.size1_in(0)))
    result = np.empty((count, function.size1_out(0)))
    buffer.set_arg(0, memoryview(given))
    buffer.set_res(0, memoryview(result))

    def call(points: Floats, _alive: object = buffer) -> Floats:
        given[:] = points
        trigger()
        return result

    return call


def _count(function: Function) -> int:
    return sum(function.instruction_id(k) not in _FREE for k in range(function.n_instructions()))
