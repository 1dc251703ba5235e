"""Two or three things that happen to the same coordinate, by whatever computes a motion.

Each mechanism has a derivation of its own (`motion_couplings`). Meetings that are about arguments, stores and times are in
`test_couplings_of_a_motion`.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.laws.motion_consumers import WAYS, Question, outcome
from tests.laws.motion_couplings import COUPLINGS, PARALLELOGRAM, Line, every, parallelogram
from tests.laws.motion_fragments import END, TIMES, save_controller, slide

pytestmark = [
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"),
    pytest.mark.skipif(shutil.which("node") is None, reason="needs Node"),
]


def rows() -> Iterator[Any]:
    """Each coupling by each consumer; in the fast tier each by `simulate`, and each consumer once at most."""
    for k, (name, coupling) in enumerate(COUPLINGS.items()):
        for j, way in enumerate(WAYS):
            if WAYS[way].is_alone and coupling.inputs:
                continue  # functions of Python and FMUs
            marks = [] if way == "simulate" or j + k == len(WAYS) - 1 else [pytest.mark.exhaustive]
            yield pytest.param(way, name, marks=marks, id=f"{way} - {name}")


@pytest.fixture(scope="module")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_controller(tmp_path_factory.mktemp("controller") / "controller.fmu")


@pytest.mark.parametrize(("way", "name"), list(rows()))
def test_things_that_happen_to_one_coordinate(way: str, name: str, controller: Path, tmp_path: Path) -> None:
    result = outcome(Question((COUPLINGS[name],), tmp_path, controller), way)
    assert result == "right"


@pytest.mark.parametrize("name", [name for name in COUPLINGS if "geared" in name])
def test_gears_without_their_row_are_alike(name: str, tmp_path: Path) -> None:
    assert outcome(Question((COUPLINGS[name],), tmp_path, None, substitute=True), "simulate") == "right"


@pytest.mark.parametrize("constraints", [None, sb.Partition()], ids=["default", "Partition"])
def test_dry_pins_and_a_sampled_torque_past_flat_poses(constraints: sb.Partition | None) -> None:
    """A parallelogram passes four change points; what is computed again there begins with the first modes."""
    friction = 4 * 0.15 / PARALLELOGRAM
    line = Line(
        lambda t, x, v: 3 * math.cos(7 * t) / PARALLELOGRAM, every(0.1), 0.7, 9.0, (friction, friction)
    )
    held = sb.Signal("hold", "3*cos(7*t)", sample=0.1)
    eqs = sb.form_equations(
        sb.Model("parallelogram", parallelogram(held, torque="hold", friction=sb.Friction(force=0.15)),
                 initial={"x": 0.7, "xb": -0.7, "xd": 0.7, "x_dot": 9.0})
    )  # fmt: skip
    run = sb.simulate(eqs, END, times=TIMES, rtol=1e-9, constraints=constraints)
    assert run.success and [change.t for change in run.modes] == [0.0] * 4
    np.testing.assert_allclose(run["x"], line.values("x")(TIMES)["x"], atol=50e-9 * 9.0)


def test_a_stop_at_a_sample_ends_a_stepper() -> None:
    """w = 0.3 t passes 0.3 t_k at the sample t_k, which is the end of a step as well: in it or in the next."""
    counter = sb.Signal("count", "count + 1", sample=0.1)
    pushed = sb.Drive(applied="0*count")
    eqs = sb.form_equations(sb.Model("watched", [*slide("watched", "w", force=pushed), counter]))
    for k in range(1, 10):
        stop = sb.Event(f"w - {0.3 * (0.1 * k)}", 1, "stop")
        stepper = sb.Stepper(eqs, 0.05, initial={"w": 0, "w_dot": 0.3}, events=stop)
        while stepper.t < 1 and stepper.status is not sb.Status.STOPPED:
            stepper.step()
        assert stepper.t == pytest.approx(0.1 * k, abs=1e-9)
