"""A motion holds its model, also from a file, and computes further outputs there."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.errors import FormatError, SymbodyError, UsageError
from tests.tiers import cases

EXAMPLES = Path(__file__).parents[2] / "examples"
CRANK = sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml")
OUTPUTS = ("energy", "reaction A", "frame r Rod", "constraint_violation", "work")


def crank(tree: Any = None, **choices: Any) -> sb.Trajectory:
    return sb.simulate(sb.form_equations(CRANK, tree=tree), 0.2, **choices)


def reloaded(run: sb.Trajectory, path: Path, **choices: Any) -> sb.Trajectory:
    run.save(path / "crank.run")
    return sb.Trajectory.load(path / "crank.run", **choices)


def pendulum(**changes: Any) -> sb.Model:
    rod = sb.Body("Rod", mass="m", inertia=(0, 0, "m*L**2/12"), frames={"pin": sb.Frame(at=("-L/2", 0, 0))})
    hinge = sb.Revolute("hinge", "ground", rod["pin"], axis="z", coordinate="phi", **changes)
    motor = sb.Torque("motor", rod, (0, 0, "M"))
    return sb.Model(
        "pendulum", [rod, hinge, motor], gravity=(0, -9.81, 0), parameters={"m": 2, "L": 1}, inputs=["M"]
    )


def test_a_run_knows_its_model_and_the_values_it_ran_with() -> None:
    run = crank(parameters={"L1": "L2/4"})
    assert run.model is CRANK
    assert run.parameters == {
        "m1": 1.0,
        "m2": 1.5,
        "m3": 0.8,
        "I1": 0.02,
        "I2": 0.15,
        "L1": 0.25,
        "L2": 1.0,
        "G": 9.81,
    }
    assert run.at(0.1).model is CRANK


def test_cases_of_a_sweep_know_their_values() -> None:
    eqs = sb.form_equations(CRANK)
    sweep = sb.sweep(
        eqs, 0.1, times=[0.0, 0.1], parameters={"m1": [1.0, 3.0], "m3": "m1/2"}, combine="product"
    )
    case = sweep.trajectory(1)
    assert case.model is CRANK
    assert (case.parameters["m1"], case.parameters["m3"], case.parameters["m2"]) == (3.0, 1.5, 1.5)
    together = case.outputs("energy", "frame r Rod", "t")
    for name, values in together.items():
        np.testing.assert_array_equal(values, case[name])


def test_motions_of_inverse_dynamics_know_their_model(tmp_path: Path) -> None:
    eqs = sb.form_equations(pendulum())
    run = sb.inverse_dynamics(eqs, {"phi": "t**2"}, "M", np.linspace(0.0, 1.0, 5))
    assert run.model == pendulum()
    loaded = reloaded(run, tmp_path)
    np.testing.assert_array_equal(loaded["M"], run["M"])
    np.testing.assert_allclose(loaded["reaction hinge"], run["reaction hinge"], rtol=1e-12, atol=1e-12)


def test_outputs_together_are_those_one_by_one() -> None:
    run = crank()
    names = ("theta", *OUTPUTS, "frame R Crank")
    for moment in (run, run.at([0.05, 0.1]), run.at(0.07)):
        for name, values in moment.outputs(*names).items():
            np.testing.assert_allclose(values, moment[name], rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize(
    "tree",
    cases([None, "absolute", sb.Trees(["A", "C"], ["A", "C"])], fast=[sb.Trees(["A", "C"], ["A", "C"])]),
    ids=repr,
)
def test_a_loaded_run_computes_further_outputs(tree: Any, tmp_path: Path) -> None:
    run = crank(tree, parameters={"m1": 3, "m2": "m1/2"}, inputs={"F": "m1*sin(20*t)"})
    loaded = reloaded(run, tmp_path)
    assert loaded.model == CRANK
    assert loaded.parameters == run.parameters
    for name in OUTPUTS:
        np.testing.assert_array_equal(loaded[name], run[name])
    np.testing.assert_array_equal(loaded.at(0.11)["reaction A"], run.at(0.11)["reaction A"])


def test_tables_are_kept(tmp_path: Path) -> None:
    times = np.linspace(0.0, 1.0, 90)  # more than are made part of the equations
    run = crank(inputs={"F": sb.Table(times, np.sin(9 * times), "cubic")})
    loaded = reloaded(run, tmp_path)
    np.testing.assert_array_equal(loaded["reaction A"], run["reaction A"])


def test_laws_in_python_leave_what_depends_on_them_unknown(tmp_path: Path) -> None:
    run = crank(inputs={"F": lambda t, q, u: float(np.sin(t))})
    loaded = reloaded(run, tmp_path)
    np.testing.assert_array_equal(loaded["frame r Rod"], run["frame r Rod"])
    with pytest.raises(
        UsageError, match="'reaction A'.*\n.*F, whose value was a Python function.*\n.*run.save"
    ) as caught:
        loaded["reaction A"]
    assert [problem.code for problem in caught.value.problems] == ["trajectory.not_computable"]
    with pytest.raises(UsageError, match="integrated during the motion"):
        loaded.at(0.1)["work"]


def test_forces_of_joints_that_stuck_are_not_computed_from_files(tmp_path: Path) -> None:
    friction = sb.Friction(mu=0.1, radius=0.1)
    run = sb.simulate(sb.form_equations(pendulum(friction=friction)), 0.3, initial={"phi": 1.0})
    loaded = reloaded(run, tmp_path)
    np.testing.assert_array_equal(loaded["frame r Rod"], run["frame r Rod"])
    np.testing.assert_array_equal(loaded["energy"], run["energy"])
    with pytest.raises(UsageError, match="changes the equations"):
        loaded["reaction hinge"]


def without_model(run: sb.Trajectory, path: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    run.save(path)
    with zipfile.ZipFile(path) as archive:
        arrays = {name.removesuffix(".npy"): np.load(archive.open(name)) for name in archive.namelist()}
    about = json.loads(str(arrays["about"]))
    change(about)
    arrays["about"] = np.array(json.dumps(about))
    with open(path, "wb") as file:
        np.savez(file, **arrays)
    return path


@pytest.mark.parametrize("tree", cases([None, "absolute"], fast=[None]))
def test_older_files_take_the_model(tree: Any, tmp_path: Path) -> None:
    run = crank(tree)
    path = without_model(run, tmp_path / "old.run", lambda about: about.pop("model"))
    old = sb.Trajectory.load(path)
    assert (old.model, old.parameters) == (None, {})
    with pytest.raises(UsageError, match="did you mean|stores additional"):
        old["energy"]
    with pytest.raises(UsageError, match="does not contain its mechanism"):
        old.of_model()
    loaded = sb.Trajectory.load(path, CRANK)
    assert loaded.model == CRANK
    np.testing.assert_array_equal(loaded["energy"], run["energy"])


def test_another_model_is_refused(tmp_path: Path) -> None:
    run = crank()
    path = without_model(run, tmp_path / "old.run", lambda about: about.pop("model"))
    with pytest.raises(UsageError, match=r"phi") as caught:
        sb.Trajectory.load(path, pendulum())
    assert caught.value.problems[0].code == "trajectory.another_model"
    run.save(path)
    with pytest.raises(UsageError, match="no joint 'A'"):
        sb.Trajectory.load(path, pendulum())["energy"]


DAMAGE: dict[str, Callable[[dict[str, Any]], object]] = {
    "no text": lambda record: record.pop("text"),
    "text is a list": lambda record: record.update(text=["name"]),
    "no TOML": lambda record: record.update(text="name = "),
    "no model": lambda record: record.update(text='name = "a"\nsurprise = 1'),
    "code": lambda record: record.update(parameters={"m1": "__import__('os').getcwd()"}),
    "deep formula": lambda record: record.update(parameters={"m1": "(" * 100_000}),
    "trees are numbers": lambda record: record.update(rotation_tree=[1, 2]),
    "table without points": lambda record: record.update(tables={"F": ["linear", "hold"]}),
    "table has another type": lambda record: record.update(tables={"F": "linear"}),
    "switches": lambda record: record.update(switches="yes"),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_model_is_refused(damage: Callable[[dict[str, Any]], object], tmp_path: Path) -> None:
    path = without_model(crank(), tmp_path / "bad.run", lambda about: damage(about["model"]))
    with pytest.raises(SymbodyError) as caught:
        sb.Trajectory.load(path)
    assert str(path) in str(caught.value)


def test_unknown_trees_and_inputs_in_a_file_are_refused_when_needed(tmp_path: Path) -> None:
    for change in ({"rotation_tree": ["nothing"]}, {"inputs": {"F": "os"}}, {"inputs": {"G0": "1"}}):
        path = without_model(
            crank(), tmp_path / "bad.run", lambda about, new=change: about["model"].update(new)
        )
        with pytest.raises(SymbodyError):
            sb.Trajectory.load(path)["energy"]


def test_a_record_that_is_no_object_is_no_trajectory(tmp_path: Path) -> None:
    for record in ([], 3, "text"):
        path = without_model(crank(), tmp_path / "bad.run", lambda about, new=record: about.update(model=new))
        with pytest.raises(FormatError, match="not a trajectory"):
            sb.Trajectory.load(path)
