"""Law: a coordinate is assembled exactly where it is asked for, however far couplings carry the others.

Trains, screws, belts, equations and geared loops with ratios from 1e-3 to 1e3, one coordinate fixed 1e-4 to
1e4 from the guess. Couplings are linear, so that the others follow from the one by its ratios; loops close
after any number of turns.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache

import pytest

import symbody as sb
from symbody.formats.native import from_data
from symbody.tolerances import EXACT
from tests.problems.mechanisms import data_of

FEW, MANY = 60, 2000
# Newton's method ends where a residual is that of rounding its terms, some units in the last place of each, or
# `EXACT` of the size of its row: 1 rad, or the largest length.
ROUNDING = 1e-14

Values = dict[str, float]


@dataclass(frozen=True)
class Kind:
    """Equations, the coordinates that may be asked for, and what has to vanish, term by term."""

    eqs: sb.EquationSet
    asked: tuple[str, ...]
    terms: Callable[[Values, Values], list[list[float]]]


def turning(name: str) -> list[object]:
    body = sb.Body(name.upper(), mass=1, inertia=(1, 1, 1))
    return [body, sb.Revolute(f"axle {name}", "ground", name.upper(), axis="z", coordinate=name)]


def sliding(name: str) -> list[object]:
    body = sb.Body(name.upper(), mass=1)
    return [body, sb.Prismatic(f"rail {name}", "ground", name.upper(), coordinate=name)]


def formed(name: str, *elements: object) -> sb.EquationSet:
    parameters = dict.fromkeys(("i", "k", "m", "offset"), 1.0)
    return sb.form_equations(sb.Model(name, list(elements), parameters=parameters))


@cache
def kinds() -> dict[str, Kind]:
    gears = formed(
        "train", *turning("a"), *turning("b"), *turning("c"),
        sb.Gear("g", ("a", "b"), ratio="i", offset="offset"), sb.Gear("h", ("c", "b"), ratio="k"),
    )  # fmt: skip
    screw = formed(
        "screw", *sliding("x"), *turning("a"), *turning("b"),
        sb.RackPinion("rack", ("x", "a"), radius="m", offset="offset"), sb.Gear("g", ("b", "a"), ratio="i"),
    )  # fmt: skip
    belt = formed(
        "belt", *turning("a"), *turning("b"), *sliding("x"), *sliding("y"),
        sb.Belt("belt", ("a", "b"), radii=("abs(i)", "abs(k)")), sb.Constraint("e", ["m*x - y - offset"]),
    )  # fmt: skip
    cosine = formed(
        "cosine", *turning("a"), *turning("b"), *sliding("x"),
        sb.Gear("g", ("a", "b"), ratio="i"), sb.Constraint("e", ["x - m*cos(a) - offset"]),
    )  # fmt: skip
    data = data_of("four_bar")
    data["body"].append({"name": "Rotor", "mass": 1, "inertia": ["1", "1", "1"]})
    data["joint"].append(
        {"name": "axle", "type": "revolute", "between": ["ground", "Rotor"], "axis": "z", "coordinate": "a"}
    )
    data["constraint"] = [
        {"name": "g", "type": "gear", "coupled": ["a", "theta"], "ratio": "i", "offset": "offset"}
    ]
    data["parameters"] |= {"i": 1, "offset": 0}
    loop = sb.form_equations(from_data(data))
    return {
        "train": Kind(gears, ("a", "b", "c"), lambda q, p: [
            [q["a"], -p["i"] * q["b"], -p["offset"]], [q["c"], -p["k"] * q["b"]],
        ]),
        "screw": Kind(screw, ("x", "a", "b"), lambda q, p: [
            [q["x"], -p["m"] * q["a"], -p["offset"]], [q["b"], -p["i"] * q["a"]],
        ]),
        "belt": Kind(belt, ("a", "b", "x", "y"), lambda q, p: [
            [abs(p["i"]) * q["a"], -abs(p["k"]) * q["b"]], [p["m"] * q["x"], -q["y"], -p["offset"]],
        ]),
        "cosine": Kind(cosine, ("a", "b"), lambda q, p: [
            [q["a"], -p["i"] * q["b"]],
            # An angle of many turns has a cosine as exact as itself.
            [q["x"], -p["m"] * math.cos(q["a"]), -p["offset"], p["m"] * q["a"], -p["m"] * q["a"]],
        ]),
        "loop": Kind(loop, ("a", "theta"), lambda q, p: [[q["a"], -p["i"] * q["theta"], -p["offset"]]]),
    }  # fmt: skip


def drawn(seed: int, names: tuple[str, ...]) -> tuple[str, float, Values]:
    """The coordinate that is asked for, its value, and the parameters, all evenly spread over their decades."""
    rng = random.Random(f"far {seed}")

    def number(low: float, high: float) -> float:
        return rng.choice((-1, 1)) * 10 ** rng.uniform(low, high)

    values = {name: number(-3, 3) for name in ("i", "k", "m", "offset")}
    return rng.choice(names), number(-4, 4), values


def check(seeds: Iterable[int]) -> None:
    """Assemble the mechanism of each seed; the kinds take turns."""
    wrong, everything = [], list(kinds().items())
    for seed in seeds:
        name, kind = everything[seed % len(everything)]
        asked, value, parameters = drawn(seed, kind.asked)
        known = {key: x for key, x in parameters.items() if key in kind.eqs.parameter_names}
        try:
            state = sb.assemble(kind.eqs, {asked: value}, parameters=known)
        except sb.SymbodyError as error:
            wrong.append(f"{seed} {name}: {asked} = {value!r} at {known}: {error.problems[0].what}")
            continue
        row = EXACT * max(1.0, *map(abs, known.values()))
        for terms in kind.terms(dict(state.q), parameters):
            if not abs(sum(terms)) <= ROUNDING * sum(map(abs, terms)) + row:
                wrong.append(f"{seed} {name}: {asked} = {value!r} at {known}: {terms} sum to {sum(terms)}")
        size = max(1.0, *map(abs, state.q.values()), *map(abs, known.values()))
        is_open = name == "loop" and not state.residual <= ROUNDING * size
        if state.q[asked] != value or is_open:
            wrong.append(f"{seed} {name}: {asked} = {state.q[asked]!r}, open by {state.residual}")
    assert not wrong, "\n".join(wrong)


def test_far_values_are_reached() -> None:
    check(range(FEW))


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(FEW, MANY, 194))
def test_far_values_are_reached_often(first: int) -> None:
    check(range(first, first + 194))
