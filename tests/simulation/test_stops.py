"""Stops: gaps that close with impacts, rest closed and open again; closed forms and laws of impacts."""

from __future__ import annotations

import io
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from tests.tiers import cases

G = 9.81


def ball(restitution: float | str = 0.8, **parameters: float) -> sb.EquationSet:
    """Return a ball above a floor."""
    rail = sb.Prismatic("rail", "ground", sb.Body("Ball", mass=0.3), axis="z", coordinate="z")
    floor = sb.Stop("floor", "z", restitution=restitution)
    model = sb.Model(
        "ball", [rail, floor], gravity=(0, 0, -G), initial={"z": 1.0}, parameters=dict(parameters)
    )
    return sb.form_equations(model)


def row_of_balls(masses: Sequence[float], restitutions: Sequence[float]) -> sb.EquationSet:
    """Return points on a line, none of which passes the next one."""
    rails = [
        sb.Prismatic(f"rail{k}", "ground", sb.Body(f"B{k}", mass=mass), axis="x", coordinate=f"x{k}")
        for k, mass in enumerate(masses)
    ]
    stops = [sb.Stop(f"gap{k}", f"x{k + 1} - x{k}", restitution=e) for k, e in enumerate(restitutions)]
    return sb.form_equations(sb.Model("balls", [*rails, *stops]))


def start(x: Sequence[float], v: Sequence[float]) -> dict[str, float]:
    """Return first values of a row of balls."""
    return {f"x{k}": float(a) for k, a in enumerate(x)} | {f"x{k}_dot": float(a) for k, a in enumerate(v)}


def test_a_ball_bounces_until_its_impacts_end() -> None:
    run = sb.simulate(ball(), 6.0)
    fall, e = np.sqrt(2 / G), 0.8
    times = [event.t for event in run.events if event.name == "floor impact"]
    number = np.arange(len(times))
    assert len(times) > 20
    assert times == pytest.approx(fall * (1 + 2 * e * (1 - e**number) / (1 - e)), rel=1e-9)
    (closed,) = (event for event in run.events if event.name == "floor closed")
    assert closed.t == pytest.approx(fall * (1 + e) / (1 - e), rel=1e-9)
    assert run["gap floor"].min() > -1e-9
    rest = run.t > closed.t
    assert run["opening_effort floor"][rest] == pytest.approx(0.3 * G, rel=1e-9)
    assert abs(run.energy_drift) < 1e-8
    assert run["mode floor"][-1] == 1.0 and run["mode floor"][0] == 0.0
    assert any("Poisson" in note for note in run.notes)


def test_without_restitution_it_rests_at_once_and_with_1_it_never_does() -> None:
    run = sb.simulate(ball(0), 2.0)
    assert [event.name for event in run.events] == ["floor impact", "floor closed"]
    assert run["z"][-1] == pytest.approx(0.0, abs=1e-9) and run["z_dot"][-1] == 0.0
    run = sb.simulate(ball(1), 20.0)
    assert len(run.events) == 22
    assert run["z"].max() == pytest.approx(1.0, rel=1e-7)


@pytest.mark.parametrize(
    ("places", "speeds"), [((0, 1, 1), (-1 / 3, 2 / 3, 2 / 3)), ((0, 1, 1.001), (0, 0, 1))]
)
def test_equal_balls_strike_at_once_or_one_after_the_other(
    places: tuple[float, ...], speeds: tuple[float, ...]
) -> None:
    run = sb.simulate(row_of_balls([1, 1, 1], [1, 1]), 3.0, start(places, (1, 0, 0)))
    assert run.u[:, -1] == pytest.approx(speeds, abs=1e-12)


@pytest.mark.parametrize("seed", cases(range(12), fast=range(3)))
def test_impacts_keep_momentum_and_never_raise_the_energy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    masses, restitutions = rng.uniform(0.1, 3.0, n), rng.uniform(0.0, 1.0, n - 1)
    places = np.sort(rng.uniform(0.0, 1.0, n)) if seed % 3 else np.zeros(n)
    run = sb.simulate(row_of_balls(masses, restitutions), 2.0, start(places, rng.normal(size=n)))
    assert run.success
    kinetic, momentum = 0.5 * masses @ run.u**2, masses @ run.u
    assert np.diff(kinetic).max(initial=0.0) <= 1e-12 * kinetic[0]
    assert momentum == pytest.approx(np.full(momentum.size, momentum[0]), abs=1e-12)
    assert np.diff(run.q, axis=0).min() > -1e-9
    assert abs(run.energy_drift) < 1e-9


@pytest.mark.parametrize("order", cases([(0, 1, 2), (2, 0, 1), (1, 2, 0), (2, 1, 0)], fast=[(2, 0, 1)]))
def test_the_order_of_stops_does_not_matter(order: tuple[int, ...]) -> None:
    rails = [
        sb.Prismatic(f"rail{k}", "ground", sb.Body(f"B{k}", mass=k + 1), axis="x", coordinate=f"x{k}")
        for k in range(4)
    ]
    stops = [sb.Stop(f"gap{k}", f"x{k + 1} - x{k}", restitution=0.3 * (k + 1)) for k in order]
    eqs = sb.form_equations(sb.Model("balls", [*rails, *stops]))
    run = sb.simulate(eqs, 1.0, start((0, 0, 0, 0), (1, 0.5, 0.2, -1)))
    expected = sb.simulate(row_of_balls([1, 2, 3, 4], [0.3, 0.6, 0.9]), 1.0,
                           start((0, 0, 0, 0), (1, 0.5, 0.2, -1)))  # fmt: skip
    assert run.u[:, -1] == pytest.approx(expected.u[:, -1], rel=1e-12)


def arm(**stop: object) -> sb.EquationSet:
    """Return an arm that falls from above onto a stop for its angle."""
    body = sb.Body("Arm", mass=2.0, inertia=(0, 0, 0.1), frames={"hip": sb.Frame(at=(-0.5, 0, 0))})
    hinge = sb.Revolute("hip", "ground", body["hip"], axis="z", coordinate="phi", torque=sb.Drive("T"))
    rest = sb.Stop("rest", "phi + pi/6", **stop)  # type: ignore[arg-type]
    model = sb.Model("arm", [hinge, rest], gravity=(0, -G, 0), inputs=["T"], initial={"phi": 1.0})
    return sb.form_equations(model)


def test_an_arm_rests_on_a_stop_until_its_drive_lifts_it() -> None:
    run = sb.simulate(arm(restitution=0.2), 4.0, inputs={"T": "if(t < 2, 0, 5*(t - 2))"}, rtol=1e-10)
    moment = 2.0 * G * 0.5 * np.cos(np.pi / 6)
    (opened,) = (event.t for event in run.events if event.name == "rest open")
    assert opened == pytest.approx(2 + moment / 5, rel=1e-8)
    resting = (run.t > 1.6) & (run.t < 2.0)
    assert run["opening_effort rest"][resting] == pytest.approx(moment, rel=1e-8)
    assert run.units["opening_effort rest"] == "N m" and run.units["gap rest"] == "rad"


def test_a_table_that_shakes_throws_a_block_at_a_known_phase() -> None:
    rail = sb.Prismatic("rail", "ground", sb.Body("Block", mass=1.5), axis="z", coordinate="z")
    table = sb.Stop("table", "z - A*sin(w*t)")
    model = sb.Model(
        "table", [rail, table], gravity=(0, 0, -G), parameters={"A": 0.02, "w": 40}, initial={"z_dot": 0.8}
    )
    run = sb.simulate(sb.form_equations(model), 0.1)
    opened = next(event.t for event in run.events if event.name == "table open")
    assert opened == pytest.approx(np.arcsin(G / (0.02 * 40**2)) / 40, rel=1e-8)
    assert run["gap table"].min() > -1e-10


def test_assembly_equilibrium_and_linear_equations_know_closed_gaps() -> None:
    eqs = arm()
    with pytest.raises(sb.AssemblyError, match="rest"):
        sb.assemble(eqs, {"phi": -1.0})
    rest = sb.find_equilibrium(eqs, {"phi": -0.4})
    assert rest.q["phi"] == pytest.approx(-np.pi / 6)
    assert float(rest["opening_effort rest"]) == pytest.approx(2.0 * G * 0.5 * np.cos(np.pi / 6))
    assert any("closed" in note for note in rest.notes)


@pytest.mark.parametrize("value", [-0.1, 1.5])
def test_restitution_is_a_share(value: float) -> None:
    with pytest.raises(sb.ModelError, match=r"restitution|from 0 to 1"):
        rail = sb.Prismatic("rail", "ground", sb.Body("B", mass=1))
        sb.Model("m", [rail, sb.Stop("s", "rail", restitution=value)])


def test_a_gap_does_not_depend_on_speeds() -> None:
    rail = sb.Prismatic("rail", "ground", sb.Body("B", mass=1), coordinate="x")
    with pytest.raises(sb.FormulationError, match="speeds"):
        sb.form_equations(sb.Model("m", [rail, sb.Stop("s", "x - x_dot")]))


def test_a_stop_in_a_file_is_that_of_a_script(tmp_path: Path) -> None:
    model = ball("e", e=0.5).model
    path = tmp_path / "ball.toml"
    sb.save_model(model, path)
    assert 'type = "stop"' in path.read_text()
    assert sb.load_model(path) == model


def test_steppers_sweeps_and_programs_meet_the_same_impacts(tmp_path: Path) -> None:
    eqs = ball("e", e=0.8)
    run = sb.simulate(eqs, 3.0, times=[3.0], rtol=1e-10)
    stepper = sb.Stepper(eqs, 0.01)
    for _ in range(300):
        stepper.step()
    assert stepper["z"] == pytest.approx(run["z"][-1], abs=1e-7)
    cases = sb.sweep(eqs, 3.0, {"e": [0.8, 0.1, 1.0]}, times=[3.0])
    for k, e in enumerate((0.8, 0.1, 1.0)):
        alone = sb.simulate(eqs, 3.0, times=[3.0], parameters={"e": e})
        assert np.ravel(cases["z"])[k] == pytest.approx(alone["z"][-1], abs=1e-7)
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("a program needs cc")
    times = np.linspace(0.0, 3.0, 31)
    (tmp_path / "ball.c").write_text(sb.generate_simulation(eqs, 3.0, "c", times=times, rtol=1e-10))
    subprocess.run([compiler, "-O1", "ball.c", "-o", "ball", "-lm"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "ball"], capture_output=True, text=True, check=True).stdout
    rows = np.genfromtxt(io.StringIO(printed), delimiter=",", names=True)
    whole = sb.simulate(eqs, 3.0, times=times, rtol=1e-10)
    assert min(event.t for event in whole.events) < 1.0  # it has struck
    np.testing.assert_allclose(rows["z"], whole["z"], rtol=0, atol=1e-7)


def test_a_closed_gap_is_a_constraint_of_small_deviations() -> None:
    rest = sb.find_equilibrium(arm(), {"phi": -0.4})
    assert rest.linearization.A.shape == (0, 0) and rest.verdict == "stable"
    lifted = sb.find_equilibrium(arm(), {"phi": 1.4})
    assert lifted.q["phi"] == pytest.approx(np.pi / 2) and lifted.verdict == "unstable"
    assert any("stop rest is open" in note for note in lifted.notes)
    edge = sb.find_equilibrium(arm(), {"phi": -0.5}, inputs={"T": 2.0 * G * 0.5 * np.cos(np.pi / 6)})
    assert edge.verdict == "undecided"
    assert any("closed without effort" in note for note in edge.notes)


def test_a_stop_never_pulls_at_an_equilibrium() -> None:
    rail = sb.Prismatic("rail", "ground", sb.Body("B", mass=1), axis="z", coordinate="z",
                        force=sb.Drive(stiffness=100),
                        limits={"high": 0.5, "low": -1, "rigid": True})  # fmt: skip
    eqs = sb.form_equations(sb.Model("m", [rail], gravity=(0, 0, -10)))
    for guess in (0.5, 0.4, -0.9, -1.0):
        rest = sb.find_equilibrium(eqs, {"z": guess})
        assert rest.q["z"] == pytest.approx(-0.1) and not rest.branches
        assert "stop rail high is open" in rest.notes


def test_what_is_said_of_stops() -> None:
    eqs = ball()
    assert any("closed gap" in note for note in eqs.notes)
    assert "z >= 0 (0 while the gap is closed" in eqs.text()
    with pytest.raises(sb.UsageError, match="stop is open or closed"):
        sb.inverse_dynamics(eqs, {"z": "t"}, [], [0.0])
    with pytest.raises(sb.UsageError, match="gaps open"):
        sb.generate_code(eqs, "z", language="modelica")
    down = sb.Event("t - 0.1", action={"z": "-0.5"}, name="down")
    run = sb.simulate(eqs, 1.0, events=down)
    assert any("gap of floor negative" in note for note in run.notes)


def test_paths_end_at_stops() -> None:
    path = sb.trace_positions(arm(), {"phi": np.linspace(0.0, -1.0, 11)})
    assert path.limits["phi"] == pytest.approx(-np.pi / 6)
    assert any("stop rest: the mechanism cannot move beyond" in note for note in path.notes)
