"""FMUs with prescribed rates that jump: co-simulation passes them in its steps, model exchange by time events."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import symbody as sb
from tests.fmu.importer import KINDS, VERSIONS, check_archive, instance, simulate, states
from tests.tiers import cases

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
SCALE = {"ModelExchange": 1e-4, "CoSimulation": 1e-6}
LAW = "if(t < T, w*t, w*T + 3*w*(t - T))"


def carried(law: str = LAW, friction: sb.Friction | None = None, **values: float) -> sb.EquationSet:
    """A rider on a spring upon a carrier whose rate is prescribed."""
    parts = [
        sb.Body("Carrier", mass=1), sb.Body("Rider", mass=2),
        sb.Prismatic("carried", "ground", "Carrier", axis="x", coordinate="p", motion=law),
        sb.Prismatic("ridden", "Carrier", "Rider", axis="x", coordinate="r", friction=friction,
                     force=sb.Drive(applied="-k*r")),
    ]  # fmt: skip
    parameters = {"k": 30.0, "T": 0.4, "w": 0.5, **values}
    return sb.form_equations(sb.Model("carried", parts, (0, 0, -9.81), parameters, [], {"r": 0.1}))


def driven_loop() -> sb.EquationSet:
    """A four-bar whose crank is geared to a motion whose rate jumps, and a pendulum on its coupler."""

    def rod(name: str, length: float) -> sb.Body:
        ends = {"a": sb.Frame(at=(-length / 2, 0, 0)), "b": sb.Frame(at=(length / 2, 0, 0))}
        return sb.Body(name, mass=length, inertia=(0, 0, length**3 / 12), frames=ends)

    parts = [
        rod("Crank", 1), rod("Coupler", 2), rod("Rocker", 2), rod("Load", 0.5),
        sb.Revolute("A", "ground", "Crank.a", coordinate="alpha", motion="1 + 2*t + 3*max(t - 0.3, 0)"),
        sb.Revolute("B", "Crank.b", "Coupler.a", coordinate="beta"),
        sb.Revolute("C", "Coupler.b", "Rocker.b", coordinate="gamma"),
        sb.Revolute("D", "ground.d", "Rocker.a", coordinate="delta"),
        sb.Revolute("E", "Coupler", "Load.a", coordinate="epsilon"),
    ]  # fmt: skip
    frames = {"d": sb.Frame(at=(2, 0, 0))}
    guess = {"beta": 0.0, "delta": 1.5}
    return sb.form_equations(sb.Model("driven", parts, (0, -9.81, 0), {}, [], guess, frames))


def on_rope() -> sb.EquationSet:
    """A ball on a rope from a carriage that starts with a jerk."""
    parts = [
        sb.Body("Carriage", mass=1), sb.Body("Ball", mass=1),
        sb.Prismatic("lifted", "ground", "Carriage", axis="y", coordinate="h", motion="2*max(t - 0.3, 0)"),
        sb.Rectangular("place", "ground", "Ball", coordinates=["x", "y"]),
        sb.Distance("rope", "Carriage", "Ball", 1, rope=True),
    ]  # fmt: skip
    start = {"x": 0.6, "y": -0.8, "x_dot": 0.0, "y_dot": 0.0}
    return sb.form_equations(sb.Model("lifted", parts, (0, -9.81, 0), {}, [], start))


@pytest.mark.parametrize(
    "make", cases([carried, driven_loop, on_rope], fast=[driven_loop]), ids=["tree", "loop", "rope"]
)
def test_rates_that_jump_strike_as_in_simulate(make: object, tmp_path: Path) -> None:
    eqs = make()  # type: ignore[operator]
    run = sb.simulate(eqs, 1.0, times=np.linspace(0.0, 1.0, 21), rtol=1e-11)
    assert any("prescribed rates jump" in note or "with an impact" in note for note in run.notes)
    made = sb.save_fmu(eqs, tmp_path / "struck.fmu", sources=False)
    for kind in KINDS:
        moved = simulate(made.path, kind, 1.0, eqs.state_names, 1e-9)
        assert np.abs(moved - states(run)).max() < SCALE[kind], kind


def test_steps_of_one_length_end_at_a_jump(tmp_path: Path) -> None:
    eqs = carried()
    run = sb.simulate(eqs, 1.0, times=np.linspace(0.0, 1.0, 21), rtol=1e-11)
    method = sb.FixedStep(0.007)  # no step ends at 0.4
    made = sb.save_fmu(eqs, tmp_path / "fixed.fmu", integrator=method, sources=False)
    assert np.abs(simulate(made.path, "CoSimulation", 1.0, eqs.state_names, 1e-9) - states(run)).max() < 1e-6


@pytest.mark.parametrize("version", VERSIONS)
def test_what_decides_when_rates_jump_is_a_number(version: str, tmp_path: Path) -> None:
    made = sb.save_fmu(carried(), tmp_path / "struck.fmu", version, parameters={"T": 0.5})
    check_archive(made.path, version)
    names = [variable.name for variable in made.variables]
    assert "T" not in names and {"w", "k"} <= set(names)
    assert any(note.startswith("T: prescribed rates jump at other times") for note in made.notes)
    with instance(made.path, "CoSimulation") as fmu:
        fmu.initialize({"w": 1.0, "k": 0.0})
        fmu.steps([0.0, 0.3, 0.5, 0.7])  # the rate rises by 2 at 0.5, and the rider stays as fast in space
        assert fmu.get("r_dot")[0] == pytest.approx(-2.0, abs=1e-9)


def test_a_jump_that_these_values_hide_is_found_or_its_values_are_numbers(tmp_path: Path) -> None:
    made = sb.save_fmu(
        carried("if(t < T, w*t, w*T + v*(t - T))", v=0.5), tmp_path / "hidden.fmu", sources=False
    )
    names = {variable.name for variable in made.variables}
    assert not {"T", "w", "v"} & names and "k" in names


def test_dry_friction_on_infinite_reactions_is_rejected(tmp_path: Path) -> None:
    eqs = carried(friction=sb.Friction(0.2, mu_static=0.3))
    with pytest.raises(sb.UsageError) as caught:
        sb.save_fmu(eqs, tmp_path / "struck.fmu", sources=False)
    with pytest.raises(sb.UsageError) as same:
        sb.simulate(eqs, 1.0)
    assert caught.value.problems[0].code == same.value.problems[0].code == "simulation.struck_friction"


@pytest.mark.exhaustive
def test_jumps_are_passed_until_they_are_not_known_any_more(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its rate turns 50 times a second: at 6 s, where the first search for jumps ends, and 2,000 times, which are known."""
    eqs = carried("0.01*abs(mod(t, 0.04) - 0.02)")
    made = sb.save_fmu(eqs, tmp_path / "long.fmu", sources=False)
    run = sb.simulate(
        eqs, 8.0, times=np.linspace(0.0, 8.0, 21), rtol=1e-11
    )  # samples fall on jumps, 6 s between
    for kind in KINDS:
        moved = simulate(made.path, kind, 8.0, eqs.state_names, 1e-9)
        assert np.abs(moved - states(run))[eqs.state_names.index("r")].max() < SCALE[kind]
    with instance(made.path, "CoSimulation") as fmu:
        fmu.initialize()
        fmu.steps([0.0, 6.0, 39.99])  # the second step begins at a jump
        with pytest.raises(FMICallException, match="discard"):
            fmu.steps([39.99, 40.1])
        with pytest.raises(FMICallException, match="discard"):  # nor at a second trial
            fmu.steps([fmu.get("time")[0], 40.1])
    assert capsys.readouterr().out.count("not known to this FMU") == 2
