"""Work beside precision: all engines build the same mechanisms, and what is too slow is left out by name."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from benchmarks import stiff
from benchmarks.engines import stiff_methods
from benchmarks.engines.stiff_methods import METHODS
from benchmarks.precision import Diagram, Point, fastest
from benchmarks.stiff import attempt, summary
from benchmarks.stiff_problems import PROBLEMS, Beam, model_of, places
from benchmarks.timing import Settings

POINTS = (
    Point("GeneralizedAlpha", "GeneralizedAlpha", "rtol 1e-03", 2e-3, 1.0),
    Point("GeneralizedAlpha(step=h)", "GeneralizedAlpha(step=h)", "h 1 ms", 5e-4, 2.0),
    Point("MuJoCo", "MuJoCo RK4", "h 1 ms", 1e-4, 4.0),
    Point("MuJoCo", "MuJoCo implicitfast", "h 1 ms", 9e-4, 3.0),
)


def test_the_fastest_below_a_bound() -> None:
    assert fastest(POINTS, "GeneralizedAlpha", 1e-3) is None
    assert fastest(POINTS, "GeneralizedAlpha", 1e-2) == POINTS[0]
    assert fastest(POINTS, "MuJoCo", 1e-3) == POINTS[3] and fastest(POINTS, "MuJoCo", 2e-4) == POINTS[2]


def test_a_time_stands_beside_its_error() -> None:
    table = summary({"beam": Diagram(POINTS, ())})
    assert all(len(row) == len(table.columns) for row in table.rows)
    assert table.rows[0][table.columns.index("MuJoCo")] == "3.00 s (9e-04)"
    assert not any(table.rows[-1][2:])


@pytest.mark.parametrize("name", PROBLEMS)
def test_every_problem_is_a_mechanism_with_places(name: str) -> None:
    model = model_of(PROBLEMS[name])
    given = places(PROBLEMS[name])(np.zeros(len(model.coordinates)))
    assert given.ndim == 1 and given.size in (1, 2)


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["bushing", "bouncing ball", "sliding box"])
def test_engines_agree_where_steps_are_short(method: str, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over half a second; the ball lands in it."""
    if not METHODS[method].is_installed:
        pytest.skip(f"{METHODS[method].package} is not installed")
    monkeypatch.setattr(stiff_methods, "END", 0.5)
    exact, apart = stiff_methods.exact_places(PROBLEMS[name])
    setting = 1e-8 if METHODS[method].label is stiff_methods.rtol_label else 2e-5
    assert apart < 1e-10
    assert np.abs(METHODS[method].make(PROBLEMS[name])(setting) - exact).max() < 1e-3


@pytest.mark.exhaustive
def test_points_of_a_small_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stiff_methods, "END", 0.1)
    task = attempt("bushing", "Explicit", 2)
    assert not list(task("prepare"))
    (step,) = task("1e-6")
    assert step.figure > 0.0 and step.values is not None


@pytest.mark.exhaustive
def test_what_takes_too_long_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    few = {name: METHODS[name] for name in ("Explicit", "Exudyn")}
    monkeypatch.setattr(stiff, "METHODS", few)
    diagram = stiff.measure("bushing", Settings(limit=1e-4, rounds=1))
    for method, about in few.items():
        reason = "> 0.0001 s" if about.is_installed else "not installed"
        assert any(note.startswith(method) and reason in note for note in diagram.notes)


def test_the_beam_is_as_long_whatever_the_number_of_segments() -> None:
    lengths = {Beam(count).length * count for count in (8, 16, 32)}
    assert lengths == {10.0} and sb.form_equations(model_of(Beam(3))).coordinate_names == ("q0", "q1", "q2")
