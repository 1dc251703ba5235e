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
from symbody.model.model import Model
from symbody.simulation.native.run import Progress
from symbody.simulation.progress import show_progress
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.film.facets import Floats
from symbody.visual.film.files.animated_images import FASTEST
from symbody.visual.film.pictures import STILLS, file_kind, write_film, write_still
from symbody.visual.film.studio import Look
from symbody.visual.scene import coordinate_courses, make_motion, make_scene
from symbody.visual.scene.scene import Scene, SceneMotion
from symbody.visual.scene.view import seen_along

_MOST_FRAMES: Final = 20_000
_SIZES: Final = (32, 8192)  # pixels
_TRACK: Final = 1500  # samples of traces


@checked_arguments
def save_animation(
    run: Trajectory, path: str | PathLike[str], *,
    times: ArrayLike | None = None, view: str | Sequence[float] | Mapping[str, Any] | None = None,
    size: tuple[int, int] = (960, 540), fps: float = 30.0, speed: float = 1.0, traces: Sequence[str] = (),
    labels: bool = False, vectors: str | Sequence[str] = (), frames: bool = False, dark: bool = False,
    ghosts: float = 0.35, title: str | None = None, model: Model | None = None,
    progress: Progress | bool | None = True,
) -> None:  # fmt: skip
    """Write a film or a picture of a motion to a file, without a browser; docs/film.md shows examples.

    Parameters
    ----------
    run : Trajectory
        The motion, with its model.
    path : path
        Ends with .mp4, .webm (both by the program ffmpeg) or .gif: a film; .png, .svg or .pdf: a picture.
    times : (start, end) or (N,) array, optional
        Where a film begins and ends [s]; of a picture one time or several, laid over each other, the last
        solid. By default the whole motion, or its start.
    view : str, (3,) or mapping, optional
        Where from: a word as for `animate`, a direction, or a mapping; see docs/film.md.
    size : (width, height)
        In pixels; in .svg and .pdf 96 of them are an inch.
    fps, speed : float
        Frames in a second (of a .gif at most 50); seconds of the motion in a second of the film.
    traces : sequence of str
        Points whose paths are drawn: ``"Body.frame"``, or a body for its centre of mass.
    labels, frames, dark : bool
        Whether bodies have their names, frames are drawn, and the background is dark.
    vectors : str or sequence of str
        Forces and torques that are drawn: "all", "applied", or names of elements.
    ghosts : float
        How solid the earlier ones of several times are, from 0 to 1.
    title : str, optional
        Written above.
    model : Model, optional
        The mechanism that moves, for motions from files of older versions.
    progress : bool or callable, optional
        True shows a bar while a film is made; a callable takes the share that is done, and ends the work by
        returning False. Then, as after an interrupt, no file is written.

    Raises
    ------
    UsageError
        An unknown suffix, view, point or element; times outside of the motion; an impossible size or speed.
    EnvironmentFault
        If the file cannot be written, or ffmpeg is missing.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> sb.save_animation(sb.simulate(eqs, 1.0), "oscillator.png", times=[0, 0.5])  # doctest: +SKIP
    """
    target = Path(path)
    is_still = file_kind(target) in STILLS
    _check(run, fps, speed, ghosts)
    run = run if model is None or model == run.model else run.of_model(model)
    look = Look(view, _pixels(size), tuple(traces), labels, frames, dark, ghosts, title)
    rate = fps if target.suffix.lower() != ".gif" else min(fps, FASTEST)
    shown = _still_times(run, times) if is_still else _film_times(run, times, rate, speed)
    scene = _scene(run)
    motion = _motion_at(run, scene, shown, vectors or "none")
    touches = any(vector.places is not None for vector in motion.vectors)
    track = _track(run, scene, shown, is_still, vectors or "none") if traces or touches else None
    if is_still:
        write_still(scene, motion, target, look, track)
        return
    with show_progress(progress, "film") as report:
        write_film(scene, motion, target, look, rate, track, report)


def _scene(run: Trajectory) -> Scene:
    if run.model is None:
        raise UsageError(
            Problem("film.no_model", "run", "the motion does not contain its mechanism",
                    "its file was written by an older version, or its equations were assembled by hand",
                    "save_animation(run, ..., model=...) with the model it was computed from")
        )  # fmt: skip
    scene = make_scene(run.model, run.parameters, coordinate_courses(run))
    return seen_along(scene, _motion_at(run, scene, np.unique(run.t)[:: max(1, run.t.size // 20)], "none"))


def _motion_at(run: Trajectory, scene: Scene, times: Floats, vectors: str | Sequence[str]) -> SceneMotion:
    """Return the motion at times; where only its samples were kept, between those."""
    if run.dense_output is not None or np.isin(times, run.t).all():
        return make_motion(run, scene, times, (), vectors)
    return resample(make_motion(run, scene, np.atleast_1d(run.t), (), vectors), times)


def resample(motion: SceneMotion, times: Floats) -> SceneMotion:
    """Return a motion at other times, straight on between its samples."""

    def interpolate(values: Floats) -> Floats:
        columns = values.reshape(len(motion.times), -1).T
        rows = np.array([np.interp(times, motion.times, column) for column in columns])
        return rows.T.reshape(len(times), *values.shape[1:])

    quaternions = interpolate(motion.quaternions)
    quaternions /= np.linalg.norm(quaternions, axis=-1, keepdims=True)
    vectors = tuple(
        replace(
            each,
            values=interpolate(each.values),
            places=None if each.places is None else interpolate(each.places),
        )
        for each in motion.vectors
    )
    return SceneMotion(times, interpolate(motion.positions), quaternions, (), vectors, motion.events)


def _track(
    run: Trajectory, scene: Scene, shown: Floats, is_still: bool, vectors: str | Sequence[str]
) -> SceneMotion:
    """Return the motion in steps fit for traces and footprints: of a picture all, of a film its part."""
    first, last = _range(run) if is_still else (float(shown[0]), float(shown[-1]))
    return _motion_at(run, scene, np.linspace(first, last, _TRACK), vectors)


def _still_times(run: Trajectory, times: ArrayLike | None) -> Floats:
    return _check_times(run, [_range(run)[0]] if times is None else times, "0.5, or (0, 0.5, 1)")


def _film_times(run: Trajectory, times: ArrayLike | None, fps: float, speed: float) -> Floats:
    """Return when the frames of a film are taken."""
    ends = _check_times(run, _range(run) if times is None else times, "(0, 2): start and end")
    first, last = float(ends[0]), float(ends[-1])
    count = max(1, round((last - first) / speed * fps))
    if count > _MOST_FRAMES:
        raise UsageError(
            Problem("film.long", "times", f"the film would have {count} frames; the maximum is "
                                          f"{_MOST_FRAMES}",
                    fix="give times=(START, END), a smaller fps= or a larger speed=")
        )  # fmt: skip
    return np.asarray(np.minimum(first + np.arange(count) * (speed / fps), last), dtype=np.float64)


def _check_times(run: Trajectory, times: ArrayLike, example: str) -> Floats:
    try:
        chosen = np.unique(np.asarray(times, dtype=np.float64))
    except (TypeError, ValueError):
        chosen = np.empty(0)
    first, last = _range(run)
    slack = 1e-9 * max(last - first, 1e-300)
    if chosen.size == 0 or not ((chosen >= first - slack) & (chosen <= last + slack)).all():
        raise UsageError(
            Problem("film.times", "times", f"{times!r} is not within the motion: {first:g} to {last:g} s",
                    fix=f"give times such as {example}")
        )  # fmt: skip
    return np.clip(chosen, first, last)


def _range(run: Trajectory) -> tuple[float, float]:
    return float(np.min(run.t)), float(np.max(run.t))


def _pixels(size: tuple[int, int]) -> tuple[int, int]:
    if len(size) != 2 or not all(_SIZES[0] <= each <= _SIZES[1] for each in size):
        raise UsageError(
            Problem("film.size", "size", f"size = {size!r} is not a valid picture size",
                    fix=f"give width and height in pixels, {_SIZES[0]} to {_SIZES[1]}, such as (960, 540)")
        )  # fmt: skip
    return int(size[0]), int(size[1])


def _check(run: Trajectory, fps: float, speed: float, ghosts: float) -> None:
    if not isinstance(run, Trajectory):
        raise UsageError(
            Problem("film.not_a_motion", "run", f"{run!r} is not a motion",
                    fix="give what simulate returns; of a sweep, one case: sweep.trajectory(3)")
        )  # fmt: skip
    if run.t.size == 0:
        raise UsageError(
            Problem("film.no_samples", "run", "the motion has no samples: nothing was computed",
                    fix="see run.status and run.notes")
        )  # fmt: skip
    limits = (("fps", fps, 0.01, 1000.0), ("speed", speed, 1e-9, 1e9), ("ghosts", ghosts, 0.0, 1.0))
    for name, value, low, high in limits:
        if not low <= value <= high:
            raise UsageError(
                Problem("film.number", name, f"{name} = {value!r} is not valid for a film",
                        fix=f"give a number from {low:g} to {high:g}")
            )  # fmt: skip
