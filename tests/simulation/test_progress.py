"""Reports of how far a motion is."""

from __future__ import annotations

from typing import Any

import pytest
from rich.progress import Progress as Bar
from rich.progress import TaskID

from symbody.equations.form import form_equations
from symbody.errors import UsageError
from symbody.expr.deadline import watch_stages
from symbody.simulation import progress_bar
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


def test_the_bar_names_the_stages_of_a_first_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[dict[str, Any]] = []

    class Watched(Bar):
        def update(self, task_id: TaskID, **fields: Any) -> None:
            shown.append(fields)
            super().update(task_id, **fields)

    monkeypatch.setattr(progress_bar, "Bar", Watched)
    eqs = form_equations(example("spring_mass_damper").model)
    names: list[str] = []
    with watch_stages(names.append):  # whoever watches goes on doing so
        simulate(eqs, SECOND, progress=True)
    in_the_bar = [fields["description"] for fields in shown if "completed" not in fields]
    assert "motion: computational sequence" in in_the_bar
    assert in_the_bar == [f"motion: {name}" for name in names]
    assert shown[-1] == {"description": "motion", "total": 1.0, "completed": 1.0}


def test_what_cannot_be_told_is_an_error() -> None:
    eqs = example("spring_mass_damper")
    wrong: Any = 3
    for call in (lambda: simulate(eqs, SECOND, progress=wrong), lambda: sweep(eqs, SECOND, progress=wrong)):
        with pytest.raises(
            UsageError,
            match="progress = 3 is neither True, False nor a function\n.*give True for a progress bar",
        ):
            call()
