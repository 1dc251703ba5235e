"""FMUs whose equations switch: conditions in formulas, joints that stick and slip, ropes that slacken."""

from __future__ import annotations

import math
import re
import shutil
import tempfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import symbody as sb
from tests.fmu.importer import EXAMPLES, KINDS, VERSIONS, instance, pendulum, simulate, states
from tests.laws.test_cradles import first_values, hits, in_rounds, names_of, rail
from tests.mechanisms import example
from tests.tiers import cases

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
SLIP = sb.Friction(0.3, mu_static=0.4)


def block() -> sb.EquationSet:
    """A block that is pulled to and fro on a dry plane."""
    body = sb.Body("Block", mass="m")
    pull = sb.Drive(applied="F + 12*sin(3*t) - k*x")
    slide = sb.Prismatic("slide", "ground", body, axis="x", coordinate="x", friction=SLIP, force=pull)
    values, start = {"m": 2.0, "k": 5.0}, {"x": 1.0, "x_dot": 2.0}
    return sb.form_equations(sb.Model("block", [body, slide], (0, 0, -9.81), values, ["F"], start))


def stack() -> sb.EquationSet:
    """A block on a block."""
    lower, upper = sb.Body("Lower", mass=2), sb.Body("Upper", mass=1)
    below = sb.Prismatic("below", "ground", lower, axis="x", coordinate="x", friction=sb.Friction(0.2))
    above = sb.Prismatic("above", "Lower", upper, axis="x", coordinate="z", friction=SLIP)
    start = {"x_dot": 1.0, "z_dot": -0.5}
    return sb.form_equations(sb.Model("stack", [lower, upper, below, above], (0, 0, -9.81), {}, [], start))


def dry_crank() -> sb.EquationSet:
    text = (EXAMPLES / "slider_crank" / "slider_crank.toml").read_text()
    drive = 'force = { applied = "F" }'
    assert drive in text
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dry_crank.toml"
        path.write_text(text.replace(drive, f"{drive}\nfriction = {{ mu = 0.3 }}"))
        return sb.form_equations(sb.load_model(path))


def swing(*lengths: str) -> sb.EquationSet:
    """A ball in a vertical plane on ropes from points beside each other, thrown."""
    ball = sb.Body("Ball", mass="m")
    place = sb.Rectangular("place", "ground", ball, coordinates=["x", "y"])
    ground = {f"hook{k}": sb.Frame(at=(0.3 * k, 0, 0)) for k in range(len(lengths))}
    ropes = [
        sb.Distance(f"rope {k}", f"ground.hook{k}", ball, length, rope=True)
        for k, length in enumerate(lengths)
    ]
    values, start = {"m": 2.0, "L": 1.0}, {"x": 0.6, "y": 0.3, "x_dot": 1.0}
    model = sb.Model("swing", [ball, place, *ropes], (0, -9.81, 0), values, [], start, ground)
    return sb.form_equations(model)


def stop() -> sb.EquationSet:
    """A ball that falls on a damped spring, through air and past shelves that tilt the force."""
    body = sb.Body("Ball", mass=1)
    force = "-if(y < 0, k*y, 0) - c*abs(y_dot)*y_dot - 0.1*sign(y_dot) + 0.05*max(y, 0.2) + 0.02*floor(3*y)"
    fall = sb.Prismatic("fall", "ground", body, axis="y", coordinate="y", force=sb.Drive(applied=force))
    return sb.form_equations(
        sb.Model("stop", [body, fall], (0, -9.81, 0), {"k": 1000.0, "c": 0.1}, [], {"y": 1.0})
    )


def event_times(path: Path, kind: str, end: float, capsys: pytest.CaptureFixture[str]) -> list[float]:
    """Return when modes ended or events happened, from the log of the FMU."""
    capsys.readouterr()
    fmpy.simulate_fmu(
        str(path), stop_time=end, output_interval=end / 20, relative_tolerance=1e-12, fmi_type=kind,
        debug_logging=True, record_events=False,
    )  # fmt: skip
    return [float(time) for time in re.findall(r" at t = (\S+)", capsys.readouterr().out)]


@pytest.fixture(scope="module")
def dry_block(tmp_path_factory: pytest.TempPathFactory) -> tuple[sb.EquationSet, Path]:
    eqs = block()
    path = tmp_path_factory.mktemp("block") / "block.fmu"
    return eqs, sb.save_fmu(eqs, path, outputs=["friction slide", "friction_reserve slide"]).path


@pytest.mark.parametrize(("kind", "error"), [("ModelExchange", 1e-9), ("CoSimulation", 1e-9)])
def test_stick_and_slip_happen_when_they_do_in_simulate(
    dry_block: tuple[sb.EquationSet, Path], kind: str, error: float, capsys: pytest.CaptureFixture[str]
) -> None:
    eqs, path = dry_block
    run = sb.simulate(eqs, 5.0, rtol=1e-13, atol=1e-14)
    expected = [event.t for event in run.events]
    assert len(expected) == 5
    seen = event_times(path, kind, 5.0, capsys)
    # a joint that comes to rest and does not stick turns round in the same event
    assert seen == pytest.approx(expected, abs=error)


@pytest.mark.parametrize("kind", KINDS)
def test_friction_is_that_of_simulate(dry_block: tuple[sb.EquationSet, Path], kind: str) -> None:
    eqs, path = dry_block
    assert validate_fmu(str(path)) == []
    run = sb.simulate(eqs, 5.0, times=np.linspace(0.0, 5.0, 21), rtol=1e-11)
    names = [*eqs.state_names, "friction.slide", "friction_reserve.slide"]
    seen = simulate(path, kind, 5.0, names, 1e-9)
    assert np.abs(seen[:2] - states(run)).max() < 1e-6
    assert np.abs(seen[2] - run["friction slide"]).max() < 1e-5
    assert np.abs(seen[3] - run["friction_reserve slide"]).max() < 1e-5


def test_input_that_jumps_breaks_a_joint_away(dry_block: tuple[sb.EquationSet, Path]) -> None:
    _, path = dry_block
    with instance(path, "CoSimulation") as fmu:
        fmu.initialize({"x": 0.0, "x_dot": 0.0, "k": 0.0})
        fmu.steps([0.0, 0.05])
        assert fmu.get("x_dot") == [0.0]  # it sticks
        fmu.set("F", 20.0)
        fmu.steps([0.05, 0.1])
        assert fmu.get("x_dot")[0] > 0.1


@pytest.mark.parametrize("law", cases(["push", "if(t < 0.37, 1, 6)", "1 + 5*floor(t/0.37)"], fast=["push"]))
def test_a_force_that_jumps_in_time_breaks_a_joint_away(
    law: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At t = 0.37 the force becomes 6 N, more than 0.4 g; kinetic friction leaves 6 - 0.3 g of it."""
    table = sb.Lookup("push", points=[[0, 1], [0.37, 1], [0.37, 6], [2, 6]])
    body = sb.Body("Block", mass=1)
    slide = sb.Prismatic(
        "slide", "ground", body, axis="x", coordinate="x", friction=SLIP, force=sb.Drive(applied=law)
    )
    model = sb.Model("pushed", [body, slide, table], (0, 0, -9.81))
    path = tmp_path / "pushed.fmu"
    sb.save_fmu(sb.form_equations(model), path, events=sb.Event(f"{law} - 3", name="pushed"), sources=False)
    for kind in KINDS:
        result = fmpy.simulate_fmu(
            str(path), stop_time=0.7, output_interval=0.1, relative_tolerance=1e-8, fmi_type=kind,
            output=["x", "x_dot"], record_events=False,
        )  # fmt: skip
        passed = np.maximum(result["time"] - 0.37, 0.0)
        left = 6 - 0.3 * 9.81
        # model exchange loses up to a hundred tolerances; a step of co-simulation none
        np.testing.assert_allclose(result["x_dot"], left * passed, atol=1e-5)
        np.testing.assert_allclose(result["x"], left * passed**2 / 2, atol=1e-5)
        times = event_times(path, kind, 0.7, capsys)
        assert times and times == pytest.approx([0.37] * len(times), abs=1e-12)


def test_branches_stay_between_events(tmp_path: Path) -> None:
    eqs = stop()
    made = sb.save_fmu(eqs, tmp_path / "stop.fmu", "2.0")
    assert [v.name for v in made.variables if v.name.startswith("condition")] == [
        f"condition[{k}]" for k in range(1, 5)
    ]
    with instance(made.path, "ModelExchange") as fmu:
        fmu.initialize()
        fmu.fmu.newDiscreteStates()
        fmu.fmu.enterContinuousTimeMode()
        above, below = [-1.0, 0.01], [-1.0, -0.01]
        fmu.set_states(above)
        fmu.fmu.completedIntegratorStep()
        fmu.fmu.enterEventMode()  # from rest to falling, and over shelves
        fmu.fmu.newDiscreteStates()
        fmu.fmu.enterContinuousTimeMode()
        fmu.set_states(below)
        frozen = fmu.get("der(y_dot)")[0]
        assert fmu.derivative(["der(y_dot)"], "y") == [0.0]
        assert fmu.fmu.completedIntegratorStep()[0]
        fmu.fmu.enterEventMode()
        fmu.fmu.newDiscreteStates()
        live = fmu.get("der(y_dot)")[0]
        assert fmu.derivative(["der(y_dot)"], "y") == [-1000.0]
        assert live == pytest.approx(frozen + 10.0 - 0.02)  # the spring, and a shelf below
        assert live == pytest.approx(float(sb.compile(eqs, "xdot").of_state(0.0, below)[0]))


@pytest.mark.exhaustive
@pytest.mark.parametrize("kind", KINDS)
def test_motion_through_conditions(kind: str, tmp_path: Path) -> None:
    eqs = stop()
    made = sb.save_fmu(eqs, tmp_path / "stop.fmu")
    assert validate_fmu(str(made.path)) == []
    fine = sb.Explicit(max_step=1e-3)  # steps of simulate go over conditions in the state
    run = sb.simulate(eqs, 1.0, times=np.linspace(0.0, 1.0, 21), rtol=1e-11, integrator=fine)
    assert np.abs(simulate(made.path, kind, 1.0, eqs.state_names, 1e-9) - states(run)).max() < 1e-4


@pytest.mark.exhaustive
def test_slack_rope_may_start_where_its_ends_coincide(tmp_path: Path) -> None:
    eqs = swing("L")
    start = {"x": 0, "y": 0, "x_dot": 1.0}
    run = sb.simulate(eqs, 1.0, initial=start, times=np.linspace(0.0, 1.0, 21), rtol=1e-10)
    assert run.events  # it goes taut
    made = sb.save_fmu(eqs, tmp_path / "swing.fmu", outputs=["reaction rope 0"], initial=start)
    for kind in KINDS:
        assert np.abs(simulate(made.path, kind, 1.0, eqs.state_names, 1e-9) - states(run)).max() < 1e-6
    with instance(made.path, "ModelExchange") as fmu:
        fmu.initialize()
        shown = [v.name for v in made.variables if v.causality == "output"]
        assert np.isfinite(fmu.get(*shown)).all()
        assert np.isfinite(fmu.derivative([*shown, "der(y_dot)"], "y")).all()


@pytest.mark.exhaustive
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("make", "end", "outputs"),
    [
        (stack, 1.0, []),
        (dry_crank, 2.0, ["friction D"]),
        (lambda: swing("L"), 3.0, ["rope_tension rope 0"]),
        (lambda: swing("L", "1.1*L"), 3.0, ["rope_tension rope 0", "rope_tension rope 1"]),
    ],
    ids=["stack", "crank", "rope", "two ropes"],
)
def test_modes_change_as_in_simulate(
    make: object, end: float, outputs: list[str], version: str, tmp_path: Path
) -> None:
    eqs = make()  # type: ignore[operator]
    run = sb.simulate(eqs, end, times=np.linspace(0.0, end, 21), rtol=1e-11)
    assert run.success and run.events
    made = sb.save_fmu(eqs, tmp_path / "switching.fmu", version, outputs=outputs)
    assert validate_fmu(str(made.path)) == []
    for kind in KINDS:
        seen = simulate(made.path, kind, end, eqs.state_names, 1e-9)
        assert np.abs(seen - states(run)).max() < (1e-4 if kind == "ModelExchange" else 1e-5), kind


def test_ball_bounces_to_the_nanosecond(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    body = sb.Body("Ball", mass=1)
    fall = sb.Prismatic("fall", "ground", body, axis="y", coordinate="y")
    model = sb.Model("ball", [body, fall], (0, -9.81, 0), {"e": 0.7}, [], {"y": 1.0})
    bounce = sb.Event("y", -1, {"y_dot": "-e*y_dot"}, "bounce")
    made = sb.save_fmu(sb.form_equations(model), tmp_path / "ball.fmu", events=[bounce])
    first = math.sqrt(2 / 9.81)  # as the Reference FMU of this name
    for kind in KINDS:
        seen = event_times(made.path, kind, 2.0, capsys)
        assert seen == pytest.approx([first, 2.4 * first, 3.38 * first, 4.066 * first], abs=1e-9)


def test_each_mode_has_an_indicator(tmp_path: Path) -> None:
    eqs = example("rr_robot")
    assert not [
        v for v in sb.save_fmu(eqs, tmp_path / "a.fmu", platforms=()).variables if "mode_end." in v.name
    ]
    made = sb.save_fmu(stack(), tmp_path / "b.fmu", platforms=())
    assert [v.name for v in made.variables[-2:]] == ["mode_end.below", "mode_end.above"]


@pytest.mark.parametrize(
    ("make", "event"),
    [
        pytest.param(
            block, sb.Event("t - 0.2", action={"x_dot": "-2*x_dot + 1"}), marks=pytest.mark.exhaustive
        ),
        (block, sb.Event("t - 4.9", action={"x_dot": "0.5"})),  # it sticks before
        pytest.param(
            lambda: swing("L"), sb.Event("y + 0.7", -1, {"x_dot": "0.3*x_dot"}), marks=pytest.mark.exhaustive
        ),
        pytest.param(  # slack, whatever it was
            lambda: swing("L"), sb.Event("t - 1.5", action={"x": "0.6*x"}), marks=pytest.mark.exhaustive
        ),
        (lambda: swing("L", "1.1*L"), sb.Event("t - 2", action={"x_dot": "3 - x_dot"})),  # a shock at once
    ],
    ids=["slips", "sticks", "rope", "slack", "shock"],
)
def test_actions_beside_dry_friction_and_ropes(make: object, event: sb.Event, tmp_path: Path) -> None:
    eqs = make()  # type: ignore[operator]
    run = sb.simulate(eqs, 5.0, times=np.linspace(0.0, 5.0, 21), rtol=1e-11, events=event)
    assert run.success and event.label in {each.name for each in run.events}
    made = sb.save_fmu(eqs, tmp_path / "acting.fmu", events=event, sources=False)
    for kind, error in zip(KINDS, (1e-4, 1e-6), strict=True):
        assert np.abs(simulate(made.path, kind, 5.0, eqs.state_names, 1e-9) - states(run)).max() < error, kind


def test_an_action_that_leaves_a_rope_too_long_ends_the_motion(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    eqs, event = swing("L"), sb.Event("t - 0.1", action={"y": "2"})
    assert sb.simulate(eqs, 1.0, events=event).status is sb.Status.UNMET_ACTION
    made = sb.save_fmu(eqs, tmp_path / "torn.fmu", events=event, sources=False)
    for kind in KINDS:
        with pytest.raises(Exception, match="rror|ailed|iscard"):
            simulate(made.path, kind, 1.0, ["y"], 1e-9)
        assert "moves the ends of a rope farther apart than it is long" in capsys.readouterr().out


def test_actions_at_one_instant_follow_each_other(tmp_path: Path) -> None:
    events = [
        sb.Event("t - 0.1", action={"theta_dot": "2"}, name="first"),
        sb.Event("2*t - 0.2", action={"theta_dot": "3*theta_dot"}, name="second"),
    ]
    run = sb.simulate(pendulum(), 0.5, events=events, rtol=1e-11)
    made = sb.save_fmu(pendulum(), tmp_path / "twice.fmu", events=events, sources=False)
    for kind in KINDS:
        seen = simulate(made.path, kind, 0.5, ["theta_dot", "theta"], 1e-9)
        assert np.abs(seen[:, -1] - states(run)[:, -1]).max() < 1e-5


def log_of(path: Path, kind: str, end: float, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return the names of events, in their order, as an FMU logs them."""
    capsys.readouterr()
    fmpy.simulate_fmu(
        str(path), stop_time=end, output_interval=end / 10, relative_tolerance=1e-10, fmi_type=kind,
        debug_logging=True, record_events=False,
    )  # fmt: skip
    return re.findall(r"event\.(\w+) at t", capsys.readouterr().out)


@pytest.mark.parametrize("version", VERSIONS)
def test_balls_that_touch_hit_each_other(
    version: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As by `simulate`: two balls of five come with a speed, two leave with it."""
    eqs, start = rail(5), first_values(np.array([1.0, 1.0, 0.0, 0.0, 0.0]), 0.0)
    watched = [sb.Event(e.expression, e.direction, e.action, f"p{e.name}") for e in hits(5)]
    made = sb.save_fmu(eqs, tmp_path / "cradle.fmu", version, events=watched, initial=start)
    run = sb.simulate(eqs, 0.1, start, events=hits(5))
    for kind in KINDS:
        seen = simulate(made.path, kind, 0.1, eqs.state_names, 1e-9)
        assert np.abs(seen[:, -1] - states(run)[:, -1]).max() < 1e-9, kind
        names = [int(name[1:]) for name in log_of(made.path, kind, 0.1, capsys)]
        assert in_rounds(names) == in_rounds(names_of(run)), kind


def test_a_ball_on_its_floor_bounces_or_chatters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    body = sb.Body("Ball", mass=1)
    fall = sb.Prismatic("fall", "ground", body, axis="y", coordinate="y")
    eqs = sb.form_equations(sb.Model("ball", [body, fall], (0, -9.81, 0), {"e": 0.7}))
    bounce = sb.Event("y", -1, {"y_dot": "-e*y_dot"}, "bounce")
    thrown = sb.save_fmu(eqs, tmp_path / "thrown.fmu", events=[bounce], initial={"y": 0, "y_dot": -1})
    lies = sb.save_fmu(eqs, tmp_path / "lies.fmu", events=[bounce], initial={"y": 0, "y_dot": 0})
    for kind in KINDS:
        assert log_of(thrown.path, kind, 0.05, capsys) == ["bounce"]
        seen = simulate(thrown.path, kind, 0.05, ["y", "y_dot"], 1e-9)
        assert seen[:, -1] == pytest.approx([0.7 * 0.05 - 9.81 * 0.05**2 / 2.0, 0.7 - 9.81 * 0.05], abs=1e-6)
        with pytest.raises(Exception, match="rror|ailed"):
            simulate(lies.path, kind, 0.05, ["y", "y_dot"], 1e-9)
        assert "bounce happens at t = 0 where its value is zero" in capsys.readouterr().out
