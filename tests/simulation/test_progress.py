"""Reports of how far a motion is."""

from __future__ import annotations

from typing import Any

import pytest

from symbody.errors import UsageError
from symbody.simulation.progress import show_progress
from symbody.simulation.simulate import simulate
from symbody.simulation.sweeps.sweep import sweep
from tests.simulation.loops import example

SECOND = 1.0


def test_a_bar_on_demand_and_nothing_else(capsys: pytest.CaptureFixture[str]) -> None:
    eqs = example("spring_mass_damper")
    for silent in (None, False):
        simulate(eqs, SECOND, progress=silent)
        with show_progress(silent, "motion") as listener:
            assert listener is None
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", "")
    run = simulate(eqs, SECOND, progress=True)
    shown = capsys.readouterr()
    assert shown.out == "" and "motion" in shown.err and "100%" in shown.err
    assert (run.q == simulate(eqs, SECOND).q).all()


def test_what_cannot_be_told_is_an_error() -> None:
    eqs = example("spring_mass_damper")
    wrong: Any = 3
    for call in (lambda: simulate(eqs, SECOND, progress=wrong), lambda: sweep(eqs, SECOND, progress=wrong)):
        with pytest.raises(
            UsageError, match="progress = 3 is neither a switch nor a function\n.*give True for a bar"
        ):
            call()
