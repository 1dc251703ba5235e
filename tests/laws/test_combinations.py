"""Whatever happens to a motion, in whatever computes it: fragments that do not touch each other change nothing.

Sixteen fragments, each with one thing that happens, stand in fourteen models so that each two of them meet; each model
is computed by every consumer, and each value agrees with that of its fragment alone. The exhaustive tier takes each
two of them by themselves, too.
"""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.laws.motion_consumers import WAYS, Question, names_for, outcome
from tests.laws.motion_fragments import FRAGMENTS, save_controller

pytestmark = [
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"),
    pytest.mark.skipif(shutil.which("node") is None, reason="needs Node"),
]
NAMES = tuple(FRAGMENTS)
(OSCILLATOR, DRY, ROPE, PLATE, PUCK, BOUNCE, JUMP, SAMPLED, FMU, TABLE, PYTHON, GEARS, LOOP, LAG, STOP, MEASURED,
 QUATERNION, CONTACT) = NAMES  # fmt: skip
# Found by exchanges at random; a test counts that no pair is missing.
MODELS = (
    (ROPE, BOUNCE, FMU, TABLE, PYTHON, GEARS, PLATE, PUCK),
    (OSCILLATOR, ROPE, FMU, STOP, QUATERNION, CONTACT),
    (DRY, JUMP, SAMPLED, FMU, GEARS, LOOP),
    (OSCILLATOR, DRY, SAMPLED, TABLE, QUATERNION, CONTACT, PLATE),
    (BOUNCE, FMU, TABLE, LAG, STOP, MEASURED),
    (DRY, ROPE, BOUNCE, TABLE, PYTHON, CONTACT),
    (ROPE, JUMP, SAMPLED, PYTHON, STOP, MEASURED, PLATE, PUCK),
    (OSCILLATOR, DRY, BOUNCE, LAG, MEASURED, QUATERNION, PUCK),
    (OSCILLATOR, JUMP, PYTHON, LOOP, QUATERNION, CONTACT, PUCK),
    (BOUNCE, JUMP, TABLE, LOOP, LAG, CONTACT),
    (ROPE, FMU, LOOP, LAG, STOP, CONTACT, PLATE),
    (ROPE, BOUNCE, SAMPLED, FMU, LAG, MEASURED),
    (PYTHON, GEARS, LOOP, LAG, MEASURED, CONTACT),
    (OSCILLATOR, DRY, TABLE, GEARS, STOP, QUATERNION),
)
# What is compiled takes seconds with six fragments; `test_couplings` has it in the fast tier with one thing.
SLOW = ("C", "C GeneralizedAlpha", "live page", "FMU co-simulation", "FMU model exchange")


def row(way: str, names: tuple[str, ...], substitute: bool, *, is_fast: bool) -> Any:
    """A consumer and fragments as a case."""
    marks = [] if is_fast else [pytest.mark.exhaustive]
    return pytest.param(way, names, substitute, marks=marks, id=f"{way} - {', '.join(names)}")


def rows_of_models() -> Iterator[Any]:
    """Each model by each consumer; in the fast tier each model by one of the quick ones in turn."""
    quick = [way for way in WAYS if way not in SLOW]
    for k, model in enumerate(MODELS):
        for way in WAYS:
            names, substitute = names_for(way, model), k % 2 == 1
            is_fast = quick[k % len(quick)] == way
            yield row(way, names, substitute, is_fast=is_fast)


def rows_of_pairs() -> Iterator[Any]:
    for k, pair in enumerate(itertools.combinations(NAMES, 2)):
        for way in WAYS:
            if names_for(way, pair) == pair:
                yield row(way, pair, k % 2 == 1, is_fast=False)


@pytest.fixture(scope="module")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_controller(tmp_path_factory.mktemp("controller") / "controller.fmu")


def check(way: str, names: tuple[str, ...], substitute: bool, controller: Path, folder: Path) -> None:
    result = outcome(Question(tuple(FRAGMENTS[name] for name in names), folder, controller, substitute), way)
    assert result == "right"


def test_each_two_fragments_meet() -> None:
    met = {frozenset(pair) for model in MODELS for pair in itertools.combinations(model, 2)}
    counts = [sum({a, b} <= set(model) for model in MODELS) for a, b in itertools.combinations(NAMES, 2)]
    for model in MODELS:
        print("; ".join(model))
    print(f"{len(met)} pairs; {counts.count(1)} once, {counts.count(2)} twice")
    assert len(met) == len(NAMES) * (len(NAMES) - 1) // 2


@pytest.mark.parametrize(("way", "names", "substitute"), list(rows_of_models()))
def test_fragments_beside_each_other(
    way: str, names: tuple[str, ...], substitute: bool, controller: Path, tmp_path: Path
) -> None:
    check(way, names, substitute, controller, tmp_path)


@pytest.mark.parametrize(("way", "names", "substitute"), list(rows_of_pairs()))
def test_each_two_fragments_beside_each_other(
    way: str, names: tuple[str, ...], substitute: bool, controller: Path, tmp_path: Path
) -> None:
    check(way, names, substitute, controller, tmp_path)
