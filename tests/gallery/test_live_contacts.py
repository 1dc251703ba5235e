"""Rigid contacts of the gallery in live pages: motions and arrows, computed by JavaScript, are those of `simulate`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from tests.gallery.test_gallery_checks import module_of
from tests.laws.motion_consumers import run_in

FRAMES = """
import { makeSimulation } from "./page.mjs";
const s = makeSimulation();
const frames = TIMES.map((t) => {
  s.advanceTo(t);
  const pose = s.computePose();
  return [s.time, Array.from(s.state), Array.from(pose.axes.subarray(9 * BODIES))];
});
console.log(JSON.stringify(frames));
"""


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
    script = FRAMES.replace("TIMES", json.dumps(times.tolist())).replace("BODIES", str(len(eqs.model.bodies)))
    (tmp_path / "frames.mjs").write_text(script)
    frames = json.loads(run_in(tmp_path, "node", "frames.mjs"))
    assert [t for t, *_ in frames] == pytest.approx(times, abs=1e-12)
    states = np.array([state for _, state, _ in frames])
    for state, found in zip(eqs.state_names, states.T, strict=False):  # the work is one more
        assert found == pytest.approx(run[state], abs=1e-6 * max(1.0, np.abs(run[state]).max()))
    arrows = np.array([axes for *_, axes in frames]).reshape(len(frames), -1, 3, 3)[:, :, 0]
    vectors = [vector["name"] for vector in page.data["motion"]["vectors"]]  # type: ignore[union-attr]
    contacts = [vector for vector in vectors if vector.startswith("contact ")]
    assert contacts and arrows.shape[1] == len(vectors)
    for name in contacts:
        sizes = np.linalg.norm(run[f"contact_force {name.removeprefix('contact ')}"], axis=0)
        drawn = np.linalg.norm(
            arrows[1:, vectors.index(name)], axis=1
        )  # modes are decided as the motion begins
        assert drawn == pytest.approx(sizes[1:], abs=1e-5 * max(1.0, sizes.max()))
