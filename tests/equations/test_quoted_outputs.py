"""Outputs in quotes inside formulas, in every place that reads formulas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import symbody as sb
from symbody.cli.commands import app
from symbody.errors import SymbodyError

EXAMPLES = Path(__file__).parents[2] / "examples"
FORCE = "sqrt('reaction A Fx'^2 + 'reaction A Fy'^2)"
TIMES = np.linspace(0.0, 0.1, 6)
BRAKE = "-10*'frame v Piston ground ground x'"  # the piston slides along x with the rate s_dot


@cache
def crank() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))


@cache
def motion() -> sb.Trajectory:
    return sb.simulate(crank(), 0.1, times=TIMES)


def force(run: sb.Trajectory) -> np.ndarray:
    return np.hypot(run["reaction A Fx"], run["reaction A Fy"])


def test_motions_sweeps_and_tables_read_them() -> None:
    run = motion()
    np.testing.assert_allclose(run[FORCE], force(run), rtol=1e-13)
    np.testing.assert_allclose(run.columns(FORCE)[FORCE], force(run), rtol=1e-13)
    assert run.units[FORCE] == "N"
    swept = sb.sweep(crank(), 0.1, {"m1": [1.0, 2.0]}, times=TIMES)
    np.testing.assert_allclose(swept[FORCE][0], force(run), rtol=1e-6)  # rtol of two motions


def test_steppers_functions_code_and_small_motions_read_them() -> None:
    stepper = sb.Stepper(crank(), 0.02, inputs={"F": 0})
    stepper.step()
    value = np.hypot(stepper["reaction A Fx"], stepper["reaction A Fy"])
    assert stepper[FORCE] == pytest.approx(value, rel=1e-13)
    run = motion()
    computed = sb.compile(crank(), FORCE)(run.t, run.q.T, run.u.T, np.zeros((run.t.size, 1)))
    np.testing.assert_allclose(computed, force(run), rtol=1e-13)
    assert "sqrt" in sb.generate_code(crank(), FORCE, "python")
    twice = sb.linearize(crank(), outputs=["2*'reaction A Fx'", "reaction A Fx"])
    np.testing.assert_allclose(twice.C[0], 2 * twice.C[1], rtol=1e-13)


def test_events_watch_and_set_them() -> None:
    level = float(force(motion()).max() + force(motion()).min()) / 2
    watch = sb.Event(f"{FORCE} - {level!r}", name="level")
    run = sb.simulate(crank(), 0.1, events=watch)
    assert run.events
    np.testing.assert_allclose(run.at(run.events[0].t)[FORCE], level, rtol=1e-6)
    kick = sb.Event("t - 0.05", action={"theta_dot": "theta_dot + 0*'reaction A Fx' + 'kinetic_energy'"})
    run = sb.simulate(crank(), 0.1, events=kick)
    # the samples at the instant: before the action and after it; the loop is closed again by the least move
    before, after = np.flatnonzero(run.t == run.events[0].t)[[0, -1]]
    assert run["theta_dot"][after] > run["theta_dot"][before] + 0.1 * run["kinetic_energy"][before]


def test_laws_of_inputs_read_them_as_formulas_of_states_do() -> None:
    plain = sb.simulate(crank(), 0.5, inputs={"F": "-10*s_dot"})
    quoted = sb.simulate(crank(), 0.5, inputs={"F": BRAKE})
    np.testing.assert_array_equal(plain.q, quoted.q)
    whole = sb.simulate(crank(), 0.1, inputs={"F": "kinetic_energy"}, times=TIMES)
    np.testing.assert_allclose(whole["F"], whole["kinetic_energy"], rtol=1e-14)
    frame = sb.simulate(crank(), 0.1, inputs={"F": "frame v Piston ground ground x"}, times=TIMES)
    np.testing.assert_allclose(frame["F"], frame["s_dot"], rtol=1e-14)


@pytest.mark.parametrize(
    "analyse",
    [
        lambda law: sb.linearize(crank(), inputs={"F": law}).A,
        lambda law: sb.simulate(crank(), 0.1, inputs={"F": law}, integrator=sb.Stiff(), times=TIMES).q,
        lambda law: sb.sweep(crank(), 0.1, {"m1": [1.0, 2.0]}, inputs={"F": law}, times=TIMES)["s"],
        lambda law: sb.Stepper(crank(), 0.01, inputs={"F": law}).step(),
    ],
    ids=["linearize", "stiff", "sweep", "stepper"],
)
def test_all_analyses_take_such_laws(analyse: Callable[[str], object]) -> None:
    plain, quoted = analyse("-10*s_dot"), analyse(BRAKE)
    if isinstance(plain, np.ndarray):
        np.testing.assert_allclose(quoted, plain, rtol=1e-12, atol=1e-14)


def test_laws_read_other_inputs_in_any_order() -> None:
    drive = {"x": sb.Drive("F"), "y": sb.Drive("G")}
    joint = sb.Rectangular("j", "ground", "B", coordinates=["x", "y"], force=drive)
    eqs = sb.form_equations(sb.Model("point", [sb.Body("B", mass=2), joint], inputs=["F", "G"]))
    run = sb.simulate(eqs, 1.0, inputs={"F": "2*G", "G": "sin(t)"}, times=TIMES)
    np.testing.assert_allclose(run["F"], 2 * np.sin(run.t), atol=1e-15)
    # what does not follow from the input itself is there before it: y'' = G/2
    run = sb.simulate(eqs, 1.0, inputs={"F": "y_ddot", "G": "sin(t)"}, times=TIMES)
    np.testing.assert_allclose(run["F"], np.sin(run.t) / 2, atol=1e-15)
    with pytest.raises(
        SymbodyError, match=r"(?s)input_loop.*reads y_ddot, which follows from G.*F -> G -> F"
    ):
        sb.simulate(eqs, 1.0, inputs={"F": "y_ddot", "G": "F"})


@pytest.mark.parametrize("law", ["'reaction A Fx'", "effort D", "2*s_ddot", "power", "1 - F"])
def test_laws_that_read_what_follows_from_them_are_refused(law: str) -> None:
    with pytest.raises(SymbodyError, match="which follows from F") as caught:
        sb.simulate(crank(), 0.1, inputs={"F": law})
    problem = caught.value.problems[0]
    assert problem.code == "equations.input_loop"
    assert "a signal with a rate" in problem.fix


def test_work_and_violations_stand_in_formulas_of_samples() -> None:
    run = sb.simulate(crank(), 0.1, inputs={"F": "-10*s_dot"})
    np.testing.assert_allclose(run["'energy' - 'work'"], run.energy - run.work, rtol=1e-14)
    assert run.at(0.05)["'energy' - 'work'"] == pytest.approx(run.energy[0], rel=1e-7)
    both = run.outputs("m1*'work'", "energy")
    np.testing.assert_allclose(both["m1*'work'"], run.work, rtol=1e-14)  # m1 = 1
    swept = sb.sweep(crank(), 0.1, {"m1": [1.0, 2.0]}, times=TIMES)
    product = swept["m1*'constraint_violation'"]
    np.testing.assert_allclose(product[1], 2 * swept["constraint_violation"][1], rtol=1e-14)
    with pytest.raises(SymbodyError, match=r"(?s)trajectory.formula.*'udot' is not a number.*\(3, "):
        run["'work' + 'udot'"]


def test_files_of_motions_compute_formulas_of_what_they_hold(tmp_path: Path) -> None:
    run = sb.simulate(crank(), 0.1, inputs={"F": BRAKE}, times=TIMES)
    run.save(tmp_path / "run.npz", "reaction A Fx")
    loaded = sb.Trajectory.load(tmp_path / "run.npz")
    np.testing.assert_allclose(loaded["F"], run["F"], rtol=1e-12)
    bare = replace(loaded, evaluate=None)
    np.testing.assert_array_equal(bare["2*'reaction A Fx'"], 2 * run["reaction A Fx"])
    with pytest.raises(SymbodyError, match="trajectory.unknown_name"):
        bare["2*'reaction A Fy'"]


@pytest.mark.parametrize(
    ("name", "cure"),
    [
        ("sqrt((reaction A Fx)^2)", "sqrt(('reaction A Fx')^2)"),
        ("reaction A Fx + 1", "'reaction A Fx' + 1"),
        ('2*"reaction A Fx"', "2*'reaction A Fx'"),
        ("frame r Crank.B ground ground x + 1", "'frame r Crank.B ground ground x' + 1"),
        ("2*'reacton A Fx'", "did you mean 'reaction A Fx'"),
        ("2*'reaction Aa Fx'", "did you mean 'A'?"),
        ("2*'reaction A Fq'", "with one of Fx, Fy, Fz, Mx, My, Mz"),
        ("2*'kinetic_enrgy'", "did you mean 'kinetic_energy'"),
        ("2*'udot'", "name one component"),
    ],
)
def test_the_cure_is_what_to_type(name: str, cure: str) -> None:
    with pytest.raises(SymbodyError) as caught:
        motion()[name]
    assert cure in caught.value.problems[0].fix


def test_faults_of_events_and_of_forces_name_the_way() -> None:
    with pytest.raises(
        SymbodyError, match=r"(?s)simulation.event_shape.*new value of theta_dot has shape \(6,\)"
    ):
        sb.simulate(crank(), 0.1, events=sb.Event("t - 0.05", action={"theta_dot": "reaction A"}))
    with pytest.raises(SymbodyError, match=r"run\['work'\]"):
        sb.simulate(crank(), 0.1, events=sb.Event("'work' - 1"))
    drive = "-k*'length S'"
    with pytest.raises(SymbodyError, match="a force reads an output by a signal"):
        sb.Prismatic("J", "ground", "B", coordinate="x", force=sb.Drive(drive))


def test_the_command_line_reads_them(tmp_path: Path) -> None:
    model = tmp_path / "crank.toml"
    model.write_text((EXAMPLES / "slider_crank" / "slider_crank.toml").read_text("utf-8"), "utf-8")
    runner = CliRunner()
    table = tmp_path / "run.csv"
    words = ["simulate", str(model), "-t", "0.1", "-i", f"F={BRAKE}", "-s", FORCE, "--csv", str(table)]
    result = runner.invoke(app, words)
    assert result.exit_code == 0, result.output
    assert FORCE in table.read_text("utf-8").splitlines()[0]
    result = runner.invoke(app, ["code", str(model), "-o", FORCE])
    assert result.exit_code == 0, result.output
    assert "sqrt" in result.output
