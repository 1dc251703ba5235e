"""Inputs that FMUs compute: our own controllers in the loop against loops in Python, faults, ends."""

from __future__ import annotations

import importlib
import math
import re
import shutil
import zipfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import symbody as sb
from symbody.errors import SymbodyError
from tests.problems.mechanisms import equations_of
from tests.tiers import cases

fmpy = pytest.importorskip("fmpy", reason="needs the package fmpy")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")

GAINS = {"Kx": 1.0, "Kv": 2.0, "Kt": -30.0, "Kw": -8.0, "Ki": 0.5}
READS = {"x": "x", "v": "x_dot", "phi": "theta", "w": "theta_dot"}
STEP = 0.01
Version = Literal["2.0", "3.0"]
Maker = Callable[[Version], Path]


@pytest.fixture(scope="module")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Maker:
    """Return the FMU of a controller of the cart-pole: state feedback and a filtered position."""
    folder = tmp_path_factory.mktemp("controllers")
    eqs = sb.form_equations(
        sb.Model(
            "controller",
            [
                sb.Signal("F", value="Kx*x + Kv*v + Kt*phi + Kw*w + Ki*e"),
                sb.Signal("e", rate="-e + x", initial=0.0),
                sb.Signal("twice", value="2*F"),
                sb.Signal("root", value="sqrt(0.5 - x)"),
            ],
            inputs=["x", "v", "phi", "w"],
            parameters=GAINS,
        )
    )

    def make(version: Version) -> Path:
        path = folder / f"controller_{version[0]}.fmu"
        if not path.exists():
            sb.save_fmu(eqs, path, version, outputs=["F", "twice", "root"], sources=False)
        return path

    return make


def in_python(end: float, gains: Mapping[str, float] = GAINS, *, is_late: bool = False) -> sb.Stepper:
    """Return the cart-pole at the end of a loop of steps with the same controller."""
    stepper = sb.Stepper(equations_of("cart_pole"), STEP, initial={"theta": 0.2}, rtol=1e-11)
    e, F = 0.0, gains["Kt"] * 0.2
    for _ in range(round(end / STEP)):
        x, v, phi, w = (float(stepper[name]) for name in READS.values())
        e = x + (e - x) * math.exp(-STEP)
        new = (gains["Kx"] * x + gains["Kv"] * v + gains["Kt"] * phi + gains["Kw"] * w) + gains["Ki"] * e
        stepper.step(F=float(F if is_late else new))
        F = new
    return stepper


def balance(law: sb.FmuInput, end: float = 2.0, **more: Any) -> sb.Trajectory:
    return sb.simulate(equations_of("cart_pole"), end, {"theta": 0.2}, inputs={"F": law}, rtol=1e-11, **more)


@pytest.mark.parametrize("version", cases(["2.0", "3.0"], fast=["3.0"]))
@pytest.mark.parametrize("is_late", cases([False, True], fast=[True]))
def test_loop_equals_steps_in_python(controller: Maker, version: Version, is_late: bool) -> None:
    law = sb.FmuInput(controller(version), "F", READS, STEP, is_late=is_late)
    run, stepper = balance(law), in_python(2.0, is_late=is_late)
    assert run.success
    for name in (*READS.values(), "energy"):
        assert run[name][-1] == pytest.approx(stepper[name], abs=1e-9), name


def test_values_are_held_between_samples(controller: Maker) -> None:
    times = np.linspace(0.0, 0.1, 41)
    run = balance(sb.FmuInput(controller("2.0"), "F", READS, STEP), 0.1, times=times)
    assert (run.t == times).all()
    force = run["F"].reshape(-1)
    assert all(np.unique(force[k : k + 4]).size == 1 for k in range(0, 40, 4))  # a sample has the new value
    assert np.unique(force[:40]).size == 10
    every = balance(sb.FmuInput(controller("2.0"), "F", READS, STEP), 0.1)
    for name in ("x", "theta", "F", "work"):
        assert run[name] == pytest.approx(np.interp(times, every.t, every[name]), abs=1e-3)
    assert every["energy"] - every["energy"][0] == pytest.approx(every["work"], abs=1e-8)


def test_saved_motion_knows_its_inputs(controller: Maker, tmp_path: Path) -> None:
    run = balance(sb.FmuInput(controller("2.0"), "F", READS, STEP), 0.1, times=np.linspace(0.0, 0.095, 20))
    run.save(tmp_path / "run.npz")
    again = sb.Trajectory.load(tmp_path / "run.npz")
    assert again["F"] == pytest.approx(run["F"], abs=1e-15)
    assert again["x_ddot"] == pytest.approx(run["x_ddot"], abs=1e-9)


def test_parameters_expressions_and_last_piece(controller: Maker) -> None:
    gains = GAINS | {"Kt": -40.0}
    reads = READS | {"phi": "2*theta - 'theta'"}
    law = sb.FmuInput(controller("2.0"), "F", reads, STEP, {"Kt": -40.0})
    assert balance(law, 1.0)["theta"][-1] == pytest.approx(in_python(1.0, gains)["theta"], abs=1e-9)
    assert balance(law, 0.0351).t[-1] == 0.0351  # no whole number of steps


def test_inputs_by_one_instance(controller: Maker, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = watch_instances(monkeypatch)
    reads = {"x": "theta1", "v": "theta1_dot"}
    eqs = equations_of("rr_robot")
    names = eqs.coordinate_names[:1]
    reads = {"x": names[0], "v": f"{names[0]}_dot"}
    both = [sb.FmuInput(controller("2.0"), output, reads, 0.05) for output in ("F", "twice")]
    run = sb.simulate(eqs, 0.2, inputs={"T1": both[0], "T2": both[1]})
    assert run["T2"] == pytest.approx(2.0 * run["T1"]) and np.unique(run["T1"]).size > 2
    assert calls == ["instantiate", "terminate", "freeInstance"]


def test_samples_of_different_steps(controller: Maker) -> None:
    eqs = equations_of("rr_robot")
    name = eqs.coordinate_names[0]
    laws = {
        "T1": sb.FmuInput(controller("2.0"), "F", {"x": name}, 0.1),
        "T2": sb.FmuInput(controller("3.0"), "F", {"x": name}, 0.15),
    }
    run = sb.simulate(eqs, 0.6, inputs=laws)
    changes = {word: run.t[1:][np.diff(run[word]) != 0.0] for word in laws}
    assert changes["T1"] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert changes["T2"] == pytest.approx([0.15, 0.3, 0.45])


def test_loops_stay_closed_and_events_stop(controller: Maker) -> None:
    law = sb.FmuInput(controller("2.0"), "F", {"x": "s", "v": "s_dot"}, 0.02)
    eqs = equations_of("slider_crank")
    run = sb.simulate(eqs, 1.0, inputs={"F": law})
    assert run.success and run["constraint_violation"].max() < 1e-9
    half = float(run.at(0.51)["s"])
    stopped = sb.simulate(eqs, 1.0, inputs={"F": law}, events=sb.Event(f"s - {half!r}", 0, "stop"))
    assert stopped.status is sb.Status.STOPPED and stopped.t[-1] <= 0.51 + 1e-9
    assert len(stopped.events) == 1


def test_inputs_decide_when_a_formula_changes(controller: Maker) -> None:
    body = sb.Body("Block", mass=1.0)
    force = sb.Drive(applied="if(t*F > 0.52, 3, 0)")
    rail = sb.Prismatic("rail", "ground", body, axis="x", coordinate="x", force=force)
    eqs = sb.form_equations(sb.Model("block", [body, rail], (0, 0, 0), inputs=["F"]))
    law = sb.FmuInput(controller("2.0"), "F", {"x": "1"}, 0.25, {"Ki": 0.0})
    run = sb.simulate(eqs, 1.0, inputs={"F": law})
    assert run["F"] == pytest.approx(np.ones(run.t.size))
    assert run["x"][-1] == pytest.approx(1.5 * 0.48**2, abs=1e-12)


def test_what_was_computed_moves_it_again(controller: Maker) -> None:
    body = sb.Body("Block", mass=1.0)
    force = sb.Drive(applied="F - 4*x - 2*held")
    rail = sb.Prismatic("rail", "ground", body, axis="x", coordinate="x", force=force)
    held = sb.Signal("held", value="x_dot", sample=0.03)  # samples of both kinds go on beside each other
    model = sb.Model("block", [body, rail, held], (0, 0, 0), inputs=["F"], initial={"x": 0.3})
    eqs = sb.form_equations(model)
    law = sb.FmuInput(controller("2.0"), "F", {"x": "x", "w": "x_dot"}, 0.05)
    run = sb.simulate(eqs, 1.0, inputs={"F": law}, rtol=1e-11)
    assert run.provenance is not None
    again = sb.simulate(eqs, 1.0, inputs={"F": run.provenance.tables["F"]}, rtol=1e-11)
    for name in ("x", "x_dot", "held", "F"):
        assert run[name][-1] == pytest.approx(again[name][-1], abs=1e-10), name


# Faults


def problem_of(call: Callable[[], object]) -> Any:
    with pytest.raises(SymbodyError) as caught:
        call()
    return caught.value.problems[0]


def test_step_is_needed(controller: Maker) -> None:
    assert problem_of(lambda: sb.FmuInput(controller("2.0"), "F", READS)).code == "fmu_input.step"
    assert problem_of(lambda: sb.FmuInput(controller("2.0"), "F", READS, -1.0)).code == "fmu_input.step"


def test_names_have_suggestions(controller: Maker) -> None:
    path = controller("2.0")
    assert "'twice'" in problem_of(lambda: balance(sb.FmuInput(path, "twic", READS, STEP))).fix
    fault = problem_of(lambda: balance(sb.FmuInput(path, "F", {"phy": "theta"}, STEP)))
    assert fault.code == "fmu_input.variable" and "'phi'" in fault.fix
    fault = problem_of(lambda: balance(sb.FmuInput(path, "F", {"theta": "phi"}, STEP)))
    assert "did you mean" in fault.fix or fault.code != "fmu_input.variable"
    fault = problem_of(lambda: balance(sb.FmuInput(path, "F", {"x": "tehta"}, STEP)))
    assert "theta" in fault.fix
    fault = problem_of(lambda: balance(sb.FmuInput(path, "F", {"x": "mass_matrix"}, STEP)))
    assert fault.code == "fmu_input.no_number"
    assert problem_of(lambda: balance(sb.FmuInput(path, "F", READS, STEP, {"K": 1.0}))).where.endswith(
        "parameters"
    )


def test_no_such_input(controller: Maker) -> None:
    law = sb.FmuInput(controller("2.0"), "F", READS, STEP)
    fault = problem_of(lambda: sb.simulate(equations_of("cart_pole"), 1.0, inputs={"G": law}))
    assert fault.code == "fmu_input.unknown" and "F" in fault.fix


def test_libraries_that_do_not_load(controller: Maker, tmp_path: Path) -> None:
    path = rewrite(
        controller("2.0"), tmp_path / "empty.fmu",
        lambda entry, data: (entry, b"" if entry.endswith(".so") else data),
    )  # fmt: skip
    here = Path.cwd()
    assert problem_of(partial(balance, sb.FmuInput(path, "F", READS, STEP))).code == "fmu_input.load"
    assert Path.cwd() == here


def test_no_fmpy(controller: Maker, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = importlib.import_module

    def refuse(name: str, *more: Any) -> Any:
        if name.startswith("fmpy"):
            raise ImportError(name)
        return usual(name, *more)

    monkeypatch.setattr(importlib, "import_module", refuse)
    fault = problem_of(lambda: balance(sb.FmuInput(controller("2.0"), "F", READS, STEP)))
    assert fault.code == "fmu_input.no_fmpy" and "pip install" in fault.fix


def rewrite(path: Path, target: Path, change: Callable[[str, bytes], tuple[str, bytes]]) -> Path:
    """Return an archive whose entries were changed."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w") as made:
        for entry in source.namelist():
            made.writestr(*change(entry, source.read(entry)))
    return target


def test_files_that_cannot_be_stepped_here(controller: Maker, tmp_path: Path) -> None:
    path = controller("2.0")

    def for_another(entry: str, data: bytes) -> tuple[str, bytes]:
        return re.sub(r"binaries/[^/]+/", "binaries/win64/", entry).replace(".so", ".dll"), data

    def for_exchange(entry: str, data: bytes) -> tuple[str, bytes]:
        return entry, re.sub(rb"<CoSimulation.*?(/>|</CoSimulation>)", b"", data, flags=re.DOTALL)

    (tmp_path / "text.fmu").write_text("no archive", encoding="utf-8")
    files = {
        "fmu_input.file": tmp_path / "text.fmu",
        "fmu_input.platform": rewrite(path, tmp_path / "other.fmu", for_another),
        "fmu_input.kind": rewrite(path, tmp_path / "exchange.fmu", for_exchange),
        "fmu_input.description": rewrite(
            path,
            tmp_path / "wrong.fmu",
            lambda entry, data: (entry, data.replace(b"causality", b"casuality")),
        ),
    }
    for code, file in files.items():
        law = sb.FmuInput(file, "F", READS, STEP)
        assert problem_of(partial(balance, law)).code == code
    missing = problem_of(lambda: balance(sb.FmuInput(tmp_path / "none.fmu", "F", READS, STEP)))
    assert missing.code == "fmu_input.file"


# Steppers


def stepped(law: sb.FmuInput, dt: float = STEP, **more: Any) -> sb.Stepper:
    return sb.Stepper(
        equations_of("cart_pole"), dt, initial={"theta": 0.2}, inputs={"F": law}, rtol=1e-11, **more
    )


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("is_late", [False, True])
def test_steppers_step_fmus(controller: Maker, version: Version, is_late: bool) -> None:
    stepper = stepped(sb.FmuInput(controller(version), "F", READS, STEP, is_late=is_late))
    assert not stepper.inputs  # steps give none
    expected = in_python(1.0, is_late=is_late)
    for _ in range(100):
        stepper.step()
    assert stepper.q == pytest.approx(expected.q, abs=1e-9)
    assert stepper["F"] == pytest.approx(expected["F"], abs=1e-7)
    with pytest.raises(sb.UsageError):
        stepper.step(F=1.0)


@pytest.mark.parametrize("dt", [0.004, 0.025])
def test_steps_need_not_fit_samples(controller: Maker, dt: float) -> None:
    stepper = stepped(sb.FmuInput(controller("2.0"), "F", READS, STEP), dt)
    for _ in range(round(0.5 / dt)):
        stepper.step()
    assert stepper.t == pytest.approx(0.5, abs=1e-12)
    assert stepper.q == pytest.approx(in_python(0.5).q, abs=1e-9)


def test_saved_and_copied_steppers_go_on_with_their_fmus(controller: Maker) -> None:
    law = sb.FmuInput(controller("3.0"), "F", READS, STEP)
    stepper, other = stepped(law, 0.004), stepped(law, 0.004)
    for _ in range(36):
        stepper.step()
    saved, copied = stepper.save(), stepper.copy()
    other.restore(saved)
    for _ in range(40):
        for each in (stepper, copied, other):
            each.step()
    assert stepper.q.tolist() == copied.q.tolist() == other.q.tolist()
    stepper.set(m=1.1).restore(saved)
    for _ in range(40):
        stepper.step()
    assert stepper.q.tolist() == other.q.tolist()
    stepper.reset()
    for _ in range(125):
        stepper.step()
    assert stepper.q == pytest.approx(in_python(0.5).q, abs=1e-9)


def test_event_stops_a_step_between_samples(controller: Maker) -> None:
    law = sb.FmuInput(controller("2.0"), "F", READS, STEP)
    event = sb.Event("theta - 0.1", action="stop")
    stepper = stepped(law, 0.025, events=event)
    while stepper.status is sb.Status.SUCCESS:
        stepper.step()
    run = balance(law, events=[event])
    assert stepper.t == pytest.approx(float(run.t[-1]), abs=1e-9)
    stepper.step()
    assert stepper.status is sb.Status.SUCCESS


@pytest.mark.parametrize("times", [np.linspace(0.0, 2.0, 21), np.array([0.0, 2.0])])
def test_a_stop_has_its_own_time_among_times(controller: Maker, times: Any) -> None:
    law = sb.FmuInput(controller("2.0"), "F", READS, STEP)
    event = sb.Event("theta - 0.1", action="stop")
    run, every = (balance(law, times=t, events=[event]) for t in (times, None))
    assert run.status is sb.Status.STOPPED and run.t[-1] == run.events[-1].t
    np.testing.assert_array_equal(run.t[:-1], times[: run.t.size - 1])
    assert run.t[-1] == pytest.approx(every.t[-1], abs=1e-9)
    assert run["theta"][-1] == pytest.approx(0.1, abs=1e-9)


def test_fmu_without_states_is_not_saved(controller: Maker, tmp_path: Path) -> None:
    def forget(entry: str, data: bytes) -> tuple[str, bytes]:
        return entry, data.replace(b'canSerializeFMUstate="true"', b"")

    path = rewrite(controller("2.0"), tmp_path / "forgetful.fmu", forget)
    stepper = stepped(sb.FmuInput(path, "F", READS, STEP)).step()
    for call in (stepper.save, stepper.copy):
        assert problem_of(call).code == "fmu_input.no_state"
    assert stepper.reset().step().t == STEP


def test_where_no_motion_is_computed_at_once(controller: Maker) -> None:
    eqs, law = equations_of("cart_pole"), sb.FmuInput(controller("2.0"), "F", READS, STEP)
    program = problem_of(lambda: sb.generate_simulation(eqs, 1.0, inputs={"F": law}))
    assert program.code == "fmu_input.elsewhere"
    back = problem_of(lambda: sb.simulate(eqs, (1.0, 0.0), inputs={"F": law}))
    assert back.code == "fmu_input.backwards"


def test_a_sweep_computes_each_case_with_an_fmu_of_its_own(controller: Maker, tmp_path: Path) -> None:
    eqs, law = equations_of("cart_pole"), sb.FmuInput(controller("2.0"), "F", READS, STEP)
    times = np.linspace(0, 0.5, 11)
    given = {"times": times, "inputs": {"F": law}}
    swept = sb.sweep(eqs, 0.5, {"m": [1.0, 2.0]}, store=tmp_path / "store", **given)
    again = sb.sweep(eqs, 0.5, {"m": [1.0, 2.0]}, store=tmp_path / "store", **given)
    for case, mass in enumerate((1.0, 2.0)):
        run = sb.simulate(eqs, 0.5, parameters={"m": mass}, **given)
        for name in (*eqs.state_names, "F", "energy"):
            np.testing.assert_array_equal(swept[name][case], run[name])
            np.testing.assert_array_equal(again[name][case], run[name])
    assert problem_of(lambda: sb.sweep(eqs, 0.5, {"m": [1.0]}, inputs={"G": law})).code == "fmu_input.unknown"


# Ends


def watch_instances(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a list that the beginnings and ends of all instances are added to."""
    calls: list[str] = []
    kind = importlib.import_module("fmpy.fmi2").FMU2Slave
    for name in ("instantiate", "terminate", "freeInstance"):
        usual = getattr(kind, name)

        def note(self: Any, *given: Any, _name: str = name, _usual: Any = usual, **named: Any) -> Any:
            calls.append(_name)
            return _usual(self, *given, **named)

        monkeypatch.setattr(kind, name, note)
    return calls


def test_instances_end_with_the_motion(controller: Maker, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = watch_instances(monkeypatch)
    law = sb.FmuInput(controller("2.0"), "F", {"x": "t"}, 0.05)

    def fail(t: float, q: object, u: object) -> float:
        if t > 0.2:
            raise RuntimeError("broken off")
        return 0.0

    fault = problem_of(lambda: sb.simulate(equations_of("rr_robot"), 1.0, inputs={"T1": law, "T2": fail}))
    assert "broken off" in fault.what
    assert calls == ["instantiate", "terminate", "freeInstance"]


def test_progress_ends_the_motion(controller: Maker) -> None:
    shares: list[float] = []

    def report(share: float) -> bool:
        shares.append(share)
        return share < 0.5

    run = balance(sb.FmuInput(controller("2.0"), "F", READS, STEP), 1.0, progress=report)
    assert run.status is sb.Status.INTERRUPTED and run.t[-1] == pytest.approx(0.5)
    assert shares == sorted(shares) and len(shares) >= 49


def test_numbers_that_are_none(controller: Maker, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = watch_instances(monkeypatch)
    law = sb.FmuInput(controller("2.0"), "root", {"x": "10*t"}, STEP)
    fault = problem_of(lambda: balance(law))
    assert fault.code == "fmu_input.failed" and "t = 0.0" in fault.what
    assert calls[0] == "instantiate" and calls[-1] == "freeInstance"
    law = sb.FmuInput(controller("2.0"), "F", {"x": "sqrt(0.05 - t)"}, STEP)
    assert problem_of(lambda: balance(law)).code == "fmu_input.not_finite"
    assert calls[-1] == "freeInstance"


def test_events_see_each_sample_of_an_fmu(controller: Maker) -> None:
    """F is held from sample to sample, rises from -6 through -3 at t = 0.12 and through 0 at t = 0.39.

    F (t - 0.455) falls through zero where F becomes positive, and rises where t passes 0.455.
    """
    law = sb.FmuInput(controller("3.0"), "F", READS, STEP)
    events = [sb.Event("F + 3", name="up"), sb.Event("F*(t - 0.455)", -1, name="falls")]
    events += [sb.Event("F*(t - 0.455)", 1, name="rises")]
    run = balance(law, 0.6, events=events)
    F = run["F"]
    crossed = [run.t[1:][np.diff(np.sign(F - level)) > 0][0] for level in (-3.0, 0.0)]
    seen = [(event.name, event.t) for event in run.events]
    assert [name for name, _ in seen] == ["up", "falls", "rises"]
    np.testing.assert_allclose([t for _, t in seen], [*crossed, 0.455], atol=1e-9)


@pytest.mark.parametrize("events", [(), sb.Event("theta - 9", 1, "stop")])
def test_lanes_step_fmus(controller: Maker, events: Any) -> None:
    eqs, dt, angles = equations_of("cart_pole"), 0.025, [0.2, 0.1, -0.15]
    laws = {"F": sb.FmuInput(controller("2.0"), "F", READS, STEP)}
    lanes = sb.LaneStepper(eqs, dt, 3, initial={"theta": angles}, inputs=laws, events=events)
    singles = [sb.Stepper(eqs, dt, initial={"theta": angle}, inputs=laws, events=events) for angle in angles]
    copied = lanes.copy()
    for _ in range(20):
        for single in singles:
            single.step()
        for each in (lanes, copied):
            each.step()
            np.testing.assert_array_equal(each.x, [[*single.u, *single.q] for single in singles])
            np.testing.assert_array_equal(each.t, [single.t for single in singles])


@pytest.mark.parametrize("times", [None, np.array([0.0, 0.3, 0.4, 0.55, 0.6])])
@pytest.mark.parametrize("jump", [0.3, 0.4])
def test_a_rate_that_jumps_at_a_sample_strikes(controller: Maker, jump: float, times: Any) -> None:
    """What rides freely on a carrier stays as fast as it was in space; it was struck by no force."""
    rider = sb.Prismatic("ridden", "Carrier", sb.Body("Rider", mass=1), axis="z", coordinate="r")
    law = f"if(t < {jump}, t, 2*t - {jump})"
    carrier = sb.Prismatic(
        "carried", "ground", sb.Body("Carrier", mass=1), axis="z", coordinate="p", motion=law
    )
    pushed = sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=sb.Drive("F"))
    eqs = sb.form_equations(sb.Model("struck", [carrier, rider, pushed], inputs=["F"]))
    reads = {"x": "r", "v": "r_dot", "phi": "p_dot", "w": "x_dot"}
    run = sb.simulate(
        eqs,
        0.6,
        {"r": 0, "r_dot": 0},
        inputs={"F": sb.FmuInput(controller("2.0"), "F", reads, 0.05)},
        times=times,
    )
    assert (np.diff(run.t) >= 0.0).all() and (times is None or (run.t == times).all())
    assert run["r_dot"][-1] == pytest.approx(-1.0, abs=1e-9)
    assert run["r"][-1] == pytest.approx(jump - 0.6, abs=1e-9)
    assert run["energy"] - run["energy"][0] == pytest.approx(run["work"], abs=1e-8)
    assert sum("prescribed rates jump" in note for note in run.notes) == 1
