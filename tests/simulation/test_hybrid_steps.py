"""Steps on the way of which joints stick, ropes go taut, values are sampled and rates jump."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.simulation.test_friction import SPEED, K, dragged, dragged_run, first_slip
from tests.tiers import cases

STEP = 0.05


def dragged_stepper(**options: Any) -> sb.Stepper:
    return sb.Stepper(sb.form_equations(dragged()), STEP, rtol=1e-10, atol=1e-12, **options)


def test_a_block_that_sticks_and_slips_goes_on_from_step_to_step() -> None:
    stepper, run = dragged_stepper(), dragged_run()
    happened = [event for _ in range(60) for event in stepper.step().events]
    assert not stepper.notes
    assert [event.name for event in happened] == [event.name for event in run.events]
    np.testing.assert_allclose([e.t for e in happened], [e.t for e in run.events], rtol=0, atol=1e-9)
    for name in ("x", "x_dot", "work", "friction guide", "mode guide"):
        assert stepper[name] == pytest.approx(run[name][-1], abs=1e-9)
    assert stepper.modes == {run.modes[-1].name: run.modes[-1].mode}
    start, *_ = first_slip()
    assert happened[0].t == pytest.approx(start, abs=1e-9)


@pytest.mark.parametrize("integrator", [None, sb.FixedStep(1e-3), sb.Stiff()], ids=str)
def test_outputs_at_present_are_those_of_the_modes(integrator: Any) -> None:
    stepper = dragged_stepper(integrator=integrator)
    for _ in range(3):
        pull = K * SPEED * stepper.t
        assert stepper["x_ddot"] == 0.0
        assert stepper["friction guide"] == pytest.approx(-pull, abs=1e-12)
        stepper.step()
    assert stepper.modes == {"guide": "sticks"}


def pushed() -> sb.EquationSet:
    """A block of 2 kg on a table, pushed by an input: friction holds 0.4*m*g, and brakes by 0.2*m*g."""
    guide = sb.Prismatic(
        "guide", "ground", sb.Body("Block", mass=2), axis="x", coordinate="x",
        friction=sb.Friction(mu=0.2, mu_static=0.4), force=sb.Drive(applied="F"),
    )  # fmt: skip
    return sb.form_equations(sb.Model("pushed", [guide], gravity=(0, 0, -10), inputs=["F"]))


def test_an_input_that_jumps_between_steps_breaks_a_block_away() -> None:
    stepper = sb.Stepper(pushed(), 0.1)
    stepper.step(F=7.9)
    assert stepper["x"] == 0.0 and stepper.modes == {"guide": "sticks"}
    stepper.step(F=8.1)
    assert [event.name for event in stepper.events] == ["guide slips forward"]
    assert stepper.events[0].t == pytest.approx(0.1)
    assert stepper["x"] == pytest.approx(0.5 * (8.1 - 4.0) / 2.0 * 0.1**2, rel=1e-9)
    stepper.step(F=0.0).step()  # it comes to rest 0.1025 s later
    assert stepper.modes == {"guide": "sticks"} and stepper["x_dot"] == pytest.approx(0.0, abs=1e-12)
    stopped = 0.1 + 0.1 + 0.205 / 2.0
    assert stepper.events[-1].t == pytest.approx(stopped, abs=1e-9)


def test_lanes_stick_and_slip_each_for_itself() -> None:
    eqs, forces = pushed(), [7.9, 8.1, 9.0]
    lanes = sb.LaneStepper(eqs, 0.1, lanes=3)
    for _ in range(3):
        lanes.step(F=forces)
    for lane, force in enumerate(forces):
        single = sb.Stepper(eqs, 0.1)
        for _ in range(3):
            single.step(F=force)
        np.testing.assert_array_equal(lanes.x[lane], np.concatenate([single.u, single.q]))


def sampled() -> sb.EquationSet:
    """The pushed block with a sampled controller, whose force the friction may hold."""
    guide = sb.Prismatic(
        "guide", "ground", sb.Body("Block", mass=2), axis="x", coordinate="x",
        friction=sb.Friction(mu=0.2, mu_static=0.4), force=sb.Drive(applied="push"),
    )  # fmt: skip
    push = sb.Signal("push", "30*(goal - x) - 2*x_dot", sample=0.03)
    return sb.form_equations(
        sb.Model("sampled", [guide, push], gravity=(0, 0, -10), parameters={"goal": 1.0})
    )


def test_the_first_sample_comes_before_modes_are_decided() -> None:
    """Without it the spring would break the block away: it is held by a force that is sampled at the start."""
    guide = sb.Prismatic(
        "guide", "ground", sb.Body("Block", mass=2), axis="x", coordinate="x",
        friction=sb.Friction(force=3), force=sb.Drive(applied="5 + hold"),
    )  # fmt: skip
    hold = sb.Signal("hold", "-5", sample=0.1)
    stepper = sb.Stepper(sb.form_equations(sb.Model("held", [guide, hold])), 0.05)
    assert stepper.step().events == () and stepper.modes == {"guide": "sticks"}
    assert stepper["x"] == 0.0


def jumping() -> sb.EquationSet:
    """A rail whose prescribed speed jumps twice, and a sprung block that sticks on it."""
    carriage, block = sb.Body("Carriage", mass=1), sb.Body("Block", mass=2)
    rail = sb.Prismatic(
        "rail", "ground", carriage, axis="x", motion="if(t < 0.33, 0.5*t, 0.165 - 0.7*(t - 0.33))"
    )
    slide = sb.Prismatic(
        "slide", carriage, block, axis="x", coordinate="x",
        friction=sb.Friction(force=3.0, static=4.0), force=sb.Drive(applied="-20*x"),
    )  # fmt: skip
    return sb.form_equations(sb.Model("jumping", [rail, slide]))


@pytest.mark.parametrize("make", cases([sampled, jumping], fast=[jumping]))
def test_steps_are_those_of_simulate(make: Any) -> None:
    eqs = make()
    stepper = sb.Stepper(eqs, 0.02, rtol=1e-10, atol=1e-12)
    assert not stepper.notes
    for _ in range(60):
        stepper.step()
    run = sb.simulate(eqs, 1.2, rtol=1e-10, atol=1e-12)
    assert stepper["x"] == pytest.approx(run["x"][-1], abs=1e-9)
    assert stepper["x_dot"] == pytest.approx(run["x_dot"][-1], abs=1e-8)
    assert stepper["work"] == pytest.approx(run["work"][-1], abs=1e-8)
    assert stepper.modes == {"guide" if make is sampled else "slide": run.modes[-1].mode}


@pytest.mark.parametrize("make", [sampled, jumping])
def test_restored_steps_go_on_to_the_bit(make: Any) -> None:
    eqs = make()
    stepper = sb.Stepper(eqs, 0.02, events=[sb.Event("x - 0.1", name="far")])
    for _ in range(12):
        stepper.step()
    saved, ends = stepper.save(), []
    for other in (stepper, stepper.copy(), sb.Stepper(eqs, 0.02, events=[sb.Event("x - 0.1", name="far")])):
        other.restore(saved)
        ends.append([(other.step().save(), other.events) for _ in range(20)])
    assert ends[0] == ends[1] == ends[2]
    first = sb.Stepper(eqs, 0.02, events=[sb.Event("x - 0.1", name="far")]).step()
    assert stepper.reset().step().save() == first.save()


def test_a_rope_that_goes_taut_in_a_step() -> None:
    ball = sb.Body("Ball", mass=2)
    place = sb.Rectangular("place", "ground", ball, coordinates=["x", "y"])
    rope = sb.Distance("rope", "ground", ball, 0.5, rope=True)
    eqs = sb.form_equations(sb.Model("drop", [place, rope], gravity=(0, -10, 0)))
    stepper = sb.Stepper(eqs, 0.1, initial={"y": -0.1})
    happened = [event for _ in range(4) for event in stepper.step().events]
    assert [event.name for event in happened] == ["rope taut"]
    assert happened[0].t == pytest.approx(np.sqrt(0.08), abs=1e-8)
    assert stepper["y"] == pytest.approx(-0.5, abs=1e-9) and stepper["y_dot"] == pytest.approx(0.0, abs=1e-9)
    assert stepper["rope_tension rope"] == pytest.approx(20.0)
    assert stepper["work"] == pytest.approx(-2.0 * 10.0 * 0.4, abs=1e-7)  # what the shock has lost
