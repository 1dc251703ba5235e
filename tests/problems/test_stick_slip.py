"""Blocks that stick and slip, on a belt and on an incline: every switch at its time of the closed form."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import symbody as sb

M, G, K, SPEED = 1.5, 9.81, 40.0, 0.3
STATIC, SLIDING = 0.3, 0.2
OMEGA = math.sqrt(K / M)
# What is promised; roots of v = 0 are found at rtol = 1e-10, and no error grows from cycle to cycle, because
# every sticking begins anew.
SWITCH = 1e-6


@cache
def belt() -> sb.EquationSet:
    """A block on a belt, held back by a spring to ground (den Hartog's oscillator of the second kind)."""
    parts = [
        *(sb.Body("Belt"), sb.Body("Block", "m")),
        sb.Prismatic("drive", "ground", "Belt", axis="x", coordinate="b", motion="V*t"),
        sb.Prismatic("contact", "Belt", "Block", axis="x", coordinate="slip",
                     friction=sb.Friction(mu="mu", mu_static="mus")),
        sb.SpringDamper("spring", "ground.post", "Block", stiffness="k", free=1),
    ]  # fmt: skip
    numbers = {"m": M, "g": G, "k": K, "V": SPEED, "mu": SLIDING, "mus": STATIC}
    post = {"post": sb.Frame((-1, 0, 0))}
    return sb.form_equations(
        sb.Model("belt", parts, gravity=(0, 0, "-g"), ground=post, parameters=numbers)
    )  # fmt: skip


def switches(until: float) -> list[tuple[str, float]]:
    """Break-away where the spring pulls with STATIC m g; then x about SLIDING m g / K until x' = SPEED again.

    With A = (STATIC - SLIDING) m g / K: x = A cos(w s) + SPEED / w sin(w s), whose rate is SPEED again at
    tan(w s / 2) = -A w / SPEED, at -A by symmetry; the belt carries it back to A in 2 A / SPEED.
    """
    A = (STATIC - SLIDING) * M * G / K
    slip, stick = 2.0 * (math.pi - math.atan(A * OMEGA / SPEED)) / OMEGA, 2.0 * A / SPEED
    found, t = [], STATIC * M * G / (K * SPEED)
    while t < until:
        found.append(("contact slips backward", t))
        if t + slip < until:
            found.append(("contact sticks", t + slip))
        t += slip + stick
    return found


def test_a_block_on_a_belt_switches_when_it_should() -> None:
    run = sb.simulate(belt(), 20.0, {"slip": 0.0, "slip_dot": 0.0}, rtol=1e-10, atol=1e-12)
    assert run.success
    wanted = switches(20.0)
    assert len(wanted) > 30 and [event.name for event in run.events] == [name for name, _ in wanted]
    late = [abs(event.t - t) for event, (_, t) in zip(run.events, wanted, strict=True)]
    assert max(late) < SWITCH
    # No stall: some steps a phase, where a sign() in the force takes millions.
    assert run.statistics.accepted < 40 * len(wanted)
    sticking = np.abs(run["slip_dot"]) < 1e-12
    pull = run["friction contact"]
    assert sticking.any() and np.abs(pull[sticking]).max() <= STATIC * M * G * (1 + 1e-9)
    assert run.energy_drift < 1e-8


@pytest.mark.parametrize("rate", [0.1, 2.0])
def test_a_block_on_an_incline_that_tilts(rate: float) -> None:
    """It rests at the axis of the tilt until tan(angle) = mu_static, whatever the rate, then slides down."""
    parts = [
        *(sb.Body("Plane"), sb.Body("Block", "m")),
        sb.Revolute("tilt", "ground", "Plane", axis="z", coordinate="a", motion="rate*t"),
        sb.Prismatic("contact", "Plane", "Block", axis="x", coordinate="x",
                     friction=sb.Friction(mu="mu", mu_static="mus")),
    ]  # fmt: skip
    numbers = {"m": M, "g": G, "mu": SLIDING, "mus": STATIC, "rate": rate}
    eqs = sb.form_equations(sb.Model("tilting", parts, gravity=(0, "-g", 0), parameters=numbers))
    away = math.atan(STATIC) / rate
    run = sb.simulate(eqs, 1.5 * away, rtol=1e-10, atol=1e-12)
    assert run.success and [event.name for event in run.events] == ["contact slips backward"]
    assert run.events[0].t == pytest.approx(away, abs=SWITCH)
    before = run.t < away
    assert np.abs(run["x"][before]).max() == 0.0 and run["x"][-1] < 0.0


@pytest.mark.parametrize(("slope", "stays"), [(0.15, True), (0.25, False)])
def test_a_block_pushed_down_an_incline(slope: float, stays: bool) -> None:
    """Less steep than the angle of sliding friction it stops after v / (g (mu cos - sin)) and stays."""
    guide = sb.Prismatic("guide", "ground.i", sb.Body("Block", "m"), coordinate="x",
                         friction=sb.Friction(mu="mu", mu_static="mus"))  # fmt: skip
    numbers = {"m": M, "g": G, "a": slope, "mu": SLIDING, "mus": STATIC}
    plane = {"i": sb.Frame(rotate=[("z", "a")])}
    eqs = sb.form_equations(
        sb.Model("incline", [guide], gravity=(0, "-g", 0), parameters=numbers, ground=plane)
    )
    run = sb.simulate(eqs, 3.0, {"x_dot": -0.8}, rtol=1e-10, atol=1e-12)
    slower = G * (SLIDING * math.cos(slope) - math.sin(slope))
    assert run.success and [event.name for event in run.events] == (["guide sticks"] if stays else [])
    if stays:
        assert run.events[0].t == pytest.approx(0.8 / slower, abs=SWITCH)
        assert run["x"][-1] == pytest.approx(-(0.8**2) / (2 * slower), abs=SWITCH)
    else:
        assert run["x_dot"][-1] == pytest.approx(-0.8 + slower * 3.0, rel=1e-9)
