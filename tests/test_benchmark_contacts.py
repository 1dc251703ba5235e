"""Bodies that fall on a floor: all engines have the same body, and what is too slow or absent is said."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import symbody as sb
from benchmarks import contacts, many_contacts
from benchmarks.contact_problems import PROBLEMS, height_and_way, model_of
from benchmarks.contacts import attempt, summary
from benchmarks.engines.contact_methods import COMPLIANT, LAWS
from benchmarks.precision import Diagram, Point, fastest
from benchmarks.timing import Settings
from tests.tiers import rows

POINTS = (
    Point(COMPLIANT, "order 8", "1e-06", 5e-4, 2e-3),
    Point(COMPLIANT, "order 5", "1e-06", 8e-3, 1e-3),
    Point("MuJoCo", "Euler", "0.001", 9e-3, 2e-2),
    Point("MuJoCo", "RK4", "0.001", 9e-4, 8e-2),
)


def test_the_fastest_below_a_bound() -> None:
    assert fastest(POINTS, COMPLIANT, 1e-4) is None
    assert fastest(POINTS, COMPLIANT, 1e-2) == POINTS[1] and fastest(POINTS, "MuJoCo", 1e-3) == POINTS[3]


def test_a_time_stands_beside_ours_at_the_same_error() -> None:
    table = summary({"bouncing ball": Diagram(POINTS, ())})
    column = table.columns.index("MuJoCo")
    assert [row[column] for row in table.rows] == ["20.0 ms (20x), 9e-03"] * 2 + ["80.0 ms (40x), 9e-04", ""]
    rows = contacts.table("bouncing ball", Diagram(POINTS, ())).rows
    assert [row[-1].partition(" (")[2] for row in rows] == ["1.0x)", "1.0x)", "20x)", "40x)"]


@pytest.mark.parametrize(
    ("name", "rigid"),
    rows(product(PROBLEMS, [False, True]), fast=lambda name, rigid: rigid == (name == "sliding box")),
)
def test_every_problem_is_a_body_over_its_floor(name: str, rigid: bool) -> None:
    """It falls freely until it strikes, so that the first place is that of a throw."""
    problem = PROBLEMS[name]
    run = sb.simulate(sb.form_equations(model_of(problem, rigid=rigid)), 0.1)
    places = run.q[list(height_and_way(problem)), -1]
    up = 2 if problem.place == "space" else 0
    assert places[up] == pytest.approx(problem.height - 0.5 * 9.81 * 0.1**2)
    along = {"line": [], "plane": [1], "space": [0, 1]}[problem.place]
    np.testing.assert_allclose(places[along], 0.1 * np.array(problem.velocity)[: len(along)], atol=1e-12)


@pytest.mark.parametrize("name", ["Drake", "Drake, SAP", "MuJoCo"])
@pytest.mark.parametrize("problem", PROBLEMS)
def test_the_bodies_of_others_fall_alike(name: str, problem: str) -> None:
    law = LAWS[name]
    if not law.is_installed:
        pytest.skip(f"{law.package} is not installed")
    ours = LAWS[COMPLIANT].make(PROBLEMS[problem])("order 8", 1e-8)
    theirs = law.make(PROBLEMS[problem])(*next((m, s[2]) for m, s in law.methods.items()))
    assert theirs.shape == ours.shape
    np.testing.assert_allclose(theirs[:, :2], ours[:, :2], atol=6e-3)  # still in the air, steps of 1 ms


def test_one_setting_answers_with_time_and_places() -> None:
    task = attempt("sliding box", COMPLIANT, 1)
    (step,) = task("order 5|1e-06")
    assert step.figure > 0.0 and step.values is not None and step.values.shape == (2, 20)


def test_what_is_not_installed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contacts, "LAWS", {"Absent": LAWS["MuJoCo"]._replace(package="no_such_package")})
    assert contacts.measure("sliding box", Settings(rounds=1)).notes == ["Absent: not installed"]


@pytest.mark.exhaustive
def test_balls_fall_into_a_pit(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row for each tolerance, and one for MuJoCo where it is installed."""
    monkeypatch.setattr(many_contacts, "END", 0.01)
    rows = list(many_contacts.rows_of(3))
    laws = [row[1].partition(",")[0] for row in rows]
    assert laws[:2] == ["symbody"] * 2 and laws[2:] in ([], ["MuJoCo"])
    model = many_contacts.pit_model(3)
    assert len([each for each in model.elements if isinstance(each, sb.Contact)]) == 3 + 4 * 3
    assert len(many_contacts.places(8)) == 8
