"""Law: what an action sets holds, in every loop, and no other way to the same equations changes what follows."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.errors import SymbodyError
from tests.laws.building import build_model
from tests.laws.holding import movable, settings_of
from tests.laws.mechanisms import random_mechanism
from tests.laws.tally import chunks, name_of

GALLERY = Path(__file__).parents[2] / "examples" / "gallery"
# Small mechanisms with loops: the fast tier spends its time on settings, not on compiling.
SMALL = (13, 16, 19, 21)
ROUNDS = 5
NUMBER = 2000  # settings of the exhaustive tier
SEEDS = 320  # seven settings each on the average
QUICK = {"crank_rocker", "planetary_gear"}
FILES = [
    path if path.stem in QUICK else pytest.param(path, marks=pytest.mark.exhaustive)
    for path in sorted(GALLERY.glob("*/*.toml"))
]
# The values before an action are those of the motion; an action adds to them, and rounds once.
EPS = float(np.finfo(float).eps)


def check(eqs: sb.EquationSet, rounds: int, seed: int) -> int:
    """Check that every state that can be set reads back what was set; count them."""
    names = movable(eqs, sb.assemble(eqs))
    if not names:
        return 0
    run, settings = settings_of(eqs, names, rounds, seed)
    assert run.success, run.notes
    assert len(settings) == rounds * len(names)
    for setting in settings:
        assert abs(setting.found - setting.asked) <= 2.0 * EPS * abs(setting.asked), setting
    return len(settings)


def equations(seed: int) -> sb.EquationSet | None:
    """The equations of a random mechanism with a loop; None where its model's own values cannot start it."""
    try:
        eqs = sb.form_equations(build_model(random_mechanism(seed)))
        sb.assemble(eqs)
    except SymbodyError:
        return None
    return eqs if eqs.multiplier_names and eqs.speed_names else None


def check_seeds(seeds: Iterable[int], rounds: int) -> int:
    found = ((seed, equations(seed)) for seed in seeds)
    return sum(check(eqs, rounds, seed) for seed, eqs in found if eqs is not None)


def test_states_of_random_loops_hold() -> None:
    assert check_seeds(SMALL, ROUNDS) >= 200


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(SEEDS), ids=name_of)
def test_states_of_all_random_loops_hold(seeds: range) -> None:
    assert check_seeds(seeds, 1) * SEEDS >= NUMBER * len(seeds) / 4  # chunks differ


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_states_of_the_gallery_hold(path: Path) -> None:
    eqs = sb.form_equations(sb.load_model(path))
    if eqs.multiplier_names and eqs.speed_names and not eqs.formed.friction:
        check(eqs, 1, 0)
