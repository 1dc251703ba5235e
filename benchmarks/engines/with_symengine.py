"""SymEngine: matrices, and Lambdify with LLVM and cse, for arrays of one or many points."""

from __future__ import annotations

from collections.abc import Sequence

import symengine

from benchmarks.engines.algebra import Compiled, Floats, Matrix, Scalar
from benchmarks.engines.counting import count_operations


class Engine:
    """SymEngine, which keeps nothing from run to run."""

    def __init__(self) -> None:
        self._inputs: list[Scalar] = []

    def inputs(self, count: int) -> list[Scalar]:
        """Return the variables."""
        self._inputs = list(symengine.symbols(f"x:{count}"))
        return self._inputs

    def sin(self, x: Scalar) -> Scalar:
        """Return the sine."""
        return symengine.sin(x)

    def cos(self, x: Scalar) -> Scalar:
        """Return the cosine."""
        return symengine.cos(x)

    def matrix(self, rows: Sequence[Sequence[Scalar]]) -> Matrix:
        """Return a matrix."""
        return symengine.DenseMatrix([list(row) for row in rows])

    def product(self, a: Matrix, b: Matrix) -> Matrix:
        """Return the product of two matrices."""
        return a * b

    def rows(self, a: Matrix) -> list[list[Scalar]]:
        """Return the entries."""
        return [list(row) for row in a.tolist()]

    def jacobian(self, roots: Sequence[Scalar], by: Sequence[Scalar]) -> Matrix:
        """Return the derivatives of `roots`, one row a root."""
        column = symengine.DenseMatrix([[x] for x in roots])
        return column.jacobian(symengine.DenseMatrix([[x] for x in by]))

    def compile(self, outputs: Sequence[Scalar]) -> Compiled:
        """Return machine code, by LLVM where this build of SymEngine has it."""
        backend = "llvm" if symengine.have_llvm else "lambda"
        function = symengine.Lambdify(self._inputs, list(outputs), backend=backend, cse=True)

        def call(points: Floats) -> Floats:
            values: Floats = function(points)
            return values

        def count() -> int:
            shared, reduced = symengine.cse([symengine.S(x) for x in outputs])
            return count_operations([*(value for _, value in shared), *reduced])

        return Compiled(call, call, count)
