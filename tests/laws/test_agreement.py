"""Any legal choice of trees and of orientation coordinates: same accelerations, same reactions."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from tests.laws.agreement import (
    SYSTEM,
    acceleration_error,
    choices,
    other_orientations,
    outcome,
    reaction_error,
)
from tests.laws.building import build_model
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import EPS, arguments, condition, equations, values_at
from tests.laws.mechanisms import random_mechanism
from tests.laws.tally import BOUND, Tally, chunks, name_of
from tests.tiers import cases


def compare(seeds: Iterable[int], number: int) -> None:
    """Compare `number` random choices of trees, absolute coordinates and other orientations with joint coordinates."""
    accelerations, reactions, orientations = Tally(), Tally(), Tally()
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state = consistent_state(mechanism)
        first, *others = [
            outcome(mechanism, equations(mechanism, choice), state) for choice in choices(mechanism, number)
        ]
        for k, other in enumerate(others):
            accelerations.enter(seed, f"choice {k + 1}", acceleration_error(mechanism, state, first, other))
            reactions.enter(seed, f"choice {k + 1}", reaction_error(mechanism, first, other))
        turned = other_orientations(mechanism)
        found = outcome(turned, equations(turned), consistent_state(turned))
        orientations.enter(seed, "orientation", acceleration_error(mechanism, state, first, found))
        reactions.enter(seed, "orientation", reaction_error(mechanism, first, found))
    accelerations.close("accelerations of trees")
    orientations.close("accelerations of orientations")
    reactions.close("reactions where they are unique")


@pytest.mark.parametrize("seeds", cases([range(1), range(1, 3)], fast=[range(1)]), ids=name_of)
def test_trees_and_orientations_agree(seeds: range) -> None:
    compare(seeds, 1)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(400), ids=name_of)
def test_trees_and_orientations_agree_often(seeds: range) -> None:
    compare(seeds, 3)


@pytest.mark.parametrize("seed", cases([2, 6, 11, 13, 38], fast=[6, 38]))
def test_native_code_agrees_with_plain_evaluation(seed: int) -> None:
    mechanism = random_mechanism(seed)
    state = consistent_state(mechanism)
    eqs = sb.form_equations(build_model(mechanism))
    native = sb.compile(eqs, SYSTEM)(*arguments(eqs, state))._asdict()
    reference = equations(mechanism)
    plain = values_at(reference, state, SYSTEM)
    assert eqs.speed_names == reference.speed_names
    weights = np.sqrt(np.diag(plain["mass_matrix"]))
    scale = np.abs(weights * plain["udot"]).max()
    error = np.abs(weights * (native["udot"] - plain["udot"])).max()
    assert error <= BOUND * EPS * condition(plain).number * scale
