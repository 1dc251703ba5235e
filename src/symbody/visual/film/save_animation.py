"""`save_animation`: films and still pictures of a motion, without a browser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from symbody.arguments import checked_arguments
from symbody.errors import Problem, UsageError
from symbody.simulation.native.run import Progress
from symbody.simulation.progress import told
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.film.facets import Floats
from symbody.visual.film.pictures import STILLS, fastest, file_kind, write_film, write_still
from symbody.visual.film.studio import Look
from symbody.visual.scene import make_motion, make_scene
from symbody.visual.scene.scene import Scene, SceneMotion

_MOST_FRAMES: Final = 20_000
_SIZES: Final = (32, 8192)  # pixels
_TRACK: Final = 1500  # samples of traces


@checked_arguments
def save_animation(
    run: Trajectory,
    path: str | PathLike[str],
    *,
    times: ArrayLike | None = None,
    view: str | Sequence[float] | Mapping[str, Any] | None = None,
    size: tuple[int, int] = (960, 540),
    fps: float = 30.0,
    speed: float = 1.0,
    traces: Sequence[str] = (),
    labels: bool = False,
    vectors: str | Sequence[str] = (),
    frames: bool = False,
    dark: bool = False,
    ghosts: float = 0.35,
    title: str | None = None,
    progress: Progress | bool | None = True,
) -> None:
    """Write a film or a picture of a motion to a file; no browser is needed.

    Parameters
    ----------
    path : path
        Its suffix chooses: .mp4, .webm (both by the program ffmpeg) and .gif are films; .png, .svg and
        .pdf are pictures.
    times : (start, end) or (N,) array, optional
        Of a film where it begins and ends [s], by default all of the motion. Of a picture one time or
        several, which are laid over each other, the last solid and earlier ones fainter; by default the
        start.
    view : str, (3,) or mapping, optional
        "front", "back", "left", "right", "top", "bottom", "isometric", or the direction from the mechanism to
        the eye in ground's axes. A mapping has "direction" (either of these), "up" (what is drawn upwards),
        "zoom" and "perspective" (True: what is far looks small). By default planar mechanisms are seen
        against the normal of their plane, others isometrically.
    size : (width, height)
        Of films and .png in pixels; in .svg and .pdf 96 of them are an inch.
    fps : float
        Frames in a second; a .gif has at most 50.
    speed : float
        Seconds of the motion in a second of the film.
    traces : sequence of str
        Points whose ways are drawn: ``"body.frame"``, or a body for its centre of mass.
    labels, frames : bool
        Whether joints and bodies are named, and the axes of their frames drawn.
    vectors : str or sequence of str
        Forces and torques that are drawn: "all", "applied", or names of elements.
    dark : bool
        Whether the picture is dark.
    ghosts : float
        How opaque earlier positions in a picture are, from 0 to 1.
    title : str, optional
        Stands in the upper left corner.
    progress : bool or callable, optional
        True shows a bar while a film is made; a callable takes the share that is done, and ends the work
        by returning False. Then, as after an interrupt, no file is written.

    Raises
    ------
    UsageError
        An unknown suffix, view, point or element, times outside of the motion, or a size or speed that makes
        no picture.
    EnvironmentFault
        If the file cannot be written, or ffmpeg is missing.
    """
    target = Path(path)
    suffix = file_kind(target)
    _check(run, fps, speed, ghosts)
    look = Look(view, _pixels(size), tuple(traces), labels, frames, dark, ghosts, title)
    is_still = suffix in STILLS
    rate = fastest(suffix, fps)
    shown = _still_times(run, times) if is_still else _film_times(run, times, rate, speed)
    scene = _scene(run)
    chosen = vectors if isinstance(vectors, str) else tuple(vectors) or "none"
    motion = _motion_at(run, scene, shown, chosen)
    track = _track(run, scene, shown, is_still) if traces else None
    if is_still:
        write_still(scene, motion, target, look, track)
        return
    with told(progress, "film") as report:
        write_film(scene, motion, target, look, rate, track, report)


def _scene(run: Trajectory) -> Scene:
    if run.model is None:
        what = "the motion does not say which mechanism moves"
        why = "its file was written by an older version, or its equations were placed by hand"
        raise UsageError(Problem("film.no_model", "run", what, why, "compute it again with simulate"))
    courses = {name: np.atleast_1d(run[name]) for name in run.coordinate_names}
    return make_scene(run.model, run.parameters, courses)


def _motion_at(run: Trajectory, scene: Scene, times: Floats, vectors: str | tuple[str, ...]) -> SceneMotion:
    """Return the motion at times; where only its samples were kept, between those."""
    if run.dense_output is not None or np.isin(times, run.t).all():
        return make_motion(run, scene, times, (), vectors)
    return resample(make_motion(run, scene, np.atleast_1d(run.t), (), vectors), times)


def resample(motion: SceneMotion, times: Floats) -> SceneMotion:
    """Return a motion at other times, straight on between its samples."""

    def between(values: Floats) -> Floats:
        columns = values.reshape(len(motion.times), -1).T
        rows = np.array([np.interp(times, motion.times, column) for column in columns])
        return rows.T.reshape(len(times), *values.shape[1:])

    quaternions = between(motion.quaternions)
    quaternions /= np.linalg.norm(quaternions, axis=-1, keepdims=True)
    vectors = tuple(replace(each, values=between(each.values)) for each in motion.vectors)
    return SceneMotion(times, between(motion.positions), quaternions, (), vectors, motion.events)


def _track(run: Trajectory, scene: Scene, shown: Floats, is_still: bool) -> SceneMotion:
    """Return the motion in steps fine enough for traces: of a picture all of it, of a film what it shows."""
    first, last = _range(run) if is_still else (float(shown[0]), float(shown[-1]))
    return _motion_at(run, scene, np.linspace(first, last, _TRACK), "none")


def _still_times(run: Trajectory, times: ArrayLike | None) -> Floats:
    return _inside(run, [_range(run)[0]] if times is None else times, "0.5, or (0, 0.5, 1)")


def _film_times(run: Trajectory, times: ArrayLike | None, fps: float, speed: float) -> Floats:
    """Return when the frames of a film are taken."""
    ends = _inside(run, _range(run) if times is None else times, "(0, 2): where it begins and ends")
    first, last = float(ends[0]), float(ends[-1])
    count = max(1, round((last - first) / speed * fps))
    if count > _MOST_FRAMES:
        what = f"the film would have {count} frames, and {_MOST_FRAMES} are the most"
        fix = "give times=(START, END), a smaller fps= or a larger speed="
        raise UsageError(Problem("film.long", "times", what, fix=fix))
    return np.asarray(np.minimum(first + np.arange(count) * (speed / fps), last), dtype=np.float64)


def _inside(run: Trajectory, times: ArrayLike, example: str) -> Floats:
    try:
        chosen = np.unique(np.asarray(times, dtype=np.float64))
    except (TypeError, ValueError):
        chosen = np.empty(0)
    first, last = _range(run)
    slack = 1e-9 * max(last - first, 1e-300)
    if chosen.size == 0 or not ((chosen >= first - slack) & (chosen <= last + slack)).all():
        what = f"{times!r} is not within the motion, which goes from {first:g} to {last:g} s"
        raise UsageError(Problem("film.times", "times", what, fix=f"give times such as {example}"))
    return np.clip(chosen, first, last)


def _range(run: Trajectory) -> tuple[float, float]:
    return float(np.min(run.t)), float(np.max(run.t))


def _pixels(size: tuple[int, int]) -> tuple[int, int]:
    if len(size) != 2 or not all(_SIZES[0] <= each <= _SIZES[1] for each in size):
        what = f"size = {size!r} makes no picture"
        fix = f"give width and height in pixels, from {_SIZES[0]} to {_SIZES[1]}, such as (960, 540)"
        raise UsageError(Problem("film.size", "size", what, fix=fix))
    return int(size[0]), int(size[1])


def _check(run: Trajectory, fps: float, speed: float, ghosts: float) -> None:
    if not isinstance(run, Trajectory):
        fix = "give what simulate returns; of a sweep, one case: sweep.trajectory(3)"
        raise UsageError(Problem("film.not_a_motion", "run", f"{run!r} is no motion", fix=fix))
    if run.t.size == 0:
        what = "the motion has no samples: nothing of it was computed"
        raise UsageError(Problem("film.no_samples", "run", what, fix="see run.status and run.notes"))
    limits = (("fps", fps, 0.01, 1000.0), ("speed", speed, 1e-9, 1e9), ("ghosts", ghosts, 0.0, 1.0))
    for name, value, low, high in limits:
        if not low <= value <= high:
            fix = f"give a number from {low:g} to {high:g}"
            raise UsageError(Problem("film.number", name, f"{name} = {value!r} makes no film", fix=fix))
