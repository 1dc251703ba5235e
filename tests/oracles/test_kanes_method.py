"""Accelerations of random trees, beside SymPy's KanesMethod evaluated to 40 digits."""

from __future__ import annotations

import numpy as np
import pytest
import sympy.physics.mechanics as me

from tests.oracles.comparison import EPS, compiled, sensitivity
from tests.oracles.kane import accelerations, kanes_method
from tests.oracles.trees import KINDS, Tree, build_model, random_tree
from tests.tiers import cases

# An entry of M and F is some ten roundings deep for each of up to four bodies, and terms of it cancel.
ROUNDINGS = 100
STATES = 3

# Quick for SymPy, and together with all joints, speeds and loads; see the test at the end.
FAST = (2, 5, 14, 15, 25, 28)
ALL = range(1, 51)


@pytest.mark.parametrize("seed", cases(FAST, fast=[2, 14, 15, 28]))
def test_accelerations_agree(seed: int) -> None:
    assert worst_error(random_tree(seed)) <= ROUNDINGS


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", [seed for seed in ALL if seed not in FAST])
def test_accelerations_of_more_trees_agree(seed: int) -> None:
    assert worst_error(random_tree(seed)) <= ROUNDINGS


def worst_error(tree: Tree) -> float:
    """Largest deviation over states, relative to the largest acceleration, divided by eps and the sensitivity."""
    method, code = kanes_method(tree), compiled(build_model(tree), "udot")
    errors = []
    for number in range(STATES):
        q, u = tree.state(number)
        known = {me.dynamicsymbols(name): value for name, value in q.items()}
        for name, speed in zip(tree.coordinates, tree.speeds, strict=True):
            known[me.dynamicsymbols(name.replace("q", "u", 1))] = u[speed]
        M, F, exact = accelerations(method, known)
        udot = code(q | u)["udot"][[code.speed_names.index(name) for name in tree.speeds]]
        deviation = max(abs(float(x - y)) for x, y in zip(udot, exact, strict=True))
        expected = [float(x) for x in exact]
        scale = EPS * sensitivity(M.tolist(), list(F), expected)
        errors.append(deviation / np.abs(expected).max() / scale)
    return float(max(errors))


@pytest.mark.parametrize("seeds", [FAST, ALL], ids=["fast", "all"])
def test_trees_have_all_that_is_compared(seeds: tuple[int, ...]) -> None:
    trees = [random_tree(seed) for seed in seeds]
    joints = [joint for tree in trees for joint in tree.joints]
    assert {joint.kind for joint in joints} == set(KINDS)
    assert {joint.speeds for joint in joints if joint.kind == "spherical"} == {"rates", "start", "end"}
    assert {joint.kind for joint in joints if joint.drives} >= {"revolute", "prismatic", "planar"}
    assert {load.kind for tree in trees for load in tree.loads} == {"force", "torque"}
    assert any(load.reaction >= 0 for tree in trees for load in tree.loads)
    assert any(tree.springs for tree in trees)
    assert {tree.literal for tree in trees} == {True, False}
    assert {len(tree.bodies) for tree in trees} == {1, 2, 3, 4}
    assert any(all(joint.axis) for joint in joints if joint.kind == "revolute")
