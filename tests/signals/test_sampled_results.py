"""Held values in results and files, in sweeps and steppers, and what refuses them."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.formats.python_script import model_to_script
from tests.faults.refusals import refused

MODEL = """
version = 2
name = "sampled cart"
inputs = ["F"]

[parameters]
dt = 0.1
gain = 2

[initial]
x_dot = 1

[[body]]
name = "Cart"
mass = 1

[[joint]]
name = "slide"
type = "prismatic"
between = ["ground", "Cart"]
coordinate = "x"
force = { applied = "servo + F" }

[[signal]]
name = "count"
value = "count + 1"
sample = "3*dt"
initial = 2

[[signal]]
name = "push"
output = "reaction slide Fx"
sample = 0.25

[[block]]
name = "servo"
type = "pid"
input = "-x"
gains = { p = "gain", i = 1, d = 0.5 }
sample = "dt"
"""


@pytest.fixture
def model(tmp_path: Path) -> sb.Model:
    path = tmp_path / "cart.toml"
    path.write_text(MODEL)
    return sb.load_model(path)


@pytest.fixture
def eqs(model: sb.Model) -> sb.EquationSet:
    return sb.form_equations(model)


def test_models_with_samples_are_written_and_read(model: sb.Model, tmp_path: Path) -> None:
    sb.save_model(model, tmp_path / "again.toml")
    again = sb.load_model(tmp_path / "again.toml")
    assert again == model
    assert [str(signal) for signal in again.held_signals] == [str(signal) for signal in model.held_signals]
    names: dict[str, object] = {}
    exec(model_to_script(model), names)  # noqa: S102
    assert model in names.values()


def test_held_values_are_inputs_of_functions_and_no_states(eqs: sb.EquationSet) -> None:
    assert eqs.state_names == ("x_dot", "x")
    assert eqs.input_names == (
        "F",
        "count",
        "push",
        "servo_derivative",
        "servo_error",
        "servo",
        "servo_integral",
    )
    values = dict.fromkeys(eqs.input_names, 0.0) | {"F": 3.0, "servo": 4.0}
    assert sb.compile(eqs, "udot")(0.0, [0.0], [0.0], list(values.values())) == pytest.approx(7.0)
    assert "servo" in sb.generate_code(eqs, "udot", language="c")


def test_equations_list_what_is_sampled(eqs: sb.EquationSet) -> None:
    text = eqs.text(width=0)
    assert "samples:" in text and "count = count + 1, every 3*dt s" in text
    assert r"\text{count + 1, every 3*dt s}" in eqs.latex()


def test_motions_in_files_have_their_held_values(eqs: sb.EquationSet, tmp_path: Path) -> None:
    run = sb.simulate(eqs, 1.0, {"count": 5}, inputs={"F": "sin(t)"})
    assert run.held_values is not None and run["count"][0] == 6.0
    run.save(tmp_path / "run.npz")
    again = sb.Trajectory.load(tmp_path / "run.npz")
    assert again.held_values is not None
    assert again.held_values.names == run.held_values.names
    np.testing.assert_array_equal(again.held_values.values, run.held_values.values)
    for name in ("servo", "count", "x_ddot", "effort slide", "servo + count*x"):
        np.testing.assert_allclose(again[name], run[name], rtol=1e-14, atol=1e-14)
    assert again.at(0.55)["servo"] == run.at(0.55)["servo"]


def test_files_of_motions_without_samples_are_read(tmp_path: Path) -> None:
    cart = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x")
    run = sb.simulate(sb.form_equations(sb.Model("cart", [cart])), 1.0, {"x_dot": 1})
    assert run.held_values is None
    run.save(tmp_path / "run.npz")
    with zipfile.ZipFile(tmp_path / "run.npz") as archive, archive.open("about.npy") as file:
        about = json.loads(str(np.load(file)))
    assert "held" not in about["model"]  # as older versions wrote them
    assert sb.Trajectory.load(tmp_path / "run.npz").held_values is None


def test_damaged_held_values_are_refused(eqs: sb.EquationSet, tmp_path: Path) -> None:
    path, cut = tmp_path / "run.npz", tmp_path / "cut.npz"
    sb.simulate(eqs, 1.0).save(path)
    with zipfile.ZipFile(path) as whole, zipfile.ZipFile(cut, "w") as part:
        for member in whole.namelist():
            content = whole.read("u.npy" if member == "held.npy" else member)
            part.writestr(member, content)
    assert [code for code, _ in refused(lambda: sb.Trajectory.load(cut))] == ["trajectory.format"]


def test_sweeps_sample_each_case(eqs: sb.EquationSet, tmp_path: Path) -> None:
    times = np.linspace(0.0, 1.0, 5)
    arguments = (eqs, 1.0, {"dt": [0.1, 0.05], "gain": [2, 3]})
    words = {"initial": {"count": 1.0}, "times": times}
    sweep = sb.sweep(*arguments, **words, store=tmp_path / "store")
    assert sweep.success and "sampled" in sweep.notes[0]
    kept = sb.sweep(*arguments, **words, store=tmp_path / "store")
    for case in range(4):
        values = {name: column[case] for name, column in sweep.cases.items()}
        run = sb.simulate(eqs, 1.0, {"count": 1.0}, parameters=values, times=times)
        for name in ("x", "servo", "count", "push", "x_ddot"):
            np.testing.assert_array_equal(sweep[name][case], run[name])
            np.testing.assert_array_equal(kept[name][case], run[name])
            np.testing.assert_array_equal(sweep.trajectory(case)[name], run[name])
        assert sweep.trajectory(case).held_values is not None


def test_sweeps_vary_what_held_values_start_from(eqs: sb.EquationSet) -> None:
    times = np.linspace(0.0, 1.0, 5)
    sweep = sb.sweep(eqs, 1.0, initial={"count": [1, 10], "x": [0.0, 2.0]}, times=times)
    runs = [
        sb.simulate(eqs, 1.0, {"count": count, "x": x}, times=times) for count in (1, 10) for x in (0.0, 2.0)
    ]
    for name in ("count", "x*'work'", "count*'work'"):
        np.testing.assert_array_equal(sweep[name], np.stack([run[name] for run in runs]))


def test_steppers_take_samples_in_their_steps(eqs: sb.EquationSet) -> None:
    stepper = sb.Stepper(eqs, 0.04, initial={"count": 1})
    assert stepper["count"] == 1.0 and not any("slow" in note for note in stepper.notes)
    for _ in range(20):
        stepper.step(F=0.5)
    saved, other = stepper.save(), stepper.copy()
    for each in (stepper, other):
        for _ in range(10):
            each.step()
    run = sb.simulate(eqs, 1.2, {"count": 1}, inputs={"F": 0.5})
    fresh = sb.Stepper(eqs, 0.04, initial={"count": 1}).restore(saved)
    for _ in range(10):
        fresh.step()
    for each in (stepper, other, fresh):
        for name in ("x", "servo", "count", "x_ddot"):
            assert each[name] == pytest.approx(run[name][-1], rel=1e-9), name
    stepper.reset()
    assert stepper["count"] == 1.0 and stepper["servo_integral"] == 0.0
    stepper.reset({"count": "50*gain"}, x=0.5)
    assert stepper["count"] == 100.0 and stepper.step(F=0)["count"] == 101.0
    with pytest.raises(sb.SymbodyError):
        stepper.reset(count="unknown")
    assert stepper.t == 0.04 and stepper["count"] == 101.0


def test_parameters_of_a_stepper_change_between_samples(eqs: sb.EquationSet) -> None:
    stepper = sb.Stepper(eqs, 0.1, inputs={"F": 0})
    for _ in range(5):
        stepper.step()
    before = {name: stepper[name] for name in ("servo", "count", "servo_integral")}
    stepper.set(gain=0)
    assert {name: stepper[name] for name in before} == before
    stepper.set(dt=0.05)
    stepper.step()
    assert stepper["count"] == before["count"] + 1  # at 0.6


SAMPLED = "signal.sampled"


ATTEMPTS = [
    (lambda eqs, path: sb.linearize(eqs), SAMPLED),
    (lambda eqs, path: sb.linearize(eqs, inputs={"servo": 0}), SAMPLED),
    (lambda eqs, path: sb.find_equilibrium(eqs), SAMPLED),
    (lambda eqs, path: sb.inverse_dynamics(eqs, {"x": "sin(t)"}, "F", np.linspace(0, 1, 5)), SAMPLED),
    (lambda eqs, path: sb.simulate(eqs, (1.0, 0.0)), "signal.backwards"),
    (lambda eqs, path: sb.simulate(eqs, 1.0, inputs={"servo": 1}), "signal.held_input"),
    (lambda eqs, path: sb.simulate(eqs, 1.0, parameters={"dt": 0}), "signal.sample"),
    (lambda eqs, path: sb.simulate(eqs, 1.0, parameters={"dt": 1e-18}), "signal.sample"),
    (lambda eqs, path: sb.without_sampling(eqs.model), "signal.no_continuous"),
    (lambda eqs, path: sb.Stepper(eqs, 0.1, inputs=["servo"]), "stepper.unknown_name"),
]


@pytest.mark.parametrize(("attempt", "code"), ATTEMPTS, ids=map(str, range(len(ATTEMPTS))))
def test_what_takes_no_samples_says_so(
    eqs: sb.EquationSet, tmp_path: Path, attempt: Callable[[sb.EquationSet, Path], object], code: str
) -> None:
    assert {found for found, _ in refused(lambda: attempt(eqs, tmp_path))} == {code}


def test_analyses_take_held_values_as_inputs(eqs: sb.EquationSet) -> None:
    lin = sb.linearize(eqs, inputs=dict.fromkeys(eqs.input_names, 0))
    assert lin.input_names == eqs.input_names
    np.testing.assert_array_equal(lin.B[0], [1, 0, 0, 0, 0, 1, 0])
    held = [name for name in eqs.input_names if name not in ("F", "servo")]
    rest = sb.find_equilibrium(
        eqs, inputs={"F": 3, **dict.fromkeys(held, 0)}, unknowns="servo", fixed={"x": 1}
    )
    assert rest.inputs["servo"] == pytest.approx(-3.0)


def test_held_values_stand_where_signals_stand() -> None:
    body = sb.Body("Cart", mass="z")
    joint = sb.Prismatic("slide", "ground", body, coordinate="x")
    words = "a signal may depend on states"
    found = refused(lambda: sb.Model("m", [joint, sb.Signal("z", "t", sample=0.1)]), words=words)
    assert [code for code, _ in found] == ["names.not_here"]
    ring = [sb.Signal("a", "b", sample=0.1), sb.Signal("b", "2*a")]
    cart = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x")
    model = sb.Model("m", [cart, *ring])  # the sample opens the ring
    assert [code for code, _ in refused(lambda: sb.without_sampling(model))] == ["signal.loop"]


def test_a_sample_of_a_vector_is_refused(eqs: sb.EquationSet) -> None:
    cart = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x")
    z = sb.Signal("z", output="frame r Cart ground ground", sample=0.1)
    found = refused(lambda: sb.simulate(sb.form_equations(sb.Model("m", [cart, z])), 1.0))
    assert [code for code, _ in found] == ["signal.no_number"]
