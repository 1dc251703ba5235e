"""States that other tools may choose, where the others follow from constraints."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.compile import compile
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet

Floats = NDArray[np.float64]

_NOTHING = 1e-9  # a pivot of rows whose largest entry is 1


def free_states(
    eqs: EquationSet, parameters: Mapping[str, Value], x: Floats, r: Floats, preferred: Collection[int]
) -> tuple[bool, ...]:
    """Return which states (u, q, s) are chosen, preferred speeds and their coordinates as far as possible."""
    n_u, n = len(eqs.speed_names), len(eqs.speed_names) + len(eqs.coordinate_names)
    function = compile(eqs, ["position_jacobian", "jacobian"], parameters, quick=True)
    by_q, jacobian = map(np.asarray, function(0.0, x[n_u:n], x[:n_u], r, s=x[n:]))
    chosen = {eqs.speed_names[k] for k in preferred}
    speeds = _free_columns(jacobian, [name in chosen for name in eqs.speed_names])
    are_wanted = [f"{name}_dot" in chosen for name in eqs.coordinate_names]
    positions = _free_columns(by_q[: len(eqs.formed.holonomic)], are_wanted)
    return (*speeds, *positions, *[True] * (x.size - n))


def _free_columns(matrix: Floats, are_preferred: list[bool]) -> list[bool]:
    """Return which variables of linear equations are chosen: those that no pivot falls on."""
    matrix = matrix / np.maximum(np.abs(matrix).max(axis=1, initial=0.0, keepdims=True), 1e-300)
    free = [True] * matrix.shape[1]
    for wanted in (False, True):
        columns = [k for k, is_preferred in enumerate(are_preferred) if is_preferred is wanted]
        while columns and matrix.shape[0]:
            sizes = np.abs(matrix[:, columns])
            row, place = divmod(int(sizes.argmax()), len(columns))
            if sizes[row, place] < _NOTHING:
                break
            column = columns.pop(place)
            pivot = matrix[row] / matrix[row, column]
            matrix = np.delete(matrix - np.outer(matrix[:, column], pivot), row, axis=0)
            free[column] = False
    return free
