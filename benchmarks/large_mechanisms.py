"""Mechanisms of any number of bodies: chains, trees, and loops of rods."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

import symbody as sb
from benchmarks.mechanisms import spatial_chain

_GRAVITY: Final = (0, -9.81, 0)


def chain(bodies: int) -> sb.Model:
    """Return a chain of bodies, hinged in turn about y, z and x of the one before."""
    return spatial_chain(bodies).model()


def tree(bodies: int) -> sb.Model:
    """Return a tree in which every body carries two others, hinged in turn about x, y and z."""
    elements: list[Any] = []
    for k in range(1, bodies + 1):
        frames = {"top": sb.Frame(at=(0, 0.5, 0)), "end": sb.Frame(at=(0.1, -0.5, 0))}
        below = "ground" if k == 1 else f"B{k // 2}.end"
        elements += [
            sb.Body(f"B{k}", mass=1.0, inertia=(0.1, 0.2, 0.3), frames=frames),
            sb.Revolute(f"J{k}", below, f"B{k}.top", axis="xyz"[k % 3], coordinate=f"q{k}"),
        ]
    return sb.Model("tree", elements, gravity=_GRAVITY)


def ring(bodies: int) -> sb.Model:
    """Return a ring of rods in a plane, pinned to each other and to ground in one place."""
    length, turn = 2.0 * math.sin(math.pi / bodies), math.tau / bodies
    elements: list[Any] = []
    for k in range(1, bodies + 1):
        below = "ground" if k == 1 else f"B{k - 1}.end"
        elements += [
            _rod(k, length),
            sb.Revolute(f"J{k}", below, f"B{k}", axis="z", coordinate=f"q{k}"),
        ]
    elements.append(sb.Revolute("closing", f"B{bodies}.end", "ground", axis="z"))
    initial = {f"q{k}": turn for k in range(1, bodies + 1)}
    return sb.Model("ring", elements, gravity=_GRAVITY, initial=initial)


def truss(bodies: int) -> sb.Model:
    """Return a strip of triangles of rods of length 1, pinned to each other and to ground in a corner."""
    nodes: dict[int, str] = {0: "ground"}
    elements: list[Any] = []
    for k in range(1, bodies + 1):
        start, step = (k - 1) // 2, 1 + (k - 1) % 2
        elements.append(_rod(k, 1.0))
        for node, frame in ((start, f"B{k}"), (start + step, f"B{k}.end")):
            if node in nodes:
                elements.append(sb.Revolute(f"J{k}_{node}", nodes[node], frame, axis="z"))
            else:
                nodes[node] = frame
    return sb.Model("truss", elements, gravity=_GRAVITY)


def _rod(k: int, length: float) -> sb.Body:
    return sb.Body(f"B{k}", mass=1.0, inertia=(0.1, 0.1, 0.1), frames={"end": sb.Frame(at=(length, 0, 0))})


LARGE: Final[Mapping[str, Callable[[int], sb.Model]]] = MappingProxyType(
    {"chain": chain, "tree": tree, "ring": ring, "truss": truss}
)
