"""Newton and Euler for each body and the whole; the energy changes by the power."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from symbody.graph.trees import TreeChoice
from tests.laws.balance import balance_errors, energy_error
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import equations
from tests.laws.mechanisms import random_mechanism
from tests.laws.tally import Tally, chunks, name_of


def check(seeds: Iterable[int], tree: TreeChoice) -> None:
    balance, energy = Tally(), Tally()
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state = consistent_state(mechanism)
        eqs = equations(mechanism, tree)
        for law, error in balance_errors(mechanism, eqs, state).items():
            balance.enter(seed, law, error)
        energy.enter(seed, "energy", energy_error(mechanism, eqs, state))
    # Both are entered before either is judged.
    try:
        balance.close("balance of forces and moments")
    finally:
        energy.close("energy")


@pytest.mark.parametrize("seeds", [range(6)], ids=name_of)
def test_balance_and_energy(seeds: range) -> None:
    check(seeds, None)


@pytest.mark.parametrize("seeds", [range(4)], ids=name_of)
def test_balance_and_energy_in_absolute_coordinates(seeds: range) -> None:
    check(seeds, "absolute")


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_balance_and_energy_often(seeds: range) -> None:
    check(seeds, "absolute" if seeds.start % 50 == 0 else None)
