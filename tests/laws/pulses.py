"""Oscillators at rest that a short pulse strikes, with their motions by linear systems theory alone.

A mass m hangs on a support by a spring k and a damper d: ``m x'' = F - k (x - s) - d (x' - s')``. The force F or
the displacement s of the support is zero but for a pulse. Before it nothing moves; behind it the state is
Duhamel's integral over the pulse.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

import symbody as sb

Floats = NDArray[np.float64]
Shape = Callable[[float], float]


@dataclass(frozen=True)
class Pulse:
    """A pulse: its formula in t, or a table; its values, and between which times it is not zero."""

    law: str | sb.Table
    value: Shape
    breaks: tuple[float, ...]


def window(start: float, width: float, height: float) -> Pulse:
    """A force that is switched on and off."""
    end = start + width
    law = f"if(t > {start!r} and t < {end!r}, {height!r}, 0)"
    return Pulse(law, lambda t: height if start < t < end else 0.0, (start, end))


def triangle(start: float, width: float, height: float) -> Pulse:
    """The polygon of `interp1`."""
    places = (start, start + 0.3 * width, start + width)
    law = f"interp1(t, {places[0]!r}, 0, {places[1]!r}, {height!r}, {places[2]!r}, 0)"
    return Pulse(law, lambda t: float(np.interp(t, places, [0.0, height, 0.0])), places)


def bell(start: float, width: float, height: float) -> Pulse:
    """A smooth bell that is zero to rounding beyond its width: exp(-36) at the ends."""
    centre, half = start + 0.5 * width, width / 12.0
    law = f"{height!r}*exp(-((t - {centre!r})/{half!r})^2)"
    places = tuple(np.linspace(start, start + width, 9).tolist())
    return Pulse(law, lambda t: height * float(np.exp(-(((t - centre) / half) ** 2))), places)


def power(start: float, width: float, height: float) -> Pulse:
    """The highest arch of a sine to the power 60, alone."""
    rate = 1.6 / width  # sin(x)^60 < 1e-10 where |x - pi/2| > 0.8
    law = (
        f"{height!r}*if(abs(t - {start + 0.5 * width!r}) < {0.9 * width!r}, "
        f"cos({rate!r}*(t - {start + 0.5 * width!r}))^60, 0)"
    )
    centre = start + 0.5 * width

    def value(t: float) -> float:
        return height * float(np.cos(rate * (t - centre)) ** 60) if abs(t - centre) < 0.9 * width else 0.0

    return Pulse(law, value, tuple(np.linspace(centre - 0.9 * width, centre + 0.9 * width, 13).tolist()))


def arch(start: float, width: float, height: float) -> Pulse:
    """One arch of a parabola between two zeros, by max: continuous, with corners."""
    end = start + width
    law = f"{height!r}*max(0, (t - {start!r})*({end!r} - t))/{0.25 * width**2!r}"
    return Pulse(law, lambda t: height * max(0.0, (t - start) * (end - t)) / (0.25 * width**2), (start, end))


def table(start: float, width: float, height: float) -> Pulse:
    """A bump of 28 points."""
    return _table(start, width, height, 28)


def long_table(start: float, width: float, height: float) -> Pulse:
    """A bump in a table that Python reads."""
    return _table(start, width, height, 80)


def _table(start: float, width: float, height: float, count: int) -> Pulse:
    times = np.concatenate([[start - 1.0], np.linspace(start, start + width, count), [start + width + 1.0]])
    values = np.concatenate([[0.0], height * np.sin(np.linspace(0.0, np.pi, count)) ** 2, [0.0]])
    values[[1, -2]] = 0.0
    return Pulse(
        sb.Table(times, values), lambda t: float(np.interp(t, times, values)), tuple(times[1:-1].tolist())
    )


def stepped(start: float, width: float, height: float) -> Pulse:
    """A table with two jumps: times that stand there twice."""
    end = start + width
    law = sb.Table([start, start, end, end], [0.0, height, height, 0.0])
    return Pulse(law, lambda t: height if start <= t < end else 0.0, (start, end))


FORCES = (window, triangle, bell, power, arch, table, long_table, stepped)
SUPPORTS = (triangle, bell, arch)


@dataclass(frozen=True)
class Struck:
    """One oscillator, its pulse, its exact state at the end, and by how much errors before may grow in it."""

    model: sb.Model
    inputs: dict[str, str | sb.Table]
    end: float
    exact: Floats
    condition: float
    words: str


def struck(rng: Generator) -> Struck:
    """Return a random oscillator that a random pulse strikes by its input, its force or its support."""
    m, omega, zeta = rng.uniform(0.5, 2.0), rng.uniform(2.0, 12.0), rng.uniform(0.02, 0.3)
    k, d = m * omega**2, 2.0 * zeta * m * omega
    rest, width = 10.0 ** rng.uniform(0.0, 1.5), 10.0 ** rng.uniform(-4.0, -1.3)
    end = rest + width + rng.uniform(0.5, 1.5) * 2.0 * np.pi / omega
    way = str(rng.choice(["input", "force", "support", "constraint"]))
    if way in ("input", "force"):
        shape = FORCES[rng.integers(len(FORCES))] if way == "input" else FORCES[rng.integers(5)]
        pulse = shape(rest, width, 1.0 / width)  # an impulse of about 1 N s
        forced: Shape = pulse.value
    else:
        shape = SUPPORTS[rng.integers(len(SUPPORTS))]
        width *= 0.01 / width if width < 0.01 else 1.0
        pulse = shape(rest, width, 1e-3 / width)
        forced = _of_support(pulse, k, d)
    law = pulse.law
    words = f"{way} {shape.__name__} at {rest:.3g} s for {width:.3g} s, omega {omega:.3g}"
    inputs = {"F": law} if way == "input" else {}
    applied = {"input": "F", "force": law}.get(way)
    exact = _response(m, k, d, forced, pulse.breaks, end)
    # A support that passes A in a time w leaves speeds of A w omega^2, of relative speeds of A/w before.
    condition = 1.0 if way in ("input", "force") else max(1.0, (width * omega) ** -2)
    return Struck(_model(m, k, d, way, applied, law), inputs, end, exact, condition, words)


def _model(m: float, k: float, d: float, way: str, applied: object, law: object) -> sb.Model:
    mass = sb.Body("Mass", mass=m)
    if way in ("input", "force"):
        drive = sb.Drive(applied, stiffness=k, damping=d)
        joint = sb.Prismatic("j", "ground", mass, axis="x", coordinate="x", force=drive)
        return sb.Model("struck", [mass, joint], inputs=["F"] if way == "input" else [])
    support = sb.Body("Support", mass=1.0)
    parts = [
        mass,
        sb.Prismatic(
            "s", "ground", support, axis="x", coordinate="s", motion=law, as_constraint=way == "constraint"
        ),
        sb.Prismatic("j", support, mass, axis="x", coordinate="r", force=sb.Drive(stiffness=k, damping=d)),
    ]
    return sb.Model("struck", parts)


def _of_support(pulse: Pulse, k: float, d: float) -> Shape:
    """Return the force of a moving support on the mass; its rate from central differences within a piece."""

    def force(t: float) -> float:
        near = [abs(t - place) for place in pulse.breaks]
        h = min(1e-4 * (pulse.breaks[-1] - pulse.breaks[0]), 0.5 * min(near)) or 1e-12
        return k * pulse.value(t) + d * (pulse.value(t + h) - pulse.value(t - h)) / (2.0 * h)

    return force


def _response(m: float, k: float, d: float, force: Shape, breaks: tuple[float, ...], end: float) -> Floats:
    """Return (x, x') at the end: Duhamel's integral, by Gauss's rule of 20 points in each piece."""
    decay = d / (2.0 * m)
    omega = np.sqrt(k / m - decay**2)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    total = np.zeros(2)
    for start, stop in zip(breaks[:-1], breaks[1:], strict=True):
        t = start + 0.5 * (stop - start) * (1.0 + nodes)
        left = end - t
        swing = np.exp(-decay * left) * np.sin(omega * left) / (m * omega)
        rate = np.exp(-decay * left) * np.cos(omega * left) / m - decay * swing
        forces = np.array([force(float(time)) for time in t])
        total += 0.5 * (stop - start) * np.array([(weights * forces * each).sum() for each in (swing, rate)])
    return total
