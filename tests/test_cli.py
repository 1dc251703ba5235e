"""The command line: what it prints, what it writes, and its exit codes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.cli import run
from symbody.equations.form import form_equations
from symbody.equations.outputs.equation_lines import equation_lines
from symbody.formats.model_files import examples_folder
from symbody.formats.native import load_model
from symbody.simulation.native import run as native_run
from tests.simulation.interruption import ctrl_c

SHAFT = """name = "shaft"
[[body]]
name = "Shaft"
mass = 1
inertia = [1, 1, 1]
frames.far = { at = [0, 0, 1] }
[ground.frames]
far = { at = [0, 0, 1] }  # post
[[joint]]
name = "near"
type = "revolute"
between = ["ground", "Shaft"]
coordinate = "a"
tree = false
[[joint]]
name = "far"
type = "revolute"
between = ["ground.far", "Shaft.far"]
tree = false
"""


@pytest.fixture
def model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    assert run(["examples", "spring_mass_damper", "--copy", str(tmp_path)]) == 0
    capsys.readouterr()
    return tmp_path / "spring_mass_damper.toml"


def test_simulate_prints_the_equation_and_draws(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", str(model)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "m x'' + d x' + k x = F"
    assert any("input F has no value and is 0" in line for line in lines)
    picture = model.with_suffix(".png")
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10_000
    assert run(["simulate", str(model)]) == 0  # again: its own picture is made anew


def test_simulate_as_json_and_csv(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = model.with_suffix(".csv")
    arguments = [
        "simulate",
        str(model),
        "--json",
        "--end",
        "1",
        "-p",
        "d=2",
        "-i",
        "F=0",
        "--csv",
        str(table),
    ]
    assert run(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["success"] is True and result["t"][-1] == 1.0
    assert result["states"]["x"][-1] == pytest.approx(2 * np.exp(-1), abs=1e-7)  # critical damping
    rows = table.read_text(encoding="utf-8").splitlines()
    assert rows[0].split(",")[0] == "t" and len(rows) == len(result["t"]) + 1


def test_simulate_sets_whatever_has_a_name(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Parameter, input, coordinate and rate; the closed form of critical damping under a constant force."""
    arguments = ["simulate", str(model), "--json", "--end", "2", "--samples", "5"]
    for setting in ("d=2", "F=3", "x=1", "x_dot=-1"):
        arguments += ["--set", setting]
    assert run(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    t = np.array(result["t"])
    assert t.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    # x = 3 + (a + b t) exp(-t) with x(0) = 1, x'(0) = -1; tolerances of 1e-8 over 2 s.
    assert result["states"]["x"] == pytest.approx(3 + (-2 - 3 * t) * np.exp(-t), abs=1e-7)


def test_simulate_closed_loops(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Values of [initial] are guesses, those of --set hold; the loop stays closed."""
    assert run(["examples", "slider_crank", "--copy", str(tmp_path)]) == 0
    path, table = tmp_path / "slider_crank.toml", tmp_path / "motion.csv"
    capsys.readouterr()
    arguments = ["simulate", str(path), "-t", "0.5", "--set", "theta=0.7", "--set", "theta_dot=5"]
    arguments += ["--show", "s", "--show", "reaction B Fx", "--csv", str(table), "--tree", "joints"]
    assert run([*arguments, "--samples", "6"]) == 0
    told = capsys.readouterr().out
    assert re.search(r"constraints: 2, largest error \d\.\de-1\d", told)
    rows = np.genfromtxt(table, delimiter=",", names=True)
    assert rows["t"].tolist() == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5], abs=1e-15)
    assert rows["theta"][0] == 0.7 and rows["theta_dot"][0] == pytest.approx(5.0, abs=1e-14)
    lean = np.arcsin(0.4 * np.sin(rows["theta"]))
    assert rows["beta"] == pytest.approx(-lean, abs=1e-9)
    assert rows["s"] == pytest.approx(0.4 * np.cos(rows["theta"]) + np.cos(lean), abs=1e-9)
    assert "reaction_B_Fx" in rows.dtype.names
    whole = ["simulate", str(path), "-t", "0.1", "-s", "reaction B", "--csv", str(table), "--force"]
    assert run([*whole, "-o", str(tmp_path / "a.png")]) == 0
    assert {"reaction_B_Fx", "reaction_B_Mz"} <= set(
        np.genfromtxt(table, delimiter=",", names=True).dtype.names
    )
    assert path.with_suffix(".png").stat().st_size > 10_000


def test_code_in_python(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = model.with_suffix(".py")
    assert run(["code", str(model), "-l", "python", "-o", "udot", "--out", str(target), "--force"]) == 0
    script = f"{target.read_text(encoding='ascii')}print(f(0.0, [2.0], [3.0], [1.0], [1.0, 0.5, 4.0]))"
    done = subprocess.run([sys.executable, "-I", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "[-8.5]\n"  # F - d v - k x


def test_equations_as_text_and_latex(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["equations", str(model)]) == 0
    assert capsys.readouterr().out == "m x'' + d x' + k x = F\n"
    assert run(["equations", str(model), "--latex"]) == 0
    assert r"\ddot{x}" in capsys.readouterr().out


def example(name: str) -> str:
    return str(examples_folder() / name / f"{name}.toml")


def test_rates_and_constraints_are_printed_where_there_are_any(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["equations", example("spinning_top_omega")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if not line.startswith(" ")] == ["rates:", "motion:"]
    assert lines[1] == "  zeta' = (omega_x sin(xi) + omega_y cos(xi))/sin(eta)"
    assert lines[-1] == "  C omega_z' = 0"
    assert run(["equations", example("slider_crank")]) == 0
    lines = capsys.readouterr().out.splitlines()
    titles = [k for k, line in enumerate(lines) if not line.startswith(" ")]
    assert [lines[k] for k in titles] == ["motion:", "constraints:"]
    assert lines[titles[1] - 1].endswith(" = F") and lines[-1] == "  L2 sin(theta - beta) - s sin(theta) = 0"
    assert max(map(len, lines)) <= 100


def test_latex_has_titles_as_comments(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["equations", example("slider_crank"), "--latex"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "% motion" and lines[4] == "% constraints" and len(lines) == 7
    assert r"\ddot{\theta}" in lines[1]


def test_long_equations_are_written_with_definitions() -> None:
    """Each shared part is written once and defined by earlier ones; the titles stay."""
    eqs = form_equations(load_model(example("spatial_four_bar")))
    lines = equation_lines(eqs.textbook, limit=50)
    assert [line for line in lines if not line.startswith(" ")] == ["motion:", "constraints:", "where:"]
    defined = lines[lines.index("where:") + 1 :]
    assert len(defined) > 10
    for k, line in enumerate(defined):
        name, formula = line.split(" = ")
        assert name == f"  z{k + 1}"
        assert all(int(number) <= k for number in re.findall(r"\bz(\d+)\b", formula))
    assert sum(map(len, lines)) < sum(map(len, equation_lines(eqs.textbook)))


def test_tree_may_be_chosen(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = model.read_text(encoding="utf-8").replace('mass = "m"', 'mass = "m"\ninertia = [1, 1, 1]')
    model.write_text(text, encoding="utf-8")
    assert run(["equations", str(model), "--tree", "absolute"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines.index("motion:") - lines.index("rates:") == 8  # position, quaternion; x is measured
    assert run(["check", str(model), "--tree", "absolute"]) == 0
    text = capsys.readouterr().out
    assert "rotation and translation tree: Mass\n" in text
    assert "cut joints: slider\n" in text and "degrees of freedom: 1\n" in text
    assert run(["equations", str(model), "--tree", "branches"]) == 2
    assert "absolute" in capsys.readouterr().err


def test_gears_may_be_substituted(capsys: pytest.CaptureFixture[str]) -> None:
    path = str(Path(__file__).parents[1] / "examples" / "gallery" / "drives" / "planetary_gear.toml")
    printed = []
    for flags in ([], ["--substitute"]):
        assert run(["equations", path, *flags]) == 0
        printed.append(capsys.readouterr().out)
    assert "lambda" in printed[0] and "lambda" not in printed[1]


def test_check_tells_what_the_model_is(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", str(model)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "model: spring-mass-damper",
        "gravity: 0, 0, 0",
        "bodies: Mass",
        "joints:",
        "  slider  prismatic  ground -> Mass  x",
        "inputs: F",
        "parameters: m = 1.0, d = 0.5, k = 1.0",
        "rotation and translation tree: slider",
        "cut joints: none",
        "coordinates: x",
        "speeds: x_dot",
        "constraints: none",
        "degrees of freedom: 1",
        "note: gravity is zero",
    ]


def test_check_names_a_body_whose_inertia_may_be_forgotten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def rod_with(inertia: float) -> sb.Body:
        return sb.Body("Rod", mass=1, inertia=(0, 0, inertia), frames={"top": sb.Frame(at=(0, 0.5, 0))})

    pivot = sb.Revolute("pivot", "ground", "Rod.top", axis="z")
    for inertia, is_named in ((0, True), (0.1, False)):
        path = tmp_path / f"{is_named}.toml"
        sb.save_model(sb.Model("pendulum", [rod_with(inertia), pivot]), path)
        assert run(["check", str(path)]) == 0
        assert ("rotate without inertia, as point masses: Rod" in capsys.readouterr().out) is is_named


def test_check_tells_of_loops(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", example("slider_crank")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "  B  revolute   Crank.B -> Rod.B   (B)" in lines
    for fact in (
        "rotation and translation tree: A, C, D",
        "cut joints: B",
        "constraints: 2 (lambda_B_1, lambda_B_2)",
        "degrees of freedom: 1",
    ):
        assert fact in lines
    assert [line for line in lines if line.startswith("note: joint B is cut")]


def test_check_tells_parameters_without_value(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, verdict in (("rr_robot", "2"), ("slider_crank", "not counted, no value is given for")):
        text = Path(example(name)).read_text(encoding="utf-8")
        path = tmp_path / f"{name}.toml"
        path.write_text(
            re.sub(r"(?m)^m1 = .*$", 'm1 = ""', re.sub(r"(?m)^(L1) = .*$", r'\1 = ""', text)), "utf-8"
        )
        assert run(["check", str(path)]) == 0
        told = capsys.readouterr().out
        assert "parameters without value: m1" in told and f"degrees of freedom: {verdict}" in told


def test_check_tells_all_problems_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = Path(example("rr_robot")).read_text(encoding="utf-8")
    text = (
        text.replace('mass = "m1"', 'mass = "mm1"')
        .replace('"Link2.base"', '"Link2.bse"')
        .replace('T2"]', 'G"]')
    )
    path = tmp_path / "broken.toml"
    path.write_text(text, encoding="utf-8")
    assert run(["check", str(path)]) == 3
    shown = capsys.readouterr()
    assert not shown.out and "Traceback" not in shown.err
    for word in ("mm1", "bse", "did you mean"):
        assert word in shown.err
    assert shown.err.count("broken.toml:") >= 3


def test_code_goes_to_a_file_that_is_not_overwritten(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = model.with_suffix(".c")
    assert run(["code", str(model), "--out", str(target)]) == 0
    before = target.read_text(encoding="utf-8")
    assert run(["code", str(model), "--out", str(target)]) == 2
    assert "cli.file_exists" in capsys.readouterr().err
    assert run(["code", str(model), "--out", str(target), "--force"]) == 0
    assert target.read_text(encoding="utf-8") == before


def test_a_picture_beside_the_model_is_replaced_only_where_it_is_ours(
    model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The README's command runs twice; a user's picture or page of the same name stays."""
    command = ["simulate", str(model), "-t", "0.1", "--animate"]
    assert run(command) == 0 and run(command) == 0
    capsys.readouterr()
    for suffix, content in ((".png", b"a photograph"), (".html", b"<!doctype html><p>notes on symbody</p>")):
        own = model.with_suffix(suffix)
        written = own.read_bytes()
        own.write_bytes(content)
        assert run(command) == 2
        message = capsys.readouterr().err
        assert "cli.file_exists" in message and "--force" in message and "--out" in message
        assert own.read_bytes() == content
        if suffix == ".html":
            assert run(["animate", str(model), "-t", "0.1"]) == 2 and own.read_bytes() == content
            capsys.readouterr()
        assert run([*command, "--force"]) == 0 and own.read_bytes()[:8] == written[:8]


@pytest.mark.parametrize(
    ("arguments", "code", "word"),
    [
        (["simulate", "MISSING.toml"], 3, "MISSING.toml"),
        (["frobnicate"], 2, "frobnicate"),
        (["simulate", "MODEL", "--end", "soon"], 2, "--end"),
        (["simulate", "MODEL", "-p", "k"], 2, "cli.assignment"),
        (["simulate", "MODEL", "-p", "kk=3"], 2, "did you mean 'k'"),
        (["simulate", "MODEL", "-p", "x_dott=3"], 2, "did you mean 'x_dot'"),
        (["simulate", "MODEL", "--samples", "1"], 2, "cli.samples"),
        (["simulate", "MODEL", "-i", "F=sin(omega*t)"], 3, "omega"),
        (["simulate", "MODEL", "--initial", "y=3"], 4, "'y'"),
        (["code", "MODEL", "-l", "cobol"], 3, "cobol"),
        (["examples", "spring"], 2, "spring_mass_damper"),
    ],
)
def test_faults_end_in_a_message_and_an_exit_code(
    model: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], code: int, word: str
) -> None:
    given = [str(model) if argument == "MODEL" else argument for argument in arguments]
    assert run(given) == code
    shown = capsys.readouterr()
    assert word in shown.err and "Traceback" not in shown.err


def test_a_typing_error_in_the_file_is_told_with_line_and_cure(
    model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = model.read_text(encoding="utf-8").replace('stiffness = "k"', 'stifness = "k"')
    model.write_text(text, encoding="utf-8")
    assert run(["check", str(model)]) == 3
    shown = capsys.readouterr().err
    line = next(k for k, row in enumerate(text.splitlines(), 1) if "stifness" in row)
    assert f"spring_mass_damper.toml:{line}" in shown
    assert "stiffness" in shown


def test_help_and_version_of_the_installed_command() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from symbody.cli import main; main()", "--help"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0
    for command in ("simulate", "equations", "check", "code", "examples"):
        assert command in done.stdout


def test_check_names_what_is_redundant(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An equation that repeats what the loop says where it is closed, and only there."""
    assert run(["examples", "slider_crank", "--copy", str(tmp_path)]) == 0
    path = tmp_path / "slider_crank.toml"
    assert run(["check", str(path)]) == 0
    assert "redundant constraints:" not in capsys.readouterr().out
    again = '\n[[constraint]]\nname = "again"\ntype = "equation"\nequations = "EQUATION"\n'
    equation = "(s - L1*cos(theta))^2 + (L1*sin(theta))^2 - L2^2"
    path.write_text(path.read_text(encoding="utf-8") + again.replace("EQUATION", equation), encoding="utf-8")
    assert run(["check", str(path)]) == 0
    text = capsys.readouterr().out
    assert "redundant constraints: 1 (lambda_again_1)\n" in text
    assert "degrees of freedom: 1\n" in text and "would be 0 degrees of freedom" in text


def test_simulate_names_the_command_where_equations_are_long(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["examples", "bicycle", "--copy", str(tmp_path)]) == 0
    capsys.readouterr()
    assert run(["simulate", str(tmp_path / "bicycle.toml"), "--end", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) < 20 and lines[0].startswith(
        "9 coordinates, 9 speeds, 6 constraints; `symbody equations "
    )
    # The speeds of the file are those it starts with, although six of nine follow from the others.
    assert any("energy drift" in line and "drift 0.0e+00" not in line for line in lines)


def test_linearize_and_equilibrium(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """x'' + d/m x' + k/m x = F/m at rest under F: x = F/k."""
    assert run(["linearize", str(model), "-p", "d=2", "-o", "x"]) == 0
    out = capsys.readouterr().out
    assert "states: x_dot, x" in out and "verdict: stable" in out
    assert run(["linearize", str(model), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["states"] == ["x_dot", "x"] and told["A"][1] == [1.0, 0.0] and told["stationary"] is False
    assert run(["equilibrium", str(model), "-i", "F=3", "-p", "k=4"]) == 0
    assert capsys.readouterr().out.startswith("x = 0.75: ")
    assert run(["equilibrium", str(model), "-i", "F=3", "-p", "k=4", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["equilibria"][0]["q"]["x"] == pytest.approx(0.75)
    assert run(["equilibrium", str(model), "-i", "F=3", "-p", "k=0"]) == 4
    assert "equilibrium.none" in capsys.readouterr().err


def test_a_bar_names_the_stages_and_stays_out_of_the_output(
    model: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = ["simulate", str(model), "--set", "d=0", "--end", "4000"]
    assert run(arguments) == 0
    plain = capsys.readouterr()
    assert plain.err == ""  # no screen, no bar
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert run(arguments) == 0
    shown = capsys.readouterr()
    places = [
        shown.err.index(word) for word in ("forming the equations", "compiling", "integrating", "drawing")
    ]
    assert places == sorted(places) and "%" in shown.err[places[2] : places[3]]
    untimed = [re.sub(r"[\d.]+ ms", "", text) for text in (plain.out, shown.out)]
    assert untimed[0] == untimed[1]


@pytest.mark.parametrize("command", [[], ["simulate"], ["equations"], ["examples"], ["code"]])
def test_flags_have_no_word_for_a_value_in_the_help(
    command: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    assert run([*command, "--help"]) == 0
    told = capsys.readouterr().out
    lines = [line for line in told.splitlines() if re.search("--(help|version|json|force|latex) ", line)]
    assert lines and not any(re.search("bool", line, re.IGNORECASE) for line in lines), told
    assert re.search("--help +Show this message and exit", told)


def test_ctrl_c_saves_what_was_computed(
    model: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    table, usual = model.with_suffix(".csv"), sb.simulate
    with ctrl_c() as press:
        told = {"progress": press, "max_steps": 10**9}
        monkeypatch.setattr(sb, "simulate", lambda *args, **words: usual(*args, **words | told))
        asked = ["--set", "d=0", "--end", "1e8", "--samples", "100001", "--csv", str(table)]
        code = run(["simulate", str(model), *asked])
    assert code == 130
    out = capsys.readouterr().out
    assert "known up to t = " in out and sb.Status.INTERRUPTED.value in out
    assert model.with_suffix(".png").stat().st_size > 10_000
    rows = table.read_text(encoding="utf-8").splitlines()
    assert rows[0] == "t,x,x_dot" and rows[1] == "0.0,1.0,0.0" and len(rows) < 100_000


def test_more_samples_than_memory_are_refused_before_the_motion(
    model: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native_run, "memory_limit", lambda: 24_000)
    assert run(["simulate", str(model), "--samples", "1000000000000"]) == 4  # 8 TB as an array of times alone
    shown = capsys.readouterr().err
    assert "simulation.memory" in shown and "store at most 750 times" in shown


def test_check_names_the_joint_that_stays_open(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The message of a conflict differs from that of redundancy: it names what does not close, and how far."""
    path = tmp_path / "shaft.toml"
    path.write_text(SHAFT, encoding="utf-8")
    assert run(["check", str(path)]) == 0
    told = capsys.readouterr().out
    assert "redundant constraints: 5" in told and "degrees of freedom: 1\n" in told
    path.write_text(SHAFT.replace("[0, 0, 1] }  # post", "[0, 0, 1.1] }"), encoding="utf-8")
    assert run(["check", str(path)]) == 0
    told = capsys.readouterr().out
    # The least sum of squares halves the gap of 0.1 m.
    assert re.search(
        r"degrees of freedom: not counted, .*; joint near cannot be closed: a gap of 0\.05 m and 0 deg", told
    )
    assert "redundant" not in told


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.strip() == sb.__version__


def test_a_folder_that_is_missing_is_told_with_a_cure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = examples_folder() / "spring_mass_damper" / "spring_mass_damper.toml"
    assert run(["code", str(model), "--out", str(tmp_path / "none" / "f.c")]) == 5
    assert "fix: give a path in an existing folder" in capsys.readouterr().err


def test_small_numbers_bear_no_needless_digits_or_signs(capsys: pytest.CaptureFixture[str]) -> None:
    folder = examples_folder()
    top, crank = (str(folder / name / f"{name}.toml") for name in ("spinning_top", "slider_crank"))
    assert run(["linearize", top, "--cyclic", "zeta", "--at", "eta=0.5"]) == 0
    assert run(["equilibrium", crank, "--unknown", "F", "--fix", "theta=0.5"]) == 0
    out = capsys.readouterr().out
    assert "damping ratio 0" in out and "ratio -0" not in out
    assert re.search(r"inputs: F = -16\.533$", out, re.MULTILINE)  # six digits, as of all other numbers


PAGE = '<title>symbody</title><script type="application/json" id="symbody-data">null</script>'


@pytest.fixture
def small_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symbody.visual.viewer.page.built_file", lambda name: PAGE)


@pytest.mark.usefixtures("small_page")
def test_animate_writes_a_page(model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        run(["animate", str(model), "--time", "2", "--set", "k=9", "--trace", "Mass", "--vectors", "all"])
        == 0
    )
    lines = capsys.readouterr().out.splitlines()
    page = model.with_suffix(".html")
    assert lines[-1] == f"page: {page}" and any("t = 0 to 2 s" in line for line in lines)
    text = page.read_text(encoding="utf-8")
    assert "<title>spring-mass-damper</title>" in text and '"traces":["Mass.CoM"]' in text
    assert run(["animate", str(model), "--end", "1"]) == 0  # again: its own page is made anew
    other = tmp_path / "other.html"
    assert run(["animate", str(model), "--end", "1", "-o", str(other)]) == 0
    assert run(["animate", str(model), "--end", "1", "-o", str(other)]) == 2
    assert "--force" in capsys.readouterr().err
    assert run(["animate", str(model), "--end", "1", "-o", str(other), "--force"]) == 0


@pytest.mark.usefixtures("small_page")
def test_simulate_writes_a_page_beside_the_picture(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", str(model), "--end", "1", "--animate"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"page: {model.with_suffix('.html')}"
    picture = model.with_name("other.png")
    arguments = ["simulate", str(model), "--end", "1", "--animate", "--out", str(picture)]
    assert run(arguments) == 0 and picture.with_suffix(".html").is_file()
    picture.unlink()
    assert run(arguments) == 2  # the page would be overwritten
    assert "other.html" in capsys.readouterr().err


@pytest.mark.usefixtures("small_page")
@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["MISSING.toml"], 3, "MISSING.toml"),
        (["MODEL", "-o", "film.mp4"], 2, "animation.suffix"),
        (["MODEL", "-o", "no/folder/page.html"], 5, "create the directory first"),
        (["MODEL", "--trace", "Mas"], 2, "did you mean 'Mass'"),
        (["MODEL", "--vectors", "slidr"], 2, "did you mean 'slider'"),
        (["MODEL", "--show", "y"], 3, "'y'"),
        (["MODEL", "--open"], 5, "manually"),
    ],
)
def test_animate_refuses(
    arguments: list[str], code: int, text: str, model: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    monkeypatch.chdir(model.parent)
    assert (
        run(["animate", *(str(model) if item == "MODEL" else item for item in arguments), "--end", "1"])
        == code
    )
    assert text in capsys.readouterr().err


def test_without_pages_animate_ends_with_the_cure(
    model: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("symbody.visual.viewer.built_files._FOLDER", "no pages")
    assert run(["animate", str(model), "--end", "1"]) == 5
    assert "Node 20" in capsys.readouterr().err
