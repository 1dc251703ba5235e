"""Films of mechanisms that go far follow them; motions without joints are seen against their plane."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import symbody as sb
from symbody.visual.film.stage import make_stage, pose_at
from symbody.visual.film.studio import carried_extent
from symbody.visual.scene import make_motion, make_scene
from symbody.visual.scene.view import seen_along


def thrown(speed: float, time: float = 1.0) -> sb.Trajectory:
    box = sb.Body("box", mass=2, inertia=(0.1, 0.2, 0.3))
    joint = sb.Planar("way", "ground", box, coordinates=("x", "y", "theta"))
    model = sb.Model("thrown", [box, joint], gravity=(0, -9.81, 0), parameters={"L": 1})
    return sb.simulate(sb.form_equations(model), time, initial={"x_dot": speed, "theta_dot": 1.0})


@pytest.mark.parametrize(
    ("speed", "time", "is_far"), [(1.0, 0.3, False), (10.0, 1.0, True), (200.0, 1.0, True)]
)
def test_what_moves_farther_than_three_times_its_size_is_followed(
    speed: float, time: float, is_far: bool
) -> None:
    run = thrown(speed, time)
    assert run.model is not None
    scene = make_scene(run.model, run.parameters)
    motion = make_motion(run, scene)
    stage = make_stage(scene, motion)
    points, start = carried_extent(stage, [pose_at(motion, k) for k in range(len(motion.times))])
    assert (start is not None) == is_far
    assert np.ptp(points[:, 0]) < 3 * scene.size


def test_the_followed_stays_in_the_picture(tmp_path: Path) -> None:
    shares = []
    for time in (0.0, 1.0):
        times = (0.9 * time, 0.9 * time + 0.1)
        sb.save_animation(
            thrown(200.0), tmp_path / "a.gif", times=times, fps=10, size=(160, 90), progress=False
        )
        with Image.open(tmp_path / "a.gif") as film:
            pixels = np.asarray(film.convert("RGB"), dtype=int)
        shares.append(float((np.ptp(pixels, axis=2) > 40).mean()))
    assert min(shares) > 0.1


def test_a_picture_of_several_times_shows_them_all(tmp_path: Path) -> None:
    """What goes far is small in it, and as often as there are times: columns of colour with gaps between."""
    picture = tmp_path / "a.png"
    sb.save_animation(
        thrown(20.0), picture, times=[0.0, 0.5, 1.0], ghosts=1.0, size=(800, 450), progress=False
    )
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=int)[60:-90]  # without signs of gravity, scale, axes
    seen = (np.ptp(pixels, axis=2) > 40).any(axis=0)
    assert (np.diff(seen.astype(int)) == 1).sum() == 3


def test_a_motion_without_joints_in_a_plane_is_seen_against_it() -> None:
    body = sb.Body("disc", mass=1, inertia=(1, 1, 2))
    model = sb.Model("loose", [body], gravity=(0, -9.81, 0))
    run = sb.simulate(sb.form_equations(model), 0.5, initial={"disc_qw": 1, "disc_vx": 1, "disc_wz": 2})
    scene = make_scene(model)
    seen = seen_along(scene, make_motion(run, scene))
    assert scene.normal is None and seen.normal == (0, 0, 1) and seen.up == (0, 1, 0)
    tumbling = sb.simulate(sb.form_equations(model), 0.5, initial={"disc_qw": 1, "disc_vx": 1, "disc_wx": 2})
    assert seen_along(scene, make_motion(tumbling, scene)).normal is None


def test_films_take_the_model_of_older_motions(tmp_path: Path) -> None:
    run = thrown(1.0)
    old = replace(run, provenance=None)
    with pytest.raises(sb.SymbodyError, match=r"film.no_model"):
        sb.save_animation(old, tmp_path / "a.png")
    sb.save_animation(old, tmp_path / "a.png", model=run.model, size=(160, 90))
    sb.save_animation(run, tmp_path / "b.png", size=(160, 90))
    assert np.array_equal(
        np.asarray(Image.open(tmp_path / "a.png")), np.asarray(Image.open(tmp_path / "b.png"))
    )
