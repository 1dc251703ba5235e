"""Public errors are raised short: the caller's line, the public border, the message."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import symbody as sb
from symbody.errors import nearest


def crank() -> sb.Model:
    arm = sb.Body("Crank", mass=1, inertia=(0, 0, 0.1), frames={"tip": sb.Frame(at=(1, 0, 0))})
    pin = sb.Revolute("O", "ground", "Crank", coordinate="crank")
    return sb.Model("crank", [arm, pin], gravity=(0, -9.81, 0))


@pytest.fixture(scope="module")
def run() -> sb.Trajectory:
    return sb.simulate(sb.form_equations(crank()), 0.02)


CALLS: dict[str, Callable[[Any], object]] = {
    "output": lambda run: run["rockr"],
    "plot": lambda run: sb.plot(run, "rockr"),
    "initial": lambda run: sb.simulate(sb.form_equations(crank()), 1, initial={"crank": "60\u00b0"}),
    "file": lambda run: sb.load_model("nothing.toml"),
    "argument": lambda run: sb.Body("B", mas=1),  # type: ignore[call-arg]
    "joint": lambda run: (
        run.eqs.reaction("x") if hasattr(run, "eqs") else sb.form_equations(crank()).reaction("x")
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_tracebacks_are_short(name: str, run: sb.Trajectory) -> None:
    with pytest.raises(sb.SymbodyError) as caught:
        CALLS[name](run)
    message = str(caught.value).count("\n") + 1
    lines = "".join(traceback.format_exception(caught.value)).splitlines()
    # Three lines a frame: this test's, that of the call, and at most two of the border.
    assert len(lines) <= message + 1 + 3 * 5, "\n".join(lines)
    assert "direct cause" not in "\n".join(lines) and "another exception" not in "\n".join(lines)


def test_a_fault_of_the_callers_own_function_stays_the_cause() -> None:
    def law(t: float, q: object, u: object) -> float:
        raise ZeroDivisionError("mine")

    model = sb.Model(
        "m",
        [
            sb.Body("B", mass=1),
            sb.Prismatic("P", "ground", "B", axis="x", coordinate="x", force=sb.Drive(applied="F")),
        ],
        inputs=["F"],
    )
    with pytest.raises(Exception) as caught:  # noqa: B017, PT011
        sb.simulate(sb.form_equations(model), 1, inputs={"F": law})
    assert "mine" in "".join(traceback.format_exception(caught.value))


def test_cures_that_work(run: sb.Trajectory) -> None:
    with pytest.raises(sb.SymbodyError) as caught:
        _ = run["sqrt([reaction O Fx]^2 + [reaction O Fy]^2)"]
    cure = caught.value.problems[0].fix.partition(": ")[2]
    assert run[cure].shape == run.t.shape
    with pytest.raises(sb.SymbodyError, match="did you mean 'crank'"):
        _ = run["CRANK"]
    with pytest.raises(AttributeError, match=r"run\['crank'\]"):
        _ = run.crank
    assert (
        not hasattr(run, "nothing")
        and nearest("Crank", ["frame r Crank", "crank"]) == "did you mean 'crank'?"
    )
    with pytest.raises(sb.SymbodyError, match="known outputs and symbols"):
        _ = run["qqqqqqq"]


def test_what_stays_open_is_named_by_its_kind() -> None:
    ends = [sb.Body(name, mass=1, inertia=(0, 0, 1), frames={"end": sb.Frame(at=(1, 0, 0))}) for name in "AB"]
    pins = [sb.Revolute("a", "ground", "A", coordinate="p"), sb.Revolute("b", "ground", "B", coordinate="q")]
    model = sb.Model("open", [*ends, *pins, sb.Distance("rod", "A.end", "B.end", value=5)])
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(sb.form_equations(model))
    assert "rod cannot be closed: a gap of" in str(caught.value) and "joint rod" not in str(caught.value)


def test_animate_without_a_display_prints_the_path(
    run: sb.Trajectory, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("webbrowser.open", lambda _: False)
    sb.animate(run)
    said = capsys.readouterr().out
    assert said.startswith("no browser opened; the page is ")
    path = Path(said.strip().rpartition(" ")[2])
    assert path.read_text("utf-8").startswith("<!doctype html>")
    path.unlink()
