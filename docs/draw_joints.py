"""Draw the joints with bodies and coordinates: `python docs/draw_joints.py` writes docs/pictures/*.svg."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike
from sketch import BLUE, DARK, END, GREY, LETTERS, OWN, START, UNITS, Array, Picture, turned


def weld(p: Picture) -> None:
    """Draw the weld: both frames are one."""
    p.box((0, 0, -0.16), (0.6, 0.6, 0.3), GREY)
    p.box((0, 0, 0.14), (0.42, 0.42, 0.3), BLUE)
    p.frame((0, 0, 0), UNITS, START, "", 1.05, unnamed="xyz")
    p.frame((0, 0, 0), UNITS, END, "'", 0.7, unnamed="xyz")
    for k, letter in enumerate("xyz"):
        p.text(1.22 * UNITS[k], f"{letter} = {letter}'", END)


def revolute(p: Picture) -> None:
    """Draw the revolute joint."""
    r = turned("z", 40)
    p.rod((0, 0, -0.5), (0, 0, -0.1), 0.3, GREY)
    p.rod((0, 0, -0.1), (0, 0, 0.3), 0.1, GREY)
    p.rod((0, 0, -0.08), (0, 0, 0.12), 0.22, BLUE)
    p.box(0.45 * r[:, 0] + [0, 0, 0.02], (0.6, 0.16, 0.16), BLUE, r)
    p.line(-0.3 * UNITS[2], 1.1 * UNITS[2])
    p.frame((0, 0, 0), UNITS, START, "", unnamed="z")
    p.frame((0, 0, 0), r, END, "'", unnamed="z")
    p.text(1.22 * UNITS[2], "z = z'", END)
    p.angle((0, 0, 0), UNITS[2], UNITS[0], 40, "theta", 0.6)


def prismatic(p: Picture) -> None:
    """Draw the prismatic joint."""
    start, end = np.array([0, -0.5, 0]), np.array([0, 0.65, 0])
    p.box((0, 0.15, -0.12), (0.3, 2.0, 0.08), GREY)
    p.box((0, 0.15, -0.04), (0.12, 2.0, 0.1), GREY)
    p.box(end + [0, 0, 0.02], (0.4, 0.4, 0.2), BLUE)
    p.line(start - 0.2 * UNITS[1], end + 0.75 * UNITS[1])
    p.frame(start, UNITS, START, "", 0.6, unnamed="y")
    p.frame(end, UNITS, END, "'", 0.6)
    p.slide(start, end, "s", (0.0, 0.0, -0.16))


def screw(p: Picture) -> None:
    """Draw the screw joint."""
    turn = np.linspace(0, 14 * np.pi, 400)
    outwards = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    p.tube(0.1 * outwards + np.outer(np.linspace(-0.6, 0.62, 400), UNITS[2]), outwards, 0.022, GREY)
    _on_axis(p, "s = pitch theta / 2 pi", (0.0, 0.72, -0.02))


def cylindrical(p: Picture) -> None:
    """Draw the cylindrical joint."""
    _on_axis(p, "s", (0.0, 0.13, 0.0))


def _on_axis(p: Picture, slide: str, away: ArrayLike) -> None:
    """End turned about z and moved along it."""
    low, top = np.array([0, 0, -0.65]), np.array([0, 0, 0.2])
    r = turned("z", 50)
    p.rod(low - [0, 0, 0.12], low, 0.32, GREY)
    p.rod(low, top + [0, 0, 0.45], 0.09, GREY)
    p.rod(top - [0, 0, 0.1], top + [0, 0, 0.1], 0.24, BLUE)
    p.box(top + 0.45 * r[:, 0], (0.5, 0.15, 0.14), BLUE, r)
    p.line(low - 0.25 * UNITS[2], top + 0.8 * UNITS[2])
    p.frame(low, UNITS, START, "", 0.65, unnamed="z")
    p.frame(top, r, END, "'", 0.65, unnamed="z")
    p.text(top + 0.9 * UNITS[2], "z = z'", END)
    p.slide(low, top, slide, away)
    p.curve([top, top + 0.6 * UNITS[0]], START, dashed=True)
    p.angle(top, UNITS[2], UNITS[0], 50, "theta", 0.42)


def universal(p: Picture) -> None:
    """Draw the universal joint."""
    first = turned("x", 32)
    second = first @ turned("y", 30)
    p.rod((0, 0, -0.75), (0, 0, -0.4), 0.11, GREY)
    p.box((0, 0, -0.36), (0.72, 0.18, 0.1), GREY)
    for side in (-1, 1):
        p.box((0.32 * side, 0, -0.14), (0.08, 0.18, 0.44), GREY)
        p.box(second @ [0, 0.32 * side, 0.14], (0.18, 0.08, 0.44), BLUE, second)
    p.box(second @ [0, 0, 0.36], (0.18, 0.72, 0.1), BLUE, second)
    p.rod(second @ [0, 0, 0.4], second @ [0, 0, 0.7], 0.11, BLUE)
    p.rod(-0.4 * UNITS[0], 0.4 * UNITS[0], 0.05, DARK)
    p.rod(-0.4 * first[:, 1], 0.4 * first[:, 1], 0.05, DARK)
    p.line(-0.6 * UNITS[0], 0.9 * UNITS[0])
    p.line(-0.6 * first[:, 1], 0.9 * first[:, 1])
    p.frame((0, 0, 0), UNITS, START, "")
    p.frame((0, 0, 0), second, END, "'", 1.05)
    p.angle((0, 0, 0), UNITS[0], UNITS[1], 32, "a", 0.5)
    p.angle((0, 0, 0), first[:, 1], first[:, 2], 30, "b", 0.62)
    p.curve([0 * UNITS[0], 0.85 * first[:, 2]], START, dashed=True)


def constant_velocity(p: Picture) -> None:
    """Draw the constant velocity joint."""
    azimuth, bend = 80.0, 50.0
    r = turned("z", azimuth) @ turned("y", bend) @ turned("z", -azimuth)
    lean = turned("z", azimuth)[:, 0]
    p.rod((0, 0, -0.8), (0, 0, -0.1), 0.11, GREY)
    p.rod((0, 0, -0.3), (0, 0, -0.02), 0.32, GREY)
    p.sphere((0, 0, 0), 0.24, BLUE)
    p.rod((0, 0, 0), 0.75 * r[:, 2], 0.1, BLUE)
    p.frame((0, 0, 0), UNITS, START, "")
    p.frame((0, 0, 0), r, END, "'", 1.05)
    p.curve([0 * lean, 0.85 * lean], OWN, dashed=True)
    p.angle((0, 0, 0), UNITS[2], UNITS[0], azimuth, "azimuth", 0.5)
    p.angle((0, 0, 0), turned("z", azimuth)[:, 1], UNITS[2], bend, "bend", 0.7, outside=0.2)


def pin_slot(p: Picture) -> None:
    """Draw the pin slot joint."""
    start, at = np.array([0, -0.4, 0]), np.array([0, 0.6, 0])
    r = turned("z", 40)
    p.box((0, 0.15, -0.14), (0.5, 1.9, 0.06), GREY)
    for side in (-1, 1):
        p.box((0.17 * side, 0.15, -0.06), (0.14, 1.9, 0.1), GREY)
    p.rod(at - [0, 0, 0.1], at + [0, 0, 0.12], 0.1, BLUE)
    p.box(at + 0.3 * r[:, 0] + [0, 0, 0.08], (0.8, 0.18, 0.1), BLUE, r)
    p.line(start - 0.2 * UNITS[1], at + 0.6 * UNITS[1])
    p.frame(start, UNITS, START, "", 0.55, unnamed="y")
    p.text(at + 0.72 * UNITS[1], "y", START)
    p.frame(at, r, END, "'", 0.6)
    p.slide(start, at, "s", (0.0, 0.0, -0.16))
    p.curve([at, at + 0.55 * UNITS[0]], START, dashed=True)
    p.angle(at, UNITS[2], UNITS[0], 40, "theta", 0.4)


def planar(p: Picture) -> None:
    """Draw the planar joint."""
    at, r = np.array([0.75, 0.85, 0.0]), turned("z", 40)
    p.box(at, (0.4, 0.4, 0.16), BLUE, r)
    _table(p, at)
    p.frame(at, r, END, "'", 0.55)
    p.curve([at, at + 0.5 * UNITS[0]], START, dashed=True)
    p.angle(at, UNITS[2], UNITS[0], 40, "theta", 0.38)


def rectangular(p: Picture) -> None:
    """Draw the rectangular joint."""
    at = np.array([0.75, 0.85, 0.0])
    p.box(at, (0.4, 0.4, 0.16), BLUE)
    _table(p, at)
    p.frame(at, UNITS, END, "'", 0.55)


def _table(p: Picture, at: Array) -> None:
    """Two displacements in the plane of x and y."""
    corner = np.array([at[0], 0, 0])
    p.box((0.35, 0.4, -0.12), (1.7, 1.8, 0.08), GREY)
    p.frame((0, 0, 0), UNITS, START, "", 1.05)
    p.slide((0, 0, 0), corner, "X", (0.0, -0.14, 0.0))
    p.slide(corner, at, "Y", (0.14, 0.0, 0.0))


def cartesian(p: Picture) -> None:
    """Draw the cartesian joint."""
    x, y, z = 0.85, 0.9, 0.5
    p.box((0.4, 0, -0.09), (1.5, 0.14, 0.1), GREY)
    p.box((x, 0.45, -0.02), (0.12, 1.3, 0.1), GREY)
    p.box((x - 0.1, y, 0.3), (0.1, 0.12, 0.9), GREY)
    p.box((x, y, z), (0.2, 0.2, 0.2), BLUE)
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
    if sequence == "313":
        _ball(p)
    else:
        _gimbal_rings(p)
    p.frame((0, 0, 0), UNITS, START, "")
    r = _turns(p, np.zeros(3), sequence, names)
    p.frame((0, 0, 0), r, END, "'", 1.05)


def _ball(p: Picture) -> None:
    r = turned("z", 42) @ turned("x", 42) @ turned("z", 42)
    p.rod((0, 0, -0.7), (0, 0, -0.3), 0.1, GREY)
    p.rod((0, 0, -0.32), (0, 0, -0.08), 0.3, GREY)
    p.sphere((0, 0, 0), 0.25, BLUE)
    p.rod((0, 0, 0), 0.8 * r[:, 2], 0.09, BLUE)


def _gimbal_rings(p: Picture) -> None:
    one = turned("x", 42)
    two = one @ turned("y", 42)
    r = two @ turned("z", 42)
    p.ring((0, 0, 0), UNITS[1], 0.62, GREY)
    p.ring((0, 0, 0), one[:, 2], 0.52, DARK, 0.03)
    p.ring((0, 0, 0), two[:, 0], 0.42, DARK, 0.03)
    p.rod(-0.62 * UNITS[0], -0.5 * UNITS[0], 0.04, GREY)
    p.rod(0.5 * UNITS[0], 0.62 * UNITS[0], 0.04, GREY)
    p.rod(-0.42 * two[:, 2], 0.42 * two[:, 2], 0.035, BLUE)
    p.box((0, 0, 0), (0.3, 0.3, 0.22), BLUE, r)


def _turns(p: Picture, at: Array, sequence: str, names: Sequence[str], size: float = 1.0) -> Array:
    r = UNITS
    for k, (digit, name) in enumerate(zip(sequence, names, strict=True)):
        axis = "xyz"[int(digit) - 1]
        j = (int(digit) + (k == 2 and sequence == "123")) % 3
        if sequence == "313":
            j = (0, 2, 0)[k]
        p.angle(at, r @ LETTERS[axis], r[:, j], 42, name, size * (0.45, 0.62, 0.75)[k])
        r = r @ turned(axis, 42)
        p.curve([at, at + 0.85 * size * r[:, j]], START, dashed=True)
    return r


def bearing(p: Picture) -> None:
    """Draw the bearing joint."""
    low, at = np.array([0, 0, -0.6]), np.array([0, 0, 0.05])
    end = turned("x", 42) @ turned("y", 42) @ turned("z", 42)
    p.rod(low - [0, 0, 0.1], at + [0, 0, 0.8], 0.08, GREY)
    p.sphere(at, 0.19, BLUE)
    p.ring(at, end[:, 2], 0.3, BLUE, 0.05)
    p.rod(at, at + 0.3 * end[:, 0], 0.05, BLUE)
    p.rod(at, at - 0.3 * end[:, 0], 0.05, BLUE)
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
    p.rod(low - [0, 0, 0.4], low - [0, 0, 0.1], 0.2, GREY)
    p.sphere(low, 0.15, GREY)
    p.rod(low, at, 0.06, DARK)
    p.rod(at - 0.35 * r[:, 0], at + 0.2 * r[:, 0], 0.13, BLUE)
    p.line(low - 0.25 * r[:, 0], at + 0.6 * r[:, 0])
    p.frame(low, UNITS, START, "", 0.75)
    p.frame(at, r @ turned("x", 30), END, "'", 0.45, unnamed="x")
    p.text(at + 0.72 * r[:, 0], "x'", END)
    p.slide(low, at, "s", (0.0, 0.0, 0.14))
    flat = turned("z", 80)
    p.curve([low, low + 0.75 * flat[:, 0]], START, dashed=True)
    p.angle(low, UNITS[2], UNITS[0], 80, "a", 0.4)
    p.angle(low, -flat[:, 1], flat[:, 0], 32, "b", 0.62)
    p.curve([at, at + 0.45 * r[:, 2]], START, dashed=True)
    p.angle(at, r[:, 0], r[:, 2], 30, "c", 0.36)


def free(p: Picture) -> None:
    """Draw the free joint."""
    at, r = np.array([0.8, 1.0, 0.35]), turned("z", 30) @ turned("y", -25) @ turned("x", 20)
    p.box((0, 0, -0.08), (0.5, 0.5, 0.12), GREY)
    p.box(at, (0.4, 0.3, 0.24), BLUE, r)
    p.frame((0, 0, 0), UNITS, START, "", 0.8)
    p.slide((0, 0, 0), (0.8, 0, 0), "x", (0.0, -0.14, 0.0))
    p.slide((0.8, 0, 0), (0.8, 1.0, 0), "y", (0.14, 0.0, 0.0))
    p.slide((0.8, 1.0, 0), at, "z", (0.0, 0.12, -0.05))
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


def main() -> None:
    """Write every picture."""
    for joint in JOINTS:
        picture = Picture(joint.__name__.replace("_", " "))
        joint(picture)
        picture.save(joint.__name__)


if __name__ == "__main__":
    main()
