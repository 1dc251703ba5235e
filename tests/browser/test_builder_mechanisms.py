"""Whole ways by mouse: a mechanism from an empty page to its equations, motion, and file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.cli.entry import run as run_command
from symbody.formats.model_files import examples_folder
from symbody.formats.native import model_from_toml

from .builder_page import BuilderPage
from .builder_plans import Plan, PlannedBody, PlannedJoint, build, errors_of, save_as, simulate_with
from .builder_visits import visits

RR_ROBOT = Plan(
    "RR robot",
    {
        "Link1": PlannedBody((330, 60), "m1", "I1", {"base": {"x": "-L3"}, "tip": {"x": "L4"}}),
        "Link2": PlannedBody((560, 200), "m2", "I2", {"base": {"x": "-L5"}, "P": {"x": "L6"}}),
    },
    (
        PlannedJoint(
            "revolute", "Ground", "Link1.base", "shoulder", {"Coordinate": "beta_1", "Applied": "T1"}, ("Add torque",)
        ),
        PlannedJoint(
            "revolute", "Link1.tip", "Link2.base", "elbow", {"Coordinate": "beta_2", "Applied": "T2"}, ("Add torque",)
        ),
    ),
    {**dict.fromkeys(("m1", "m2", "I1", "I2", "L3", "L4", "L5", "L6"), "1.0"), "G": "10.0"},
    ("T1", "T2"),
)  # fmt: skip
FOUR_BAR = Plan(
    "four-bar",
    {
        "Crank": PlannedBody((330, 40), "m1", "I1", {"A": {"x": "-L1/2"}, "B": {"x": "L1/2"}}),
        "Coupler": PlannedBody(
            (560, 60), "m2", "I2", {"B": {"x": "-L2/2"}, "C": {"x": "L2/2"}, "P": {"y": "H"}}
        ),
        "Rocker": PlannedBody((400, 250), "m3", "I3", {"D": {"x": "-L3/2"}, "C": {"x": "L3/2"}}),
    },
    (
        PlannedJoint("revolute", "Ground", "Crank.A", "A", {"Coordinate": "theta"}),
        PlannedJoint("revolute", "Crank.B", "Coupler.B", "B", {"Coordinate": "beta"}),
        PlannedJoint("revolute", "Coupler.C", "Rocker.C", "C"),
        PlannedJoint("revolute", "Ground.D", "Rocker.D", "D", {"Coordinate": "phi"}),
        PlannedJoint("spring", "Ground", "Coupler.P", "pull", {"Stiffness": "k", "Free": "L1"}),
    ),
    {
        "m1": "1.0", "m2": "1.2", "m3": "1.5", "I1": "0.004", "I2": "0.03", "I3": "0.02", "L1": "0.2",
        "L2": "0.5", "L3": "0.4", "L4": "0.5", "H": "0.25", "G": "9.81", "k": "40.0",
    },
    initial={"theta": "60 deg", "beta": "-40 deg", "phi": "100 deg", "theta_dot": "12.0"},
    ground={"D": {"x": "L4"}},
)  # fmt: skip


@pytest.fixture
def builder(chromium: Any, settings: Any) -> Iterator[BuilderPage]:
    with visits(chromium, settings) as visit:
        yield visit()


def rr_robot() -> sb.Model:
    return sb.load_model(examples_folder() / "rr_robot" / "rr_robot.toml")


def four_bar_with_spring() -> sb.Model:
    """Return the example with a spring, and without the torque that the page does not get."""
    text = (examples_folder() / "four_bar" / "four_bar.toml").read_text(encoding="utf-8")
    text = text.replace('torque = { applied = "T" }\n', "").replace('inputs = ["T"]', "inputs = []")
    text = text.replace("[parameters]", "[parameters]\nk = 40.0")
    spring = '[[spring]]\nname = "pull"\nbetween = ["ground", "Coupler.P"]\nstiffness = "k"\nfree = "L1"\n\n'
    return model_from_toml(text.replace("[initial]", f"{spring}[initial]"))


def assert_same_equations(one: sb.Model, other: sb.Model) -> None:
    """Compare accelerations, and constraints where there are some, at configurations without symmetry."""
    sets = [sb.form_equations(model) for model in (one, other)]
    assert sets[0].coordinate_names == sets[1].coordinate_names
    assert sets[0].speed_names == sets[1].speed_names
    outputs = ["udot", "mass_matrix", "forcing", *(["constraints"] if sets[0].multiplier_names else [])]
    random = np.random.default_rng(3)
    q, u = (
        random.uniform(-1, 1, (5, len(names))) for names in (sets[0].coordinate_names, sets[0].speed_names)
    )
    r = random.uniform(-1, 1, (5, len(sets[0].input_names)))
    results = [sb.compile(eqs, outputs, quick=True)(0.0, q, u, r) for eqs in sets]
    for mine, theirs in zip(*results, strict=True):
        assert np.allclose(mine, theirs, rtol=1e-10, atol=1e-10)


def derive(builder: BuilderPage) -> list[str]:
    """Derive the equations and return the names of their tabs."""
    builder.keys("F6")
    builder.wait("s.equations !== null && s.equations.of === s.data || s.notice.length > 0", 120)
    assert builder.page.locator(".equations math").first.is_visible()
    names: list[str] = builder.state("equations.result.names")
    return names


def assert_whole_way(
    builder: BuilderPage, plan: Plan, model: sb.Model, inputs: Mapping[str, str], seconds: float
) -> None:
    build(builder, plan)
    assert errors_of(builder) == []
    assert "Mass matrix" in derive(builder)
    simulate_with(builder, seconds, inputs)
    motion = None
    for name in sb.form_equations(model).coordinate_names:
        times, values = builder.curve(name)
        if motion is None:
            motion = sb.simulate(sb.form_equations(model), times[-1], times=np.array(times), inputs=inputs)
        assert np.max(np.abs(np.array(values) - motion[name])) < 1e-6, name
    path = save_as(builder, f"{plan.title.replace(' ', '_')}.toml")
    assert run_command(["check", path]) == 0
    assert_same_equations(sb.load_model(path), model)


@pytest.mark.exhaustive
def test_an_rr_robot_with_torques(builder: BuilderPage) -> None:
    assert_whole_way(builder, RR_ROBOT, rr_robot(), {"T1": "20*sin(t)", "T2": "-2*beta_2"}, 2.0)


@pytest.mark.exhaustive
def test_a_four_bar_with_a_spring(builder: BuilderPage) -> None:
    assert_whole_way(builder, FOUR_BAR, four_bar_with_spring(), {}, 1.0)
