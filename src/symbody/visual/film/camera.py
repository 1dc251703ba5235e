"""`Camera`: from points of the mechanism to points of the picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from symbody.errors import Problem, UsageError, nearest
from symbody.visual.film.facets import Floats, unit
from symbody.visual.scene.scene import Scene

View = str | Sequence[float] | Mapping[str, Any]

# Components along right, forward and up: towards the eye, and what is drawn upwards.
VIEWS: Final[Mapping[str, tuple[tuple[int, int, int], tuple[int, int, int]]]] = {
    "front": ((0, -1, 0), (0, 0, 1)),
    "back": ((0, 1, 0), (0, 0, 1)),
    "left": ((-1, 0, 0), (0, 0, 1)),
    "right": ((1, 0, 0), (0, 0, 1)),
    "top": ((0, 0, 1), (0, 1, 0)),
    "bottom": ((0, 0, -1), (0, -1, 0)),
    "isometric": ((1, -1, 1), (0, 0, 1)),
}
KEYS: Final = ("direction", "up", "zoom", "perspective")
FIELD: Final = np.radians(32.0)  # that a perspective picture spans


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """How points are projected.

    Attributes
    ----------
    axes : (3, 3) array
        Rows: to the right, upwards and towards the eye, in ground's axes.
    center : (3,) array
        The point that the camera looks at [m].
    middle : (2,) array
        Where that point is drawn, from the upper left corner [pt].
    scale : float
        Points of the picture for a metre at `center` [pt/m].
    distance : float
        From the eye to `center` [m]; 0 for parallel projection.
    """

    axes: Floats
    center: Floats
    middle: Floats
    scale: float
    distance: float = 0.0

    def project(self, points: Floats) -> Floats:
        """Return points (..., 3) [m] as x rightwards [pt], y downwards [pt] and depth from the eye [m].

        In perspective the depth is bent so that a plane of space stays a plane.
        """
        right, up, near = np.moveaxis((points - self.center) @ self.axes.T, -1, 0)
        factor = self.scale * np.ones_like(near)
        depth = -near
        if self.distance:
            shrink = self.distance / (self.distance - near)
            factor, depth = factor * shrink, self.distance * (1.0 - shrink)
        return np.stack([self.middle[0] + factor * right, self.middle[1] - factor * up, depth], axis=-1)


def fit_camera(
    scene: Scene, view: View | None, points: Floats, size: tuple[float, float], margin: float
) -> Camera:
    """Return the camera of a view that shows all points (N, 3) [m] on a picture of a size [pt].

    Raises
    ------
    UsageError
        If there is no such view.
    """
    axes, zoom, is_perspective = _view_of(scene, view)
    low, high = points.min(axis=0), points.max(axis=0)
    center = (low + high) / 2
    radius = max(float(np.linalg.norm(points - center, axis=1).max()), 1e-9)
    distance = radius / np.sin(FIELD / 2) if is_perspective else 0.0
    plain = Camera(axes, center, np.zeros(2), 1.0, distance)
    flat = plain.project(points)[:, :2]
    left, right = flat.min(axis=0), flat.max(axis=0)
    span = np.maximum(right - left, 1e-3 * radius)
    room = np.maximum(np.array(size) - 2 * margin, 1.0)
    scale = zoom * float((room / span).min())
    return Camera(axes, center, np.array(size) / 2 - scale * (left + right) / 2, scale, distance)


def _view_of(scene: Scene, view: View | None) -> tuple[Floats, float, bool]:
    """Return axes of the camera, zoom and whether distant things look smaller."""
    if isinstance(view, Mapping):
        unknown = [key for key in view if key not in KEYS]
        if unknown:
            raise _no_view(f"has no {unknown[0]!r}", nearest(str(unknown[0]), KEYS))
        zoom = view.get("zoom", 1.0)
        if isinstance(zoom, bool) or not isinstance(zoom, int | float) or not 0.0 < zoom < 1e6:
            raise _no_view(f"cannot have zoom = {zoom!r}", "give a number above 0, such as 2")
        up = None if view.get("up") is None else _direction(view["up"])
        return _axes_of(scene, view.get("direction"), up), float(zoom), bool(view.get("perspective", False))
    return _axes_of(scene, view, None), 1.0, False


def _axes_of(scene: Scene, view: Any, up: Floats | None) -> Floats:
    right, forward, above = _home_axes(np.array(scene.up))
    if view is None:
        if scene.normal is not None:
            return _camera_axes(np.array(scene.normal), above if up is None else up, forward)
        view = "isometric"
    if isinstance(view, str):
        if view not in VIEWS:
            raise _no_view(f"cannot be {view!r}", nearest(view, VIEWS))
        eye, top = (np.array(each) @ np.stack([right, forward, above]) for each in VIEWS[view])
        return _camera_axes(eye, top if up is None else up, forward)
    return _camera_axes(_direction(view), above if up is None else up, forward)


def _home_axes(up: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the directions right, ahead and up of a viewer in front of the mechanism."""
    x, y = np.eye(3)[:2]
    side = x if abs(up @ x) < 0.9 else y
    right = unit(side - (side @ up) * up)
    return right, np.cross(up, right), up


def _camera_axes(eye: Floats, up: Floats, second_up: Floats) -> Floats:
    towards = unit(eye)
    above = up - (up @ towards) * towards
    if np.linalg.norm(above) < 1e-6:
        above = second_up - (second_up @ towards) * towards
    above = unit(above)
    return np.stack([np.cross(above, towards), above, towards])


def _direction(value: Any) -> Floats:
    try:
        vector = np.array([float(each) for each in value])
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not np.linalg.norm(vector) > 0.0:
        fix = "give one of " + ", ".join(VIEWS) + ", or three components towards the eye, such as (1, -1, 1)"
        raise _no_view(f"has no direction {value!r}", fix)
    return unit(vector)


def _no_view(what: str, fix: str) -> UsageError:
    return UsageError(Problem("film.view", "view", f"a view {what}", fix=fix))
