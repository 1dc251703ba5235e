"""SymPy: matrices, `cse`, and lambdify with the cse found once; `math` for one point, NumPy for many."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import sympy
from sympy.core.cache import clear_cache

from benchmarks.engines.algebra import Compiled, Floats, Matrix, Scalar
from benchmarks.engines.counting import count_operations


class Engine:
    """SymPy with an empty cache."""

    def __init__(self) -> None:
        clear_cache()
        self._inputs: list[Scalar] = []

    def inputs(self, count: int) -> list[Scalar]:
        """Return the variables."""
        self._inputs = list(sympy.symbols(f"x:{count}", real=True))
        return self._inputs

    def sin(self, x: Scalar) -> Scalar:
        """Return the sine."""
        return sympy.sin(x)

    def cos(self, x: Scalar) -> Scalar:
        """Return the cosine."""
        return sympy.cos(x)

    def matrix(self, rows: Sequence[Sequence[Scalar]]) -> Matrix:
        """Return a matrix."""
        return sympy.Matrix(rows)

    def product(self, a: Matrix, b: Matrix) -> Matrix:
        """Return the product of two matrices."""
        return a * b

    def rows(self, a: Matrix) -> list[list[Scalar]]:
        """Return the entries."""
        return [list(row) for row in a.tolist()]

    def jacobian(self, roots: Sequence[Scalar], by: Sequence[Scalar]) -> Matrix:
        """Return the derivatives of `roots`, one row a root."""
        return sympy.Matrix(roots).jacobian(list(by))

    def compile(self, outputs: Sequence[Scalar]) -> Compiled:
        """Return Python code."""
        shared, reduced = sympy.cse([sympy.S(x) for x in outputs])

        def found(expressions: object) -> object:
            return shared, reduced

        inputs = self._inputs
        function = sympy.lambdify(inputs, outputs, modules="math", cse=found)

        @cache
        def over_arrays() -> Scalar:
            return sympy.lambdify(inputs, outputs, modules="numpy", cse=found)

        def one(point: Floats) -> Floats:
            return np.array(function(*point.tolist()))

        def many(points: Floats) -> Floats:
            columns = over_arrays()(*points.T)
            return np.stack([np.broadcast_to(column, len(points)) for column in columns], axis=1)

        def count() -> int:
            return count_operations([*(value for _, value in shared), *reduced])

        return Compiled(one, many, count)
