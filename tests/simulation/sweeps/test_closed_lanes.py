"""Closed loops side by side, each held by its own projections: the bits of one after the other."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.parameter_set import ParameterSet
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.machine import lanes
from tests.simulation.sweeps.test_sweep import equations, same_bits
from tests.tiers import cases

MANY = 3 * lanes() + 1  # refilled twice, and one lane a third time

Options = dict[str, object]
SUCCESS, COLLAPSE, SINGULAR = sb.Status.SUCCESS, sb.Status.STEP_COLLAPSE, sb.Status.SINGULAR


@functools.cache
def four_bar() -> sb.EquationSet:
    """Three bars in the plane, each of its own mass; the last hinge closes the loop."""

    def bar(name: str, mass: str, length: float) -> sb.Body:
        ends = {"start": sb.Frame(at=(-length / 2, 0, 0)), "end": sb.Frame(at=(length / 2, 0, 0))}
        return sb.Body(name, mass=mass, inertia=(0, 0, 0.05), frames=ends)

    elements = [
        bar("Crank", "m1", 0.4), bar("Coupler", "m2", 1.0), bar("Rocker", "m3", 0.8),
        sb.Revolute("A", "ground", "Crank.start", axis="z", coordinate="theta"),
        sb.Revolute("B", "Crank.end", "Coupler.start", axis="z", coordinate="phi"),
        sb.Revolute("D", "ground.post", "Rocker.start", axis="z", coordinate="psi"),
        sb.Revolute("C", "Coupler.end", "Rocker.end", axis="z"),
    ]  # fmt: skip
    start = {"theta": 1.0, "phi": -0.7, "psi": 1.4}
    masses = {"m1": 1.0, "m2": 2.0, "m3": 1.5}
    model = sb.Model(
        "four-bar", elements, gravity=(0, -9.81, 0), parameters=masses, initial=start,
        ground={"post": sb.Frame(at=(1, 0, 0))},
    )  # fmt: skip
    return sb.form_equations(model)


@functools.cache
def ball() -> sb.EquationSet:
    """A body on a ball joint, whose quaternion is all there is to project."""
    joint = sb.Spherical("ball", "ground", "B.pivot", coordinates=("a", "b", "c", "d"), angles="quaternion")
    body = sb.Body("B", mass="m", inertia=(0.1, 0.2, 0.3), frames={"pivot": sb.Frame(at=(0, 0, 0.5))})
    return sb.form_equations(sb.Model("ball", [body, joint], gravity=(0, 0, -9.81), parameters={"m": 1.0}))


def _swept(eqs: sb.EquationSet, name: str, low: float, high: float, rate: str, **options: object) -> sb.Sweep:
    options = {"constraints": sb.Projection(), "threads": 1, "part": MANY} | options
    return sb.sweep(eqs, 1.5, {name: np.linspace(low, high, MANY)}, initial={rate: 4.0}, **options)  # type: ignore[arg-type]


def cranks(**options: object) -> sb.Sweep:
    return _swept(equations("slider_crank"), "m3", 0.1, 4.0, "theta_dot", **options)


def failing_cranks(**options: object) -> sb.Sweep:
    """Pistons of negative mass make the linear systems of some singular on the way."""
    return _swept(equations("slider_crank"), "m3", -2.0, 0.8, "theta_dot", **options)


def four_bars(**options: object) -> sb.Sweep:
    return _swept(four_bar(), "m2", 0.1, 4.0, "theta_dot", **options)


def failing_four_bars(**options: object) -> sb.Sweep:
    """Steps of 0.02 s pass the place where the mass is zero, which steps that follow an error do not."""
    method: Options = {"integrator": sb.FixedStep(0.02)}
    return _swept(four_bar(), "m2", -1.12, 4.0, "theta_dot", **{**method, **options})


def spatial_four_bars(**options: object) -> sb.Sweep:
    """Two freedoms left, so that lanes may differ in their pivots."""
    return _swept(equations("spatial_four_bar"), "m2", 0.1, 4.0, "theta_dot", **options)


def balls(**options: object) -> sb.Sweep:
    rates = {ball().speed_names[0]: np.linspace(1.0, 20.0, MANY)}
    return sb.sweep(ball(), 1.5, {"m": 2.0}, initial=rates, **{"threads": 1, "part": MANY, **options})  # type: ignore[arg-type]


@pytest.fixture(autouse=True)
def _masses_are_not_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Negative masses, which sweeps refuse, are what makes linear systems singular on the way."""
    monkeypatch.setattr(ParameterSet, "require_possible", lambda values: None)


SWEEPS = [cranks, failing_cranks, four_bars, failing_four_bars, spatial_four_bars, balls]
METHODS: list[Options] = [
    {},
    {"times": [1.5]},
    {"constraints": sb.Projection(limit=0.3), "rtol": 1e-4, "times": [0.5, 1.5]},
    {"integrator": sb.Explicit(order=5), "rtol": 1e-5},
    {"integrator": sb.FixedStep(0.01)},
    {"integrator": sb.FixedStep(0.002, "semi-implicit")},
    {"constraints": sb.Projection(tolerance=1e-15)},
]
NAMES = ["samples", "ends", "small moves", "order 5", "RK4", "semi-implicit", "tight"]


@pytest.mark.parametrize("options", METHODS[:1], ids=NAMES[:1])
@pytest.mark.parametrize("made", cases(SWEEPS, fast=[failing_four_bars, spatial_four_bars]))
def test_closed_loops_in_lanes_have_the_bits_of_one_after_the_other(
    made: Callable[..., sb.Sweep], options: Options
) -> None:
    assert same_bits(made(lanes=False, **options), made(lanes=True, **options))


@pytest.mark.exhaustive
@pytest.mark.parametrize("options", METHODS[1:], ids=NAMES[1:])
@pytest.mark.parametrize("made", SWEEPS)
def test_every_method_has_the_same_bits_for_closed_loops(
    made: Callable[..., sb.Sweep], options: Options
) -> None:
    assert same_bits(made(lanes=False, **options), made(lanes=True, **options))


def test_a_lane_that_fails_leaves_the_others_alone() -> None:
    for made, failure in ((failing_cranks, COLLAPSE), (failing_four_bars, SINGULAR)):
        result = made(lanes=True)
        ends = Counter(result.status)
        assert set(ends) == {SUCCESS, failure}
        # Each is what it is beside neighbours that succeed.
        good = np.flatnonzero(result.succeeded)
        alone = sb.sweep(
            four_bar() if made is failing_four_bars else equations("slider_crank"),
            1.5,
            {name: column[good] for name, column in result.cases.items() if name != "theta_dot"},
            initial={"theta_dot": 4.0},
            constraints=sb.Projection(),
            integrator=None if made is failing_cranks else sb.FixedStep(0.02),
            lanes=False,
        )
        assert alone.x.tobytes() == result.x[good].tobytes()


def test_projections_that_fail_end_their_own_lanes() -> None:
    # Moves this small are asked for by some motions alone.
    options: Options = {"constraints": sb.Projection(limit=1e-7), "times": [1.5]}
    alone, together = cranks(lanes=False, **options), cranks(lanes=True, **options)
    assert set(alone.status) == {SUCCESS, COLLAPSE}
    assert same_bits(alone, together)


def test_loops_stay_closed_in_lanes() -> None:
    for made in (cranks, four_bars):
        assert np.abs(made(lanes=True)["constraints"]).max() < 1e-9


def test_closed_loops_use_lanes(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    usual = CompiledFunction.in_lanes
    monkeypatch.setattr(CompiledFunction, "in_lanes", lambda function: asked.append(1) or usual(function))
    cranks(times=[1.5], lanes=False)
    assert not asked
    cranks(times=[1.5], lanes=True)
    assert asked
