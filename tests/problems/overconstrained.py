"""Closed loops of hinges, by Denavit and Hartenberg's numbers or by lines in space, and pinned plates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, sin

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

import symbody as sb

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Link:
    """From one hinge to the next: along its axis by d, along the common normal by a, turned about it by alpha."""

    a: float
    alpha: float
    d: float = 0.0
    pitch: float | None = None  # of the hinge at its beginning: a screw then [m/rad]


def step(link: Link, theta: float) -> Array:
    """The transform from one hinge to the next (Denavit & Hartenberg 1955)."""
    ct, st, ca, sa = cos(theta), sin(theta), cos(link.alpha), sin(link.alpha)
    d = link.d + (0.0 if link.pitch is None else link.pitch * theta)
    return np.array([
        [ct, -st * ca, st * sa, link.a * ct], [st, ct * ca, -ct * sa, link.a * st], [0, sa, ca, d], [0, 0, 0, 1.0],
    ])  # fmt: skip


def closing(links: Sequence[Link], angles: Sequence[float]) -> Array:
    """What is left of the loop's closure: (12,)."""
    product = np.eye(4)
    for link, angle in zip(links, angles, strict=True):
        product = product @ step(link, angle)
    return (product - np.eye(4))[:3].ravel()


def closed_angles(links: Sequence[Link], guess: Sequence[float], held: Mapping[int, float]) -> list[float]:
    """Angles of all hinges that close the loop, with some held; the nearest to the guess that are found."""
    free = [k for k in range(len(links)) if k not in held]
    random = np.random.default_rng(5)
    for spread in (0.0, *(0.3 * k for k in range(1, 60))):
        start = np.array(guess, dtype=float) + spread * random.standard_normal(len(links))
        for k, value in held.items():
            start[k] = value

        def values(x: Array, start: Array = start) -> Array:
            angles = start.copy()
            angles[free] = x
            return closing(links, angles.tolist())

        found = least_squares(values, start[free], xtol=1e-15, ftol=1e-15, gtol=1e-15)
        if np.abs(found.fun).max() < 1e-12:
            start[free] = found.x
            return [
                float(x if link.pitch is not None else np.arctan2(np.sin(x), np.cos(x)))
                for link, x in zip(links, start, strict=True)
            ]
    raise AssertionError("the loop does not close")


def loop(links: Sequence[Link], angles: Sequence[float]) -> sb.Model:
    """A closed loop of hinges, the last of its links on ground."""
    n = len(links)
    bodies, names = [], ["ground"]
    for k, link in enumerate(links[:-1]):
        far = sb.Frame(at=(link.a, 0, link.d), rotate=[("x", link.alpha)])
        bodies.append(
            sb.Body(f"L{k}", mass=1, inertia=(0.1, 0.1, 0.1), frames={"in": sb.Frame(), "out": far})
        )
        names.append(f"L{k}")
    last = links[-1]
    ground = {"in": sb.Frame(), "out": sb.Frame(at=(last.a, 0, last.d), rotate=[("x", last.alpha)])}
    joints: list[object] = []
    for k, link in enumerate(links):
        end = "ground" if k == n - 1 else names[k + 1]
        place, coordinate = (f"{names[k]}.out", f"{end}.in"), f"t{k}"
        if link.pitch is None:
            joints.append(sb.Revolute(f"J{k}", *place, coordinate=coordinate))
        else:
            joints.append(sb.Screw(f"J{k}", *place, coordinate=coordinate, pitch=2 * np.pi * link.pitch))
    initial = {f"t{k}": angle for k, angle in enumerate(angles)}
    return sb.Model("loop", [*bodies, *joints], ground=ground, initial=initial)


def lines(points: Array, directions: Array) -> sb.Model:
    """A closed loop of hinges through these points along these directions, all angles 0 as it stands."""
    n = len(points)
    places = [tuple(map(float, point)) for point in points]
    names = ["ground", *(f"L{k}" for k in range(n - 1))]
    bodies = [
        sb.Body(name, mass=1, inertia=(0.1, 0.1, 0.1),
                frames={"in": sb.Frame(at=places[k]), "out": sb.Frame(at=places[k + 1])})
        for k, name in enumerate(names[1:])
    ]  # fmt: skip
    joints = [
        sb.Revolute(f"J{k}", f"{names[k]}.out", f"{names[(k + 1) % n]}.in", coordinate=f"t{k}",
                    axis=tuple(map(float, directions[k])))
        for k in range(n)
    ]  # fmt: skip
    ground = {"in": sb.Frame(at=places[-1]), "out": sb.Frame(at=places[0])}
    return sb.Model("lines", [*bodies, *joints], ground=ground)


def plates(
    points: Mapping[str, tuple[float, float]], words: Sequence[Sequence[str]], turn: Array | None = None
) -> sb.Model:
    """Plates in a plane, one a word, pinned to each other at points, one a letter; the first is ground.

    All angles are 0 as they stand. A rotation matrix turns the plane in space.
    """
    matrix = np.eye(3) if turn is None else turn
    places = {letter: tuple(map(float, matrix @ [x, y, 0.0])) for letter, (x, y) in points.items()}
    names = ["ground", *(f"P{k}" for k in range(1, len(words)))]
    frames = {
        name: {letter: sb.Frame(at=places[letter]) for letter in word}
        for name, word in zip(names, words, strict=True)
    }
    elements: list[object] = [
        sb.Body(name, mass=1, inertia=(0.1, 0.1, 0.1), frames=frames[name]) for name in names[1:]
    ]
    axis = "z" if turn is None else tuple(map(float, matrix[:, 2]))
    for letter in points:
        first, *others = [name for name, word in zip(names, words, strict=True) if letter in word]
        elements += [
            sb.Revolute(f"{letter}_{other}", f"{first}.{letter}", f"{other}.{letter}", axis=axis,
                        coordinate=f"t_{letter}_{other}")
            for other in others
        ]  # fmt: skip
    return sb.Model("plates", elements, ground=frames["ground"])
