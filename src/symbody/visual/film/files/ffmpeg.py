"""MP4 and WebM by the program ffmpeg, which takes pixels from a pipe."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final

from symbody.errors import EnvironmentFault, Problem
from symbody.visual.film.drawing import Bytes

# yuv420p plays everywhere; it needs even sizes.
_SHARED: Final = ("-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p")
_CODECS: Final = {
    ".mp4": ("-c:v", "libx264", "-crf", "18", "-preset", "medium", "-movflags", "+faststart"),
    ".webm": ("-c:v", "libvpx-vp9", "-crf", "28", "-b:v", "0", "-deadline", "good", "-cpu-used", "4"),
}


def ffmpeg_program() -> str:
    """Return the path of ffmpeg: that of the package imageio-ffmpeg, else one that is installed.

    Raises
    ------
    EnvironmentFault
        If there is none.
    """
    with suppress(ImportError, RuntimeError):  # RuntimeError: the package has no program for this computer
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    program = shutil.which("ffmpeg")
    if program is None:
        raise EnvironmentFault(
            Problem("film.no_ffmpeg", "", "films need the program ffmpeg, which is not installed",
                    fix="pip install symbody[film], or put ffmpeg on PATH; a .gif needs neither")
        )  # fmt: skip
    return program


def write_video(frames: Iterable[Bytes], path: Path, size: tuple[int, int], fps: float, program: str) -> None:
    """Write frames (height, width, 3) to an MP4 or WebM file.

    Raises
    ------
    EnvironmentFault
        If ffmpeg fails.
    """
    source = (
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-s",
        f"{size[0]}x{size[1]}",
        "-r",
        f"{fps:g}",
        "-i",
        "-",
    )
    codec = _CODECS[path.suffix.lower()]
    command = [program, "-y", "-loglevel", "error", *source, "-an", *_SHARED, *codec, str(path)]
    with tempfile.TemporaryFile() as messages:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=messages, stderr=messages) as process:
            try:
                _feed(process, frames)
            except BaseException:
                process.kill()
                raise
        if process.returncode:
            messages.seek(0)
            lines = messages.read().decode("utf-8", "replace").strip().splitlines() or ["no reason was given"]
            raise EnvironmentFault(
                Problem("film.ffmpeg", program, f"ffmpeg cannot make this film: {lines[-1]}",
                        fix="pip install symbody[film] installs one that can, or end the name with .gif")
            )  # fmt: skip


def _feed(process: subprocess.Popen[bytes], frames: Iterable[Bytes]) -> None:
    assert process.stdin is not None
    for frame in frames:
        try:
            process.stdin.write(frame.tobytes())
        except OSError:  # ffmpeg has ended; its own words say why
            return
    with suppress(OSError):
        process.stdin.close()
