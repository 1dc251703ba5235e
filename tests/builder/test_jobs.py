"""Jobs: their stages, their results, and that they end at once when they shall."""

from __future__ import annotations

import base64
import io
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import symbody as sb
from symbody.builder import workers
from symbody.builder.jobs import Jobs
from symbody.builder.settings import ServerLimits, pages_folder
from symbody.builder.task_failure import TaskFailure
from symbody.builder.tasks.analyses import equilibrium, inverse, modes, singular_positions
from symbody.builder.tasks.equations import all_tabs, derive_equations, equation_tab
from symbody.builder.tasks.exports import export_model
from symbody.builder.tasks.formula_blocks import FormulaBlock, entry_label, render_block
from symbody.builder.tasks.simulation import curve_list, more_curves, simulate_model
from symbody.builder.tasks.sweeps import sweep_parameter
from symbody.builder.tasks.transmission import ratios, torque
from symbody.errors import EnvironmentFault, SymbodyError
from symbody.expr.deadline import watch_stages
from symbody.expr.graph import Graph, Symbol
from symbody.expr.opcodes import ADD, SIN
from symbody.formats.model_files import examples_folder
from symbody.formats.native import to_data
from symbody.model.output_names import TITLES
from tests.builder.conftest import Builder
from tests.builder.test_checks import example
from tests.tiers import cases

FORMULATIONS = ["newton_euler", "recursive"]


def work(task: Any, data: dict[str, Any], **options: Any) -> tuple[dict[str, Any], list[str]]:
    stages: list[str] = []
    with watch_stages(stages.append):
        result = task(
            {"data": data, "folder": "", "options": options}, lambda stage, *_: stages.append(stage)
        )
    json.dumps(result, allow_nan=False)
    return result, list(dict.fromkeys(stages))


def decoded(text: str, kind: str = "<f4") -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(text), kind).astype(float)


def curve(curves: list[dict[str, Any]], name: str) -> np.ndarray[Any, Any]:
    return decoded(next(each for each in curves if each["name"] == name)["values"])


def test_a_motion_is_that_of_simulate() -> None:
    result, stages = work(simulate_model, example("rr_robot"), t_end=1.0, inputs={"T1": "sin(t)"})
    assert stages[0] == "reading the model" and "drawing" in stages
    eqs = sb.form_equations(sb.load_model(examples_folder() / "rr_robot" / "rr_robot.toml"))
    run = sb.simulate(eqs, 1.0, inputs={"T1": "sin(t)"})
    times = decoded(result["motion"]["times"], "<f8")
    expected = run.at(times)
    for name in eqs.coordinate_names:  # single precision
        np.testing.assert_allclose(
            curve(result["motion"]["curves"], name), expected[name], rtol=1e-6, atol=1e-6
        )
    assert result["run"]["status"] == "SUCCESS" and result["run"]["t_end"] == 1.0
    assert {"name": "beta_1", "unit": "rad", "title": "Positions", "group": ""} in result["curves"]
    titles = [each["title"] for each in result["curves"]]
    assert titles == sorted(titles, key=TITLES.index) and {"Reactions", "Forces and torques"} <= {*titles}
    more = more_curves({"names": ["energy", "T1", "sin(beta_1)"]}, lambda *_: None)["curves"]
    np.testing.assert_allclose(curve(more, "T1"), np.sin(times), atol=1e-6)
    np.testing.assert_allclose(curve(more, "sin(beta_1)"), np.sin(expected["beta_1"]), atol=1e-6)


def test_every_curve_that_is_offered_can_be_computed() -> None:
    work(simulate_model, example("slider_crank"), t_end=0.1)
    eqs = sb.form_equations(sb.load_model(examples_folder() / "slider_crank" / "slider_crank.toml"))
    names = [each["name"] for each in curve_list(eqs)]
    curves = more_curves({"names": names}, lambda *_: None)["curves"]
    assert [each["name"] for each in curves] == names
    assert all(np.isfinite(decoded(each["values"])).all() for each in curves)


def test_options_that_make_no_sense_are_named() -> None:
    for options, where in (({"t_end": -1}, "t_end"), ({"times": "x"}, "times"), ({"speed": 2}, "speed")):
        with pytest.raises(TaskFailure) as caught:
            work(simulate_model, example("rr_robot"), **options)
        assert caught.value.problems[0]["where"] == where
    with pytest.raises(TaskFailure) as failed:
        work(simulate_model, example("rr_robot") | {"joint": [{"name": "j"}]})
    assert failed.value.problems[0]["pointer"] == "/joint/0"


def tabs_of(data: dict[str, Any], **options: str) -> list[dict[str, Any]]:
    return all_tabs({"data": data, "folder": "", "options": options})


@cache
def tabs_of_the_robot() -> list[dict[str, Any]]:
    return tabs_of(example("rr_robot"))


def test_equations_of_the_oscillator_are_those_of_the_book() -> None:
    data = example("spring_mass_damper")
    result, stages = work(derive_equations, data)
    assert "kinematics" in stages and [tab["name"] for tab in result["tabs"]] == ["Equations"]
    tabs = {tab["name"]: tab for tab in tabs_of(data)}
    assert [*tabs] == result["names"]
    (block,) = tabs["Equations"]["blocks"]
    assert block["latex"].count("&=") == 1 and "\\ddot{x}" in block["latex"]
    assert block["sympy"] == "Eq(d*Derivative(x(t), t) + k*x(t) + m*Derivative(x(t), (t, 2)), F(t))"
    assert "<math" in block["mathml"] and "xdot" in block["c"]
    assert tabs["Mass matrix"]["blocks"][0]["sympy"] == "M = Matrix([[m]])"
    assert not tabs["Constraints"]["blocks"] and tabs["Constraints"]["note"]
    (a, b) = tabs["Linearization"]["blocks"]
    assert a["sympy"] == "A = Matrix([[-d/m, -k/m], [1, 0]])" and b["sympy"] == "B = Matrix([[1/m], [0]])"


def sources(data: dict[str, Any]) -> dict[str, list[str]]:
    """The elements of each term of the equations of motion, by the letters of the term."""
    work(derive_equations, data)
    block = equation_tab({"name": "Equations"}, lambda *_: None)["blocks"][0]
    elements = {each["span"]: each["elements"] for each in block["sources"]}
    page = ElementTree.fromstring(block["mathml"])
    marked = {
        each.get("data-span", ""): "".join(each.itertext()) for each in page.iter() if each.get("data-span")
    }
    assert marked.keys() == elements.keys()  # every term can be clicked
    return {"".join(marked[span].split()).lstrip("=+\u2212"): names for span, names in elements.items()}


def test_terms_name_the_elements_they_come_from() -> None:
    by_letters = sources(example("slider_crank"))
    found = {frozenset(names) for names in by_letters.values()}
    assert {
        frozenset({"Crank"}),
        frozenset({"Rod"}),
        frozenset({"Rod", "Piston"}),
        frozenset({"B"}),
        frozenset({"D"}),
    } == found
    assert by_letters["F"] == ["D"]
    assert all(("\u03bb" in letters) == (names == ["B"]) for letters, names in by_letters.items())


def test_a_term_that_two_springs_share_names_both() -> None:
    data = {"name": "two springs", "parameters": {"k": "2", "m": "1"},
            "body": [{"name": "Cart", "mass": "m"}, {"name": "Idle", "mass": "3"}],
            "joint": [{"name": "slide", "type": "prismatic", "between": ["ground", "Cart"], "coordinate": "x",
                       "force": {"stiffness": "k", "damping": "4"}},
                      {"name": "other", "type": "prismatic", "between": ["ground", "Idle"], "coordinate": "y"}],
            "force": [{"name": "push", "on": "Cart", "vector": ["-k*x", "0", "0"]}]}  # fmt: skip
    by_letters = sources(data)
    (shared,) = [names for letters, names in by_letters.items() if "k" in letters]
    assert set(shared) == {"slide", "push"}
    assert (
        ["Cart"] in by_letters.values()
        and ["Idle"] in by_letters.values()
        and ["slide"] in by_letters.values()
    )


@pytest.mark.parametrize("formulation", cases(FORMULATIONS, fast=["recursive"]))
def test_every_formulation_gives_the_same_mass_matrix(formulation: str) -> None:
    result, usual = tabs_of(example("rr_robot"), formulation=formulation), tabs_of_the_robot()
    assert [tab["name"] for tab in result] == [tab["name"] for tab in usual]
    assert result[1]["blocks"][0]["sympy"] == usual[1]["blocks"][0]["sympy"]


def test_a_loop_has_constraints_reactions_and_linear_equations_in_numbers() -> None:
    tabs = {tab["name"]: tab for tab in tabs_of(example("slider_crank"))}
    titles = [block["title"] for block in tabs["Constraints"]["blocks"]]
    assert len(titles) == 3 and all(block["mathml"] for block in tabs["Constraints"]["blocks"])
    assert [block["title"].split(",")[0] for block in tabs["Reactions"]["blocks"]] == [
        f"Joint {x}" for x in "ABCD"
    ]
    linear = sb.linearize(
        sb.form_equations(sb.load_model(examples_folder() / "slider_crank" / "slider_crank.toml"))
    )
    block = tabs["Linearization"]["blocks"][0]
    assert ", ".join(linear.state_names) in block["title"]
    assert f"{linear.A[0, 1]:.5g}" in block["latex"]


def test_what_is_too_long_is_named_part_by_part_or_counted() -> None:
    tabs = tabs_of_the_robot()
    block = next(tab for tab in tabs if tab["name"] == "Linearization")["blocks"][0]
    assert (
        re.search(r"^z_\{?1\}? &=", block["latex"], re.MULTILINE)
        and "<msub><mi>z</mi><mn>1</mn></msub>" in block["mathml"]
    )
    graph = Graph()
    node = graph.symbol(Symbol("x"))
    for k in range(12_000):
        node = graph.node(SIN, graph.node(ADD, node, graph.constant(k + 1)))
    long = render_block(graph, FormulaBlock("f", (node,), (entry_label("f", 1),)), str)
    assert long["mathml"] is None and long["latex"] is None and long["characters"] > 20_000


def test_rest_and_modes_of_a_pendulum() -> None:
    data = {"name": "pendulum", "gravity": ["0", "-9.81", "0"],
            "body": [{"name": "Bob", "mass": "2", "inertia": ["0", "0", "0.1"], "frames": {"P": {"at": ["0", "1", "0"]}}}],
            "joint": [{"name": "pivot", "type": "revolute", "between": ["ground", "Bob.P"], "coordinate": "theta"}],
            "initial": {"theta": "0.3"}}  # fmt: skip
    rest, _ = work(equilibrium, data)
    assert rest["values"]["theta"] == pytest.approx(0.0, abs=1e-9) and rest["verdict"] == "marginal"
    assert any(abs(abs(each["values"]["theta"]) - math.pi) < 1e-6 for each in rest["branches"])
    result, _ = work(modes, data)
    (mode,) = result["modes"]
    assert mode["frequency"] == pytest.approx(math.sqrt(2 * 9.81 / 2.1)) and mode["hertz"] == pytest.approx(
        mode["frequency"] / 2 / math.pi
    )
    places = decoded(mode["motion"]["positions"]).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), 1.0, atol=1e-6)  # it stays on its rod
    assert 0.2 < np.ptp(np.arctan2(places[:, 0], -places[:, 1])) < 1.0  # and can be seen to move
    period = decoded(mode["motion"]["times"], "<f8")[-1]
    assert period == pytest.approx(1.0 / mode["hertz"])


def test_singular_positions_of_a_slider_driven_crank() -> None:
    result, _ = work(singular_positions, example("slider_crank"), independent=["s"], over={"theta": [-4, 4]})
    assert result["places"] and all(place["kind"] == "lock-up" for place in result["places"])
    angles = {round(abs(math.sin(place["values"]["theta"])), 6) for place in result["places"]}
    assert angles == {0.0}  # the dead centres
    assert result["places"][0]["picture"]["scene"]["name"] == "slider-crank"


def test_inputs_for_a_motion_and_a_sweep() -> None:
    result, _ = work(
        inverse, example("rr_robot"), motion={"beta_1": "t", "beta_2": "t^2"}, unknowns=["T1", "T2"]
    )
    assert [each["name"] for each in result["motion"]["curves"]][:2] == ["T1", "T2"]
    swept, _ = work(
        sweep_parameter,
        example("spring_mass_damper"),
        parameter="k",
        values=[1.0, 4.0],
        t_end=1.0,
        samples=11,
    )
    assert [case["value"] for case in swept["cases"]] == [1.0, 4.0]
    assert [case["status"] for case in swept["cases"]] == ["SUCCESS", "SUCCESS"]
    assert decoded(swept["times"], "<f8").size == 11 == decoded(swept["cases"][1]["curves"][0]["values"]).size


def test_exports(tmp_path: Path) -> None:
    data = example("slider_crank")
    texts = {
        kind: export_model({"data": data, "folder": "", "kind": kind}, lambda *_: None)
        for kind in ("c", "latex", "python")
    }
    assert {each["name"] for each in texts.values()} == {
        "slider-crank.c",
        "slider-crank.tex",
        "slider-crank.py",
    }
    assert "\\begin{document}" in texts["latex"]["text"] and texts["latex"]["text"].rstrip().endswith(
        "\\end{document}"
    )
    assert "void" in texts["c"]["text"]


def test_the_whole_life_of_jobs_on_the_server(builder: Builder) -> None:
    data = to_data(sb.load_model(examples_folder() / "spring_mass_damper" / "spring_mass_damper.toml"))
    job = builder.get("job", kind="simulate", data=data, options={"t_end": 1.0})["job"]
    state = builder.finished(job)
    assert state["state"] == "done", state["problems"]
    assert state["stages"][0] == "reading the model" and state["result"]["run"]["success"]
    assert builder.get("outputs", job=job, names=["energy"])["curves"][0]["name"] == "energy"
    assert builder.ask("outputs", job=job, names=["nothing like it"]).status == 422
    failed = builder.finished(builder.get("job", kind="simulate", data={"name": "x", "body": [{}]})["job"])
    assert failed["state"] == "failed" and failed["problems"][0]["pointer"] == "/body/0/name"
    assert builder.ask("job_state", job="nothing").status == 404
    assert builder.ask("job", kind="format the disk", data={}).status == 422
    exported = builder.get("export", data=data, kind="toml")
    assert exported["name"] == "spring-mass-damper.toml" and sb.form_equations is not None


def test_cancel_ends_a_job_within_a_second_and_others_wait_their_turn(builder: Builder) -> None:
    chain = {"name": "chain", "gravity": ["0", "-9.81", "0"], "body": [], "joint": []}
    bodies: list[Any] = chain["body"]  # type: ignore[assignment]
    joints: list[Any] = chain["joint"]  # type: ignore[assignment]
    for k in range(60):
        bodies.append(
            {
                "name": f"B{k}",
                "mass": "1",
                "inertia": ["1", "1", "1"],
                "frames": {"e": {"at": ["1", "0", "0"]}},
            }
        )
        start = "ground" if k == 0 else f"B{k - 1}.e"
        joints.append({"name": f"J{k}", "type": "gimbal", "between": [start, f"B{k}"]})
    jobs = [
        builder.get("job", kind="equations", data=chain, options={"formulation": "lagrange"})["job"]
        for _ in range(2)
    ]
    refused = builder.ask("job", kind="equations", data=chain)
    assert refused.status == 429 and refused.code == "builder.too_many_jobs"
    for job in jobs:
        begun = time.monotonic()
        assert builder.get("cancel", job=job)["state"] == "cancelled"
        assert time.monotonic() - begun < 5.0  # a second on an idle machine
        assert builder.get("job_state", job=job, seen=0)["state"] == "cancelled"
    assert builder.ask("recent").status == 200


def test_velocity_ratios_and_the_torque_of_a_constant_speed() -> None:
    data = example("slider_crank")
    found, _ = work(ratios, data, independent=["theta"])
    L1, L2 = 0.4, 1.0
    beta = lambda theta: -math.asin(L1 / L2 * math.sin(theta))  # noqa: E731
    theta = sb.assemble(
        sb.form_equations(sb.load_model(examples_folder() / "slider_crank/slider_crank.toml"))
    ).q["theta"]
    by_hand = {
        "beta_dot / theta_dot": -L1 * math.cos(theta) / (L2 * math.cos(beta(theta))),
        "s_dot / theta_dot": -L1 * math.sin(theta) + L1 * math.cos(theta) * math.tan(beta(theta)),
    }
    assert found["ratios"] == pytest.approx(by_hand, rel=1e-9)
    driven, _ = work(torque, data, coordinate="theta", rate=5.0)
    # over one turn the energies come back, and nothing else acts: the torque does no work
    assert abs(driven["mean"]) < 1e-3 * driven["largest"] and driven["smallest"] < 0.0 < driven["largest"]
    assert driven["run"]["t_end"] == pytest.approx(2.0 * math.pi / 5.0)
    for wrong in ({"coordinate": "theta", "rate": 0.0}, {"coordinate": "x", "rate": 1.0}):
        with pytest.raises((TaskFailure, SymbodyError)):
            work(torque, data, **wrong)


class BrokenWorker:
    """A worker, and a reserve of it, in which something fails that nobody foresaw."""

    def __init__(self, taken: bool) -> None:
        self.taken, self.killed = taken, 0

    def take(self) -> Any:
        if not self.taken:
            raise OSError("no process is left")
        return self

    def kill(self) -> None:
        self.killed += 1

    def run(self, *_: Any) -> Any:
        raise ZeroDivisionError("inside")


def test_a_job_ends_whatever_happens_and_no_longer_counts() -> None:
    broken = BrokenWorker(taken=True)
    jobs = Jobs(broken, ServerLimits(jobs=1))  # type: ignore[arg-type]
    for turn in range(1, 4):  # one at a time is the limit
        answer: dict[str, Any] = {"state": "running", "seen": -1}
        job = jobs.start("simulate", {})
        while answer["state"] == "running":
            answer = jobs.state(job, answer["seen"])
        (problem,) = answer["problems"]
        assert (answer["state"], problem["code"]) == ("failed", "builder.fault")
        assert "ZeroDivisionError" in problem["what"] and "inside" not in str(problem)
        until = time.monotonic() + 10
        while broken.killed < turn and time.monotonic() < until:
            time.sleep(0.01)
        assert broken.killed == turn


def test_a_job_that_finds_no_process_is_none() -> None:
    jobs = Jobs(BrokenWorker(taken=False), ServerLimits(jobs=1))  # type: ignore[arg-type]
    for _ in range(2):
        with pytest.raises(OSError, match="no process"):
            jobs.start("simulate", {})


def _children(pid: int) -> set[int]:
    listed = subprocess.run(["ps", "-eo", "pid,ppid"], capture_output=True, text=True, check=True).stdout
    pairs = [tuple(map(int, line.split())) for line in listed.splitlines()[1:]]
    return {child for child, parent in pairs if parent == pid}


def _is_there(pid: int) -> bool:
    try:
        return not Path(f"/proc/{pid}/stat").read_text().split(")")[1].startswith(" Z")
    except OSError:
        return False


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are looked up in /proc")
@pytest.mark.parametrize("signal_name", ["SIGINT", "SIGKILL"])
def test_no_process_is_left_behind(tmp_path: Path, signal_name: str) -> None:
    pages = tmp_path / "pages"
    pages.mkdir()
    (pages / "index.html").write_text("<html><head></head></html>")
    script = tmp_path / "start.py"
    script.write_text(
        "from pathlib import Path\n"
        "from symbody.builder.run import listening_socket, serve\n"
        "from symbody.builder.settings import make_settings\n"
        "if __name__ == '__main__':\n"
        "    line = listening_socket(0)\n"
        f"    here = Path({str(tmp_path)!r})\n"
        "    settings = make_settings(line.getsockname()[1], (here,), here / 'state', here / 'pages')\n"
        "    print(settings.address(), flush=True)\n"
        "    serve(settings, line)\n"
    )
    process = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert isinstance(process.stdout, io.TextIOWrapper)
    try:
        address = process.stdout.readline().strip()
        opened = subprocess.run(
            [sys.executable, "-c", _OPEN, address], capture_output=True, text=True, timeout=60
        )
        assert opened.returncode == 0, opened.stderr
        deadline = time.monotonic() + 30
        while not (children := _children(process.pid)) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert children
        process.send_signal(getattr(signal, signal_name))
        process.wait(30)
        while any(map(_is_there, children)) and time.monotonic() < deadline + 30:
            time.sleep(0.05)
        assert not [child for child in children if _is_there(child)]
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
        if process.stderr is not None:
            process.stderr.close()


_OPEN = """
import sys, http.cookiejar, urllib.request
opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(http.cookiejar.CookieJar()))
assert b"symbody-token" in opener.open(sys.argv[1], timeout=30).read()
"""


def test_the_command_names_what_is_missing(tmp_path: Path) -> None:
    environment = os.environ | {"SYMBODY_STATE": str(tmp_path)}
    try:
        pages_folder()
    except EnvironmentFault as fault:
        assert fault.problems[0].code == "builder.no_page" and "npm run build" in fault.problems[0].fix
        done = subprocess.run([sys.executable, "-m", "symbody", "builder", "--no-browser", "--port", "0"],
                              capture_output=True, text=True, timeout=60, env=environment)  # fmt: skip
        assert done.returncode == 5 and "builder.no_page" in done.stderr


def test_of_two_requests_that_overtake_each_other_the_later_one_is_answered() -> None:
    class Recorder:
        """A reserve of one worker that answers at once."""

        is_alive = True

        def take(self) -> Any:
            return self

        def load(self) -> None:
            """Be loaded."""

        def run(self, task: str, payload: dict[str, Any], is_over: Any) -> str:
            return str(payload["data"])

    newest = workers.NewestOnly(Recorder())  # type: ignore[arg-type]
    assert newest.run("check", {"data": "second"}, "page", 1.0, turn=2) == "second"
    with pytest.raises(SymbodyError, match="newer request"):
        newest.run("check", {"data": "first"}, "page", 1.0, turn=1)
    assert newest.run("check", {"data": "another page"}, "other", 1.0, turn=1) == "another page"
    assert newest.run("check", {"data": "third"}, "page", 1.0, turn=3) == "third"
