"""Where a formula in x, y, z vanishes, as a mesh: marching tetrahedra.

Doi & Koide, An efficient method of triangulating equi-valued surfaces by using tetrahedral cells (1991).
"""

from __future__ import annotations

from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.expr.language.formula import Formula
from symbody.visual.scene.numbers import ModelNumbers
from symbody.visual.scene.scene import Floats, SceneMesh

# A cube's corners by their bits x, y, z; six tetrahedra about the diagonal from 0 to 7.
_TETRAHEDRA: Final = (
    (0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7),
)  # fmt: skip


def level_surface(
    numbers: ModelNumbers, equation: Formula, middle: Floats, reach: float, cells: int
) -> SceneMesh | None:
    """Return the surface on which a formula vanishes inside a cube, or None if there is none.

    Parameters
    ----------
    middle : (3,) array
        Of the cube; `reach` is half its edge.
    cells : int
        Cells along each edge.
    """
    ticks = np.linspace(-reach, reach, cells + 1)
    # The grid stands a little aside, so that no corner lies on a plane through the middle.
    grid = np.stack(np.meshgrid(ticks, ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    points = middle + 1e-4 * reach * np.array([0.37, 0.53, 0.71]) + grid
    values = numbers.samples((equation,), ("x", "y", "z"), points)[:, 0]
    values[~np.isfinite(values)] = np.nan
    corners = _cells(cells)
    triangles = [
        _cut_tetrahedra(corners[:, list(tetrahedron)], values, points) for tetrahedron in _TETRAHEDRA
    ]
    soup = np.vstack(triangles)
    if not len(soup):
        return None
    places = np.round(soup.reshape(-1, 3) / (1e-7 * reach)).astype(np.int64)
    _, first, numbering = np.unique(places, axis=0, return_index=True, return_inverse=True)
    vertices = soup.reshape(-1, 3)[first]
    mesh = numbering.reshape(-1, 3)
    is_proper = (mesh[:, 0] != mesh[:, 1]) & (mesh[:, 1] != mesh[:, 2]) & (mesh[:, 2] != mesh[:, 0])
    return SceneMesh(vertices, mesh[is_proper].astype(np.int32))


def _cells(count: int) -> NDArray[np.int64]:
    """Return the corners (N, 8) of all cells as numbers of grid points."""
    steps = np.arange(count)
    x, y, z = (axis.ravel() for axis in np.meshgrid(steps, steps, steps, indexing="ij"))
    side = count + 1
    bits = [((k & 1), (k >> 1) & 1, (k >> 2) & 1) for k in range(8)]
    return np.stack([((x + a) * side + y + b) * side + z + c for a, b, c in bits], axis=1)


def _cut_tetrahedra(tetrahedra: NDArray[np.int64], values: Floats, points: Floats) -> Floats:
    """Return triangles (N, 3, 3) in which a value of zero cuts tetrahedra (M, 4)."""
    inside = values[tetrahedra] < 0.0
    finite = np.all(np.isfinite(values[tetrahedra]), axis=1)
    count = inside.sum(axis=1)
    result = [np.zeros((0, 3, 3))]
    for corner in range(4):  # one corner on its own side
        others = [k for k in range(4) if k != corner]
        for is_alone, number in ((True, 1), (False, 3)):
            rows = tetrahedra[finite & (count == number) & (inside[:, corner] == is_alone)]
            result.append(_triangle(rows, [(corner, k) for k in others], values, points))
    for pair in combinations(range(4), 2):  # two on each side
        a, b = pair
        c, d = (k for k in range(4) if k not in pair)
        rows = tetrahedra[finite & (count == 2) & inside[:, a] & inside[:, b]]
        result.append(_triangle(rows, [(a, c), (a, d), (b, d)], values, points))
        result.append(_triangle(rows, [(a, c), (b, d), (b, c)], values, points))
    return np.vstack(result)


def _triangle(
    rows: NDArray[np.int64], edges: list[tuple[int, int]], values: Floats, points: Floats
) -> Floats:
    """Return triangles whose corners are on edges of tetrahedra."""
    corners = []
    for first, second in edges:
        low, high = values[rows[:, first]], values[rows[:, second]]
        share = (low / (low - high))[:, np.newaxis]
        corners.append(points[rows[:, first]] * (1.0 - share) + points[rows[:, second]] * share)
    return np.stack(corners, axis=1) if len(rows) else np.zeros((0, 3, 3))
