"""What a problem asks of an engine: arithmetic, matrices, derivatives, a function of numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Scalar = Any  # an engine's expression or a Python number; the engines share no type
Matrix = Any  # an engine's matrix of them


@dataclass(frozen=True, slots=True)
class Compiled:
    """A function of numbers.

    Attributes
    ----------
    one : callable
        From (inputs,) to (outputs,): what a caller in Python pays for one point.
    many : callable
        From (points, inputs) to (points, outputs), the loop being the engine's own.
    count : callable
        Operations of one evaluation. Counting may take time, which is not the engine's fault.
    """

    one: Callable[[Floats], Floats]
    many: Callable[[Floats], Floats]
    count: Callable[[], int]


class Algebra(Protocol):
    """One engine with nothing in it yet; scalars have the operators + - * of Python."""

    def inputs(self, count: int) -> list[Scalar]:
        """Return the variables, to be called once."""

    def sin(self, x: Scalar) -> Scalar:
        """Return the sine."""

    def cos(self, x: Scalar) -> Scalar:
        """Return the cosine."""

    def matrix(self, rows: Sequence[Sequence[Scalar]]) -> Matrix:
        """Return a matrix in the engine's own form."""

    def product(self, a: Matrix, b: Matrix) -> Matrix:
        """Return the product of two matrices."""

    def rows(self, a: Matrix) -> list[list[Scalar]]:
        """Return the entries."""

    def jacobian(self, roots: Sequence[Scalar], by: Sequence[Scalar]) -> Matrix:
        """Return the derivatives of `roots` by variables, one row a root."""

    def compile(self, outputs: Sequence[Scalar]) -> Compiled:
        """Return the function from all inputs to `outputs`."""
