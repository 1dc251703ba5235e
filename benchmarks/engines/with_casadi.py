"""CasADi's SX: sparse matrices, Function with cse, called through buffers and mapped over points.

The function runs in CasADi's interpreter, or as the C that CasADi writes.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Final

import casadi
import numpy as np

from benchmarks.engines.algebra import Compiled, Floats, Matrix, Scalar

_FREE: Final = frozenset(
    {casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST, casadi.OP_PARAMETER, casadi.OP_NEG}
)

Function = Any  # CasADi has no types


def interpreted() -> Engine:
    """Return CasADi with its interpreter."""
    return Engine(lambda function: function)


def through_c() -> Engine:
    """Return CasADi with the machine's C compiler."""
    return Engine(_through_c)


class Engine:
    """CasADi, which keeps nothing from run to run.

    Parameters
    ----------
    finish : callable
        Makes of a Function what is to be called.
    """

    def __init__(self, finish: Callable[[Function], Function]) -> None:
        self._finish = finish
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
        """Return the function from all inputs to `outputs`."""
        column = casadi.densify(casadi.SX(casadi.vertcat(*outputs)))
        function = casadi.Function("f", [self._inputs], [column], {"cse": True})
        finished = self._finish(function)
        one = _buffered(finished, 1)

        @cache
        def over(count: int) -> Callable[[Floats], Floats]:
            return _buffered(finished.map(count), count)

        return Compiled(
            lambda point: one(point)[0], lambda points: over(len(points))(points), lambda: _count(function)
        )


def _through_c(function: Function) -> Function:
    compiler = shutil.which("cc")
    if compiler is None:
        raise FileNotFoundError("there is no C compiler named cc")
    folder = Path(mkdtemp())  # in the folder of this process, which goes with it
    generator = casadi.CodeGenerator("f.c")
    generator.add(function)
    generator.generate(f"{folder}/")
    source, library = folder / "f.c", folder / "f.so"
    options = ["-O3", "-march=native", "-shared", "-fPIC"]
    subprocess.run([compiler, *options, str(source), "-o", str(library), "-lm"], check=True)
    return casadi.external("f", str(library))


def _buffered(function: Function, count: int) -> Callable[[Floats], Floats]:
    """Return a call without conversions: CasADi reads columns, which are our rows."""
    buffer, trigger = function.buffer()
    given = np.empty((count, function.size1_in(0)))
    result = np.empty((count, function.size1_out(0)))
    buffer.set_arg(0, given.data)
    buffer.set_res(0, result.data)

    def call(points: Floats, _alive: object = buffer) -> Floats:
        given[:] = points
        trigger()
        return result

    return call


def _count(function: Function) -> int:
    return sum(function.instruction_id(k) not in _FREE for k in range(function.n_instructions()))
