"""The benchmark of robots at tiny size and without peers, and what it says of results that differ."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import robots
from benchmarks.engines.call_loops.loops import c_compiler
from benchmarks.mechanisms import EXAMPLES
from benchmarks.operations import Robot
from benchmarks.robot_calls import TASKS
from benchmarks.robots import largest
from benchmarks.timing import Settings


@pytest.mark.exhaustive
def test_robots_are_measured_without_peers() -> None:
    arm = Robot("robot_arm/robot_arm.urdf", False, 0, 0)
    absent = Robot("no_such/robot.urdf", False, 0, 0)
    loops, python, batches = robots.tables(
        Settings(rounds=1), {"arm": arm, "absent": absent}, EXAMPLES, peers=False, count=20
    )
    named = "compiled loops are left out: there is no C compiler" in loops.notes
    assert named == (c_compiler() is None)
    tasks = [f"arm, {task}" for task in TASKS]
    assert [row[0] for row in loops.rows] == ([] if named else tasks)
    assert [row[0] for row in python.rows] == tasks
    assert [row[0] for row in batches.rows] == tasks
    assert all(row[1] and row[2] and not any(row[3:]) for row in loops.rows)
    assert "absent is not installed: no_such/robot.urdf" in loops.notes


def test_results_of_a_robot_that_differ_are_told() -> None:
    values = np.array([[1.0, -2.0], [4.0, 0.0]])
    assert largest([values], [values + [[0.0, 0.0], [0.04, 0.0]]]) == pytest.approx(0.04 / 4.04)
    assert robots.ratio_cell([1000.0, 1100.0, 1200.0], [100.0, 100.0, 100.0]) == "11 (10-12)"


def test_robots_without_a_compiler_are_called_from_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robots, "c_compiler", lambda: None)
    arm = Robot("robot_arm/robot_arm.urdf", False, 0, 0)
    loops, python, _ = robots.tables(Settings(rounds=1), {"arm": arm}, EXAMPLES, peers=False, count=20)
    assert not loops.rows and len(python.rows) == len(TASKS)
    assert "compiled loops are left out: there is no C compiler" in loops.notes
