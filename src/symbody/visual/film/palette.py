"""Colours of pictures: of bodies, connectors, ink and paper, by day and by night."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.visual.film.facets import Floats

# Soft relatives of the palette of Okabe and Ito: distinct to readers with any colour vision, and in print.
BODIES: Final = ("#4f8fc4", "#e08a3c", "#4da887", "#c987ad", "#d8b13a", "#79b8dd", "#8f7fc0", "#b9705c")
GROUND: Final = "#a9b0b8"
CONNECTORS: Final[Mapping[str, str]] = {
    "spring": "#9aa6b2",
    "damper": "#a4abb4",
    "rope": "#8a6d4b",
    "actuator": "#c2a14d",
    "line": "#6d7a86",
}
FORCE: Final = "#c62f3b"
TORQUE: Final = "#7a3fa0"
CONTACT: Final = "#d81b7a"
AXES: Final = ("#c8382e", "#2e8b45", "#2f63c2")  # x, y, z


@dataclass(frozen=True, slots=True)
class Paper:
    """What a picture is drawn on, and with what it is written: ``"#rrggbb"``."""

    background: str
    ink: str
    faint: str


LIGHT: Final = Paper("#ffffff", "#20262d", "#6b737c")
DARK: Final = Paper("#14181d", "#e8ebee", "#98a2ad")


def components(color: str) -> Floats:
    """Return red, green and blue from 0 to 1."""
    return np.array([int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])


def color_text(color: Floats) -> str:
    """Return components from 0 to 1 as ``"#rrggbb"``."""
    return "#" + "".join(f"{int(round(255 * min(max(float(each), 0.0), 1.0))):02x}" for each in color)


def blend(color: str, other: str, share: float) -> str:
    """Return a colour between two, the first at 0."""
    return color_text((1.0 - share) * components(color) + share * components(other))


def edge_color(color: Floats) -> Floats:
    """Return the colour of edges of bodies of a colour."""
    return 0.36 * color


def body_color(place: int) -> str:
    """Return the colour of a body, by its place among those of a scene; the ground's is grey."""
    return GROUND if place == 0 else BODIES[(place - 1) % len(BODIES)]
