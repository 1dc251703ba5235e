"""Foucault's pendulum.

The plane of a pendulum turns against the floor, because the floor turns. Here the Earth turns 100 times
faster than ours, so that a short motion shows it.

Check: the plane turns at `-Omega sin(latitude)`, the part of the Earth's turning about the vertical, all
around in 24 h over `sin(latitude)` on Earth. L. Foucault gave the formula with his experiment to the Academy
in Paris on 3 February 1851 (Comptes rendus, volume 32).
"""

import numpy as np

import symbody as sb

LATITUDE, OMEGA, LENGTH = float(np.radians(48.85)), 0.00729, 10.0  # Paris; rad/s; m
TOLERANCE = 1e-3  # rad; the formula leaves out (Omega/omega)^2 and the turn of a large ellipse by itself
LOOK = {}


def model():
    """Return the mechanism."""
    up = (
        float(np.cos(LATITUDE)),
        0.0,
        float(np.sin(LATITUDE)),
    )  # the bob hangs on the Earth's axis when at rest
    site = {"site": sb.Frame([LENGTH * part for part in up], rotate=[("y", np.pi / 2 - LATITUDE)])}
    earth = sb.Body("Earth", 1.0, (1, 1, 1), frames=site, shapes=[sb.Sphere(0.05)])
    parts = [
        earth,
        sb.Body(
            "Bob",
            1.0,
            frames={"eye": sb.Frame((0, 0, LENGTH))},
            shapes=[sb.Sphere(0.35, color="goldenrod"), sb.Cylinder(0.02, LENGTH, at=(0, 0, LENGTH / 2))],
        ),
        sb.Revolute("axis", "ground", earth, coordinate="turn", motion=f"{OMEGA}*t"),
        sb.Universal("hook", "Earth.site", "Bob.eye", axes=("x", "y"), coordinates=["a", "b"]),
        sb.Force("weight", "Bob", (0, 0, -9.81), resolved_in="Earth.site"),
    ]
    return sb.Model("Foucault's pendulum", parts, initial={"b": -0.02})


def motion():
    """Return five minutes of the swing, the ground being at rest among the stars."""
    return sb.simulate(sb.form_equations(model()), 300.0, times=np.linspace(0, 300, 30001))


def comparison(run):
    """Return the direction of the swing at its farthest points, and the formula."""
    place = run["frame r Bob Earth.site Earth.site"][:2]
    far = np.hypot(*place)
    peaks = 1 + np.flatnonzero((far[1:-1] >= far[:-2]) & (far[1:-1] > far[2:]))
    direction = np.unwrap(2 * np.arctan2(place[1, peaks], place[0, peaks])) / 2  # a line, so modulo pi
    direction -= np.pi * np.round(direction[0] / np.pi)
    return direction, -OMEGA * np.sin(LATITUDE) * run.t[peaks]


def draw(run, ax):
    """Draw the way of the bob over the floor, the first and the last swings stronger."""
    x, y = run["frame r Bob Earth.site Earth.site"][:2]
    ax.plot(x, y, color="C0", alpha=0.25, linewidth=0.7)
    ax.plot(x[:700], y[:700], color="C0", label="first swing")
    ax.plot(x[-700:], y[-700:], color="C3", label="after 300 s")
    ax.set(xlabel="south [m]", ylabel="east [m]", aspect="equal")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
