"""FMUs in FMPy: what an importer sees of a small mechanism, and what is refused."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import mpmath
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import symbody as sb
from symbody.cli.entry import run
from symbody.codegen.formation.sequences import form_sequence
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.precise_numbers import MPMATH
from tests.fmu.importer import EXAMPLES, check_archive, instance, pendulum, simulate, states
from tests.mechanisms import example
from tests.tiers import cases

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


@pytest.fixture(scope="module")
def crank(tmp_path_factory: pytest.TempPathFactory) -> tuple[sb.EquationSet, sb.Fmu]:
    eqs = example("slider_crank")
    path = tmp_path_factory.mktemp("fmu") / "slider_crank.fmu"
    return eqs, sb.save_fmu(eqs, path, outputs=["reaction B Fx", "theta_ddot"])


def test_archive_is_valid_and_says_what_it_holds(crank: tuple[sb.EquationSet, sb.Fmu]) -> None:
    eqs, made = crank
    check_archive(made.path, "3.0")
    names = [variable.name for variable in made.variables]
    assert names[: 1 + 2 * 6] == [
        "time", *eqs.state_names, *(f"der({name})" for name in eqs.state_names),
    ]  # fmt: skip
    assert names[-4:] == ["constraint_violation", "energy", "reaction.B.Fx", "theta_ddot"]
    assert {v.name: v.unit for v in made.variables}["reaction.B.Fx"] == "N"
    exact = [v.name for v in made.variables if v.initial == "exact" and v.causality == "local"]
    assert exact == ["theta_dot", "theta"]  # one degree of freedom
    assert "slider_crank.fmu" in repr(made)


def test_what_rates_depend_on_is_listed(crank: tuple[sb.EquationSet, sb.Fmu]) -> None:
    _, made = crank
    reads = {v.name: v.dependencies for v in made.variables}
    assert reads["der(theta)"] == ((1, "constant"),)  # theta_dot
    assert len(reads["der(theta_dot)"] or ()) == 7  # all states and the force


def test_the_same_model_gives_the_same_bytes(crank: tuple[sb.EquationSet, sb.Fmu], tmp_path: Path) -> None:
    _, made = crank
    again = sb.save_fmu(
        example("slider_crank"), tmp_path / "slider_crank.fmu", outputs=["reaction B Fx", "theta_ddot"]
    )
    assert again.path.read_bytes() == made.path.read_bytes()


# A loop that FMPy's CVODE integrates with absolute tolerances of about 1e-8 a step drifts from the exact motion
# by some ten times more over a second; our own integrator bounds the same errors.
@pytest.mark.parametrize(("kind", "error"), [("ModelExchange", 2e-4), ("CoSimulation", 1e-6)])
def test_motion_is_that_of_simulate(crank: tuple[sb.EquationSet, sb.Fmu], kind: str, error: float) -> None:
    eqs, made = crank
    run = sb.simulate(eqs, 1.0, times=np.linspace(0.0, 1.0, 21), rtol=1e-11)
    seen = simulate(made.path, kind, 1.0, [*eqs.state_names, "constraint_violation"], 1e-8)
    assert np.abs(seen[:-1] - states(run)).max() < error
    assert seen[-1].max() < 1e-6


def test_first_values_are_assembled_in_the_fmu(crank: tuple[sb.EquationSet, sb.Fmu]) -> None:
    eqs, made = crank
    with instance(made.path, "ModelExchange") as fmu:
        fmu.initialize({"theta": 0.7, "theta_dot": 1.3, "F": 2.0})
        seen = fmu.get(*eqs.state_names, "reaction.B.Fx")
        state = sb.assemble(eqs, {"theta": 0.7, "theta_dot": 1.3}, inputs={"F": 2.0})
        x = [*state.u.values(), *state.q.values()]
        assert seen[:6] == pytest.approx(x, abs=1e-9)
        value = sb.compile(eqs, "reaction B Fx").of_state(0.0, x, [2.0])
        assert seen[6] == pytest.approx(float(value), rel=1e-9)


def test_derivatives_are_those_of_the_model(crank: tuple[sb.EquationSet, sb.Fmu]) -> None:
    eqs, made = crank
    with instance(made.path, "ModelExchange") as fmu:
        fmu.initialize({"theta": 0.7, "theta_dot": 1.3, "F": 2.0})
        x = np.array(fmu.get(*eqs.state_names))
        slopes = sb.compile(sb.Baumgarte().applied(eqs), "d xdot/d(u, q, r)").of_state(0.0, x, [2.0])
        shown = sb.compile(eqs, "d reaction B Fx/d(u, q, r)").of_state(0.0, x, [2.0])
        unknowns = [f"der({name})" for name in eqs.state_names] + ["reaction.B.Fx"]
        seen = np.array([fmu.derivative(unknowns, name) for name in (*eqs.state_names, "F")]).T
        # the text computes in another order of roundings than machine code that fuses products
        np.testing.assert_allclose(seen, np.vstack([slopes, shown]), rtol=1e-10, atol=1e-9)


def test_derivatives_are_those_of_60_digits(crank: tuple[sb.EquationSet, sb.Fmu]) -> None:
    eqs, made = crank
    with instance(made.path, "ModelExchange") as fmu:
        fmu.initialize({"theta": 0.7, "theta_dot": 1.3, "F": 2.0})
        x = fmu.get(*eqs.state_names)
        p = fmu.get(*eqs.parameter_names)
        rates = [f"der({name})" for name in eqs.state_names]
        seen = np.array([fmu.derivative(rates, name) for name in eqs.state_names]).T
    sequence, _ = form_sequence(sb.Baumgarte().applied(eqs), ["xdot"], {}, eqs.parameter_names)
    n_u, step = len(eqs.speed_names), mpmath.mpf(10) ** -25

    def slopes(place: int, sign: int) -> list[mpmath.mpf]:
        moved = [mpmath.mpf(value) + (sign * step if k == place else 0) for k, value in enumerate(x)]
        point = {"t": [0], "q": moved[n_u:], "u": moved[:n_u], "r": [2], "p": [mpmath.mpf(v) for v in p]}
        return evaluate_sequence(sequence, point, MPMATH)[0]

    with mpmath.workdps(60):
        pairs = [(slopes(k, 1), slopes(k, -1)) for k in range(len(x))]
        exact = np.array(
            [[float((a - b) / (2 * step)) for a, b in zip(*pair, strict=True)] for pair in pairs]
        ).T
    assert np.abs(seen - exact).max() < 1e-10 * np.abs(exact).max()


def test_copy_of_the_state_repeats_the_bits(crank: tuple[sb.EquationSet, sb.Fmu]) -> None:
    eqs, made = crank
    with instance(made.path, "CoSimulation") as fmu:
        fmu.initialize()
        fmu.steps(np.linspace(0.0, 0.7, 8).tolist())
        kept = fmu.fmu.getFMUState()
        later = np.linspace(0.7, 1.2, 6).tolist()
        fmu.steps(later)
        first = fmu.get(*fmu.references)
        fmu.fmu.setFMUState(kept)
        fmu.steps(later)
        assert fmu.get(*fmu.references) == first
        fmu.fmu.freeFMUState(kept)


def test_calls_out_of_order_are_refused_with_a_cure(
    crank: tuple[sb.EquationSet, sb.Fmu], capfd: pytest.CaptureFixture[str]
) -> None:
    _, made = crank
    with instance(made.path, "CoSimulation") as fmu:
        with pytest.raises(Exception, match="fmi3DoStep"):
            fmu.fmu.doStep(0.0, 0.1)
        with pytest.raises(Exception, match="fmi3SetFloat64"):
            fmu.set("beta", 0.1)
        fmu.initialize()
        with pytest.raises(Exception, match="fmi3SetFloat64"):
            fmu.set("theta", 0.1)
    heard = capfd.readouterr()
    text = heard.out + heard.err
    assert "enter initialization mode first" in text
    assert "beta follows from the constraints: set others instead" in text
    assert "theta can be set before initialization mode ends only" in text


def test_loop_that_cannot_close_is_told(
    crank: tuple[sb.EquationSet, sb.Fmu], capfd: pytest.CaptureFixture[str]
) -> None:
    _, made = crank
    with instance(made.path, "CoSimulation") as fmu:
        with pytest.raises(Exception, match="fmi3ExitInitializationMode"):
            fmu.initialize({"L1": 50.0, "theta": 1.5})
        assert "no configuration near the one before" in "".join(capfd.readouterr())


def test_archive_without_libraries_holds_sources(tmp_path: Path) -> None:
    made = sb.save_fmu(pendulum(), tmp_path / "a pendulum.fmu", "2.0", platforms=())
    files = zipfile.ZipFile(made.path).namelist()
    assert made.platforms == () and "no library: importers" in made.notes[0]
    assert "sources/fmi2.c" in files and not any(name.startswith("binaries") for name in files)
    assert validate_fmu(str(made.path)) == []


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"path": "pendulum.zip"}, "fmu.path"),
        ({"fixed": ["mass"]}, "fmu.fixed"),
        ({"platforms": "arm-linux"}, "fmu.platform"),
        ({"platforms": "aarch64-linux", "version": "2.0"}, "fmu.platform"),
        ({"platforms": (), "sources": False}, "fmu.empty"),
    ],
)
def test_wrong_arguments_are_refused(tmp_path: Path, arguments: dict[str, object], code: str) -> None:
    path = tmp_path / str(arguments.pop("path", "pendulum.fmu"))
    with pytest.raises(sb.UsageError) as caught:
        sb.save_fmu(pendulum(), path, **arguments)  # type: ignore[arg-type]
    assert caught.value.problems[0].code == code
    assert not path.exists()


def test_platform_without_compiler_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symbody.fmu.binaries.compiler_for", lambda target: ())
    with pytest.raises(sb.EnvironmentFault) as caught:
        sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", platforms="x86_64-windows")
    assert caught.value.problems[0].code == "fmu.compiler"
    made = sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu")
    assert made.platforms == () and "there is no C compiler" in made.notes[0]


def test_compiler_that_refuses_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symbody.fmu.binaries.compiler_for", lambda target: ("cc", "--no-such-flag"))
    with pytest.raises(sb.CompileError) as caught:
        sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu")
    assert caught.value.problems[0].code == "fmu.compile"


def test_command_line_writes_an_fmu(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.fmu"
    model = str(EXAMPLES / "rr_robot" / "rr_robot.toml")
    command = ["fmu", model, "-o", str(path), "--version", "2.0", "--output", "kinetic_energy"]
    assert run(command) == 0
    assert f"{path}: FMI 2.0" in capsys.readouterr().out
    assert validate_fmu(str(path)) == []
    assert run(command) == 2  # the file exists
    assert "--force" in capsys.readouterr().err
    assert run([*command, "--force", "--platform", "amiga"]) == 2
    assert "fmu.platform" in capsys.readouterr().err


def test_integrators_in_python_are_refused(tmp_path: Path) -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", constraints=sb.Partition())  # type: ignore[arg-type]
    assert caught.value.problems[0].code in ("fmu.motion", "call.wrong_argument", "call.type")


@pytest.mark.exhaustive
def test_steps_of_generalized_alpha_are_those_of_simulate(tmp_path: Path) -> None:
    method = sb.GeneralizedAlpha(rho=0.8, step=0.01)
    run = sb.simulate(pendulum(), 1.0, times=np.linspace(0.0, 1.0, 21), rtol=1e-6, integrator=method)
    made = sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", integrator=method)
    assert b'tolerance="1e-05"' in zipfile.ZipFile(made.path).read("modelDescription.xml")
    seen = simulate(made.path, "CoSimulation", 1.0, ["theta_dot", "theta"], 1e-6)
    np.testing.assert_allclose(seen, states(run), rtol=1e-12, atol=1e-13)


def test_implicit_steps_end_at_samples(tmp_path: Path) -> None:
    """A pole under a digital controller with two sample times."""
    eqs, start, end = example("cart_pole_pid"), {"theta": 0.1}, 0.5
    times = np.linspace(0.0, end, 21)
    run = sb.simulate(eqs, end, start, times=times, rtol=1e-10)
    own = sb.simulate(eqs, end, start, times=times, rtol=1e-7, integrator=sb.GeneralizedAlpha())
    made = sb.save_fmu(eqs, tmp_path / "cart.fmu", initial=start, integrator=sb.GeneralizedAlpha())
    seen = simulate(made.path, "CoSimulation", end, eqs.state_names, 1e-7)
    assert np.abs(seen - states(run)).max() < 2 * np.abs(states(own) - states(run)).max() < 1e-3


def test_folder_that_is_not_there_is_a_fault(tmp_path: Path) -> None:
    with pytest.raises(sb.FormatError) as caught:
        sb.save_fmu(pendulum(), tmp_path / "none" / "pendulum.fmu", platforms=())
    assert caught.value.problems[0].code == "file.not_saved"


def test_table_that_is_the_law_of_an_input_is_noted(tmp_path: Path) -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "quarter_car" / "quarter_car.toml"))
    made = sb.save_fmu(eqs, tmp_path / "car.fmu", platforms=())
    assert made.notes[-1].startswith("road is an input: 0 until an importer sets it")
    assert "use co-simulation, or a tolerance of 1e-10" in made.notes[-2]


@pytest.mark.parametrize("kind", cases(["ModelExchange", "CoSimulation"], fast=["CoSimulation"]))
def test_what_an_action_sets_holds_in_a_loop(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A crank that turns back at half its rate takes the whole loop with it; what cannot be met is said."""
    eqs = example("slider_crank")
    turn = sb.Event("t - 0.1", action={"theta_dot": "-theta_dot/2"})
    run = sb.simulate(eqs, 0.2, times=np.linspace(0.0, 0.2, 21), rtol=1e-11, events=turn)
    made = sb.save_fmu(eqs, tmp_path / "crank.fmu", events=[turn])
    seen = simulate(made.path, kind, 0.2, eqs.state_names, 1e-9)
    behind = run.t > 0.1
    # as in `test_motion_is_that_of_simulate`, a fifth of its time
    assert np.abs(seen[:, behind] - states(run)[:, behind]).max() < 1e-4
    tear = sb.Event("t - 0.1", action={"theta_dot": "-theta_dot", "s_dot": "5 + s_dot"})
    torn = sb.save_fmu(eqs, tmp_path / "torn.fmu", events=[tear])
    with pytest.raises(Exception, match="fmi|FMI"):
        simulate(torn.path, kind, 0.2, eqs.state_names, 1e-9, debug_logging=True)
    said = capsys.readouterr()
    assert "the constraints do not admit what the action of an event sets" in said.out + said.err


def test_leaders_share_what_is_set_although_their_coupling_is_substituted(tmp_path: Path) -> None:
    """With moments 1 and 3 of a and c, and a - b - c = 0, the least energy for b' = -1 is a' = -3/4, c' = 1/4."""
    bodies = [sb.Body(name, inertia=(0, 0, moment)) for name, moment in (("A", 1), ("B", 5), ("C", 3))]
    joints = [sb.Revolute(f"J{x}", "ground", x, coordinate=x.lower()) for x in "ABC"]
    model = sb.Model("shafts", [*bodies, *joints, sb.Constraint("K", "a - b - c")])
    eqs = sb.form_equations(model, substitute=True)
    made = sb.save_fmu(eqs, tmp_path / "shafts.fmu", events=[sb.Event("t - 0.1", action={"b_dot": -1})])
    for kind in ("ModelExchange", "CoSimulation"):
        seen = simulate(made.path, kind, 0.2, ["b_dot", "c_dot"], 1e-9)
        np.testing.assert_allclose(seen[:, -1], [-1.0, 0.25], rtol=0.0, atol=1e-12, err_msg=kind)
