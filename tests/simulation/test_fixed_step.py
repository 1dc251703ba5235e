"""Steps of one length: orders, energies, and what happens where they fail."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from tests.simulation.loops import example
from tests.simulation.test_change_point import wheels_on_a_rod
from tests.simulation.test_closed_loops import angle, at_lowest_point, free_pendulum
from tests.simulation.test_order import IMPACTS, mass_on_spring

EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def oscillator() -> sb.EquationSet:
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("-w**2*x"))
    model = sb.Model("oscillator", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0), parameters={"w": 2.0})
    return sb.form_equations(model)


def motion(step: float, method: str, end: float = 1.0) -> sb.Trajectory:
    integrator = sb.FixedStep(step, method)  # type: ignore[arg-type]
    return sb.simulate(oscillator(), end, {"x": 1.0}, integrator=integrator)


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("semi-implicit", 1)])
def test_errors_shrink_with_the_order(method: str, order: int) -> None:
    errors = [abs(motion(step, method)["x"][-1] - np.cos(2.0)) for step in (1 / 64, 1 / 128)]
    # the next term of the error is smaller by a factor of the order of the step
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_semi_implicit_steps_are_those_of_symplectic_euler() -> None:
    run = motion(1 / 4, "semi-implicit", 2.0)
    x, v = 1.0, 0.0
    for k in range(9):
        assert run["x"][k] == pytest.approx(x, rel=1e-13) and run["x_dot"][k] == pytest.approx(v, rel=1e-13)
        v -= 4.0 * x / 4
        x += v / 4


def test_semi_implicit_euler_keeps_its_own_energy() -> None:
    # v^2 + w^2 x^2 - h w^2 x v is constant for the oscillator, up to rounding of each of 4000 steps
    run = motion(1 / 40, "semi-implicit", 100.0)
    x, v = run["x"], run["x_dot"]
    own = v**2 + 4 * x**2 - 4 * x * v / 40
    assert np.ptp(own) < 4000 * 4 * 2.2e-16 * own[0]


def test_steps_have_one_length_but_the_last() -> None:
    run = motion(0.3, "rk4")
    np.testing.assert_allclose(np.diff(run.t), [0.3, 0.3, 0.3, 0.1], rtol=1e-12)
    assert run.statistics.rejected == 0


def test_closed_loops_are_closed_after_every_step() -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    run = sb.simulate(eqs, 0.5, integrator=sb.FixedStep(5e-3))
    exact = sb.simulate(eqs, 0.5, times=[0.5])
    assert run.success and run.t.size == 101
    assert run.constraint_violation.max() < 1e-9
    assert run["s"][-1] == pytest.approx(exact["s"][-1], abs=1e-6)  # 5e-3**4 times derivatives of about 1e3


def test_a_failing_step_is_not_tried_again() -> None:
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("sqrt(1 - t)"))
    model = sb.Model("stop", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0))
    run = sb.simulate(sb.form_equations(model), 2.0, integrator=sb.FixedStep(0.25))
    assert run.status is sb.Status.NOT_FINITE
    assert run.t[-1] == 1.0 and run.statistics.rejected == 1


def test_sweeps_take_fixed_steps() -> None:
    result = sb.sweep(oscillator(), 1.0, {"w": [1.0, 2.0]}, initial={"x": 1.0}, integrator=sb.FixedStep(1e-2))
    np.testing.assert_allclose(result["x"][:, -1], np.cos([1.0, 2.0]), atol=1e-7)


def test_steps_and_methods_that_make_no_sense_are_refused_together() -> None:
    with pytest.raises(sb.UsageError) as fault:
        sb.FixedStep(-1.0, "euler")  # type: ignore[arg-type]
    assert len(fault.value.problems) == 2
    with pytest.raises(sb.UsageError, match="cannot be combined"):
        sb.simulate(oscillator(), 1.0, integrator=sb.FixedStep(0.1), constraints=sb.GGL())


BOUNCE = sb.Event("y", -1, {"y_dot": "-e*y_dot"})


def bouncing(method: str, steps: float) -> sb.Trajectory:
    """The mass that hits its wall after every pi seconds, so many steps a flight; speeds fall by 0.8."""
    integrator = sb.FixedStep(np.pi / steps, method)  # type: ignore[arg-type]
    start = {"y": 0.0, "y_dot": 1.0}
    return sb.simulate(mass_on_spring(), (IMPACTS + 0.5) * np.pi, start, integrator=integrator, events=BOUNCE)


@pytest.mark.parametrize("method", ["rk4", "semi-implicit"])
def test_steps_keep_their_length_after_an_event(method: str) -> None:
    run = bouncing(method, 200.4)
    lengths = np.diff(run.t)
    hits = [int(np.searchsorted(run.t, event.t)) for event in run.events]
    assert len(hits) == IMPACTS and lengths.max() < np.pi / 200.4 * (1 + 1e-9)
    whole = np.isclose(lengths, np.pi / 200.4, rtol=1e-9)
    # Short are only the steps cut by an impact, the two samples at it, and the last.
    assert set(np.flatnonzero(~whole)) == {*(k - 1 for k in hits), *hits, lengths.size - 1}


@pytest.mark.parametrize(
    ("method", "order", "counts"), [("rk4", 4, (20, 26, 34, 44)), ("semi-implicit", 1, (200, 300, 450, 700))]
)
def test_impacts_keep_the_order(method: str, order: int, counts: tuple[int, ...]) -> None:
    """Of the state a quarter of a period after the last impact, where the speed is zero: its error is of phase."""
    errors = [abs(bouncing(method, count + 0.4)["y_dot"][-1]) for count in counts]
    slope = np.polyfit(-np.log(np.add(counts, 0.4)), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize(
    ("method", "order", "counts"), [("rk4", 4, (100, 128, 160, 200)), ("semi-implicit", 1, (560, 800, 1100))]
)
def test_projection_keeps_the_order(method: str, order: int, counts: tuple[int, ...]) -> None:
    eqs, errors = free_pendulum(), []
    start = dict(zip(eqs.state_names, at_lowest_point(eqs), strict=True))
    for count in counts:
        integrator = sb.FixedStep(10.0 / count, method)  # type: ignore[arg-type]
        run = sb.simulate(eqs, 10.0, start, integrator=integrator)
        assert run.constraint_violation.max() < 1e-9
        errors.append(np.abs(run["theta"] - angle(run.t)).max())
    slope = np.polyfit(-np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("step", [1e-2, 1e-3, 1e-4])
def test_flat_poses_between_steps_are_noted(step: float) -> None:
    """A parallelogram is flat at a = pi, after 0.24 s at 9 rad/s; every step is long beside the pose itself."""
    eqs = wheels_on_a_rod([0.0, 1.0])
    start = {"a0": 1.0, "a1": 1.0, "b0": -1.0, "a0_dot": 9.0, "a1_dot": 9.0}
    run = sb.simulate(eqs, 0.3, start, integrator=sb.FixedStep(step))
    noted = [note for note in run.notes if "are almost redundant" in note]
    assert len(noted) == 1
    t = (np.pi - 1.0) / 9.0
    assert float(noted[0].split()[3]) == pytest.approx(t, abs=20 * step)


@pytest.mark.parametrize("name", ["slider_crank", "spatial_four_bar"])
def test_ordinary_loops_are_not_noted(name: str) -> None:
    run = sb.simulate(example(name), 1.0, integrator=sb.FixedStep(1e-3))
    assert run.success and not any("almost follow" in note for note in run.notes)


@cache
def pushed() -> sb.EquationSet:
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F - 3*x"))
    model = sb.Model("pushed", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0), inputs=["F"])
    return sb.form_equations(model)


JUMP_TIMES = [0.3, 0.7, 1.1, 2.0]
JUMP_LEVELS = [1.0, -2.0, 0.5, 3.0, -1.0]


def levels_as_table(ends: tuple[float, float]) -> sb.Table:
    times = [ends[0], *np.repeat(JUMP_TIMES, 2), ends[1]]
    return sb.Table(times, np.repeat(JUMP_LEVELS, 2))


def levels_as_formula(ends: tuple[float, float]) -> str:
    changes = np.diff(JUMP_LEVELS)
    return f"{JUMP_LEVELS[0]}" + "".join(
        f" + ({change})*if(t >= {t}, 1, 0)" for t, change in zip(JUMP_TIMES, changes, strict=True)
    )


@pytest.mark.parametrize("method", ["rk4", "semi-implicit"])
@pytest.mark.parametrize("law", [levels_as_table, levels_as_formula])
@pytest.mark.parametrize("ends", [(0.0, 2.5), (2.5, 0.0)])
@pytest.mark.parametrize("step", [0.1, 0.05, 0.1 / 3.0])
def test_a_jump_on_the_raster_is_the_end_of_one_run_and_the_start_of_the_next(
    method: str, law: object, ends: tuple[float, float], step: float
) -> None:
    """The step before a jump reads the value before it, the step behind it the one behind."""
    integrator = sb.FixedStep(step, method)  # type: ignore[arg-type]
    run = sb.simulate(pushed(), ends, {"x": 1.0}, inputs={"F": law(sorted(ends))}, integrator=integrator)  # type: ignore[operator]
    assert run.t.size == 1 + round(2.5 / step)
    np.testing.assert_allclose(np.abs(np.diff(run.t)), step, rtol=1e-9)
    forward = ends[0] < ends[1]
    times = [ends[0], *(JUMP_TIMES if forward else JUMP_TIMES[::-1]), ends[1]]
    levels = JUMP_LEVELS if forward else JUMP_LEVELS[::-1]
    state = {"x": 1.0, "x_dot": 0.0}
    for begin, end, level in zip(times, times[1:], levels, strict=False):
        part = sb.simulate(pushed(), (begin, end), state, inputs={"F": level}, integrator=integrator)
        state = {name: float(part[name][-1]) for name in state}
    assert run["x"][-1] == pytest.approx(state["x"], rel=1e-10)


@pytest.mark.parametrize("lanes", [True, False])
def test_steppers_and_sweeps_read_jumps_on_the_raster_as_motions_do(lanes: bool) -> None:
    given = {"inputs": {"F": levels_as_table((0.0, 2.5))}, "integrator": sb.FixedStep(0.1)}
    run = sb.simulate(pushed(), 2.5, {"x": 1.0}, **given)
    cases = sb.sweep(pushed(), 2.5, initial={"x": [0.5, 1.0]}, lanes=lanes, times=[2.5], **given)
    assert cases["x"][1, -1] == pytest.approx(run["x"][-1], rel=1e-14)
    stepper = sb.Stepper(pushed(), dt=0.5, initial={"x": 1.0}, **given)
    for _ in range(5):
        stepper.step()
    # within how much of its time a jump lies follows from the span that is looked at
    assert stepper["x"] == pytest.approx(run["x"][-1], rel=1e-9)


@pytest.mark.parametrize("step", [0.1, 0.05, 0.03])
@pytest.mark.parametrize("jump", [0.5, 100.0, 120.0])
def test_steppers_read_jumps_at_the_ends_of_their_steps_however_late(step: float, jump: float) -> None:
    """Also where the last step before the jump is shorter, and beyond the thousand steps looked at first."""
    force = sb.Table([0.0, jump, jump, 2.0 * jump], [0.0, 0.0, 1.0, 1.0])
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    model = sb.Model("push", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0), inputs=["F"])
    stepper = sb.Stepper(sb.form_equations(model), 0.1, inputs={"F": force}, integrator=sb.FixedStep(step))
    for _ in range(round(jump / 0.1)):
        stepper.step()
    assert stepper["x_dot"] == 0.0
    stepper.step()
    assert stepper["x_dot"] == pytest.approx(0.1, rel=1e-9)


def test_a_long_step_behind_short_ones_passes_over_nothing() -> None:
    pulse = "if(t < 150, 0, if(t < 150.01, 100, 0))"
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    model = sb.Model("push", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0), inputs=["F"])
    stepper = sb.Stepper(sb.form_equations(model), 0.01, inputs={"F": pulse}).step().step(120.0)
    copy, restored = stepper.copy(), sb.Stepper(sb.form_equations(model), 0.01, inputs={"F": pulse})
    restored.restore(stepper.save())
    assert stepper.step(80.0)["x_dot"] == pytest.approx(1.0, rel=1e-5)
    assert copy.step(80.0)["x_dot"] == restored.step(80.0)["x_dot"] == stepper["x_dot"]


@pytest.mark.parametrize("step", [None, 0.1, 0.03])
def test_implicit_steps_of_steppers_read_jumps_at_their_ends_from_before(step: float | None) -> None:
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    model = sb.Model("push", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0), inputs=["F"])
    force = {"F": "if(t < 0.5, 0, 1)"}
    integrator = sb.GeneralizedAlpha(step=step)
    stepper = sb.Stepper(sb.form_equations(model), 0.1, inputs=force, integrator=integrator)
    for _ in range(5):
        stepper.step()
    assert stepper["x_dot"] == pytest.approx(0.0, abs=1e-6)
    stepper.step()
    assert stepper["x_dot"] == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize(
    "integrator",
    [sb.FixedStep(0.1), sb.FixedStep(0.03, "semi-implicit"), sb.GeneralizedAlpha(step=0.1)],
    ids=str,
)
@pytest.mark.parametrize("law", ["if(t < 0.5, 0, 2)", "if(t <= 0.5, 0, 2)", sb.Table([0.0, 0.5, 0.5, 1.0], [0.0, 0.0, 2.0, 2.0])], ids=["less", "equal", "table"])  # fmt: skip
def test_a_jump_at_the_very_end_of_a_motion_is_read_from_before(integrator: object, law: object) -> None:
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    model = sb.Model("push", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0), inputs=["F"])
    eqs, given = sb.form_equations(model), {"inputs": {"F": law}, "integrator": integrator}
    assert sb.simulate(eqs, 0.5, **given)["x_dot"][-1] == 0.0  # type: ignore[arg-type]
    backwards = sb.simulate(eqs, (1.0, 0.5), **given)  # type: ignore[arg-type]
    assert backwards["x_dot"][-1] == pytest.approx(-1.0, rel=1e-9)
    if isinstance(integrator, sb.FixedStep):
        cases = sb.sweep(eqs, 0.5, initial={"x": [0.0, 1.0]}, times=[0.5], **given)  # type: ignore[arg-type]
        assert (cases["x_dot"] == 0.0).all()


@pytest.mark.parametrize(
    "integrator",
    [sb.FixedStep(0.1), sb.FixedStep(0.03, "semi-implicit"), sb.GeneralizedAlpha(step=0.1), sb.Explicit()],
    ids=str,
)
@pytest.mark.parametrize(("law", "ends", "gain"), [("floor(2*t)", (1.0, 0.0), -0.5), ("if(t <= 1, 3, 1)", (1.0, 2.0), 1.0), (sb.Table([0.0, 1.0, 1.0, 2.0], [0.0, 0.0, 1.0, 1.0]), (1.0, 0.0), 0.0)], ids=["floor", "equal", "table"])  # fmt: skip
def test_a_jump_at_the_very_start_of_a_motion_is_read_from_behind(
    integrator: object, law: object, ends: tuple[float, float], gain: float
) -> None:
    slide = sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    model = sb.Model("push", [sb.Body("B", mass=1), slide], gravity=(0, 0, 0), inputs=["F"])
    run = sb.simulate(sb.form_equations(model), ends, inputs={"F": law}, integrator=integrator)  # type: ignore[dict-item, arg-type]
    if integrator == sb.FixedStep(0.03, "semi-implicit") and law == "floor(2*t)":
        assert run["x_dot"][-1] == pytest.approx(gain, abs=0.03)  # the jump at 0.5 s is not on the raster
    else:
        assert run["x_dot"][-1] == pytest.approx(gain, abs=1e-9)
