"""M, J, gamma and the rates of the rows, how many freedoms they leave; ``u^T (Mdot - 2 C) u = 0``."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from symbody.graph.trees import TreeChoice
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import equations
from tests.laws.mechanisms import random_mechanism
from tests.laws.structure import closed_errors, mass_matrix_errors, row_errors, skewness_error
from tests.laws.tally import Tally, chunks, name_of

# Rows are compared at 50 digits, so this counts what the derivation rounded when it folded numbers, and by how
# much rates of angles exceed the speeds near (0.4 rad) a singularity.
# A wrong term would show as 1e12 and more.
ROWS = 1e4


def check(seeds: Iterable[int], tree: TreeChoice) -> None:
    mass, rows, skew = Tally(), Tally(ROWS), Tally()
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state = consistent_state(mechanism)
        eqs = equations(mechanism, tree)
        for law, error in mass_matrix_errors(mechanism, eqs, state).items():
            mass.enter(seed, law, error if law != "indefinite" else (float("inf") if error else 0.0))
        checked = row_errors(mechanism, eqs, state) | closed_errors(mechanism, eqs, state)
        for law, error in checked.items():
            rows.enter(seed, law, error)
        skew.enter(seed, "skewness", skewness_error(mechanism, eqs, state))
    mass.close("mass matrix")
    rows.close("rows of constraints")
    skew.close("skewness", may_be_empty=True)  # motions and laws that read rates leave few in ten


@pytest.mark.parametrize("seeds", chunks(4), ids=name_of)
def test_structure(seeds: range) -> None:
    check(seeds, None)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(1000), ids=name_of)
def test_structure_often(seeds: range) -> None:
    check(seeds, "absolute" if seeds.start % 100 == 0 else None)
