"""Right-hand sides in the kernel language, with the signature of generated code."""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import NAN, Reals

HALF_TURN: Final = 3.141592653589793
TURN: Final = 2.0 * 3.141592653589793
TERMS: Final = 15


def sine(x: float) -> float:
    """Return the sine by its series."""
    turns = float(int(x / TURN))
    s = x - turns * TURN
    if s > HALF_TURN:
        s = s - TURN
    elif s < -HALF_TURN:
        s = s + TURN
    total = 1.0
    for k in range(TERMS, 0, -1):
        total = 1.0 - total * s * s / (2 * k * (2 * k + 1))
    return s * total


def pendulum(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """u' = -sin q."""
    out[0] = -sine(q[0])
    out[1] = u[0]
    return 0


def oscillator(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """u' = -q."""
    out[0] = -q[0]
    out[1] = u[0]
    return 0


def rational(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """u' = -t u^2, which from u(0) = 1 is 1 / (1 + t^2 / 2): neither linear nor autonomous."""
    out[0] = -t[0] * u[0] * u[0]
    return 0


def blow_up(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """A speed at rest, and q' = q^2, which is infinite at t = 1 / q(0)."""
    out[0] = 0.0
    out[1] = q[0] * q[0]
    return 0


def walled(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """A speed at rest, and q' = -1, which is not a number beyond q = 1/2."""
    out[0] = 0.0
    out[1] = NAN
    if q[0] > 0.5:
        out[1] = -1.0
    return 0


def never_finite(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """q' is no number."""
    out[0] = 1.0
    out[1] = NAN
    return 0


def singular(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """q' = 1, whose third kernel fails beyond q = 1."""
    out[0] = 0.0
    out[1] = 1.0
    if q[0] > 1.0:
        return 3
    return 0


def damped(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """u' = -1e5 (u - cos t): soon slow, but steps above 6.1e-5 are unstable."""
    out[0] = -1e5 * (u[0] - sine(t[0] + 0.5 * HALF_TURN))
    return 0


def every_group(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """Two speeds and one coordinate; each argument enters in its own way."""
    work[0] = 3.0 * p[0]
    work[1] = 5.0 * c[0]
    out[0] = r[0] + 2.0 * r[1] + work[0] + work[1]
    out[1] = 7.0 * t[0] - q[0]
    out[2] = u[0] + 0.1 * u[1]
    return 0


def nothing(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """No states."""
    return 0
