"""Rigid contacts of the gallery in live pages: their frames, computed by JavaScript, are those of `simulate`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from tests.gallery.test_gallery_checks import module_of
from tests.laws.motion_consumers import FRAMES, columns, run_in


@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node")
@pytest.mark.parametrize(
    ("name", "seconds"),
    [
        pytest.param("backspin", 1.5),
        pytest.param("hopper", 1.0),
        pytest.param("cradle", 2.0, marks=pytest.mark.exhaustive),
        pytest.param("cam_lift_off", 2.0, marks=pytest.mark.exhaustive),
        pytest.param("clearance", 0.3, marks=pytest.mark.exhaustive),
        pytest.param("gripper", 2.0, marks=pytest.mark.exhaustive),
        pytest.param("tippe_top", 1.0, marks=pytest.mark.exhaustive),
    ],
)
def test_frames_of_a_live_page_are_those_of_simulate(name: str, seconds: float, tmp_path: Path) -> None:
    eqs = sb.form_equations(module_of(name).model())
    times = np.linspace(0, seconds, 21)
    run = sb.simulate(eqs, seconds, times=times, rtol=1e-9)
    assert run.success
    page = sb.animate(eqs, tmp_path / "page.html", live=True, rtol=1e-9)
    (tmp_path / "page.mjs").write_text(page.program.module, encoding="utf-8")  # type: ignore[union-attr]
    names = json.dumps(",".join(["t", *eqs.state_names, "work"]))
    script = FRAMES.replace("TIMES", json.dumps(times.tolist())).replace("NAMES", names)
    (tmp_path / "frames.mjs").write_text(script)
    (frames,) = columns(run_in(tmp_path, "node", "frames.mjs"))
    assert frames.t == pytest.approx(times, abs=1e-12)
    for state in eqs.state_names:
        scale = max(1.0, np.abs(run[state]).max())
        assert frames.values[state] == pytest.approx(run[state], abs=1e-6 * scale)
