"""Several joints that stick and slip: however they are listed, shared, or as close as a smooth law comes."""

from __future__ import annotations

from functools import cache
from itertools import permutations

import numpy as np
import pytest

import symbody as sb

PINS = "ABCD"
START = {"a": 0.6, "b": -0.3, "c": 1.1}


def four_bar(rubbing: str, order: tuple[str, ...], mu_static: float) -> sb.EquationSet:
    """A four-bar linkage under its weight whose pins of radius 0.05 m rub with mu = 0.1."""
    lengths = {"Crank": 0.5, "Rod": 1.5, "Rocker": 1.0}
    bodies = {
        name: sb.Body(name, length, (0, 0, length**3 / 12),
                      frames={"p": sb.Frame(at=(-length / 2, 0, 0)), "q": sb.Frame(at=(length / 2, 0, 0))})
        for name, length in lengths.items()
    }  # fmt: skip
    base = sb.Frame(at=(1.6, 0, 0))
    ends = {"A": ("ground", "Crank.p", "a"), "B": ("Crank.q", "Rod.p", "b"),
            "C": ("Rod.q", "Rocker.q", "c"), "D": ("ground.right", "Rocker.p", "d")}  # fmt: skip
    law = sb.Friction(mu=0.1, mu_static=mu_static, radius=0.05)
    joints = [
        sb.Revolute(
            name, *ends[name][:2], coordinate=ends[name][2], friction=law if name in rubbing else None
        )
        for name in order
    ]
    model = sb.Model("four-bar", [*bodies.values(), *joints], gravity=(0, -9.81, 0), ground={"right": base})
    return sb.form_equations(model, tree=sb.Trees("ABC", "ABC"))


@cache
def moved(rubbing: str, order: tuple[str, ...], mu_static: float) -> sb.Trajectory:
    return sb.simulate(
        four_bar(rubbing, order, mu_static), 2.5, {"a": 0.6}, guess=START, rtol=1e-9, atol=1e-11
    )


@pytest.mark.parametrize("mu_static", [0.1, 0.2], ids=["alike", "twice"])
@pytest.mark.parametrize("rubbing", ["B", PINS])
@pytest.mark.parametrize(
    "order",
    [pytest.param(order, marks=[] if k % 8 == 7 else pytest.mark.exhaustive, id="".join(order))
     for k, order in enumerate(permutations(PINS)) if k],
)  # fmt: skip
def test_the_order_of_joints_changes_nothing(rubbing: str, order: tuple[str, ...], mu_static: float) -> None:
    first, other = moved(rubbing, tuple(PINS), mu_static), moved(rubbing, order, mu_static)
    assert first.success and other.success and first.energy_drift < 1e-6
    assert len(first.modes) > 3

    def changes(run: sb.Trajectory) -> list[tuple[float, str, str]]:
        return sorted((round(change.t, 6), change.name, change.mode) for change in run.modes)

    times = [[change[0] for change in changes(run)] for run in (first, other)]
    assert [change[1:] for change in changes(first)] == [change[1:] for change in changes(other)]
    assert times[1] == pytest.approx(times[0], abs=1e-6)
    for name in ("a", "b", "c"):
        assert other[name][-1] == pytest.approx(first[name][-1], abs=1e-7)
