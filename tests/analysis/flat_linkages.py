"""Linkages that can lie flat, with all their equilibria from a potential along each branch of their motion.

All have one freedom, and a closed form of their configurations in the angle of a crank, one on each branch.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq

import symbody as sb

G = 9.81
Values = Mapping[str, float]
Place = dict[str, float]
# From the angle of the crank to all coordinates.
Way = Callable[[float, Values], Place]
GRID = np.linspace(-math.pi, math.pi, 721) + 0.00137


@dataclass(frozen=True)
class Linkage:
    """One linkage: its model, a draw of its parameters, its branches, and its potential energy."""

    model: Callable[[], sb.Model]
    draw: Callable[[random.Random], dict[str, float]]
    ways: tuple[Way, ...]
    potential: Callable[[Place, Values], float]


@dataclass(frozen=True)
class Rest:
    """An equilibrium, and the second derivative of the potential by the crank's angle there."""

    q: Place
    curvature: float


def rests(linkage: Linkage, values: Values) -> list[Rest]:
    """Return all equilibria on all branches: zeros of the slope of the potential, which is smooth on each."""
    found = []
    for way in linkage.ways:

        def slope(angle: float, way: Way = way, h: float = 1e-4) -> float:
            v = [linkage.potential(way(angle + k * h, values), values) for k in (-2, -1, 1, 2)]
            return (v[0] - 8.0 * v[1] + 8.0 * v[2] - v[3]) / (12.0 * h)

        slopes = [slope(angle) for angle in GRID]
        for a, b, left, right in zip(GRID, GRID[1:], slopes, slopes[1:], strict=False):
            if left * right < 0.0:
                angle = float(brentq(slope, a, b, xtol=1e-13))
                found.append(Rest(way(angle, values), (slope(angle + 1e-3) - slope(angle - 1e-3)) / 2e-3))
    return found


def turned(angle: float) -> float:
    """Return an angle within half a turn."""
    return math.remainder(angle, 2.0 * math.pi)


def hang(mass: float, x: float, y: float, values: Values) -> float:
    """Return the potential energy of a mass in gravity of any direction."""
    return -mass * (values["gx"] * x + values["gy"] * y)


def weights(rng: random.Random) -> dict[str, float]:
    """Return a direction of gravity, masses, and centres of mass."""
    down = rng.uniform(-math.pi, math.pi)
    return {
        "gx": G * math.cos(down), "gy": G * math.sin(down), "m1": rng.uniform(0.2, 3), "m2": rng.uniform(0.2, 3),
        "mk": rng.uniform(0.2, 3), "c1": rng.uniform(-0.5, 1.5), "c2": rng.uniform(-0.5, 1.5),
        "kx": rng.uniform(-1, 2), "ky": rng.uniform(-1, 1), "d": rng.uniform(0.05, 0.5),
    }  # fmt: skip


def crank(name: str, mass: str, share: str, tip: str = "a") -> sb.Body:
    """Return a crank along x whose centre of mass is a share of its length away from its pivot."""
    frames = {"O": sb.Frame(at=(f"-{share}*{tip}", 0, 0)), "P": sb.Frame(at=(f"(1-{share})*{tip}", 0, 0))}
    return sb.Body(name, mass, inertia=(0, 0, 0.1), frames=frames)


def parallelogram(offsets: tuple[str, ...] = ("b",)) -> sb.Model:
    """Return equal cranks in a row under a coupler, the first of them driven and damped."""
    places = {f"Q{k}": sb.Frame(at=(f"{b}-kx", "-ky", 0)) for k, b in enumerate(offsets)}
    coupler = sb.Body("K", "mk", inertia=(0, 0, 0.1), frames={"Q": sb.Frame(at=("-kx", "-ky", 0)), **places})
    first = crank("C", "m1", "c1")
    parts: list[object] = [
        first, coupler,
        sb.Revolute("A", "ground", "C.O", coordinate="q1", torque=sb.Drive(damping="d")),
        sb.Revolute("D", "C.P", "K.Q", coordinate="q3"),
    ]  # fmt: skip
    for k, _ in enumerate(offsets):
        parts += [
            crank(f"C{k}", "m2", "c2"),
            sb.Revolute(f"B{k}", f"ground.b{k}", f"C{k}.O", coordinate=f"p{k}"),
            sb.Revolute(f"E{k}", f"K.Q{k}", f"C{k}.P"),
        ]
    defaults = dict.fromkeys(("a", "b", "e", "m1", "m2", "mk", "d"), 1.0)
    defaults |= dict.fromkeys(("c1", "c2", "kx", "ky", "gx", "gy"), 0.0)
    ground = {f"b{k}": sb.Frame(at=(b, 0, 0)) for k, b in enumerate(offsets)}
    return sb.Model("cranks", parts, gravity=("gx", "gy", 0), ground=ground, parameters=defaults)


def parallel(angle: float, values: Values) -> Place:
    """Return the configuration in which the cranks are parallel."""
    return {"q1": angle, "q3": -angle, "p0": angle, "p1": angle}


def crossed(angle: float, values: Values) -> Place:
    """Return the configuration in which two cranks cross: the coupler's end mirrored at the diagonal."""
    a, b = values["a"], values["b"]
    x, y = a * math.cos(angle), a * math.sin(angle)
    # The end of the second crank, b + a (cos, sin), mirrored at the line from (x, y) to (b, 0).
    ux, uy = b - x, -y
    share = 2.0 * (a * math.cos(angle) * ux + a * math.sin(angle) * uy) / (ux**2 + uy**2)
    px, py = share * ux - a * math.cos(angle), share * uy - a * math.sin(angle)
    coupler = math.atan2(py - y, b + px - x)
    return {"q1": angle, "q3": coupler - angle, "p0": math.atan2(py, px), "p1": math.nan}


def crank_weights(q: Place, values: Values, offsets: tuple[str, ...] = ("b",)) -> float:
    """Return the potential energy of cranks and coupler."""
    a, tilt = values["a"], q["q1"] + q["q3"]
    c, s = math.cos(tilt), math.sin(tilt)
    x = a * math.cos(q["q1"]) + c * values["kx"] - s * values["ky"]
    y = a * math.sin(q["q1"]) + s * values["kx"] + c * values["ky"]
    along = values["c1"] * a
    total = hang(values["mk"], x, y, values)
    total += hang(values["m1"], along * math.cos(q["q1"]), along * math.sin(q["q1"]), values)
    for k, b in enumerate(offsets):
        p, along = q[f"p{k}"], values["c2"] * a
        total += hang(values["m2"], values[b] + along * math.cos(p), along * math.sin(p), values)
    return total


def draw_cranks(rng: random.Random) -> dict[str, float]:
    """Return parameters of cranks that are not as long as the coupler, where further branches begin."""
    a = rng.uniform(0.4, 2.0)
    b = a * rng.choice([rng.uniform(0.3, 0.85), rng.uniform(1.2, 3.0)])
    return {"a": a, "b": b, "e": b * rng.uniform(1.3, 2.5), **weights(rng)}


def slider_crank() -> sb.Model:
    """Return a crank and a rod of equal length: the slider may stay at the pivot."""
    rod = crank("Rod", "m2", "c2")
    slider = sb.Body("S", "mk")
    parts = [
        crank("C", "m1", "c1"), rod, slider,
        sb.Revolute("A", "ground", "C.O", coordinate="q1", torque=sb.Drive(damping="d")),
        sb.Revolute("D", "C.P", "Rod.O", coordinate="q3"),
        sb.Prismatic("P", "ground", "S", axis="x", coordinate="s", force=sb.Drive(stiffness="k", free="s0")),
        sb.Revolute("E", "S", "Rod.P"),
    ]  # fmt: skip
    defaults = dict.fromkeys(("a", "k", "m1", "m2", "mk", "d"), 1.0)
    defaults |= dict.fromkeys(("c1", "c2", "gx", "gy", "s0"), 0.0)
    return sb.Model("slider-crank", parts, gravity=("gx", "gy", 0), parameters=defaults)


def stretched(angle: float, values: Values) -> Place:
    """Return the configuration in which the rod mirrors the crank."""
    return {"q1": angle, "q3": -2.0 * angle, "s": 2.0 * values["a"] * math.cos(angle)}


def folded(angle: float, values: Values) -> Place:
    """Return the configuration in which the rod lies on the crank."""
    return {"q1": angle, "q3": math.pi, "s": 0.0}


def slider_weights(q: Place, values: Values) -> float:
    """Return the potential energy of crank, rod, slider and spring."""
    a, tilt = values["a"], q["q1"] + q["q3"]
    x, y = a * math.cos(q["q1"]), a * math.sin(q["q1"])
    total = hang(values["m1"], values["c1"] * x, values["c1"] * y, values)
    reach = values["c2"] * a
    total += hang(values["m2"], x + reach * math.cos(tilt), y + reach * math.sin(tilt), values)
    return total + hang(values["mk"], q["s"], 0.0, values) + values["k"] * (q["s"] - values["s0"]) ** 2 / 2.0


def draw_slider(rng: random.Random) -> dict[str, float]:
    """Return parameters of a slider-crank."""
    known = {name: x for name, x in weights(rng).items() if name not in ("kx", "ky")}
    return {"a": rng.uniform(0.3, 2.0), "k": rng.uniform(0.5, 60), "s0": rng.uniform(-1, 1), **known}


def three_weights(q: Place, values: Values) -> float:
    """Return the potential energy with two more cranks."""
    return crank_weights(q, values, ("b", "e"))


LINKAGES = {
    "two cranks": Linkage(parallelogram, draw_cranks, (parallel, crossed), crank_weights),
    "three cranks": Linkage(lambda: parallelogram(("b", "e")), draw_cranks, (parallel,), three_weights),
    "slider-crank": Linkage(slider_crank, draw_slider, (stretched, folded), slider_weights),
}


@cache
def equations(kind: str) -> sb.EquationSet:
    """Return the equations of a linkage."""
    return sb.form_equations(LINKAGES[kind].model())
