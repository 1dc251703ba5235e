"""A four-bar whose pins stick and slip: what is found does not depend on the order of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import pytest

import symbody as sb

MU = (0.3, 0.4, 0.5, 0.6)
START = {"a": 1.0, "a_dot": 0.0}
GUESS = {"b": -0.7, "c": 1.0, "d": 1.6}


def four_bar(order: Sequence[int], torque: str) -> sb.EquationSet:
    """Crank 0.6, coupler 2.2, rocker 1.5, ground 2 m; dry friction in all pins; a torque on the crank."""
    numbers = {"m1": 1.0, "m2": 2.0, "m3": 1.5, "l1": 0.6, "l2": 2.2, "l3": 1.5, "g": 9.81, "r": 0.05}
    bodies = {
        name: sb.Body(name, f"m{k}", (0, 0, f"m{k}*l{k}^2/3"), frames={"tip": sb.Frame(at=(f"l{k}", 0, 0))})
        for k, name in enumerate(("Crank", "Coupler", "Rocker"), 1)
    }
    ends = [
        ("A", "ground", "Crank"), ("B", "Crank.tip", "Coupler"), ("C", "Coupler.tip", "Rocker.tip"),
        ("D", "ground.g", "Rocker"),
    ]  # fmt: skip
    pins = [
        sb.Revolute(name, start, end, axis="z", coordinate=name.lower(),
                    friction=sb.Friction(mu=mu, radius="r"))
        for (name, start, end), mu in zip(ends, MU, strict=True)
    ]  # fmt: skip
    load = sb.Torque("drive", "Crank", (0, 0, torque))
    ground = {"g": sb.Frame(at=(2, 0, 0))}
    parts = [*bodies.values(), *(pins[k] for k in order), load]
    return sb.form_equations(
        sb.Model("bar", parts, gravity=(0, "-g", 0), ground=ground, parameters=numbers),
        tree=sb.Trees("ABD", "ABD"),
    )


def run(order: Sequence[int], torque: str) -> sb.Trajectory:
    return sb.simulate(four_bar(order, torque), 1.0, START, guess=GUESS, rtol=1e-9, atol=1e-11)


def test_pins_whose_rates_pass_zero_slip_the_other_way() -> None:
    """The crank turns over, the pins of the rocker reverse one after the other, and none sticks."""
    found = run((0, 1, 2, 3), "9.4 + 10*t")
    assert found.success
    assert [event.name for event in found.events] == ["C slips backward", "D slips backward"]
    for event in found.events:
        assert abs(float(found.at(event.t)[f"{event.name[0].lower()}_dot"])) < 1e-8


def compare(orders: Sequence[Sequence[int]]) -> None:
    first = run((0, 1, 2, 3), "40*t")
    away = [event.name for event in first.events[:4]]
    assert sorted(away) == ["A slips forward", "B slips backward", "C slips forward", "D slips forward"]
    for order in orders:
        other = run(order, "40*t")
        assert sorted(e.name for e in other.events) == sorted(e.name for e in first.events)
        times = sorted(e.t for e in other.events), sorted(e.t for e in first.events)
        assert times[0] == pytest.approx(times[1], abs=1e-8)
        assert other.at(1.0)["a"] == pytest.approx(float(first.at(1.0)["a"]), abs=1e-7)


@pytest.mark.exhaustive
def test_the_order_of_pins_changes_neither_modes_nor_the_motion() -> None:
    compare([(2, 0, 3, 1)])


@pytest.mark.exhaustive
def test_no_order_of_pins_changes_modes_or_the_motion() -> None:
    compare(list(permutations(range(4)))[1:])
