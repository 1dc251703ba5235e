"""Tumbling wing nut.

A body in free space that spins about its middle axis of inertia turns over, again and again, at even
intervals; V. Dzhanibekov saw a wing nut do so in a space station.

Check: Euler's equations are solved by `w1 = p cn(x)`, `w2 = q sn(x)`, `w3 = r dn(x)`, `x = s t + K(k)`,
Jacobi's elliptic functions, L. D. Landau and E. M. Lifshitz, Mechanics, on the asymmetrical top. For a
first spin `q` about the middle axis and `e` about the third, energy and angular momentum give
`p^2 = I2 (I3 - I2) q^2/(I1 (I3 - I1))` and `r^2 = e^2 + I2 (I2 - I1) q^2/(I3 (I3 - I1))`; then
`s = (I3 - I1) p r/(I2 q)` and `k^2 = 1 - e^2/r^2`.
"""

import numpy as np
from scipy.special import ellipj, ellipk

import symbody as sb

INERTIA, SPIN, OFF = (1.0e-3, 2.0e-3, 2.8e-3), 6.0, 0.02  # kg m^2; rad/s about the middle and the third axis
TOLERANCE = 1e-6
LOOK = {"times": (0.0, 2.2, 4.6, 6.6), "view": (0.25, -1.0, 0.35)}


def model():
    """Return the mechanism: one free body, which drifts along x."""
    shapes = [
        sb.Cylinder(0.03, 0.09, rotate=[("x", "pi/2")], color="goldenrod"),
        sb.Capsule(0.012, 0.2, rotate=[("y", "pi/2")], color="steelblue"),
        sb.Sphere(0.022, at=(0, 0.05, 0), color="crimson"),
    ]
    flight = sb.Free(
        "flight", "ground", sb.Body("Nut", 1.0, INERTIA, shapes=shapes), angles="quaternion",
        coordinates=["x", "y", "z", "qw", "qx", "qy", "qz"], speeds="end",
        speed_names=["vx", "vy", "vz", "w1", "w2", "w3"],
    )  # fmt: skip
    return sb.Model("wing nut", [flight], initial={"qw": 1.0, "vx": 0.1, "w2": SPIN, "w3": OFF})


def motion():
    """Return ten seconds."""
    return sb.simulate(
        sb.form_equations(model()), 10.0, times=np.linspace(0, 10, 401), rtol=1e-11, atol=1e-13
    )


def comparison(run):
    """Return the angular velocity in the axes of the body, and the formula."""
    I1, I2, I3 = INERTIA
    p = SPIN * np.sqrt(I2 * (I3 - I2) / (I1 * (I3 - I1)))
    r = np.sqrt(OFF**2 + SPIN**2 * I2 * (I2 - I1) / (I3 * (I3 - I1)))
    square = 1 - (OFF / r) ** 2
    sn, cn, dn, _ = ellipj((I3 - I1) * p * r / (I2 * SPIN) * run.t + ellipk(square), square)
    return np.array([run["w1"], run["w2"], run["w3"]]), np.array([p * cn, SPIN * sn, r * dn])
