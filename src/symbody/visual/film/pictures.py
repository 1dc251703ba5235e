"""Pictures and films of a scene and its motion: which file a suffix stands for, and how each is made."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from PIL import Image

from symbody.arguments import checked_arguments
from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.storage import create_file
from symbody.visual.film.drawing import Bytes, Drawing
from symbody.visual.film.files.animated_images import frame_delays, shared_palette, write_gif
from symbody.visual.film.files.axes_drawing import draw_on_axes, figure_of
from symbody.visual.film.files.ffmpeg import ffmpeg_program, write_video
from symbody.visual.film.files.raster import pixels_of
from symbody.visual.film.files.svg import svg_text
from symbody.visual.film.labels import Offsets
from symbody.visual.film.studio import Look, Studio, make_studio
from symbody.visual.scene.scene import Scene, SceneMotion

Report = Callable[[float], bool | None]

STILLS: Final = (".png", ".svg", ".pdf")
FILMS: Final = (".mp4", ".webm", ".gif")
_PALETTE_FRAMES: Final = 6
_MOST_SAMPLES: Final = 6e6  # of a picture made of regions
_FINEST: Final = 6.0  # samples in a pixel
TONE_WIDTH: Final = 7.0  # samples, on the average
_MOST_PIXEL_SAMPLES: Final = 4e7


class Cancelled(Exception):
    """The caller's progress function ended the work."""


def file_kind(path: Path) -> str:
    """Return the suffix of a path, in small letters.

    Raises
    ------
    UsageError
        If it is none of a picture or film.
    """
    suffix = path.suffix.lower()
    if suffix not in STILLS + FILMS:
        fix = f"end it with one of {', '.join(FILMS)} for a film or {', '.join(STILLS)} for a picture"
        raise UsageError(
            Problem(
                "film.format",
                str(path),
                what="the name does not end like that of a picture or a film",
                fix=fix,
            )
        )
    return suffix


@checked_arguments
def draw_scene(
    ax: Axes,
    scene: Scene,
    motion: SceneMotion,
    samples: int | Sequence[int] = 0,
    look: Look | None = None,
) -> Axes:
    """Draw a scene on axes of matplotlib and return them; they lose their scales.

    Parameters
    ----------
    samples : int or sequence of int
        Which samples of the motion: of several the last is solid.
    look : Look, optional
        View, size and whatever else is shown. The size sets how large letters are beside the mechanism.
    """
    chosen = [samples] if isinstance(samples, int) else list(samples)
    draw_on_axes(ax, vector_drawing(scene, motion, chosen, Look() if look is None else look))
    return ax


def vector_drawing(
    scene: Scene, motion: SceneMotion, samples: Sequence[int], look: Look, track: SceneMotion | None = None
) -> Drawing:
    """Return a picture whose surfaces have few tones, fit for files of regions."""
    finest = np.sqrt(_MOST_SAMPLES / (look.size[0] * look.size[1]))
    studio = make_studio(scene, motion, look, float(np.clip(finest, 1.0, _FINEST)), TONE_WIDTH, track)
    return studio.draw(samples)[0]


def write_still(
    scene: Scene, motion: SceneMotion, path: Path, look: Look, track: SceneMotion | None = None
) -> None:
    """Write one picture of all samples of a motion, the last solid.

    Raises
    ------
    UsageError
        If there is no such view, or a traced point is unknown.
    EnvironmentFault
        If the file cannot be written.
    """
    samples = range(len(motion.times))
    with _file_replacement(path) as draft:
        if path.suffix.lower() == ".png":
            fine = next(
                n for n in (4, 3, 2, 1) if n == 1 or n * n * np.prod(look.size) <= _MOST_PIXEL_SAMPLES
            )
            drawing = make_studio(scene, motion, look, fine, track=track).draw(samples)[0]
            image = Image.fromarray(pixels_of(drawing, look.size))
            image.save(draft, format="PNG", optimize=True, dpi=(96, 96))
            return
        drawing = vector_drawing(scene, motion, samples, look, track)
        if path.suffix.lower() == ".svg":
            draft.write_text(svg_text(drawing, look.title or scene.name), encoding="utf-8")
        else:
            figure_of(drawing).savefig(draft, format="pdf", facecolor=drawing.background)


def write_film(
    scene: Scene,
    motion: SceneMotion,
    path: Path,
    look: Look,
    fps: float,
    track: SceneMotion | None = None,
    report: Report | None = None,
) -> None:
    """Write a film whose frames are the samples of a motion.

    Parameters
    ----------
    report : callable, optional
        Takes the share that is done; nothing is written when it returns False.

    Raises
    ------
    UsageError
        If there is no such view, or a traced point is unknown.
    EnvironmentFault
        If the file cannot be written, or there is no ffmpeg for it.
    """
    suffix = path.suffix.lower()
    program = ffmpeg_program() if suffix in (".mp4", ".webm") else ""
    studio = make_studio(scene, motion, look, 2.0, track=track, follows=True)
    frames = film_frames(studio, report)
    try:
        with _file_replacement(path) as draft:
            if suffix == ".gif":
                palette = shared_palette(_typical_frames(studio))
                delays = frame_delays(len(motion.times), fps)
                write_gif(frames, draft, delays, palette, studio.paper.background)
            else:
                write_video(frames, draft, look.size, fps, program)
    except Cancelled:
        return


def film_frames(studio: Studio, report: Report | None = None) -> Iterator[Bytes]:
    """Yield the pixels (height, width, 3) of each sample of a motion.

    Raises
    ------
    Cancelled
        If the report returns False.
    """
    count = len(studio.motion.times)
    offsets: Offsets = {}
    for k in range(count):
        drawing, offsets = studio.draw([k], float(studio.motion.times[k]), offsets)
        yield pixels_of(drawing, studio.look.size)
        if report is not None and report((k + 1) / count) is False:
            raise Cancelled


def _typical_frames(studio: Studio) -> list[Bytes]:
    count = len(studio.motion.times)
    chosen = np.unique(np.linspace(0, count - 1, min(count, _PALETTE_FRAMES)).astype(int))
    times = studio.motion.times
    return [pixels_of(studio.draw([int(k)], float(times[k]))[0], studio.look.size) for k in chosen]


@contextmanager
def _file_replacement(path: Path) -> Iterator[Path]:
    """Yield the path of a new file beside `path`, with the same suffix, that takes its place at the end.

    Raises
    ------
    EnvironmentFault
        If there can be no file.
    """
    try:
        handle, name = create_file(path.parent, ".", path.suffix)
        os.close(handle)
    except OSError as error:
        raise _unwritable(path, error) from error
    draft = Path(name)
    try:
        yield draft
        draft.replace(path)
    except OSError as error:
        raise _unwritable(path, error) from error
    finally:
        draft.unlink(missing_ok=True)


def _unwritable(path: Path, error: OSError) -> EnvironmentFault:
    return EnvironmentFault(
        Problem("film.unwritable", str(path), f"the picture cannot be written: {error.strerror or error}",
                fix="choose an existing folder with write permission and enough space")
    )  # fmt: skip
