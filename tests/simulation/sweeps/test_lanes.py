"""Cases side by side: the bits of one after the other, whatever happens to their neighbours."""

from __future__ import annotations

import concurrent.futures
import functools
from collections.abc import Callable
from itertools import count

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.parameter_set import ParameterSet
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.machine import lanes
from symbody.simulation.sweeps.loop_job import CASES_THAT_PAY
from tests.simulation.sweeps.test_sweep import equations, same_bits

WIDTH = lanes()
MANY = 3 * WIDTH + 1  # refilled twice, and one lane a third time

Options = dict[str, object]


@functools.cache
def slide(force: str, **parameters: float) -> sb.EquationSet:
    joint = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive(force))
    model = sb.Model("slide", [sb.Body("B", mass=1), joint], gravity=(0, 0, 0), parameters=parameters)
    return sb.form_equations(model)


def tops(**options: object) -> sb.Sweep:
    rates = np.linspace(2.0, 30.0, MANY)  # fast and slow ones, which end at different times
    return sb.sweep(equations("spinning_top"), 2.0, {"m": 1.1}, initial={"xi_dot": rates}, **options)


def duffing(**options: object) -> sb.Sweep:
    """Without sines and cosines, from the end to the beginning."""
    stiffness = np.linspace(0.0, 50.0, MANY)
    return sb.sweep(slide("-k*x**3 - x", k=1.0), (3.0, 0.0), {"k": stiffness}, initial={"x": 1.0}, **options)


def runaways(**options: object) -> sb.Sweep:
    """x' = x^2 from 1 is infinite at t = 1, from -1 it never is; from 0 it has no first step to guess."""
    starts = np.tile([-1.0, 1.0, 0.0], MANY)[:MANY]
    eqs = slide("2*x**3")
    return sb.sweep(eqs, 2.0, {}, initial={"x": starts, "x_dot": starts**2}, combine="list", **options)


def roots(**options: object) -> sb.Sweep:
    """Derivatives that are not finite: some at the start, some on the way, some never."""
    return sb.sweep(slide("sqrt(a - t)", a=1.0), 2.0, {"a": np.linspace(-1.0, 3.0, MANY)}, **options)


def dampers(**options: object) -> sb.Sweep:
    """Some of them stiff, which is judged again and again."""
    damping = np.geomspace(1.0, 1e5, MANY)
    eqs = slide("-x - d*x_dot", d=1.0)
    return sb.sweep(eqs, 3.0, {"d": damping}, initial={"x": 1.0}, max_steps=20_000, **options)


def cranks(**options: object) -> sb.Sweep:
    """Accelerations from a linear system, which pistons of negative mass make singular on the way."""
    return sb.sweep(
        equations("slider_crank"),
        0.5,
        {"m3": np.linspace(-2.0, 0.8, MANY)},
        initial={"theta_dot": 4.0},
        constraints=sb.Baumgarte(),
        **options,
    )


@pytest.fixture(autouse=True)
def _masses_are_not_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Negative masses, which sweeps refuse, are what makes linear systems singular on the way."""
    monkeypatch.setattr(ParameterSet, "require_possible", lambda values: None)


SWEEPS = [tops, duffing, runaways, roots, dampers, cranks]
METHODS: list[Options] = [
    {},
    {"times": [0.5]},
    {"integrator": sb.Explicit(order=5), "rtol": 1e-5},
    {"integrator": sb.FixedStep(0.02)},
    {"integrator": sb.FixedStep(0.02, "semi-implicit"), "times": np.linspace(0.005, 1.995, 7)},
]


@pytest.mark.parametrize("options", METHODS[:2], ids=["samples", "ends"])
@pytest.mark.parametrize("made", SWEEPS)
def test_cases_in_lanes_have_the_bits_of_one_after_the_other(
    made: Callable[..., sb.Sweep], options: Options
) -> None:
    options = dict(options, threads=1, part=MANY)
    assert same_bits(made(lanes=False, **options), made(lanes=True, **options))


@pytest.mark.exhaustive
@pytest.mark.parametrize("options", METHODS, ids=["samples", "ends", "order 5", "RK4", "semi-implicit"])
@pytest.mark.parametrize("made", SWEEPS)
def test_every_method_has_the_same_bits_in_lanes(made: Callable[..., sb.Sweep], options: Options) -> None:
    options = dict(options, threads=1, part=MANY)
    if made is duffing and "times" in options:  # it runs backwards
        options["times"] = np.flip(options["times"])  # type: ignore[arg-type]
    if made is cranks:
        options.pop("times", None)
    assert same_bits(made(lanes=False, **options), made(lanes=True, **options))


def test_these_cases_end_in_different_ways() -> None:
    ends = {status for made in SWEEPS[:4] for status in made(times=[0.5], lanes=True, part=MANY).status}
    assert ends == {sb.Status.SUCCESS, sb.Status.STEP_COLLAPSE, sb.Status.NOT_FINITE}


def test_functions_that_fail_in_one_lane_are_tried_lane_by_lane() -> None:
    options: Options = {"integrator": sb.FixedStep(0.02), "threads": 1, "part": MANY}
    alone, together = cranks(lanes=False, **options), cranks(lanes=True, **options)
    assert {*together.status} == {sb.Status.SUCCESS, sb.Status.SINGULAR}
    assert same_bits(alone, together)


def test_arrays_of_messages_cannot_be_written_to() -> None:
    for made in (duffing, cranks):
        for side_by_side in (False, True):
            sent = made(times=[0.5], lanes=side_by_side, part=MANY, executor=Sending())
            assert same_bits(sent, made(times=[0.5], lanes=side_by_side, part=MANY))


class Sending(concurrent.futures.Executor):
    """Gives each part in arrays that cannot be written to, as they come out of a message."""

    def submit(self, function, /, payload, part, threads):  # type: ignore[no-untyped-def]
        for array in (part.states, part.parameters, *part.sizes):
            array.flags.writeable = False
        task: concurrent.futures.Future[object] = concurrent.futures.Future()
        task.set_result(function(payload, part, threads))
        return task


def test_an_interrupted_sweep_tells_how_far_each_lane_came() -> None:
    eqs = equations("spinning_top")
    for patience in (1, 10, 100, 1000):  # a slow machine may be asked before its first step
        calls = count()
        result = sb.sweep(
            eqs, (0.0, 1e5), {"m": np.linspace(0.9, 1.1, 2 * WIDTH)}, times=[1e5], threads=1, lanes=True,
            progress=lambda share, calls=calls, patience=patience: next(calls) < patience,
        )  # fmt: skip
        assert set(result.status) == {sb.Status.INTERRUPTED}
        if np.isfinite(result.reached).any():
            break
    assert np.nanmax(result.reached) < 1e5


def test_lanes_are_used_where_there_are_many_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    usual = CompiledFunction.in_lanes
    monkeypatch.setattr(CompiledFunction, "in_lanes", lambda function: asked.append(1) or usual(function))
    eqs = slide("-k*x**3 - x", k=1.0)
    for cases in (CASES_THAT_PAY - 1, CASES_THAT_PAY):
        sb.sweep(eqs, 1.0, {"k": np.linspace(0.0, 1.0, cases)}, initial={"x": 1.0}, times=[1.0], threads=1)
        assert bool(asked) == (cases == CASES_THAT_PAY)


@pytest.mark.parametrize("lanes", [8, 1, 0, "yes", 1.0])
def test_lanes_are_wanted_or_not(lanes: bool) -> None:
    with pytest.raises(sb.UsageError, match="sweep.lanes") as fault:
        duffing(lanes=lanes)
    assert "neither True, False nor None" in str(fault.value)
