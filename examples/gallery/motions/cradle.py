"""Newton's cradle.

Five balls of steel hang in a row, 1 nm apart. One is lifted and let go: the last of the row flies off as
high, comes back, and the first goes up again. The contacts are rigid and elastic, and as there is a gap
between the balls each impact is that of two balls, which swap their speeds.

Check: the first ball falls and the last one rises as the same pendulum would alone, half a swing each: their
angles together are that pendulum's, whose period is `4 K sqrt(l/g)` with K the complete elliptic integral of
the first kind at the modulus `sin(theta0/2)`: E. T. Whittaker, Analytical Dynamics, section 44.
"""

import numpy as np
from scipy.special import ellipj, ellipk

import symbody as sb

BALLS, LENGTH, RADIUS, GAP = 5, 0.3, 0.02, 1e-9
START = 0.7  # rad
TOLERANCE = 1e-6  # rad
LOOK = {"times": (0.0, 0.2, 0.4, 0.56, 0.8, 1.0), "view": "front"}


def model():
    """Return the cradle; angles against the clock, the ball that is lifted on the left."""
    parts = []
    ground = {}
    for k in range(BALLS):
        ground[f"top{k}"] = sb.Frame((k * (2 * RADIUS + GAP), 0, 0))
        thread = sb.Cylinder(0.001, LENGTH, at=(0, 0, LENGTH / 2), color="gray")
        parts += [
            sb.Body(f"Ball{k}", 0.25, frames={"top": sb.Frame((0, 0, LENGTH))},
                    shapes=[sb.Sphere(RADIUS, color="silver"), thread]),
            sb.Revolute(f"swing{k}", f"ground.top{k}", f"Ball{k}.top", axis=(0, -1, 0),
                        coordinate=f"theta{k}"),
        ]  # fmt: skip
    sphere = {"sphere": RADIUS}
    parts += [
        sb.Contact(f"touch{k}", f"Ball{k}", f"Ball{k + 1}", [sphere, sphere], normal="rigid", restitution=1)
        for k in range(BALLS - 1)
    ]
    beam = [sb.Box((2 * RADIUS * (BALLS + 2), 0.02, 0.02), at=(RADIUS * (BALLS - 1), 0, 0.01))]
    first = {"theta0": -START}
    return sb.Model("cradle", parts, gravity=(0, 0, -9.81), ground=ground, ground_shapes=beam, initial=first)


def motion():
    """Return one swing to and fro."""
    return sb.simulate(sb.form_equations(model()), 1.1, times=np.linspace(0, 1.1, 221), rtol=1e-10)


def comparison(run):
    """Return the sum of the angles of the first and last ball, and that of a pendulum alone."""
    k = np.sin(START / 2) ** 2
    sn = ellipj(ellipk(k) - np.sqrt(9.81 / LENGTH) * run.t, k)[0]
    return run["theta0"] + run[f"theta{BALLS - 1}"], -2 * np.arcsin(np.sin(START / 2) * sn)
