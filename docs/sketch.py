"""`Picture`: bodies drawn by symbody's renderer, with arrows, angles and words over them."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.visual.film.annotations import arrow
from symbody.visual.film.camera import Camera
from symbody.visual.film.drawing import Caption, Drawing, Mark, Stroke
from symbody.visual.film.files.svg import svg_text
from symbody.visual.film.pictures import TONE_WIDTH
from symbody.visual.film.stage import make_stage, pose_at, stage_at
from symbody.visual.film.surfaces.layer import Grid
from symbody.visual.film.surfaces.painting import make_backdrop, paint
from symbody.visual.scene.scene import Scene, SceneBody, SceneMesh, SceneMotion, Solid

Array = NDArray[np.float64]

PICTURES: Final = Path(__file__).parent / "pictures"
START, END, OWN = "#6b727b", "#1f5fa8", "#c2410c"  # start frame, end frame, coordinates
GREY, BLUE, DARK = "#ccd1d7", "#a9c8ea", "#8d97a3"  # bodies of start, of end, between them
UNITS: Final = np.eye(3)
LETTERS: Final = {"x": UNITS[0], "y": UNITS[1], "z": UNITS[2]}
SIZE: Final = 225.0  # points: width and height of a picture
SAMPLES: Final = 6.0  # in a point


def turned(axis: Array | str, degrees: float) -> Array:
    """Return the matrix of a turn (Rodrigues)."""
    x, y, z = LETTERS[axis] if isinstance(axis, str) else axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    matrix: Array = UNITS + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    return matrix


def _camera() -> Camera:
    up, round_z = np.radians(24.0), np.radians(38.0)
    eye = np.array([np.cos(up) * np.cos(round_z), np.cos(up) * np.sin(round_z), np.sin(up)])
    right = np.array([-np.sin(round_z), np.cos(round_z), 0.0])
    axes = np.stack([right, np.cross(eye, right), eye])
    return Camera(axes, np.array([0.1, 0.1, 0.24]), np.array([SIZE / 2, SIZE / 2 + 8]), 82.0)


class Picture:
    """One joint or constraint in an orthogonal view; arrows in the colours of what they belong to."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.camera = _camera()
        self.solids: list[Solid] = []
        self.meshes: list[SceneMesh] = []
        self.marks: list[Mark] = []

    # bodies

    def box(self, at: ArrayLike, size: tuple[float, ...], color: str, r: Array = UNITS) -> None:
        """Draw a box about a point."""
        self._solid("box", size, at, r, color)

    def sphere(self, at: ArrayLike, radius: float, color: str) -> None:
        """Draw a ball."""
        self._solid("sphere", (radius,), at, UNITS, color)

    def rod(self, a: ArrayLike, b: ArrayLike, radius: float, color: str) -> None:
        """Draw a cylinder from a point to a point."""
        start, end = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length
        side = np.cross(along, UNITS[np.argmin(np.abs(along))])
        side /= np.linalg.norm(side)
        r = np.stack([side, np.cross(along, side), along], axis=1)
        self._solid("cylinder", (radius, length), (start + end) / 2, r, color)

    def ring(self, at: ArrayLike, axis: Array, radius: float, color: str, thick: float = 0.035) -> None:
        """Draw a ring about an axis."""
        side = np.cross(axis, UNITS[np.argmin(np.abs(axis))])
        side /= np.linalg.norm(side)
        turn = np.linspace(0, 2 * np.pi, 73)
        circle = np.outer(np.cos(turn), side) + np.outer(np.sin(turn), np.cross(axis, side))
        self.tube(np.asarray(at) + radius * circle, circle, thick, color)

    def tube(self, points: Array, outwards: Array, radius: float, color: str) -> None:
        """Draw a bar of round section along points; directions out of its bend say how it is turned."""
        tangents = np.gradient(points, axis=0)
        if np.allclose(points[0], points[-1]):
            tangents[[0, -1]] = points[1] - points[-2]
        tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
        first = outwards - np.sum(outwards * tangents, axis=1, keepdims=True) * tangents
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(tangents, first)
        turn = 2 * np.pi * np.arange(12) / 12
        rings = np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
        self.surface(points[:, None] + radius * rings, color, closes=True)

    def surface(self, points: Array, color: str, closes: bool = False) -> None:
        """Draw a surface through a grid of points (rows, columns, 3), perhaps closed along its rows."""
        rows, columns = points.shape[:2]
        row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns - (not closes)), indexing="ij")
        ahead = (column + 1) % columns
        a, b = row * columns + column, row * columns + ahead
        quads = np.stack([a, b, b + columns, a, b + columns, a + columns], axis=-1)
        self.meshes.append(SceneMesh(points.reshape(-1, 3), quads.reshape(-1, 3).astype(np.int32)))
        self.solids.append(Solid("", "mesh", (1, 1, 1), mesh=len(self.meshes) - 1, color=color))

    def _solid(self, kind: str, size: tuple[float, ...], at: ArrayLike, r: Array, color: str) -> None:
        x, y, z = np.asarray(at, dtype=float)
        self.solids.append(Solid("", kind, size, (x, y, z), _quaternion(r), color=color))  # type: ignore[arg-type]

    # what is over them

    def frame(
        self, at: ArrayLike, r: Array, colour: str, mark: str, length: float = 0.9, unnamed: str = ""
    ) -> None:
        """Draw three axes; the names of those of end have a dash. Where two coincide one goes `unnamed`."""
        origin = np.array(at, dtype=float)
        for k, letter in enumerate("xyz"):
            self.arrow(origin, origin + length * r[:, k], colour, 1.1)
            if letter not in unnamed:
                self.text(origin + (length + 0.11) * r[:, k], letter + mark, colour)

    def arrow(self, a: Array, b: Array, colour: str, width: float = 1.8) -> None:
        """Draw an arrow from a point to a point."""
        start, end = self.camera.project(np.stack([a, b]))[:, :2]
        self.marks += arrow(start, end, colour, width)

    def curve(self, points: ArrayLike, colour: str, width: float = 0.8, dashed: bool = False) -> None:
        """Draw a line through points (N, 3)."""
        flat = self.camera.project(np.asarray(points, dtype=float))[:, :2]
        self.marks.append(Stroke((flat,), colour, width, dashed=dashed))

    def line(self, a: Array, b: Array) -> None:
        """Draw a dashed line along which something slides or about which it turns."""
        self.curve([a, b], OWN, 0.8, dashed=True)

    def text(self, at: ArrayLike, words: str, colour: str = OWN, size: float = 9.0) -> None:
        """Write with a white rim."""
        x, y = self.camera.project(np.asarray(at, dtype=float))[:2]
        self.marks.append(Caption((x, y + 0.35 * size), words, size, colour, "middle", halo="#ffffff"))

    def slide(self, a: ArrayLike, b: ArrayLike, name: str, away: ArrayLike = (0, 0, 0.13)) -> None:
        """Draw a displacement between two points, its name beside the middle."""
        start, end = np.array(a, dtype=float), np.array(b, dtype=float)
        self.arrow(start, end, OWN)
        self.text((start + end) / 2 + np.array(away), name)

    def angle(
        self, at: ArrayLike, axis: Array, first: Array, degrees: float, name: str, radius: float,
        outside: float = 0.16,
    ) -> None:  # fmt: skip
        """Draw an arc from a direction about an axis, and its name outside of the middle."""
        origin, along = np.array(at, dtype=float), axis / np.linalg.norm(axis)
        arc = np.array([origin + radius * turned(along, x) @ first for x in np.linspace(0, degrees, 40)])
        self.curve(arc[:-3], OWN, 1.6)
        self.arrow(arc[-9], arc[-1], OWN, 1.6)
        self.text(origin + (radius + outside) * turned(along, degrees / 2) @ first, name)

    def drawing(self) -> Drawing:
        """Return the picture."""
        size = round(SIZE * SAMPLES)
        scene = Scene(
            self.title, 2.0, (0, 0, 1), None, None, (SceneBody("ground", (), tuple(self.solids)),),
            meshes=tuple(self.meshes),
        )  # fmt: skip
        motion = SceneMotion(np.zeros(1), np.zeros((1, 0, 3)), np.zeros((1, 0, 4)))
        stage = make_stage(scene, motion)
        backdrop = make_backdrop(stage, self.camera, Grid((size, size), SAMPLES), "#ffffff", TONE_WIDTH)
        samples, strokes = paint(backdrop, [stage_at(stage, pose_at(motion, 0))], 0.0)
        title = Caption((SIZE / 2, 14.0), self.title, 10.0, "#20262d", "middle")
        return Drawing((SIZE, SIZE), "#ffffff", samples, (*strokes, *self.marks, title))

    def save(self, name: str) -> None:
        """Write the picture as SVG, the same file for the same drawing."""
        (PICTURES / f"{name}.svg").write_text(svg_text(self.drawing(), self.title), encoding="utf-8")


def _quaternion(r: Array) -> tuple[float, float, float, float]:
    """Return the quaternion of a rotation matrix, from the eigenvector of its symmetric form."""
    k = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    w, x, y, z = np.linalg.eigh(k)[1][:, -1]
    return float(w), float(x), float(y), float(z)
