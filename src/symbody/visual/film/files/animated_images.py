"""Films as GIF, with one palette for all frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image

from symbody.visual.film.drawing import Bytes

FASTEST: Final = 50.0  # frames in a second; browsers play shorter delays slowly
_COLORS: Final = 256


def frame_delays(count: int, fps: float) -> list[int]:
    """Return how long frames stay [ms]: in whole hundredths of a second, whose sum is right.

    >>> frame_delays(3, 30.0)
    [30, 40, 30]
    """
    ends = np.round(100.0 * np.arange(count + 1) / fps).astype(int)
    return [10 * int(each) for each in np.diff(ends)]


def shared_palette(frames: Sequence[Bytes]) -> Image.Image:
    """Return an image whose palette fits frames (height, width, 3) together."""
    return Image.fromarray(np.concatenate(frames)).quantize(_COLORS - 1, method=Image.Quantize.MEDIANCUT)


def write_gif(
    frames: Iterable[Bytes], path: Path, delays: Sequence[int], palette: Image.Image, paper: str
) -> None:
    """Write frames on paper of a colour to a GIF that is played again and again."""
    exact = np.array([int(paper[k : k + 2], 16) for k in (1, 3, 5)], dtype=np.uint8)
    colors = np.array(palette.getpalette("RGB"), dtype=np.uint8).reshape(-1, 3)[: _COLORS - 1]
    colors = np.concatenate([colors, exact[np.newaxis]])
    images = (_in_palette(frame, palette, colors) for frame in frames)
    first = next(images)
    first.save(
        path, format="GIF", save_all=True, append_images=images, duration=delays, loop=0, optimize=False
    )


def _in_palette(frame: Bytes, palette: Image.Image, colors: Bytes) -> Image.Image:
    """Return a frame in colours of which the last is the paper's: that one is exact, others are near."""
    places = np.array(Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE))
    places[(frame == colors[-1]).all(axis=2)] = len(colors) - 1
    image = Image.fromarray(places, mode="P")
    image.putpalette(colors.reshape(-1).tolist())
    return image
