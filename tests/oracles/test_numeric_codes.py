"""Accelerations of random trees beside Pinocchio and MuJoCo, where these are installed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from tests.oracles.comparison import EPS, Floats, compiled, sensitivity
from tests.oracles.numeric_codes import by_mujoco, by_pinocchio, plain_tree
from tests.oracles.trees import Tree, build_model

# Both sides are rounded: twice what test_kanes_method allows, for twice as many bodies.
ROUNDINGS = 400
STATES = 3
FAST, ALL = range(100, 108), range(108, 200)
NONE = (Fraction(0),) * 3

Oracle = Callable[[Tree, dict[str, float], dict[str, float]], Floats]


def worst_error(tree: Tree, oracle: Oracle) -> float:
    """Largest deviation over states, relative to the largest acceleration, divided by eps and the sensitivity."""
    code, errors = compiled(build_model(tree), "udot", "mass_matrix", "forcing"), []
    for number in range(STATES):
        q, u = tree.state(number)
        found = code(q | u)
        udot = found["udot"]
        expected = oracle(tree, q, u)
        order = [code.speed_names.index(name) for name in tree.speeds]
        scale = EPS * sensitivity(found["mass_matrix"], found["forcing"], udot)
        errors.append(np.abs(udot[order] - expected).max() / np.abs(udot).max() / scale)
    return float(max(errors))


def pinocchio(tree: Tree, q: dict[str, float], u: dict[str, float]) -> Floats:
    package: Any = pytest.importorskip("pinocchio")
    return by_pinocchio(package, tree, q, u)


def mujoco(tree: Tree, q: dict[str, float], u: dict[str, float]) -> Floats:
    package: Any = pytest.importorskip("mujoco")
    return by_mujoco(package, tree, q, u)


def without_products(tree: Tree) -> Tree:
    return replace(tree, bodies=tuple(replace(body, products=NONE) for body in tree.bodies))


@pytest.mark.parametrize("seed", FAST)
def test_accelerations_agree_with_pinocchio(seed: int) -> None:
    assert worst_error(plain_tree(seed), pinocchio) <= ROUNDINGS


@pytest.mark.parametrize("seed", FAST)
def test_accelerations_agree_with_mujoco(seed: int) -> None:
    assert worst_error(without_products(plain_tree(seed)), mujoco) <= ROUNDINGS


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", ALL)
def test_accelerations_of_more_trees_agree(seed: int) -> None:
    tree = plain_tree(seed)
    assert worst_error(tree, pinocchio) <= ROUNDINGS
    assert worst_error(without_products(tree), mujoco) <= ROUNDINGS
