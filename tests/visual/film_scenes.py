"""Small scenes made by hand, with closed forms for what is seen."""

from __future__ import annotations

import numpy as np

from symbody.visual.scene.scene import Connector, Scene, SceneBody, SceneFrame, SceneMotion, Solid

Body = tuple[str, tuple[Solid, ...]]


def scene_of(
    *bodies: Body,
    ground: tuple[Solid, ...] = (),
    connectors: tuple[Connector, ...] = (),
    normal: tuple[float, float, float] | None = None,
) -> Scene:
    frame = SceneFrame("tip", (0.5, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    made = [SceneBody(name, (frame,), solids) for name, solids in bodies]
    first = SceneBody("ground", (), ground)
    return Scene("test", 2.0, (0.0, 0.0, 1.0), normal, (0.0, 0.0, -9.81), (first, *made), connectors)


def motion_of(*places: tuple[tuple[float, float, float], ...]) -> SceneMotion:
    """Return the motion through places, a tuple for each time that has one for each body."""
    count, bodies = len(places), len(places[0])
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (count, bodies, 1))
    return SceneMotion(
        0.1 * np.arange(count), np.array(places, dtype=float).reshape(count, bodies, 3), quaternions
    )


def ball(radius: float = 1.0, color: str = "#4080c0", opacity: float = 1.0) -> tuple[Solid, ...]:
    return (Solid("ball", "sphere", (radius,), color=color, opacity=opacity),)


def box(*size: float, color: str = "#c04040", opacity: float = 1.0) -> tuple[Solid, ...]:
    return (Solid("box", "box", size, color=color, opacity=opacity),)
