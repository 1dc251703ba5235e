"""Dependent speeds from constraints on velocities: the solution of ``J_d x = r`` on the graph.

Rows in which only one dependent speed is left are solved by division, one after the other. What remains is
coupled: rows perpendicular to each other are solved by their transpose, others by `solve_saddle` with a unit
mass matrix, which pivots.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from symbody.equations.kinematics.placements import fold_zeros
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr, number, saddle_entry
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph, KernelNode

Matrix = Sequence[Sequence[Expr]]

# Of a coupled block the determinant is expanded by minors, whose number doubles with each row.
MOST_COUPLED: Final = 10


@dataclass(frozen=True, slots=True)
class Pivot:
    """Part of the dependent speeds, and what must not vanish.

    Attributes
    ----------
    rows, columns : tuple of int
        Which rows give which dependent speeds.
    determinant : Expr
        Of these rows and columns of J_d.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    determinant: Expr


@dataclass(frozen=True, slots=True)
class DependentBlock:
    """A square matrix J_d, ready to be solved.

    Attributes
    ----------
    matrix : (m, m) Expr
    steps : tuple of Pivot
        Rows solved by division, each with one speed, in the order in which they are.
    coupled : Pivot or None
        The rows and columns left.
    inverse : Expr matrix
        Of the coupled rows and columns.
    method : str
        How those are solved: "division", "transpose" or "pivoting".
    """

    matrix: Matrix
    steps: tuple[Pivot, ...]
    coupled: Pivot | None
    inverse: Matrix
    method: str

    @property
    def pivots(self) -> tuple[Pivot, ...]:
        """All parts; a transposed one is never singular."""
        last = () if self.coupled is None or self.method == "transpose" else (self.coupled,)
        return (*self.steps, *last)

    def solve(self, right: Sequence[Expr]) -> list[Expr]:
        """Return x with ``J_d x = right``."""
        graph = right[0].graph
        zero = number(graph, 0)
        values: dict[int, Expr] = {}

        def residual(k: int) -> Expr:
            total = right[k]
            for column, value in values.items():
                total = total - self.matrix[k][column] * value
            return total

        for step in self.steps:
            values[step.columns[0]] = residual(step.rows[0]) / step.determinant
        if self.coupled is not None:
            rest = [residual(k) for k in self.coupled.rows]
            for column, row in zip(self.coupled.columns, self.inverse, strict=True):
                values[column] = sum((x * r for x, r in zip(row, rest, strict=True)), zero)
        return [values[k] for k in range(len(right))]


def find_solution_order(graph: Graph, matrix: Matrix) -> DependentBlock | None:
    """Return a square matrix prepared for solving; None if it is singular whatever the coordinates.

    Raises
    ------
    FormulationError
        If too many rows are coupled.
    """
    m = len(matrix)
    flat = fold_zeros(graph, [entry for row in matrix for entry in row])
    clean = [flat[k * m : (k + 1) * m] for k in range(m)]
    steps, rows, columns = _divide_rows(clean)
    if not rows:
        return DependentBlock(clean, steps, None, (), "division")
    if len(rows) > MOST_COUPLED:
        raise FormulationError(
            Problem("equations.coupled_rows", "dependent_speeds", f"{len(rows)} rows are coupled",
                    f"at most {MOST_COUPLED} coupled rows of dependent speeds can be eliminated",
                    "choose speeds that each appear in few rows, or leave dependent_speeds out")
        )  # fmt: skip
    inner = [[clean[i][j] for j in columns] for i in rows]
    determinant = _determinant(graph, inner)
    if find_zeros(graph, [determinant.index])[0]:
        return None
    inverse = _transpose_orthogonal(graph, inner)
    method = "pivoting" if inverse is None else "transpose"
    coupled = Pivot(tuple(rows), tuple(columns), determinant)
    return DependentBlock(
        clean, steps, coupled, _inverse(graph, inner) if inverse is None else inverse, method
    )


def _divide_rows(matrix: Matrix) -> tuple[tuple[Pivot, ...], list[int], list[int]]:
    """Return the rows that can be solved by division, and the rows and columns left."""
    rows, columns = list(range(len(matrix))), list(range(len(matrix)))
    steps: list[Pivot] = []
    while True:
        filled = {i: [j for j in columns if not matrix[i][j].is_zero] for i in rows}
        single = next((i for i in rows if len(filled[i]) == 1), None)
        if single is None:
            return tuple(steps), rows, columns
        column = filled[single][0]
        steps.append(Pivot((single,), (column,), matrix[single][column]))
        rows.remove(single)
        columns.remove(column)


def _determinant(graph: Graph, matrix: Matrix) -> Expr:
    """Return the determinant by its minors of the first rows, each formed once."""
    n = len(matrix)
    minors: Mapping[tuple[int, ...], Expr] = {(): number(graph, 1)}
    for k in range(n):
        larger = {}
        for columns in combinations(range(n), k + 1):
            total = number(graph, 0)
            for place, j in enumerate(columns):
                rest = minors[(*columns[:place], *columns[place + 1 :])]
                total = total + matrix[k][j] * rest * (-1 if (k + place) % 2 else 1)
            larger[columns] = total
        minors = larger
    return minors[tuple(range(n))]


def _transpose_orthogonal(graph: Graph, matrix: Matrix) -> Matrix | None:
    """Return the inverse of a matrix whose rows are perpendicular unit vectors, or None if they are not."""
    n = len(matrix)
    products = []
    for i in range(n):
        for j in range(i + 1):
            total = number(graph, -1 if i == j else 0)
            for a, b in zip(matrix[i], matrix[j], strict=True):
                total = total + a * b
            products.append(total.index)
    return list(zip(*matrix, strict=True)) if all(find_zeros(graph, products)) else None


def _inverse(graph: Graph, matrix: Matrix) -> Matrix:
    """Return the inverse by one kernel a column."""
    n = len(matrix)
    kernel = graph.kernel(KernelNode(n, n))
    zero, one = number(graph, 0), number(graph, 1)
    units = [[one if i == j else zero for j in range(n)] for i in range(n)]
    columns = []
    for unit in units:
        operands = (
            *(x for row in units for x in row),
            *(x for row in matrix for x in row),
            *[zero] * n,
            *unit,
        )
        nodes = tuple(x.index for x in operands)
        columns.append([saddle_entry(graph, kernel, nodes, k) for k in range(n)])
    return list(zip(*columns, strict=True))
