"""The generator: its mix, and that what it makes is what it says."""

from __future__ import annotations

import numpy as np
import pytest

from tests.laws.building import build_model
from tests.laws.conditions import CONTACTS, COUPLINGS
from tests.laws.consistent_states import consistent_state
from tests.laws.joint_laws import FREEDOMS, rotation, shift
from tests.laws.mechanisms import random_mechanism, report
from tests.laws.motion import body_places, frame_place

WHOLE = 2000
LEAST = 30  # of each joint type in the whole
LEAST_CONSTRAINTS = 20  # of each type: balls and discs take three of the freedoms of trees that have more


def check_mix(number: int) -> None:
    found = report(random_mechanism(seed) for seed in range(number))
    print("\n".join(f"{word}: {value:.4g}" for word, value in found.items()))
    assert found["share with a loop"] >= 0.40
    assert found["share with two loops"] >= 0.25
    assert found["rejected"] < 0.05
    assert found["share that moves"] > 0.9
    for kind in (*FREEDOMS, "none"):
        assert found[f"joints {kind}"] >= LEAST * number / WHOLE, kind
    assert 0.28 < found["share with constraints"] < 0.4
    for kind in (*CONTACTS, *COUPLINGS):
        assert found[f"constraints {kind}"] >= LEAST_CONSTRAINTS * number / WHOLE, kind


@pytest.mark.exhaustive
def test_the_mix_is_as_promised() -> None:
    check_mix(400)


@pytest.mark.exhaustive
def test_the_mix_of_all_is_as_promised() -> None:
    check_mix(WHOLE)
    sequences = {j.sequence for seed in range(WHOLE) for j in random_mechanism(seed).joints if j.sequence}
    # 12 about body axes and 12 about space axes, each in letters and in digits, and the quaternion.
    assert len(sequences) == 49


@pytest.mark.parametrize("seed", range(40))
def test_every_joint_is_closed_at_the_pose_and_the_model_is_accepted(seed: int) -> None:
    mechanism = random_mechanism(seed)
    model = build_model(mechanism)
    assert len(model.joints) == len(mechanism.joints)
    assert len(model.constraints) == len(mechanism.constrained)
    places = body_places(mechanism)
    length = mechanism.units.length
    for joint in mechanism.joints:
        (r_s, a_s), (r_e, a_e) = (
            frame_place(mechanism, places, address) for address in (joint.start, joint.end)
        )
        # Placed by a chain of at most seven rotations of numbers below ten.
        assert np.abs(a_s @ rotation(joint) - a_e).max() < 1e-13, joint.name
        assert np.abs(r_s + a_s @ shift(joint) - r_e).max() < 1e-12 * length, joint.name


def test_a_seed_gives_the_same_mechanism_and_other_units_the_same_ratios() -> None:
    one, two = random_mechanism(3), random_mechanism(3)
    assert [body.mass for body in one.bodies] == [body.mass for body in two.bodies]
    assert consistent_state(one).known == consistent_state(two).known
