"""Shapes of what is stretched between two points: coils, dampers, actuators, and ropes that hang."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
from scipy.optimize import brentq

from symbody.visual.film.facets import Facets, Floats, facets_of, join_facets, unit
from symbody.visual.film.solid_facets import facets_of_solid, grid_triangles
from symbody.visual.scene.scene import Connector, Solid

PER_TURN: Final = 20  # points of a coil
SIDES: Final = 8  # of the wire
WIRE: Final = 0.16  # of the radius of a coil
LEAD: Final = 0.1  # of a spring's length at each end is straight
HANGING: Final = 40  # points of a rope
_UNIT: Final = Solid("", "cylinder", (1.0, 1.0))
_STEEPEST: Final = (
    18.0  # half the span of a hanging rope, in its parameter; beyond it both halves are vertical
)


def coil_points(start: Floats, end: Floats, radius: float, coils: int, side: Floats) -> tuple[Floats, Floats]:
    """Return points (N, 3) along the wire of a spring, and directions (N, 3) out of its axis.

    Its turns have the full radius but for the first and the last quarter, where it comes from the axis.
    """
    along = end - start
    count = coils * PER_TURN
    turn = 2 * np.pi * coils * np.arange(count + 1) / count
    quarters = np.minimum(turn, 2 * np.pi * coils - turn) / (np.pi / 2)
    share = np.concatenate([[0.0], LEAD + (1 - 2 * LEAD) * turn / turn[-1], [1.0]])
    angle = np.concatenate([turn[:1], turn, turn[-1:]])
    radii = radius * np.concatenate([[0.0], np.sin(np.pi / 2 * np.clip(quarters, 0.0, 1.0)), [0.0]])
    second = np.cross(unit(along), side)
    outwards = np.outer(np.cos(angle), side) + np.outer(np.sin(angle), second)
    return start + np.outer(share, along) + radii[:, np.newaxis] * outwards, outwards


def coil(start: Floats, end: Floats, connector: Connector, side: Floats) -> Facets:
    """Return a spring as a wire, without outlines, which are as wide and would hide its colour."""
    points, outwards = coil_points(start, end, connector.radius, max(connector.coils, 3), side)
    wire = tube(points, outwards, WIRE * connector.radius)
    return replace(wire, edges=wire.edges[:0], neighbours=wire.neighbours[:0], creases=wire.creases[:0])


def tube(points: Floats, outwards: Floats, radius: float) -> Facets:
    """Return a tube around points (N, 3); directions (N, 3), not along it, say how its rings are turned."""
    tangents = unit(np.gradient(points, axis=0))
    first = unit(outwards - np.sum(outwards * tangents, axis=1, keepdims=True) * tangents)
    second = np.cross(tangents, first)
    turn = 2 * np.pi * np.arange(SIDES) / SIDES
    rings = (
        first[:, np.newaxis] * np.cos(turn)[:, np.newaxis]
        + second[:, np.newaxis] * np.sin(turn)[:, np.newaxis]
    )
    facets = _tube_template(len(points))
    normals = rings.reshape(-1, 3)[facets.triangles]
    return replace(facets, vertices=(points[:, np.newaxis] + radius * rings).reshape(-1, 3), normals=normals)


@lru_cache(maxsize=64)
def _tube_template(count: int) -> Facets:
    """Return the triangles and edges of a tube with as many rings; its vertices are still nowhere."""
    facets = facets_of(np.zeros((count * SIDES, 3)), grid_triangles(count, SIDES))
    return replace(facets, creases=np.zeros_like(facets.creases))


def cylinder_between(start: Floats, end: Floats, radius: float) -> Facets:
    """Return a cylinder whose axis goes from a point to a point."""
    along = end - start
    length = float(np.linalg.norm(along))
    facets = facets_of_solid(_UNIT, ())
    axis = unit(along) if length > 0.0 else np.array([0.0, 0.0, 1.0])
    side = side_of(axis, np.array([0.0, 0.0, 1.0]))
    turned = np.stack([side, np.cross(axis, side), axis], axis=1)
    stretched = turned * np.array([radius, radius, length])
    return replace(
        facets.rotate(turned, np.zeros(3)), vertices=facets.vertices @ stretched.T + (start + end) / 2
    )


def damper(start: Floats, end: Floats, radius: float, shortest: float) -> Facets:
    """Return a pot at the start and a rod at the end; the pot fits when the damper is shortest [m]."""
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / max(length, 1e-12)
    pot = min(0.62 * shortest, length) if shortest > 0.1 * length else 0.4 * length
    return join_facets(
        [
            cylinder_between(start, start + pot * axis, radius),
            cylinder_between(start + 0.5 * pot * axis, end, 0.35 * radius),
        ]
    )


def side_of(axis: Floats, reference: Floats) -> Floats:
    """Return a direction across an axis, and across the reference where that is possible."""
    for each in (reference, *np.eye(3)):
        across = np.cross(each, axis)
        if np.linalg.norm(across) > 0.05:
            return unit(across)
    raise ValueError("an axis has a direction")


def rope_points(start: Floats, end: Floats, length: float, down: Floats) -> Floats:
    """Return points (N, 3) along a rope: straight where it is taut, else the catenary of its length [m].

    A catenary with parameter a spans h and rises v where L^2 - v^2 = (2 a sinh(h / 2a))^2.
    """
    along = end - start
    if length <= np.linalg.norm(along) * (1 + 1e-9):
        return np.stack([start, end])
    rise = -float(along @ down)
    across = along + rise * down
    span = float(np.linalg.norm(across))
    tallness = np.sqrt(length**2 - rise**2) / max(span, 1e-300)
    if tallness >= np.sinh(_STEEPEST) / _STEEPEST:  # both halves are vertical
        lowest = start + down * (length - rise) / 2
        return np.stack([start, lowest, lowest + across, end])
    half = float(brentq(lambda x: np.log(np.sinh(x) / x / tallness), 1e-6, _STEEPEST + 1.0))
    a, middle = span / (2 * half), float(np.arctanh(rise / length))
    first, last = middle - half, middle + half
    # Evenly spaced both along the span and along the rope: neither the bend nor the legs lack points.
    x = np.linspace(first, last, HANGING)
    x = np.unique(np.concatenate([x, np.arcsinh(np.linspace(np.sinh(first), np.sinh(last), HANGING))]))
    heights = a * (np.cosh(x) - np.cosh(first))
    return start + np.outer(a * (x - first) / span, across) - np.outer(heights, down)
