"""The order at one instant: rates jump, events act, samples are taken; also where the motion ends."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.laws.motion_consumers import WAYS
from tests.laws.motion_fragments import END
from tests.tiers import cases

# Until t = 1 a block on a carriage swings freely; there the carriage's speed jumps by -1.2.
START, RATE = 0.1, 1.0
BEFORE = -START * np.sin(1.0)
BEHIND = BEFORE + 1.2  # momentum of the block is kept
KICK = 10.0


def carried() -> sb.EquationSet:
    """A block on a spring whose carriage is driven, with a sampled speed."""
    carriage, block = sb.Body("Carriage", mass=1), sb.Body("Block", mass=2)
    rail = sb.Prismatic("rail", "ground", carriage, axis="x", motion="if(t < 1, 0.5*t, 0.5 - 0.7*(t - 1))")
    slide = sb.Prismatic("slide", carriage, block, axis="x", coordinate="x", force=sb.Drive(applied="-2*x"))
    return sb.form_equations(
        sb.Model("carried", [rail, slide, sb.Signal("seen", "x_dot", sample=0.5)], initial={"x": START})
    )


KICKED = sb.Event("if(t < 1, -1, 1)", name="kick", action={"x_dot": f"x_dot + {KICK}"})


@pytest.mark.parametrize("integrator", [None, sb.Stiff(), sb.FixedStep(1e-3)], ids=str)
@pytest.mark.parametrize("end", cases([1.0, 1.25], fast=[1.0]))
@pytest.mark.parametrize("is_kicked", [False, True])
def test_a_jump_then_an_event_then_a_sample(integrator: Any, end: float, is_kicked: bool) -> None:
    run = sb.simulate(
        carried(), end, integrator=integrator, events=[KICKED] if is_kicked else [], rtol=1e-11, atol=1e-13
    )
    speed = BEHIND + (KICK if is_kicked else 0.0)
    assert run.held_values is not None
    np.testing.assert_allclose(run.held_values.t, [0.0, 0.5, 1.0], rtol=0, atol=1e-9)
    assert run.held_values.values[0, -1] == pytest.approx(speed, abs=1e-7)
    assert [event.t for event in run.events] == pytest.approx([1.0] * is_kicked)
    if is_kicked:
        assert run.events[0].state["x_dot"] == pytest.approx(BEHIND, abs=1e-7)
    if end == 1.0:
        assert run["x_dot"][-1] == pytest.approx(speed, abs=1e-7)
        assert run["seen"][-1] == pytest.approx(speed, abs=1e-7)


@pytest.mark.parametrize("step", [0.5, 0.4])
def test_steps_keep_the_order(step: float) -> None:
    stepper = sb.Stepper(carried(), step, events=[KICKED], rtol=1e-11, atol=1e-13)
    happened = []
    while stepper.t < 1.0 - 1e-9:
        happened += [event.name for event in stepper.step().events]
    assert happened == ["kick"]
    assert stepper["seen"] == pytest.approx(BEHIND + KICK, abs=1e-7)


def driven() -> sb.EquationSet:
    """The same with a jump at 0.5 s, and a force by the sampled speed, so that the motion shows the order."""
    carriage, block = sb.Body("Carriage", mass=1), sb.Body("Block", mass=2)
    rail = sb.Prismatic(
        "rail", "ground", carriage, axis="x", motion="if(t < 0.5, 0.5*t, 0.25 - 0.7*(t - 0.5))"
    )
    slide = sb.Prismatic(
        "slide", carriage, block, axis="x", coordinate="x", force=sb.Drive(applied="-2*x + 3*seen")
    )
    seen = sb.Signal("seen", "x_dot", sample=0.25)
    return sb.form_equations(sb.Model("driven", [rail, slide, seen], initial={"x": START}))


def place_at_end() -> float:
    """The oscillator x'' = -x + 1.5 seen, quarter by quarter; at 0.5 s the jump, then the kick, then the sample."""
    x, v, seen = START, 0.0, 0.0
    for quarter in range(4):
        if quarter == 2:
            v += 1.2 + KICK
        seen = v
        middle, cos, sin = 1.5 * seen, np.cos(0.25), np.sin(0.25)
        x, v = middle + (x - middle) * cos + v * sin, -(x - middle) * sin + v * cos
    return float(x)


@pytest.mark.parametrize(
    "way",
    cases(["simulate", "Stepper", "LaneStepper", "sweep", "C", "JavaScript", "live page", "FMU co-simulation",
           "FMU model exchange"], fast=lambda way: way != "FMU model exchange"),
)  # fmt: skip
def test_the_order_is_the_same_in_all_that_computes_motions(way: str, tmp_path: Path) -> None:
    kick = sb.Event("if(t < 0.5, -1, 1)", name="kick", action={"x_dot": f"x_dot + {KICK}"})
    question: Any = SimpleNamespace(
        eqs=driven(), events=(kick,), watched=("x",), folder=tmp_path, laws={}, freely="",
        fragments=[SimpleNamespace(initial={"x": START})],
    )  # fmt: skip
    (motion,) = WAYS[way].consume(question)[:1]
    assert motion.t[-1] == pytest.approx(END)
    assert motion.values["x"][-1] == pytest.approx(place_at_end(), abs=50 * WAYS[way].tolerance)
