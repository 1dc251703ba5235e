"""Right-hand sides with the signature of generated code, compiled here, and a call with defaults."""

from __future__ import annotations

import math
from typing import Any

from numba import cfunc, types

from symbody.simulation.methods.explicit import Explicit, RawRun, integrate

_DOUBLES = types.CPointer(types.double)
native = cfunc(types.int32(*[_DOUBLES] * 8))


@native
def pendulum(t, q, u, r, p, c, out, work):
    out[0] = -math.sin(q[0])
    out[1] = u[0]
    return 0


@native
def oscillator(t, q, u, r, p, c, out, work):
    out[0] = -q[0]
    out[1] = u[0]
    return 0


@native
def rational(t, q, u, r, p, c, out, work):
    """u' = -t u^2, which from u(0) = 1 is 1 / (1 + t^2 / 2): neither linear nor autonomous."""
    out[0] = -t[0] * u[0] * u[0]
    return 0


@native
def blow_up(t, q, u, r, p, c, out, work):
    """A speed at rest, and q' = q^2, which is infinite at t = 1 / q(0)."""
    out[0] = 0.0
    out[1] = q[0] * q[0]
    return 0


@native
def walled(t, q, u, r, p, c, out, work):
    """A speed at rest, and q' = -1, which is not a number beyond q = 1/2."""
    out[0] = 0.0
    out[1] = -1.0 if q[0] > 0.5 else math.nan
    return 0


@native
def never_finite(t, q, u, r, p, c, out, work):
    out[0] = 1.0
    out[1] = math.nan
    return 0


@native
def singular(t, q, u, r, p, c, out, work):
    """q' = 1, whose third kernel fails beyond q = 1."""
    out[0] = 0.0
    out[1] = 1.0
    return 3 if q[0] > 1.0 else 0


@native
def damped(t, q, u, r, p, c, out, work):
    """u' = -1e5 (u - cos t): soon slow, but steps above 6.1e-5 are unstable."""
    out[0] = -1e5 * (u[0] - math.cos(t[0]))
    return 0


@native
def every_group(t, q, u, r, p, c, out, work):
    """Two speeds and one coordinate; each argument enters in its own way."""
    work[0] = 3.0 * p[0]
    work[1] = 5.0 * c[0]
    out[0] = r[0] + 2.0 * r[1] + work[0] + work[1]
    out[1] = 7.0 * t[0] - q[0]
    out[2] = u[0] + 0.1 * u[1]
    return 0


@native
def nothing(t, q, u, r, p, c, out, work):
    return 0


def run(
    function: Any, n_u: int, n_q: int, x0: Any, span: tuple[float, float], order: int = 8, **options: Any
) -> RawRun:
    """Integrate one of the above; the groups are empty unless given."""
    chosen = {"method": Explicit(order=order), "inputs": (), "parameters": (), "constants": (), **options}
    return integrate(function.address, 2, n_u, n_q, x0, span, **chosen)
