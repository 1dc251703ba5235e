"""Four-bars and slider-cranks that miss a change point by little, and their motion in 40 digits.

A bar is longer or shorter by a small share of the linkage than where all bars lie on one line. There the open
direction turns within the square root of that share: 3e-5 rad for 1e-9. One freedom without friction moves
along a known curve with the speed that its energy leaves: no constraint is differentiated, no pivot chosen, and
40 digits leave 30 of what the difference of the lengths makes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin
from random import Random
from typing import Any

import numpy as np
from mpmath import mp, mpf, workdps
from numpy.typing import NDArray
from scipy.integrate import DOP853

import symbody as sb

Floats = NDArray[np.float64]
Triple = tuple[Any, Any, Any]
DIGITS = 40
# Local errors of the reference, in rad and m.
LOCAL = 1e-12
NAMES = ("a", "b", "d")


@dataclass(frozen=True)
class Neighbour:
    """A linkage near one with a change point; bars lie along x of their frames.

    Attributes
    ----------
    lengths : tuple of float
        Crank, coupler, rocker and ground, or crank, rod and none for the slider.
    """

    lengths: tuple[float, ...]
    masses: tuple[float, ...]
    inertias: tuple[float, ...]
    centres: tuple[tuple[float, float], ...]
    gravity: tuple[float, float]
    start: tuple[float, float, float]
    speed: float

    @property
    def has_slider(self) -> bool:
        """Whether the last body slides along x."""
        return len(self.lengths) == 2

    def model(self) -> sb.Model:
        """The linkage as users write it."""
        ends: list[float | None] = [*self.lengths[:3], None][:3]
        bodies = []
        for name, length, mass, inertia, (x, y) in zip(
            ("Crank", "Rod", "Last"), ends, self.masses, self.inertias, self.centres, strict=True
        ):
            frames = {"near": sb.Frame(at=(-x, -y, 0))}
            if length is not None:
                frames["far"] = sb.Frame(at=(length - x, -y, 0))
            bodies.append(sb.Body(name, mass=mass, inertia=(inertia,) * 3, frames=frames))
        joints: list[object] = [
            sb.Revolute("A", "ground", "Crank.near", coordinate="a"),
            sb.Revolute("B", "Crank.far", "Rod.near", coordinate="b"),
        ]
        if self.has_slider:
            joints.append(sb.Prismatic("D", "ground", "Last.near", axis="x", coordinate="d"))
            joints.append(sb.Revolute("C", "Rod.far", "Last.near"))
        else:
            joints.append(sb.Revolute("D", "ground.post", "Last.near", coordinate="d"))
            joints.append(sb.Revolute("C", "Rod.far", "Last.far"))
        ground = {} if self.has_slider else {"post": sb.Frame(at=(self.lengths[3], 0, 0))}
        return sb.Model("neighbour", [*bodies, *joints], ground=ground, gravity=(*self.gravity, 0.0))

    def motion(self, times: Sequence[float]) -> tuple[dict[str, Floats], Floats]:
        """Joint coordinates at times, and how fast the two angles and the last coordinate change (N, 3)."""
        with workdps(DIGITS):
            run = _Curve(self)
            found = [(run.q, run.rates(run.q)), *(run.advance(mpf(float(t))) for t in times[1:])]
        q, rates = (np.array([[float(v) for v in one] for one in some]) for some in zip(*found, strict=True))
        return {"a": q[:, 0], "b": q[:, 1] - q[:, 0], "d": q[:, 2]}, rates


class _Curve:
    """The motion along the curve of closed configurations q = (crank, rod, last), turned from x."""

    def __init__(self, made: Neighbour) -> None:
        self.made, self.t, self.h = made, mpf(0), mpf("0.01")
        self.q = self._close(tuple(mpf(v) for v in made.start))
        tangent, speed_energy, potential = self._along(self.q)
        speed = mpf(made.speed) / tangent[0]
        self.way, self.energy = (1 if speed > 0 else -1), speed_energy * speed**2 + potential

    def rates(self, q: Triple) -> Triple:
        """Velocities along the curve, by the energy."""
        tangent, speed_energy, potential = self._along(q)
        assert self.energy > potential, "the motion turns back"
        speed = self.way * mp.sqrt((self.energy - potential) / speed_energy)
        return tangent[0] * speed, tangent[1] * speed, tangent[2] * speed

    def advance(self, end: Any) -> tuple[Triple, Triple]:
        """Configuration and velocities at a time."""
        while self.t < end:
            step = min(self.h, end - self.t)
            stages = [self.rates(self.q)]
            for row in DOP853.A[1:12]:
                stages.append(self.rates(self._moved(step, row, stages)))
            q = self._moved(step, DOP853.B, stages)
            stages.append(self.rates(q))
            fifth, third = (self._size(step, weights, stages) for weights in (DOP853.E5, DOP853.E3))
            error = fifth**2 / np.hypot(fifth, 0.1 * third) / LOCAL if fifth else 0.0
            if error <= 1.0:
                self.t, self.q = (end if step == end - self.t else self.t + step), self._close(q)
            if step == self.h or error > 1.0:
                self.h = step * min(5.0, max(0.2, 0.9 * error ** (-1 / 8) if error else 5.0))
        return self.q, self.rates(self.q)

    def _moved(self, step: Any, weights: Floats, stages: list[Triple]) -> Triple:
        used = [(mpf(w), k) for w, k in zip(weights.tolist(), stages, strict=False) if w]
        x, y, z = (start + step * mp.fsum(w * k[i] for w, k in used) for i, start in enumerate(self.q))
        return x, y, z

    def _size(self, step: Any, weights: Floats, stages: list[Triple]) -> float:
        used = list(zip(weights.tolist(), stages, strict=True))
        return max(abs(float(step * mp.fsum(w * k[i] for w, k in used))) for i in range(3))

    def _rows(self, q: Triple) -> tuple[tuple[Any, Any], tuple[Triple, Triple], list[tuple[Any, Any]]]:
        """The closing vector, its derivatives, and cosine and sine of each body."""
        turns = [(mp.cos(v), mp.sin(v)) for v in q]
        (ca, sa), (cb, sb_), (cd, sd) = turns
        r, rod, *more = map(mpf, self.made.lengths)
        if self.made.has_slider:
            turns[2], one = (mpf(1), mpf(0)), mpf(1)
            closing = r * ca + rod * cb - q[2], r * sa + rod * sb_
            return closing, ((-r * sa, -rod * sb_, -one), (r * ca, rod * cb, 0 * one)), turns
        w, ground = more
        closing = r * ca + rod * cb - w * cd - ground, r * sa + rod * sb_ - w * sd
        return closing, ((-r * sa, -rod * sb_, w * sd), (r * ca, rod * cb, -w * cd)), turns

    def _along(self, q: Triple) -> tuple[Triple, Any, Any]:
        """The unit tangent, which goes on along a branch; the kinetic energy at speed 1; and the potential."""
        _, (x, y), turns = self._rows(q)
        normal = x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]
        size = mp.sqrt(sum(v**2 for v in normal))
        tangent = normal[0] / size, normal[1] / size, normal[2] / size
        made, r = self.made, mpf(self.made.lengths[0])
        kinetic, potential = mpf(0), mpf(0)
        (ca, sa), _, _ = turns
        places = ((0, 0, 0, 0), (r * ca, r * sa, -r * sa * tangent[0], r * ca * tangent[0]), (0, 0, 0, 0))
        if made.has_slider:
            places = (*places[:2], (q[2], 0, tangent[2], 0))
        for k, (px, py, vx, vy) in enumerate(places):
            (c, s), (cx, cy), m = turns[k], made.centres[k], made.masses[k]
            spin = 0 if k == 2 and made.has_slider else tangent[k]
            dx, dy = c * cx - s * cy, s * cx + c * cy
            kinetic += (
                m * ((vx - dy * spin) ** 2 + (vy + dx * spin) ** 2) / 2 + made.inertias[k] * spin**2 / 2
            )
            potential -= m * (made.gravity[0] * (px + dx) + made.gravity[1] * (py + dy))
        return tangent, kinetic, potential

    def _close(self, q: Triple) -> Triple:
        """The configuration on the curve by the least moves."""
        for _ in range(4):
            (f, g), (x, y), _ = self._rows(q)
            xx, xy, yy = (
                mp.fsum(a * b for a, b in zip(*two, strict=True)) for two in ((x, x), (x, y), (y, y))
            )
            det = xx * yy - xy**2
            first, second = (yy * f - xy * g) / det, (xx * g - xy * f) / det
            p, v, w = (a - first * b - second * c for a, b, c in zip(q, x, y, strict=True))
            q = p, v, w
        return q


def neighbour(seed: int, distance: float) -> Neighbour:
    """A random linkage whose lengths miss those of a change point by a share of the longest."""
    random = Random(seed)
    r, way = random.uniform(0.3, 0.5), random.choice([-1, 1])
    g, down = random.choice([0.0, 1.0, 3.0]), random.uniform(-pi, pi)
    centres = [(random.uniform(0, 0.3), random.uniform(-0.1, 0.1)) for _ in range(3)]
    if random.random() < 0.5:
        long, first = random.uniform(0.6, 0.9), random.uniform(0.5, 2.6) * random.choice([-1, 1])
        lengths, start = [r, long, r, long], (first, 0.0, first)
    else:
        first = random.uniform(-1, 1)
        lengths, centres[2] = [r, r], (0.0, 0.0)
        stays = random.random() < 0.3  # the rod lies on the crank and turns with it
        start = (first, first + pi, 0.0) if stays else (first, -first, 2 * r * cos(first))
    lengths[random.randrange(len(lengths))] += way * distance * max(lengths)
    return Neighbour(
        tuple(lengths), tuple(random.uniform(0.5, 2) for _ in range(3)),
        tuple(random.uniform(0.02, 0.2) for _ in range(3)), tuple(centres), (g * cos(down), g * sin(down)),
        start, random.choice([-1, 1]) * random.uniform(8, 12),
    )  # fmt: skip
