"""Every order condition of the pairs and of their dense outputs, from rooted trees."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations_with_replacement, pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import RK45

from symbody.kernels.block import Method
from symbody.simulation.native.blocks import method_numbers
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.runge_kutta import DORMAND_PRINCE_5, DORMAND_PRINCE_8, Tableau

ALL_METHODS = (DORMAND_PRINCE_5, DORMAND_PRINCE_8)
Floats = NDArray[np.float64]
Tree = tuple["Tree", ...]  # the subtrees that hang on the root

EPSILON = float(np.finfo(np.float64).eps)


@cache
def forests(nodes: int, largest: int) -> tuple[Tree, ...]:
    """All multisets of trees of at most `largest` nodes each, with so many nodes together."""
    if nodes == 0:
        return ((),)
    if largest == 0:
        return ()
    found = []
    for many in range(nodes // largest + 1):
        for rest in forests(nodes - many * largest, largest - 1):
            found += [rest + chosen for chosen in combinations_with_replacement(trees(largest), many)]
    return tuple(found)


@cache
def trees(order: int) -> tuple[Tree, ...]:
    return forests(order - 1, order - 1)


def order_of(tree: Tree) -> int:
    return 1 + sum(map(order_of, tree))


def density(tree: Tree) -> int:
    result = order_of(tree)
    for branch in tree:
        result *= density(branch)
    return result


def stage_weights(A: Floats, tree: Tree) -> Floats:
    result = np.ones(len(A))
    for branch in tree:
        result = result * (A @ stage_weights(A, branch))
    return result


def defects(A: Floats, weights: Floats, order: int, value: float = 1.0, share: float = 1.0) -> list[float]:
    """By how much ``weights . stage_weights = value share^order / density`` fails, for each tree.

    The unit is what rounding explains: a sum of products carries at most as many roundings as operations,
    each relative to the same sum over absolute values; 8 levels of 16 terms, and the coefficients', make 300.
    """
    result = []
    for tree in trees(order):
        wanted = value * share**order / density(tree)
        bound = 300.0 * EPSILON * (np.abs(weights) @ stage_weights(np.abs(A), tree) + abs(wanted))
        result.append(abs(weights @ stage_weights(A, tree) - wanted) / bound)
    return result


def coefficients(tableau: Tableau) -> tuple[Floats, Floats, Floats]:
    """Return A, error estimates and dense output as the compiled loop gets them, with their zeros."""
    method, size = Method(method_numbers(tableau, 1)), len(tableau.A)
    firsts, pairs = np.asarray(method.rows).astype(int), np.asarray(method.weights).reshape(-1, 2)
    firsts = firsts[: size + 2 + len(tableau.dense) + 1]
    full = np.zeros((len(firsts) - 1, size))
    for row, (start, end) in zip(full, pairwise(firsts), strict=True):
        row[pairs[start:end, 0].astype(int)] = pairs[start:end, 1]
    return full[:size], full[size : size + 2], full[size + 2 :]


def test_the_trees_are_all_there() -> None:
    # number of rooted trees, Hairer, Norsett and Wanner, table II.2.1
    assert [len(trees(k)) for k in range(1, 10)] == [1, 1, 2, 4, 9, 20, 48, 115, 286]


@pytest.mark.parametrize("tableau", ALL_METHODS, ids=lambda tableau: tableau.order)
def test_the_solution_has_its_order_and_no_more(tableau: Tableau) -> None:
    A, _, _ = coefficients(tableau)
    weights = A[tableau.stages]
    for order in range(1, tableau.order + 1):
        assert max(defects(A, weights, order)) < 1.0
    assert max(defects(A, weights, tableau.order + 1)) > 1e6


@pytest.mark.parametrize(
    ("tableau", "place", "order"),
    [(DORMAND_PRINCE_5, 0, 4), (DORMAND_PRINCE_8, 0, 5), (DORMAND_PRINCE_8, 1, 3)],
)
def test_an_error_estimate_vanishes_up_to_the_order_of_its_pair(
    tableau: Tableau, place: int, order: int
) -> None:
    A, error, _ = coefficients(tableau)
    weights = error[place]
    for lower in range(1, order + 1):
        assert max(defects(A, weights, lower, value=0.0)) < 1.0
    assert max(defects(A, weights, order + 1, value=0.0)) > 1e6


@pytest.mark.parametrize("tableau", ALL_METHODS, ids=lambda tableau: tableau.order)
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_the_dense_output_has_the_order_of_its_degree(tableau: Tableau, share: float) -> None:
    A, _, dense = coefficients(tableau)
    K = np.eye(len(A))  # so that the interpolated state is the vector of weights
    move, first, last = A[tableau.stages], K[0], K[tableau.stages]
    F = np.array([0 * move, move, first - move, 2 * move - first - last, *(dense @ K)])
    weights = DenseOutput(np.array([0.0, 1.0]), F[np.newaxis])(share)
    assert tableau.dense_degree == len(F) - 1
    for order in range(1, tableau.dense_degree + 1):
        # the coefficients of `dense` reach 600 and cancel to weights of at most 3: 200 times the rounding
        assert max(defects(A, weights, order, share=share)) < 200.0
    assert max(defects(A, weights, tableau.dense_degree + 1, share=share)) > 1e6


def test_the_coefficients_are_scipys() -> None:
    A, error, _ = coefficients(DORMAND_PRINCE_5)
    np.testing.assert_allclose(A[:6, :5], RK45.A, rtol=4 * EPSILON)
    np.testing.assert_allclose(A[6, :6], RK45.B, rtol=4 * EPSILON)
    np.testing.assert_allclose(-error[0, :7], RK45.E, rtol=4 * EPSILON)


def test_inconsistent_rows_are_refused() -> None:
    with pytest.raises(ValueError, match="sum to their nodes"):
        replace(DORMAND_PRINCE_5, c=(0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 0.9))
    with pytest.raises(ValueError, match="error estimates to zero"):
        replace(DORMAND_PRINCE_5, error=((0.1,), ()))
    with pytest.raises(ValueError, match="below the diagonal"):
        replace(DORMAND_PRINCE_5, A=((1.0,), *DORMAND_PRINCE_5.A[1:]))
