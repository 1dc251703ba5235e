"""Virtual work, Newton-Euler and Lagrange agree on random mechanisms, whatever trees and angles."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from tests.laws.formulations import compared
from tests.laws.mechanisms import random_mechanism
from tests.laws.tally import Tally, chunks, name_of

# A mechanism takes about a second, three derivations and their evaluation in plain Python.
NUMBER = 2000


def compare(seeds: Iterable[int]) -> None:
    """Compare both other formulations with virtual work, each with a tree and angles of its seed."""
    tallies: dict[str, Tally] = {}
    for seed in seeds:
        for formulation, found in compared(random_mechanism(seed)).items():
            for law, error in found.items():
                tallies.setdefault(f"{formulation}: {law}", Tally()).enter(seed, law, error)
    for title, tally in tallies.items():
        tally.close(title, may_be_empty=True)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_formulations_agree_often(seeds: range) -> None:
    compare(seeds)
