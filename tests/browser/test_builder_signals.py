"""Signals and blocks in the diagram: a controlled cart-pole by mouse, wires that follow the text, examples with parts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb

from .builder_page import BuilderPage, overlaps
from .builder_plans import Plan, PlannedBody, PlannedJoint, build, errors_of, save_as, simulate_with
from .builder_visits import Visit

CART_POLE = Plan(
    "controlled cart-pole",
    {
        "Cart": PlannedBody((330, 60), "m", "0", {}),
        "Pole": PlannedBody((560, 60), "mp", "mp*l^2/3", {"base": {"y": "-l"}}),
    },
    (
        PlannedJoint("prismatic", "Ground", "Cart", "rail", {"Coordinate": "x"}),
        PlannedJoint("revolute", "Cart", "Pole.base", "hinge", {"Coordinate": "theta"}),
    ),
    {"m": "1.0", "mp": "0.1", "l": "0.5", "G": "9.81", "kp": "60.0"},
    ("push",),
    {"theta": "0.1"},
)
GAINS = {"p": "kp", "i": "5", "d": "12", "filter": "0.02"}


def expected_model() -> sb.Model:
    """Return the mechanism that is built by mouse."""
    cart = sb.Body("Cart", mass="m")
    pole = sb.Body("Pole", mass="mp", inertia=(0, 0, "mp*l^2/3"), frames={"base": sb.Frame((0, "-l", 0))})
    return sb.Model(
        "controlled cart-pole",
        [
            sb.Prismatic("rail", "ground", cart, axis="x", coordinate="x"),
            sb.Revolute("hinge", cart, "Pole.base", coordinate="theta"),
            pole,
            sb.Signal("error", "-theta"),
            sb.PID("servo", "error", GAINS),
            sb.Force("thrust", "Cart", ("servo + push", 0, 0)),
        ],
        gravity=(0, "-G", 0),
        parameters={"m": 1, "mp": 0.1, "l": 0.5, "G": 9.81, "kp": 60},
        inputs=["push"],
        initial={"theta": 0.1},
    )


def wires(builder: BuilderPage) -> set[str]:
    """Return what is drawn, as "from-to"."""
    lines = builder.page.locator(".wires g.wire").all()
    return {str(each.get_attribute("data-testid")).removeprefix("wire-") for each in lines}


def add_control(builder: BuilderPage) -> None:
    """Drop a signal and a PID block, and pull the cart by a force that reads it."""
    builder.page.get_by_role("button", name="Add an element…").click()
    builder.keys("Escape")
    builder.drop("signal", 180, 330)
    builder.rename("node-signal1", "error")
    builder.fill("Value", "-theta")
    builder.drop("pid", 420, 330)
    builder.rename("node-pid1", "servo")
    builder.fill("Input", "error")
    for name, gain in GAINS.items():
        builder.fill(f"Gains {name}", gain)
    builder.join("Ground", "Cart", "force")
    builder.fill("Name", "thrust")
    builder.fill("Vector x", "servo + push")
    builder.wait_checked()


@pytest.mark.exhaustive  # a ring of links is built with the mouse in the fast tier
def test_a_cart_pole_with_a_pid_block_is_built_by_mouse_and_simulated(visit: Visit, tmp_path: Path) -> None:
    builder = visit()
    page = builder.page
    build(builder, CART_POLE)
    page.get_by_test_id("badge-rail").click()
    page.get_by_test_id("properties").get_by_role("radio", name="x", exact=True).first.click()
    add_control(builder)
    assert errors_of(builder) == []
    assert wires(builder) == {"hinge-error", "error-servo", "servo-thrust", "push-thrust"}
    assert overlaps(page, ".body-node, .edge-badge") == []
    simulate_with(builder, 3.0, {"push": "0.2*sin(3*t)"})
    eqs = sb.form_equations(expected_model())
    times, theta = builder.curve("theta")
    motion = sb.simulate(eqs, times[-1], times=np.array(times), inputs={"push": "0.2*sin(3*t)"})
    assert np.max(np.abs(np.array(theta) - motion["theta"])) < 1e-5
    assert np.max(np.abs(theta[-20:])) < 0.02 < theta[0], "the pole stays upright"
    path = save_as(builder, "controlled.toml")
    saved = sb.load_model(path)
    assert [signal.name for signal in saved.signals] == [signal.name for signal in expected_model().signals]
    assert "servo" in builder.state("data.layout.nodes") and "inputs.push" in builder.state(
        "data.layout.nodes"
    )


@pytest.mark.exhaustive
def test_wires_follow_names_and_names_follow_signals(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("dc_motor_arm")
    start = {
        "arm-height",
        "theta_ref-error",
        "shaft-error",
        "error-voltage",
        "voltage-motor",
        "shaft-motor",
        "motor-shaft",
    }
    assert wires(builder) == start
    assert overlaps(page, ".body-node, .edge-badge") == [] and overlaps(page, ".wire-label") == []
    builder.rename("node-error", "fault")
    assert builder.state("data.block[0].input") == "fault" and builder.steps() == 1
    builder.wait_checked()
    assert "fault-voltage" in wires(builder) and errors_of(builder) == []
    page.get_by_test_id("node-voltage").click()
    builder.fill("Input", "theta_ref - theta")
    builder.wait_checked()
    assert {"theta_ref-voltage", "shaft-voltage"} <= wires(builder) and "fault-voltage" not in wires(builder)
    builder.keys("Escape", "Control+z")
    builder.wait_checked()
    page.get_by_test_id("node-fault").click()
    builder.keys("Delete")
    builder.wait_checked()
    [problem] = errors_of(builder)
    assert problem["code"] == "names.unknown" and problem["pointer"] == "/block/0/input"
    assert page.get_by_test_id("node-voltage").locator(".node-flag.error").count() == 1
    builder.keys("Control+z", "Control+z")
    builder.wait_checked()
    assert wires(builder) == start and errors_of(builder) == []


@pytest.mark.exhaustive
def test_signals_by_keys_copied_and_changed_in_kind(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    builder.new()
    builder.insert("signal")
    assert builder.state("data.signal") == [{"name": "signal1", "value": "0"}]
    builder.keys("F4")
    page.get_by_test_id("properties").get_by_role("radio", name="state").click()
    builder.fill("Rate", "-2*signal1")
    builder.fill("Initial", "1")
    assert builder.state("data.signal[0]") == {"name": "signal1", "rate": "-2*signal1", "initial": "1"}
    builder.keys("Escape", "Control+c", "Control+v")
    assert builder.state("data.signal[1].name") == "signal2"
    builder.insert("state space")
    properties = page.get_by_test_id("properties")
    matrix = properties.locator("fieldset", has_text="(n, n), row by row")
    matrix.get_by_role("button", name="Add a row").click()
    matrix.get_by_role("button", name="Add a column").click()
    builder.fill("A 1, 2", "-3")
    assert builder.state("data.block[0].A") == [["0", "-3"]]
    assert overlaps(page, ".body-node") == []


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["four_legs", "quarter_car"])
def test_examples_with_parts_and_tables_are_complete(visit: Visit, name: str) -> None:
    builder = visit()
    page = builder.page
    builder.open_example(name)
    assert errors_of(builder) == []
    assert overlaps(page, ".body-node") == []
    if name == "quarter_car":
        assert wires(builder) == {"road-tyre"}
        return
    assert {"FL-FL_h", "FL_h-FL_N", "FL_N-FL_ground"} <= wires(builder)
    assert page.get_by_test_id("badge-FL_ground").count() == 1
    page.get_by_test_id("node-FL").click(position={"x": 4, "y": 4}, force=True)
    assert builder.state("selection") == ["include/0"]
    assert "leg.toml" in str(page.get_by_test_id("properties").inner_text())
    path = save_as(builder, "legs.toml")
    assert [each.prefix for each in sb.load_model(path).includes] == ["FL", "FR", "RL", "RR"]


@pytest.mark.exhaustive
def test_an_fmu_is_written_from_the_menu(visit: Visit, tmp_path: Path) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("quarter_car")
    page.locator(".brand").click()
    with page.expect_download(timeout=60_000) as arriving:
        page.get_by_role("menuitem", name="Export FMU").click()
    download: Any = arriving.value
    assert download.suggested_filename == "quarter-car.fmu"
    download.save_as(tmp_path / "car.fmu")
    assert (tmp_path / "car.fmu").read_bytes()[:2] == b"PK"
    page.get_by_text("road is an input").wait_for()
