"""Draw the joints with axes and coordinates: `python docs/draw_joints.py` writes docs/pictures/*.svg."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

PICTURES: Final = Path(__file__).parent / "pictures"
START, END, OWN = "#8a8f98", "#1f5fa8", "#c2410c"  # start frame, end frame, coordinates
UNITS: Final = np.eye(3)
LETTERS: Final = {"x": UNITS[0], "y": UNITS[1], "z": UNITS[2]}


def turned(axis: Array | str, degrees: float) -> Array:
    """Return the matrix of a turn (Rodrigues)."""
    x, y, z = LETTERS[axis] if isinstance(axis, str) else axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    found: Array = UNITS + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    return found


class Picture:
    """One joint in an orthogonal view; arrows in the colours of what they belong to."""

    def __init__(self, axes: Axes3D, title: str) -> None:
        self.axes = axes
        axes.set_title(title, fontsize=11, y=0.97)
        axes.set_axis_off()
        axes.set_proj_type("ortho")
        axes.view_init(elev=24, azim=38)
        axes.set_box_aspect((1, 1, 1), zoom=1.45)
        axes.set(xlim=(-1.0, 1.2), ylim=(-1.0, 1.2), zlim=(-0.8, 1.4))

    def frame(
        self, at: ArrayLike, r: Array, colour: str, mark: str, length: float = 0.9, unnamed: str = ""
    ) -> None:
        """Draw three axes; the names of those of end have a dash. Where two coincide one goes `unnamed`."""
        origin = np.array(at, dtype=float)
        for k, letter in enumerate("xyz"):
            tip = origin + length * r[:, k]
            self.arrow(origin, tip, colour, 1.3)
            if letter not in unnamed:
                self.text(origin + (length + 0.14) * r[:, k], letter + mark, colour)

    def arrow(self, a: Array, b: Array, colour: str, width: float = 2.2) -> None:
        """Draw an arrow from a point to a point."""
        self.axes.quiver(
            *a, *(b - a), color=colour, linewidth=width, arrow_length_ratio=0.09 / np.linalg.norm(b - a)
        )

    def line(self, a: Array, b: Array) -> None:
        """Draw a dashed line along which something slides or about which it turns."""
        self.axes.plot(*np.array([a, b]).T, color=OWN, linewidth=0.9, linestyle=(0, (5, 4)))

    def text(self, at: Array, words: str, colour: str = OWN, size: float = 10) -> None:
        """Write on a white ground."""
        self.axes.text(*at, words, color=colour, fontsize=size, ha="center", va="center", zorder=99,
                       bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6})  # fmt: skip

    def slide(self, a: ArrayLike, b: ArrayLike, name: str, away: ArrayLike = (0, 0, 0.13)) -> None:
        """Draw a displacement between two points, its name beside the middle."""
        start, end = np.array(a, dtype=float), np.array(b, dtype=float)
        self.arrow(start, end, OWN)
        self.text((start + end) / 2 + np.array(away), name)

    def angle(
        self,
        at: ArrayLike,
        axis: Array,
        first: Array,
        degrees: float,
        name: str,
        radius: float,
        outside: float = 0.16,
    ) -> None:
        """Draw an arc from a direction about an axis, and its name outside of the middle."""
        origin, along = np.array(at, dtype=float), axis / np.linalg.norm(axis)
        arc = np.array([origin + radius * turned(along, x) @ first for x in np.linspace(0, degrees, 40)])
        self.axes.plot(*arc.T, color=OWN, linewidth=2.0)
        tip = arc[-1] - arc[-4]
        self.axes.quiver(*arc[-4], *tip, color=OWN, linewidth=2.0, arrow_length_ratio=1.4)
        middle = turned(along, degrees / 2) @ first
        self.text(origin + (radius + outside) * middle, name)


def weld(p: Picture) -> None:
    """Draw the weld: both frames are one."""
    p.frame((0, 0, 0), UNITS, START, "", 1.05, unnamed="xyz")
    p.frame((0, 0, 0), UNITS, END, "'", 0.7, unnamed="xyz")
    for k, letter in enumerate("xyz"):
        p.text(1.22 * UNITS[k], f"{letter} = {letter}'", END)


def revolute(p: Picture) -> None:
    """Draw the revolute joint."""
    r = turned("z", 40)
    p.line(-0.3 * UNITS[2], 1.1 * UNITS[2])
    p.frame((0, 0, 0), UNITS, START, "", unnamed="z")
    p.frame((0, 0, 0), r, END, "'", unnamed="z")
    p.text(1.22 * UNITS[2], "z = z'", END)
    p.angle((0, 0, 0), UNITS[2], UNITS[0], 40, "theta", 0.6)


def prismatic(p: Picture) -> None:
    """Draw the prismatic joint."""
    start, end = np.array([0, -0.5, 0]), np.array([0, 0.65, 0])
    p.line(start - 0.2 * UNITS[1], end + 0.75 * UNITS[1])
    p.frame(start, UNITS, START, "", 0.6, unnamed="y")
    p.frame(end, UNITS, END, "'", 0.6)
    p.slide(start, end, "s", (0.0, 0.0, -0.16))


def screw(p: Picture) -> None:
    """Draw the screw joint."""
    _on_axis(p, "s = pitch theta / 2 pi", (0.0, 0.72, -0.02))


def cylindrical(p: Picture) -> None:
    """Draw the cylindrical joint."""
    _on_axis(p, "s", (0.0, 0.13, 0.0))


def _on_axis(p: Picture, slide: str, away: ArrayLike) -> None:
    """End turned about z and moved along it."""
    low, top = np.array([0, 0, -0.65]), np.array([0, 0, 0.2])
    p.line(low - 0.25 * UNITS[2], top + 0.8 * UNITS[2])
    p.frame(low, UNITS, START, "", 0.65, unnamed="z")
    p.frame(top, turned("z", 50), END, "'", 0.65, unnamed="z")
    p.text(top + 0.9 * UNITS[2], "z = z'", END)
    p.slide(low, top, slide, away)
    p.axes.plot(*np.array([top, top + 0.6 * UNITS[0]]).T, color=START, linewidth=0.9, linestyle=(0, (3, 3)))
    p.angle(top, UNITS[2], UNITS[0], 50, "theta", 0.42)


def universal(p: Picture) -> None:
    """Draw the universal joint."""
    first = turned("x", 32)
    second = first @ turned("y", 30)
    p.line(-0.6 * UNITS[0], 0.9 * UNITS[0])
    p.line(-0.6 * first[:, 1], 0.9 * first[:, 1])
    p.frame((0, 0, 0), UNITS, START, "")
    p.frame((0, 0, 0), second, END, "'", 1.05)
    p.angle((0, 0, 0), UNITS[0], UNITS[1], 32, "a", 0.5)
    p.angle((0, 0, 0), first[:, 1], first[:, 2], 30, "b", 0.62)
    p.axes.plot(
        *np.array([0 * UNITS[0], 0.85 * first[:, 2]]).T, color=START, linewidth=0.9, linestyle=(0, (3, 3))
    )


def constant_velocity(p: Picture) -> None:
    """Draw the constant velocity joint."""
    azimuth, bend = 80.0, 50.0
    r = turned("z", azimuth) @ turned("y", bend) @ turned("z", -azimuth)
    lean = turned("z", azimuth)[:, 0]
    p.frame((0, 0, 0), UNITS, START, "")
    p.frame((0, 0, 0), r, END, "'", 1.05)
    p.axes.plot(*np.array([0 * lean, 0.85 * lean]).T, color=OWN, linewidth=0.9, linestyle=(0, (5, 4)))
    p.angle((0, 0, 0), UNITS[2], UNITS[0], azimuth, "azimuth", 0.5)
    p.angle((0, 0, 0), turned("z", azimuth)[:, 1], UNITS[2], bend, "bend", 0.7, outside=0.2)


def pin_slot(p: Picture) -> None:
    """Draw the pin slot joint."""
    start, at = np.array([0, -0.4, 0]), np.array([0, 0.6, 0])
    p.line(start - 0.2 * UNITS[1], at + 0.6 * UNITS[1])
    p.frame(start, UNITS, START, "", 0.55, unnamed="y")
    p.text(at + 0.72 * UNITS[1], "y", START)
    p.frame(at, turned("z", 40), END, "'", 0.6)
    p.slide(start, at, "s", (0.0, 0.0, -0.16))
    p.axes.plot(*np.array([at, at + 0.55 * UNITS[0]]).T, color=START, linewidth=0.9, linestyle=(0, (3, 3)))
    p.angle(at, UNITS[2], UNITS[0], 40, "theta", 0.4)


def planar(p: Picture) -> None:
    """Draw the planar joint."""
    at = np.array([0.75, 0.85, 0.0])
    _table(p, at)
    p.frame(at, turned("z", 40), END, "'", 0.55)
    p.axes.plot(*np.array([at, at + 0.5 * UNITS[0]]).T, color=START, linewidth=0.9, linestyle=(0, (3, 3)))
    p.angle(at, UNITS[2], UNITS[0], 40, "theta", 0.38)


def rectangular(p: Picture) -> None:
    """Draw the rectangular joint."""
    at = np.array([0.75, 0.85, 0.0])
    _table(p, at)
    p.frame(at, UNITS, END, "'", 0.55)


def _table(p: Picture, at: Array) -> None:
    """Two displacements in the plane of x and y."""
    corner = np.array([at[0], 0, 0])
    p.frame((0, 0, 0), UNITS, START, "", 1.05)
    p.slide((0, 0, 0), corner, "X", (0.0, -0.14, 0.0))
    p.slide(corner, at, "Y", (0.14, 0.0, 0.0))


def cartesian(p: Picture) -> None:
    """Draw the cartesian joint."""
    x, y, z = 0.85, 0.9, 0.5
    p.frame((0, 0, 0), UNITS, START, "", 1.05)
    p.slide((0, 0, 0), (x, 0, 0), "x", (0.0, -0.14, 0.0))
    p.slide((x, 0, 0), (x, y, 0), "y", (0.14, 0.0, 0.0))
    p.slide((x, y, 0), (x, y, z), "z", (0.0, 0.12, 0.0))
    p.frame((x, y, z), UNITS, END, "'", 0.45)


def spherical(p: Picture) -> None:
    """Draw the spherical joint."""
    _rings(p, "313", ("zeta", "eta", "xi"))


def gimbal(p: Picture) -> None:
    """Draw the gimbal joint."""
    _rings(p, "123", ("a", "b", "c"))


def _rings(p: Picture, sequence: str, names: Sequence[str]) -> None:
    """Three turns, each drawn where it happens."""
    p.frame((0, 0, 0), UNITS, START, "")
    r = _turns(p, np.zeros(3), sequence, names)
    p.frame((0, 0, 0), r, END, "'", 1.05)


def _turns(p: Picture, at: Array, sequence: str, names: Sequence[str], size: float = 1.0) -> Array:
    r = UNITS
    for k, (digit, name) in enumerate(zip(sequence, names, strict=True)):
        axis = "xyz"[int(digit) - 1]
        j = (int(digit) + (k == 2 and sequence == "123")) % 3
        if sequence == "313":
            j = (0, 2, 0)[k]
        p.angle(at, r @ LETTERS[axis], r[:, j], 42, name, size * (0.45, 0.62, 0.75)[k])
        r = r @ turned(axis, 42)
        p.axes.plot(
            *np.array([at, at + 0.85 * size * r[:, j]]).T, color=START, linewidth=0.9, linestyle=(0, (3, 3))
        )
    return r


def bearing(p: Picture) -> None:
    """Draw the bearing joint."""
    low, at = np.array([0, 0, -0.6]), np.array([0, 0, 0.05])
    p.line(low - 0.2 * UNITS[2], at + 1.1 * UNITS[2])
    p.frame(low, UNITS, START, "", 0.5, unnamed="z")
    p.text(at + 1.15 * UNITS[2], "z", START)
    p.slide(low, at, "s", (0.0, 0.12, 0.0))
    r = _turns(p, at, "123", ("a", "b", "c"), 0.85)
    p.frame(at, r, END, "'", 0.85)


def telescoping(p: Picture) -> None:
    """Draw the telescoping joint."""
    low, r = np.array([0.3, -0.3, -0.2]), turned("z", 80) @ turned("y", -32)
    at = low + 0.95 * r[:, 0]
    p.line(low - 0.25 * r[:, 0], at + 0.6 * r[:, 0])
    p.frame(low, UNITS, START, "", 0.75)
    p.frame(at, r @ turned("x", 30), END, "'", 0.45, unnamed="x")
    p.text(at + 0.72 * r[:, 0], "x'", END)
    p.slide(low, at, "s", (0.0, 0.0, 0.14))
    flat = turned("z", 80)
    p.axes.plot(
        *np.array([low, low + 0.75 * flat[:, 0]]).T, color=START, linewidth=0.9, linestyle=(0, (3, 3))
    )
    p.angle(low, UNITS[2], UNITS[0], 80, "a", 0.4)
    p.angle(low, -flat[:, 1], flat[:, 0], 32, "b", 0.62)
    p.axes.plot(*np.array([at, at + 0.45 * r[:, 2]]).T, color=START, linewidth=0.9, linestyle=(0, (3, 3)))
    p.angle(at, r[:, 0], r[:, 2], 30, "c", 0.36)


def free(p: Picture) -> None:
    """Draw the free joint."""
    at = np.array([0.8, 1.0, 0.35])
    p.frame((0, 0, 0), UNITS, START, "", 0.8)
    p.slide((0, 0, 0), (0.8, 0, 0), "x", (0.0, -0.14, 0.0))
    p.slide((0.8, 0, 0), (0.8, 1.0, 0), "y", (0.14, 0.0, 0.0))
    p.slide((0.8, 1.0, 0), at, "z", (0.0, 0.12, -0.05))
    r = turned("z", 30) @ turned("y", -25) @ turned("x", 20)
    p.frame(at, r, END, "'", 0.5)


JOINTS: Final[tuple[Callable[[Picture], None], ...]] = (
    weld,
    revolute,
    prismatic,
    screw,
    cylindrical,
    universal,
    constant_velocity,
    pin_slot,
    planar,
    rectangular,
    cartesian,
    spherical,
    gimbal,
    bearing,
    telescoping,
    free,
)


def drawn(joint: Callable[[Picture], None]) -> Figure:
    """Return the figure of one joint."""
    figure = plt.figure(figsize=(3.6, 3.6))
    axes = figure.add_axes((0, 0, 1, 1), projection="3d")
    assert isinstance(axes, Axes3D)
    joint(Picture(axes, joint.__name__))
    return figure


def main(kind: str = "svg") -> None:
    """Write every picture; SVG without date and with fixed ids, so that the same drawing is the same file."""
    plt.switch_backend("agg")
    plt.rcParams.update({"svg.hashsalt": "joints", "svg.fonttype": "none", "font.family": "DejaVu Sans"})
    PICTURES.mkdir(exist_ok=True)
    for joint in JOINTS:
        figure = drawn(joint)
        metadata = {"Date": None} if kind == "svg" else None
        figure.savefig(PICTURES / f"{joint.__name__}.{kind}", metadata=metadata, dpi=100)
        plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])
