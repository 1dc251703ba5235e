"""Outlines of involute gears and racks.

Buckingham, Analytical Mechanics of Gears (1949), chapter 4. The addendum is shorter than usual so that wheels
of few teeth do not undercut each other, and there is some backlash.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from symbody.visual.scene.scene import Floats

PRESSURE_ANGLE: Final = math.radians(20.0)
# In modules: height of teeth above the pitch circle, depth below it.
ADDENDUM, DEDENDUM = 0.75, 1.0
# Share of its thickness by which a tooth is thinner than the gap.
BACKLASH: Final = 0.04
_POINTS_OF_FLANK: Final = 5


def gear_outline(
    radius: float,
    teeth: int,
    addendum: float = ADDENDUM,
    dedendum: float = DEDENDUM,
    backlash: float = BACKLASH,
) -> Floats:
    """Return the outline (N, 2) of a wheel, counter-clockwise; one tooth is centred on the x axis.

    Parameters
    ----------
    radius : float
        Of the pitch circle [m].
    addendum, dedendum : float
        In modules.
    backlash : float
        Negative for what is cut out of a ring.
    """
    module = 2.0 * radius / teeth
    base = radius * math.cos(PRESSURE_ANGLE)
    root, tip = radius - dedendum * module, radius + addendum * module
    radii = np.linspace(max(base, root), tip, _POINTS_OF_FLANK)
    pressure = np.arccos(np.minimum(1.0, base / radii))
    half = (1.0 - backlash) * math.pi / (2 * teeth) + _involute(PRESSURE_ANGLE) - _involute(pressure)
    half = np.maximum(half, 0.02 * math.pi / teeth)
    if root < base:
        # A foot a little wider: seen from the centre no part of the outline is a point.
        radii, half = np.r_[root, radii], np.r_[half[0] + 0.04 * math.pi / teeth, half]
    flank_radii, angles = np.r_[radii, radii[::-1]], np.r_[-half, half[::-1]]
    centres = 2.0 * math.pi / teeth * np.arange(teeth)
    all_angles = (centres[:, np.newaxis] + angles).ravel()
    directions = np.stack([np.cos(all_angles), np.sin(all_angles)], axis=1)
    return np.asarray(np.tile(flank_radii, teeth)[:, np.newaxis] * directions)


def ring_outlines(radius: float, teeth: int) -> tuple[Floats, Floats]:
    """Return the inner and outer outlines (N, 2) of a ring with teeth inside; a gap is on the x axis."""
    inner = gear_outline(radius, teeth, DEDENDUM, ADDENDUM, -BACKLASH)
    module = 2.0 * radius / teeth
    angles = np.arctan2(inner[:, 1], inner[:, 0])
    outer = (radius + 3.0 * module) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return inner, outer


def rack_tooth(pitch: float) -> Floats:
    """Return the outline (4, 2) of a tooth of a rack that points along y, its pitch line being y = 0."""
    module = pitch / math.pi
    slope = math.tan(PRESSURE_ANGLE)
    low, high = -DEDENDUM * module, ADDENDUM * module
    half = 0.25 * (1.0 - BACKLASH) * pitch
    return np.array([
        [-half + slope * low, low], [half - slope * low, low],
        [half - slope * high, high], [-half + slope * high, high],
    ])  # fmt: skip


def _involute(angle: float | Floats) -> Floats:
    return np.asarray(np.tan(angle) - angle)
