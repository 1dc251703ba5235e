"""Axes that show their picture in a notebook."""

from __future__ import annotations

import io
from typing import Final

from matplotlib.axes import Axes
from matplotlib.projections import get_projection_class

_RESOLUTION: Final = 100  # dots per inch: a figure fills the column of a notebook


def picture(axes: Axes) -> bytes:
    """Return the figure that holds axes as PNG."""
    file = io.BytesIO()
    axes.figure.canvas.figure.savefig(file, format="png", dpi=_RESOLUTION)
    return file.getvalue()


class PictureAxes(Axes):
    """Axes of a figure that belongs to no window; notebooks show the figure where they are a cell's value."""

    def _repr_png_(self) -> bytes:
        return picture(self)


# The same in space, derived from what matplotlib registers; its own module has no types.
PictureAxes3D: Final[type[Axes]] = type(
    "PictureAxes3D",
    (get_projection_class("3d"),),
    {"__module__": __name__, "_repr_png_": PictureAxes._repr_png_},
)


def axes_class(in_space: bool = False) -> type[Axes]:
    """Return the class of axes in the plane, or in space."""
    return PictureAxes3D if in_space else PictureAxes
