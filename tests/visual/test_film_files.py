"""Files: frames and durations, formats, faults, and that nothing is left half done."""

from __future__ import annotations

import builtins
import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import symbody as sb
from symbody.errors import EnvironmentFault, UsageError
from symbody.simulation import Trajectory
from symbody.visual.film.files.animated_images import frame_delays
from symbody.visual.film.pictures import write_film, write_still
from symbody.visual.film.save_animation import resample
from symbody.visual.film.studio import Look
from tests.visual.film_scenes import ball, box, motion_of, scene_of

SMALL = Look("front", (96, 64))
SCENE = scene_of(("ball", ball(0.3)), ground=box(2.0, 1.0, 0.1))
MOTION = motion_of(*[((0.1 * k, 0.0, 0.5),) for k in range(12)])
needs_ffmpeg = pytest.mark.skipif(shutil.which("ffprobe") is None, reason="needs ffprobe")


@pytest.fixture(scope="module")
def pendulum() -> Trajectory:
    model = sb.load_model(
        Path(__file__).parents[2] / "examples" / "spring_mass_damper" / "spring_mass_damper.toml"
    )
    return sb.simulate(sb.form_equations(model), 1.0)


def test_delays_add_up() -> None:
    assert sum(frame_delays(300, 30.0)) == 10_000 and set(frame_delays(300, 30.0)) == {30, 40}
    assert frame_delays(4, 25.0) == [40] * 4


def test_gif_has_its_frames(tmp_path: Path) -> None:
    path = tmp_path / "it.gif"
    shares: list[float] = []
    write_film(SCENE, MOTION, path, SMALL, 20.0, report=shares.append)
    with Image.open(path) as image:
        assert image.size == (96, 64) and image.n_frames == 12 and image.info["loop"] == 0  # type: ignore[attr-defined]
        frames, total = [], 0.0
        for k in range(12):
            image.seek(k)
            total += image.info["duration"]
            frames.append(np.asarray(image.convert("RGB")).astype(int))
    assert total == 600
    assert all((each[0, 0] == 255).all() for each in frames)  # the paper is white, not nearly so
    assert shares[-1] == 1.0 and len(shares) == 12
    columns = [np.flatnonzero((each[:, :, 2] - each[:, :, 0] > 40).any(axis=0)).mean() for each in frames]
    assert (np.diff(columns) > 1.0).all()  # the blue ball goes to the right
    assert list(tmp_path.iterdir()) == [path]


@needs_ffmpeg
@pytest.mark.parametrize("suffix, codec", [(".mp4", "h264"), (".webm", "vp9")])
def test_videos(tmp_path: Path, suffix: str, codec: str) -> None:
    path = tmp_path / f"it{suffix}"
    write_film(SCENE, MOTION, path, Look("front", (97, 65)), 24.0)
    command = ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", str(path)]
    (stream,) = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)["streams"]
    assert stream["codec_name"] == codec and stream["pix_fmt"] == "yuv420p"
    assert (stream["width"], stream["height"]) == (98, 66)  # even
    assert stream["nb_read_frames"] == "12" and stream["r_frame_rate"] == "24/1"


@pytest.mark.parametrize("suffix, start", [(".png", b"\x89PNG"), (".svg", b"<svg"), (".pdf", b"%PDF")])
def test_pictures(tmp_path: Path, suffix: str, start: bytes) -> None:
    path = tmp_path / f"it{suffix}"
    write_still(SCENE, motion_of(((0.0, 0.0, 0.5),), ((0.3, 0.0, 0.5),)), path, SMALL)
    assert path.read_bytes().startswith(start)
    if suffix == ".png":
        with Image.open(path) as image:
            assert image.size == (96, 64)


@pytest.mark.parametrize("fault", [KeyboardInterrupt(), False])
def test_what_is_cut_short_leaves_no_file(tmp_path: Path, fault: BaseException | bool) -> None:
    path = tmp_path / "it.gif"
    path.write_text("before")

    def report(share: float) -> bool | None:
        if share > 0.5 and isinstance(fault, BaseException):
            raise fault
        return share <= 0.5

    if isinstance(fault, BaseException):
        with pytest.raises(KeyboardInterrupt):
            write_film(SCENE, MOTION, path, SMALL, 20.0, report=report)
    else:
        write_film(SCENE, MOTION, path, SMALL, 20.0, report=report)
    assert path.read_text() == "before" and list(tmp_path.iterdir()) == [path]


@needs_ffmpeg
def test_interrupted_video_leaves_no_file(tmp_path: Path) -> None:
    def report(share: float) -> bool:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(SCENE, MOTION, tmp_path / "it.mp4", SMALL, 20.0, report=report)
    assert not list(tmp_path.iterdir())


def test_film_without_ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    importing = builtins.__import__

    def absent(name: str, *rest: Any, **named: Any) -> Any:
        if name == "imageio_ffmpeg":
            raise ImportError(name)
        return importing(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", absent)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(EnvironmentFault, match=r"\[film.no_ffmpeg\]") as error:
        write_film(SCENE, MOTION, tmp_path / "it.mp4", SMALL, 20.0)
    assert "symbody[film]" in error.value.problems[0].fix and "PATH" in error.value.problems[0].fix


def test_ffmpeg_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "bin" / "ffmpeg"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\necho 'Unknown encoder' >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setattr("symbody.visual.film.pictures.ffmpeg_program", lambda: str(program))
    with pytest.raises(EnvironmentFault, match=r"\[film.ffmpeg\].*Unknown encoder"):
        write_film(SCENE, MOTION, tmp_path / "it.mp4", SMALL, 20.0)
    assert [each.name for each in tmp_path.iterdir()] == ["bin"]


def test_motion_between_samples() -> None:
    half = resample(MOTION, np.array([0.05, 0.1]))
    assert np.allclose(half.positions[:, 0, 0], [0.05, 0.1])
    assert np.allclose(np.linalg.norm(half.quaternions, axis=-1), 1.0)


def test_run_becomes_film_and_picture(pendulum: Trajectory, tmp_path: Path) -> None:
    sb.save_animation(
        pendulum, tmp_path / "it.gif", times=(0.0, 0.5), fps=12, speed=0.5, size=(120, 90), progress=False,
        labels=True, frames=True, vectors="all", title="a title",
    )  # fmt: skip
    with Image.open(tmp_path / "it.gif") as image:
        assert image.n_frames == 12  # type: ignore[attr-defined]
    sb.save_animation(pendulum, str(tmp_path / "it.svg"), times=[0.0, 0.2], size=(120, 90))
    assert "t = 0.00, 0.20 s" in (tmp_path / "it.svg").read_text()


@pytest.mark.parametrize(
    "code, name, options",
    [
        ("film.format", "it.txt", {}),
        ("film.format", "it", {}),
        ("film.times", "it.png", {"times": 7.0}),
        ("film.times", "it.gif", {"times": (0.0, np.nan)}),
        ("film.long", "it.gif", {"speed": 1e-6}),
        ("film.number", "it.gif", {"fps": 0.0}),
        ("film.number", "it.png", {"ghosts": 2.0}),
        ("film.size", "it.png", {"size": (0, 100)}),
        ("film.view", "it.png", {"view": "abve"}),
        ("film.trace", "it.png", {"traces": ["nobody"]}),
        ("call.argument", "it.png", {"fps": "fast"}),
    ],
)
def test_what_cannot_be_drawn(
    pendulum: Trajectory, tmp_path: Path, code: str, name: str, options: dict[str, Any]
) -> None:
    with pytest.raises(UsageError) as error:
        sb.save_animation(pendulum, tmp_path / name, progress=False, **options)
    assert error.value.problems[0].code == code and error.value.problems[0].fix
    assert not list(tmp_path.iterdir())


def test_runs_without_model_or_samples(pendulum: Trajectory, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\[film.no_model\]"):
        sb.save_animation(replace(pendulum, provenance=None), tmp_path / "it.png")
    nothing = {letter: getattr(pendulum, letter)[..., :0] for letter in ("t", "q", "u")}
    empty = replace(pendulum, **nothing, stored={}, dense_output=None)
    with pytest.raises(UsageError, match=r"\[film.no_samples\]"):
        sb.save_animation(empty, tmp_path / "it.png")


def test_folder_that_does_not_exist(pendulum: Trajectory, tmp_path: Path) -> None:
    with pytest.raises(EnvironmentFault, match=r"\[film.unwritable\]"):
        sb.save_animation(pendulum, tmp_path / "nowhere" / "it.png")
    (tmp_path / "it.png").mkdir()
    with pytest.raises(EnvironmentFault, match=r"\[film.unwritable\]"):
        sb.save_animation(pendulum, tmp_path / "it.png", size=(64, 48))
    assert [each.name for each in tmp_path.iterdir()] == ["it.png"]


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "example", sorted(Path(__file__).parents[2].glob("examples/*/*.toml")), ids=lambda path: path.stem
)
def test_examples_become_films(example: Path, tmp_path: Path) -> None:
    run = sb.simulate(sb.form_equations(sb.load_model(example)), 0.5)
    sb.save_animation(run, tmp_path / "it.gif", size=(240, 160), fps=10, progress=False)
    sb.save_animation(run, tmp_path / "it.svg", times=np.linspace(run.t[0], run.t[-1], 4), labels=True)
    with Image.open(tmp_path / "it.gif") as image:
        assert image.n_frames >= 2  # type: ignore[attr-defined]
    assert (tmp_path / "it.svg").stat().st_size < 1_000_000
