"""Reactions are those of least norm by the equations of free bodies; what is undetermined is named.

Families by construction: doors on several hinges, drawers on several guides, carts on points, planar loops
of spatial joints, parallel cranks, bodies welded repeatedly, and trees, where nothing is undetermined. Each is
turned as a whole, with names and order drawn, in trees and formulations drawn.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.equations.solving.undetermined import find_undetermined
from tests.formulations import FORMULATIONS
from tests.laws.redundant import (
    ENTRIES,
    TREES,
    demands,
    model_of,
    random_build,
    statics,
    values_of,
)
from tests.laws.tally import chunks, name_of

WAYS = (None, *FORMULATIONS)
EPS = float(np.finfo(float).eps)
# Balance and data are sums of some hundred rounded terms. Least squares solutions change by the condition
# times that (Golub & Van Loan 2013, section 5.3.7: the residual is 0).
TERMS = 1e4
# Frames are typed with 17 digits, constraints depend on each other up to their rounding.
DEPENDENT = 1e-9
CLEAR = 1e-5


def check(seeds: Iterable[int]) -> None:
    for seed in seeds:
        build = random_build(seed)
        how = np.random.default_rng(seed + 10**6)
        tree, formulation = TREES[how.integers(3)], WAYS[how.integers(len(WAYS))]
        eqs = sb.form_equations(model_of(build), formulation, tree=tree).for_values({})  # type: ignore[arg-type]
        q, found = values_of(build, eqs, seed)
        matrix, columns = statics(build)
        left, sizes, right = np.linalg.svd(matrix)
        rank = int((sizes > DEPENDENT * sizes[0]).sum())
        least = right[:rank].T @ ((left.T @ demands(build, found))[:rank] / sizes[:rank])
        largest = max(float(np.abs(least).max()), float(np.abs(demands(build, found)).max()))
        told = np.array([
            found[f"reaction {name}"][entry] / (build.length if entry > 2 else 1.0) for name, entry in columns
        ])  # fmt: skip
        error = float(np.abs(told - least).max()) / largest
        condition = sizes[0] / sizes[rank - 1]
        assert error <= TERMS * EPS * condition**2, (seed, tree, formulation, error, condition)

        free = np.linalg.norm(right[rank:], axis=0) if rank < len(columns) else np.zeros(len(columns))
        words = [f"reaction {name} {ENTRIES[entry]}" for name, entry in columns]
        (open_ones,) = find_undetermined(eqs.formed, [{"t": [0.0], "q": q, "p": [], "r": []}])
        assert open_ones.names >= {word for word, size in zip(words, free, strict=True) if size > CLEAR}, seed
        assert open_ones.names <= {word for word, size in zip(words, free, strict=True) if size > DEPENDENT}
        assert open_ones.redundant >= len(columns) - rank
        assert set(eqs.undetermined_reactions) <= open_ones.names, seed


@pytest.mark.parametrize("seeds", chunks(10), ids=name_of)
def test_reactions_are_those_of_least_norm(seeds: range) -> None:
    check(seeds)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_reactions_are_those_of_least_norm_often(seeds: range) -> None:
    check(seeds)
