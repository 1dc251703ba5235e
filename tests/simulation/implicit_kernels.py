"""A spring that softens, for the implicit loop, in the kernel language: slopes with the work's, turns, derivatives."""

from __future__ import annotations

from symbody.kernels.language import Reals


def slopes(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """u' = -q + q^3 / 6 + t / 10, and the power of that push."""
    push = 0.1 * t[0]
    out[0] = -q[0] + q[0] * q[0] * q[0] / 6.0 + push
    out[1] = u[0]
    out[2] = push * u[0]
    return 0


def turns(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """q' = u."""
    out[0] = u[0]
    return 0


def derivatives(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
    """Of u' and q' by u and q."""
    out[0] = 0.0
    out[1] = -1.0 + 0.5 * q[0] * q[0]
    out[2] = 1.0
    out[3] = 0.0
    return 0
