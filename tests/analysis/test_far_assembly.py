"""Assembly far from the guess along linear rows, and what is said where nothing closes: shown or only searched."""

from __future__ import annotations

import math
import random

import pytest

import symbody as sb
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.interval_numbers import INTERVALS, Interval
from tests.problems.mechanisms import equations_of


def wheel(name: str) -> list[object]:
    body = sb.Body(name.upper(), mass=1, inertia=(1, 1, 1))
    return [body, sb.Revolute(f"axle {name}", "ground", name.upper(), axis="z", coordinate=name)]


def slide(name: str) -> list[object]:
    body = sb.Body(name.upper(), mass=1)
    return [body, sb.Prismatic(f"rail {name}", "ground", name.upper(), coordinate=name)]


def formed(*elements: object) -> sb.EquationSet:
    return sb.form_equations(sb.Model("far", list(elements)))


@pytest.mark.parametrize(
    ("elements", "asked", "value", "other", "expected"),
    [
        ((*wheel("a"), *wheel("b"), sb.Gear("g", ("a", "b"), ratio=160)), "b", math.pi, "a", 160 * math.pi),
        # One turn of the screw is 2 mm.
        ((*slide("x"), *wheel("a"), sb.RackPinion("r", ("x", "a"), radius="0.002/(2*pi)")), "x", 0.5, "a", 500 * math.pi),
        ((*slide("x"), *wheel("a"), sb.RackPinion("r", ("x", "a"), radius=0.001)), "x", 0.5, "a", 500.0),
        ((*wheel("a"), *wheel("b"), sb.Belt("t", ("a", "b"), radii=("0.3", "0.002"))), "a", 3.0, "b", 450.0),
        # Millimetres: 1000 x = y + 300.
        ((*slide("x"), *slide("y"), sb.Constraint("e", ["1000*x - y - 300"])), "x", 0.7, "y", 400.0),
    ],
    ids=["gear", "screw", "pinion", "belt", "millimetres"],
)  # fmt: skip
def test_linear_couplings_lead_any_distance(
    elements: tuple[object, ...], asked: str, value: float, other: str, expected: float
) -> None:
    eqs = formed(*elements)
    state = sb.assemble(eqs, {asked: value})
    assert state.q[asked] == value
    # The quotient of two numbers of three or four roundings each.
    assert state.q[other] == pytest.approx(expected, rel=1e-15)
    run = sb.simulate(eqs, 1e-3, initial={asked: value})
    assert run.success and run[asked][0] == value


@pytest.mark.parametrize("ratio", [200, -200, 1000])
def test_an_arm_behind_a_gear_hangs_down(ratio: int) -> None:
    link = sb.Body("Link", mass=2, inertia=(0.1, 0.1, 0.1), frames={"base": sb.Frame(at=(0, 0, 0.3))})
    elements = [
        link, sb.Revolute("arm", "ground", "Link.base", axis="y", coordinate="th"), *wheel("a"),
        sb.Gear("g", ("a", "th"), ratio=ratio),
    ]  # fmt: skip
    eqs = sb.form_equations(sb.Model("geared arm", elements, gravity=("-9.81", 0, 0)))
    found = sb.find_equilibrium(eqs, guess={"th": 0.9})
    # Across the pull the arm hangs where its centre of mass lies below the axle, a quarter turn on.
    assert found.q["th"] == pytest.approx(math.pi / 2, abs=1e-9)
    assert found.q["a"] == pytest.approx(ratio * found.q["th"], rel=1e-14)


def problem(eqs: sb.EquationSet, *given: object, **others: object) -> sb.Problem:
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(eqs, *given, **others)  # type: ignore[arg-type]
    return caught.value.problems[0]


def test_linear_contradictions_are_shown() -> None:
    gear = sb.Gear("g", ("a", "b"), ratio=160)
    both = problem(formed(*wheel("a"), *wheel("b"), gear), {"a": 1, "b": 2})
    assert both.code == "assembly.conflict" and both.what == "no configuration has a = 1, b = 2"
    assert "equations of g are linear" in both.why
    none = problem(
        formed(*wheel("a"), *wheel("b"), sb.Constraint("e", ["a - b"]), sb.Constraint("f", ["a - b - 1"]))
    )
    assert none.code == "assembly.open"
    assert "there is no configuration: equations of e, f are linear" in none.why


def test_rods_that_do_not_reach_are_shown() -> None:
    # A crank of 0.4 m and a rod of 1 m reach 1.4 m at most.
    crank = equations_of("slider_crank")
    assert problem(crank, {"s": 1.41}).what == "no configuration has s = 1.41"
    assert sb.assemble(crank, {"s": 1.39}).q["s"] == 1.39
    # Posts 0.5 m apart, crank and rocker of 0.2 and 0.4 m: a coupler of 1.2 m is longer than all three.
    long = problem(equations_of("four_bar"), parameters={"L2": 1.2})
    assert (
        long.code == "assembly.open" and "C cannot close for any values of the other coordinates" in long.why
    )


def test_what_was_only_searched_for_is_said_so() -> None:
    # No rule bounds cosh here, so that nothing is shown, although the sum is 2 at least.
    eqs = formed(*slide("x"), *slide("y"), sb.Constraint("e", ["cosh(x) + cosh(y) - 1"]))
    open_rows = problem(eqs)
    assert open_rows.code == "assembly.open" and "the search from 24 starting points" in open_rows.why
    cosh = formed(*slide("x"), *slide("y"), sb.Constraint("e", ["cosh(x) - y"]))
    fixed = problem(cosh, {"y": 0.5})
    assert fixed.what == "no configuration was found with y = 0.5"
    assert "the search from 24 starting points" in fixed.why


def test_steps_are_not_taken_for_lines() -> None:
    # The derivative of floor is 0 everywhere, and still y = floor(x) has y = 3.
    eqs = formed(*slide("x"), *slide("y"), sb.Constraint("e", ["y - floor(x/2)"]))
    assert problem(eqs, {"y": 3.5}).what == "no configuration was found with y = 3.5"


def test_intervals_hold_all_values() -> None:
    eqs = formed(*wheel("a"), *wheel("b"), *slide("x"), *slide("y"), sb.Constraint("e", [
        "sqrt((x*cos(a) - y)^2 + (x*sin(a + 2*b))^2 + 0.1) - abs(x*y)/(1.5 + sin(b)) + (x - 1)^3",
    ]))  # fmt: skip
    sequence = sb.compile(eqs, "constraints").shared_sequence
    rng = random.Random(1)
    for _ in range(200):
        lows = [rng.uniform(-4, 4) for _ in range(4)]
        highs = [low + 10 ** rng.uniform(-3, 1) for low in lows]
        still = [Interval(0.0, 0.0)] * 4
        boxes = {"t": [Interval(0.0, 0.0)], "q": list(map(Interval, lows, highs)), "u": still, "p": []}
        bound = evaluate_sequence(sequence, boxes, INTERVALS)[0][0]
        for _ in range(10):
            q = [
                rng.choice((low, high, rng.uniform(low, high))) for low, high in zip(lows, highs, strict=True)
            ]
            value = evaluate_sequence(sequence, {"t": [0.0], "q": q, "u": [0.0] * 4, "p": []})[0][0]
            assert bound.low <= value <= bound.high
