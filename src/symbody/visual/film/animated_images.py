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


def shared_palette(frames: Sequence[Bytes], paper: str) -> Image.Image:
    """Return an image whose palette fits frames (height, width, 3) and the paper."""
    image = Image.fromarray(np.concatenate(frames)).quantize(_COLORS, method=Image.Quantize.MEDIANCUT)
    colors = np.array(image.getpalette("RGB")).reshape(-1, 3)
    exact = [int(paper[k : k + 2], 16) for k in (1, 3, 5)]
    colors[np.argmin(((colors - exact) ** 2).sum(axis=1))] = exact
    image.putpalette(colors.reshape(-1).tolist())
    return image


def write_gif(frames: Iterable[Bytes], path: Path, delays: Sequence[int], palette: Image.Image) -> None:
    """Write frames to a GIF that is played again and again."""
    images = (Image.fromarray(f).quantize(palette=palette, dither=Image.Dither.NONE) for f in frames)
    first = next(images)
    first.save(
        path, format="GIF", save_all=True, append_images=images, duration=delays, loop=0, optimize=False
    )
