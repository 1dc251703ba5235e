"""A slack rope, or a joint that sticks, on a body of its own changes nothing: neither events nor actions nor ends.

Beside such an element actions end pieces of the motion; without it they happen inside the compiled loop.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
import pytest

import symbody as sb
from tests.laws.tally import chunks, name_of
from tests.laws.test_cradles import END as CRADLE_END
from tests.laws.test_cradles import GAPS, first_values, hits, in_rounds, names_of, rail, run_cradle
from tests.simulation.test_random_events import END, assert_same, oscillator, random_events

SEEDS = 500
QUICK = 4
ELEMENTS = ("slack rope", "joint that sticks")


def aside(element: str) -> list[sb.Element]:
    body = sb.Body("Aside", mass=1)
    if element == "slack rope":
        way = sb.Prismatic("aside", "ground", body, axis="y", coordinate="aside")
        return [body, way, sb.Distance("leash", "ground", "Aside", 5.0, rope=True)]
    return [
        body,
        sb.Prismatic("aside", "ground", body, axis="y", coordinate="aside", friction=sb.Friction(force=1)),
    ]


@cache
def with_aside(eqs: sb.EquationSet, element: str) -> sb.EquationSet:
    model = eqs.model
    assert isinstance(model, sb.Model)
    parts = [*model.bodies, *model.joints, *aside(element)]
    return sb.form_equations(sb.Model(model.name, parts, parameters=dict(model.parameters)))


def check_oscillator(seed: int, element: str) -> None:
    random = np.random.default_rng(seed)
    events, x = random_events(random), float(random.uniform(-1.0, 1.0))
    usual = sb.simulate(oscillator(), END, {"x": x}, events=events, rtol=1e-10)
    eqs = with_aside(oscillator(), element)
    run = sb.simulate(eqs, END, {"x": x, "aside": 0.5}, events=events, rtol=1e-10)
    assert_same(run, usual, 1e-6)
    assert run.energy_drift < 1e-6
    if usual.status is not sb.Status.CHATTERING:
        np.testing.assert_allclose(run["x"][-1], usual["x"][-1], atol=1e-6)


def check_cradle(seed: int, element: str) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 7))
    speeds, gap = random.choice([0.0, 1.0, -1.0, 0.5], count), GAPS[seed % 2]
    usual, given = run_cradle(speeds, gap), first_values(speeds, gap) | {"aside": 0.5}
    run = sb.simulate(with_aside(rail(count), element), CRADLE_END, given, events=hits(count))
    assert run.status is usual.status
    assert in_rounds(names_of(run)) == in_rounds(names_of(usual))
    for k in range(count):
        assert run[f"x{k}"][-1] == pytest.approx(usual[f"x{k}"][-1], abs=1e-9)


def cases() -> Iterator[object]:
    for element in ELEMENTS:
        yield pytest.param(range(QUICK), element, id=f"{element} {QUICK}")
        for seeds in chunks(SEEDS):
            yield pytest.param(seeds, element, id=f"{element} {name_of(seeds)}", marks=pytest.mark.exhaustive)


@pytest.mark.parametrize(("seeds", "element"), list(cases()))
def test_an_element_aside_changes_nothing(seeds: range, element: str) -> None:
    for seed in seeds:
        check_oscillator(seed, element)
        check_cradle(seed, element)
