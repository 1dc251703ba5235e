"""Draw constraints with directions of their multipliers: `python docs/draw_constraints.py` writes them."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from draw_joints import END, OWN, PICTURES, START, UNITS, Picture, turned
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D


def _ground(p: Picture, size: float = 1.1) -> None:
    edge = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]]) * size
    p.axes.plot(*edge.T, color=START, linewidth=0.8)


def rolling(p: Picture) -> None:
    """Draw a disc that leans, its contact frame, and its axle."""
    _ground(p)
    radius, lean = 0.75, 62.0
    axle = turned("z", 12) @ turned("x", lean) @ UNITS[2]
    normal = UNITS[2]
    cosine = float(axle @ normal)
    sine = float(np.sqrt(1 - cosine**2))
    forward = np.cross(axle, normal) / sine
    contact = np.array([0.1, -0.1, 0.0])
    centre = contact - radius * (cosine * axle - normal) / sine
    up = (normal - cosine * axle) / sine
    turn = np.linspace(0, 2 * np.pi, 90)
    rim = centre + radius * (np.outer(np.cos(turn), up) + np.outer(np.sin(turn), forward))
    p.axes.plot(*rim.T, color=END, linewidth=1.8)
    p.arrow(centre, centre + 0.7 * axle, END)
    p.text(centre + 0.84 * axle, "axis", END)
    p.text(centre - 0.12 * axle, "P", END)
    for direction, name in (
        (forward, "x forward"),
        (np.cross(normal, forward), "y left"),
        (normal, "z normal"),
    ):
        p.arrow(contact, contact + 0.6 * direction, OWN)
        p.text(contact + 0.76 * direction, name)
    p.text(contact + np.array([0.02, -0.12, -0.1]), "C")
    top = centre + radius * up
    p.arrow(top, top + 0.4 * forward, END)  # of a positive spin


def knife_edge(p: Picture) -> None:
    """Draw a blade, its normal, and the only velocity it leaves."""
    _ground(p)
    r = turned("z", -25)
    p.frame((-0.7, -0.5, 0), UNITS, START, "", 0.5)
    at = np.array([0.1, 0.1, 0.0])
    edge = np.array([at - 0.45 * r[:, 0], at + 0.45 * r[:, 0]])
    face = np.array([*edge, edge[1] + [0, 0, 0.35], edge[0] + [0, 0, 0.35], edge[0]])
    p.axes.plot(*face.T, color=END, linewidth=1.8)
    p.arrow(at, at + 0.75 * r[:, 1], OWN)
    p.text(at + 0.95 * r[:, 1], "axis, lambda")
    p.arrow(at, at + 0.9 * r[:, 0], END)
    p.text(at + 1.04 * r[:, 0], "v", END)


def point_on_curve(p: Picture) -> None:
    """Draw a curve in start, its parameter, and the point of end."""
    p.frame((-0.5, -0.6, -0.3), UNITS, START, "", 0.7)
    origin = np.array([-0.5, -0.6, -0.3])
    s = np.linspace(0, 2.2, 80)
    curve = origin + np.column_stack([0.9 - 0.55 * s, 0.1 + 0.75 * s, 0.45 + 0.45 * np.sin(1.4 * s)])
    p.axes.plot(*curve.T, color=START, linewidth=1.8)
    point = curve[48]
    p.axes.plot(*curve[:49].T, color=OWN, linewidth=2.2)
    p.text(curve[24] + np.array([0, 0, 0.16]), "parameter")
    p.frame(point, turned("z", 40) @ turned("x", 30), END, "'", 0.4)
    p.arrow(origin, point, START)
    p.text((origin + point) / 2 + np.array([0, 0.0, -0.14]), "p", START)


CONSTRAINTS: Final[dict[str, Callable[[Picture], None]]] = {
    "rolling": rolling,
    "knife_edge": knife_edge,
    "point_on_curve": point_on_curve,
}


def drawn(name: str) -> Figure:
    """Return the picture of one constraint."""
    figure = plt.figure(figsize=(3.6, 3.6))
    axes = figure.add_axes((0, 0, 1, 1), projection="3d")
    assert isinstance(axes, Axes3D)
    CONSTRAINTS[name](Picture(axes, name.replace("_", " ")))
    return figure


def main(kind: str = "svg") -> None:
    """Write every picture, the same file for the same drawing."""
    plt.switch_backend("agg")
    plt.rcParams.update({"svg.hashsalt": "constraints", "svg.fonttype": "none", "font.family": "DejaVu Sans"})
    PICTURES.mkdir(exist_ok=True)
    for name in CONSTRAINTS:
        figure = drawn(name)
        metadata = {"Date": None} if kind == "svg" else None
        figure.savefig(PICTURES / f"constraint_{name}.{kind}", metadata=metadata, dpi=100)
        plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])
