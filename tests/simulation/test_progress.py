"""Who is told how far a motion is, and that the loop is compiled first."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import pytest
from numba.core import event

from symbody.errors import UsageError
from symbody.simulation.native import loop as native_loop
from symbody.simulation.progress import COMPILING, StagedProgress, show_progress
from symbody.simulation.simulate import simulate
from symbody.simulation.sweeps.sweep import sweep
from tests.simulation.loops import example

SECOND = 1.0


class Heard(StagedProgress):
    """Writes down what it is told."""

    def __init__(self) -> None:
        self.stages: list[str] = []
        self.shares: list[float] = []

    def __call__(self, share: float) -> None:
        self.shares.append(share)

    def wait_for(self, stage: str) -> None:
        self.stages.append(stage)


def compiling(*functions: Any) -> None:
    """Tell what numba tells when it compiles functions, each inside the one before."""
    if functions:
        dispatcher = SimpleNamespace(py_func=functions[0])
        with event.trigger_event("numba:compile", data={"dispatcher": dispatcher}):
            compiling(*functions[1:])


def function_of(module: str) -> Any:
    def double(x: float) -> float:
        return 2.0 * x

    double.__module__ = module
    return double


OURS = function_of("symbody.simulation.native.loop")
THEIRS = function_of("elsewhere")


def test_the_compilation_of_the_loop_is_a_stage_from_its_begin_to_its_end() -> None:
    heard = Heard()
    with show_progress(heard, "motion") as listener:
        assert listener is heard
        compiling(THEIRS)
        assert heard.stages == []
        compiling(OURS, OURS, THEIRS)  # what is compiled into it is no stage of its own
        assert heard.stages == [COMPILING, ""]
    compiling(OURS)
    assert heard.stages == [COMPILING, ""]  # after the work nobody listens


def test_numba_tells_of_what_it_compiles_alone() -> None:
    heard, compiled = Heard(), numba.njit(function_of("symbody.simulation.native.loop"))
    with show_progress(heard, "motion"):
        assert compiled(2.0) == 4.0
        assert heard.stages == [COMPILING, ""]
        assert compiled(3.0) == 6.0
    assert heard.stages == [COMPILING, ""]
    dispatcher: Any = native_loop.advance
    assert dispatcher.py_func.__module__ == native_loop.__name__  # what the stage is known by


def test_a_bar_on_demand_and_nothing_else(capsys: pytest.CaptureFixture[str]) -> None:
    eqs = example("spring_mass_damper")
    for silent in (None, False):
        simulate(eqs, SECOND, progress=silent)
        with show_progress(silent, "motion") as listener:
            assert listener is None
            compiling(OURS)
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", "")
    run = simulate(eqs, SECOND, progress=True)
    shown = capsys.readouterr()
    assert shown.out == "" and "motion" in shown.err and "100%" in shown.err
    assert (run.q == simulate(eqs, SECOND).q).all()


def test_the_bar_says_that_the_loop_is_compiled(capsys: pytest.CaptureFixture[str]) -> None:
    with show_progress(True, "motion") as bar:
        assert isinstance(bar, StagedProgress)
        bar.wait_for(COMPILING)
    assert COMPILING in capsys.readouterr().err
    with show_progress(True, "motion") as bar:
        compiling(OURS)
    shown = capsys.readouterr().err
    assert (
        COMPILING not in shown and "motion" in shown
    )  # where nothing moves, the last state alone is printed


def test_what_cannot_be_told_is_an_error() -> None:
    eqs = example("spring_mass_damper")
    wrong: Any = 3
    for call in (lambda: simulate(eqs, SECOND, progress=wrong), lambda: sweep(eqs, SECOND, progress=wrong)):
        with pytest.raises(
            UsageError, match="progress = 3 is neither a switch nor a function\n.*give True for a bar"
        ):
            call()


@pytest.mark.exhaustive
def test_the_first_motion_on_a_computer_says_what_it_waits_for(tmp_path: Path) -> None:
    script = (
        "import symbody as sb\n"
        "from tests.simulation.loops import example\n"
        "eqs = example('spring_mass_damper')\n"
        "sb.simulate(eqs, 1.0, progress=True)\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "FORCE_COLOR": "1"}
    for is_first in (True, False):
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, timeout=300, env=environment
        )
        assert done.returncode == 0 and (COMPILING in done.stderr) is is_first, done.stderr
