"""Axes that show their picture in a notebook."""

from __future__ import annotations

import io

from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.axes3d import Axes3D


class PicturedAxes(Axes):
    """Axes of a figure that belongs to no window; notebooks show the figure where they are a cell's value."""

    def _repr_png_(self) -> bytes:
        return picture(self)


class PicturedAxes3D(Axes3D):
    """The same in space."""

    def _repr_png_(self) -> bytes:
        return picture(self)


def axes_class(in_space: bool = False) -> type[Axes]:
    """Return the class of axes in the plane, or in space."""
    return PicturedAxes3D if in_space else PicturedAxes


def picture(axes: Axes) -> bytes:
    """Return the figure that holds axes as PNG."""
    file = io.BytesIO()
    axes.figure.savefig(file, format="png")
    return file.getvalue()
