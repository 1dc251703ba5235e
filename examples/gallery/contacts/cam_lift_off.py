"""Cam that its follower leaves.

An eccentric disc lifts a roller, which weight and a spring press back. As the cam turns faster the force
between them falls where the roller is highest, until it is zero: there the roller takes off, flies, and
strikes the cam again. Valve trains have springs as stiff as they are so that this does not happen.

Check: in contact the middles of disc and roller are `R + r` apart, so that the lift is `y = e sin(p) +
sqrt((R + r)^2 - e^2 cos^2(p))`, and the cam presses along the line of the middles with `(m (y'' + g) + k (y
- l))/cos` of its angle to the vertical. The roller leaves where that is zero, and swings with `sqrt(k/m)`
about its rest until it meets the cam: H. A. Rothbart, Cams (1956), chapter 8.
"""

import numpy as np
from matplotlib.patches import Circle, Rectangle
from scipy.optimize import brentq

import symbody as sb

DISC, OFF, ROLLER = 0.05, 0.02, 0.015  # m: radius of the cam, its eccentricity, radius of the roller
MASS, STIFFNESS, FREE, G = 0.4, 400.0, 0.02, 9.81  # kg, N/m, m: height of the roller with the spring free
SLOW, GAIN = 15.0, 40.0  # rad/s, rad/s^2: the cam turns faster and faster
TOLERANCE = 1e-8  # m, kN
LOOK = {"view": "front", "vectors": ["cam"]}


def model():
    """Return cam and follower; y is up."""
    angle = f"{SLOW}*t + {GAIN / 2}*t^2"
    edge = f"{OFF}*cos(angle) + sqrt({DISC}^2 - {OFF}^2*sin(angle)^2)"
    parts = [
        sb.Body("Cam", 1.0, shapes=[
            sb.Cylinder(DISC, 0.02, at=(OFF, 0, 0), color="orange"),
            sb.Cylinder(0.008, 0.03, color="dimgray"),
        ]),
        sb.Body("Follower", MASS, shapes=[
            sb.Cylinder(ROLLER, 0.02, color="steelblue"),
            sb.Box((0.012, 0.1, 0.012), at=(0, 0.06, 0), color="steelblue"),
        ]),
        sb.Revolute("shaft", "ground", "Cam", axis="z", coordinate="p", motion=angle),
        sb.Prismatic("guide", "ground", "Follower", axis="y", coordinate="y",
                     force=sb.Drive(stiffness=STIFFNESS, free=FREE)),
        sb.Contact("cam", "Cam", "Follower", [{"cam": edge}, {"disc": ROLLER}], normal="rigid"),
    ]  # fmt: skip
    return sb.Model(
        "cam", parts, gravity=(0, -G, 0), initial={"y": float(np.sqrt((DISC + ROLLER) ** 2 - OFF**2))}
    )


def motion():
    """Return a second and a half."""
    return sb.simulate(sb.form_equations(model()), 1.5, rtol=1e-10)


def lift(t):
    """Return lift, rate, acceleration of the roller in contact, and the cosine of the line of middles."""
    p, w = SLOW * t + GAIN / 2 * t**2, SLOW + GAIN * t
    s, c, root = np.sin(p), np.cos(p), np.sqrt((DISC + ROLLER) ** 2 - OFF**2 * np.cos(p) ** 2)
    slope = OFF * c + OFF**2 * s * c / root
    curve = -OFF * s + OFF**2 * (c * c - s * s) / root - OFF**4 * (s * c) ** 2 / root**3
    return OFF * s + root, slope * w, curve * w**2 + slope * GAIN, root / (DISC + ROLLER)


def force(t):
    """Return the force between cam and roller in contact."""
    y, _, acceleration, cosine = lift(t)
    return (MASS * (acceleration + G) + STIFFNESS * (y - FREE)) / cosine


def flights():
    """Yield when the roller leaves the cam and strikes it again, and its height as a function of time."""
    w, rest, step, t = np.sqrt(STIFFNESS / MASS), FREE - MASS * G / STIFFNESS, 1e-4, 0.0
    while True:
        grid = np.arange(t, 1.5, step)
        if not (force(grid) < 0).any():
            return
        t = grid[np.argmax(force(grid) < 0)]
        leaves = brentq(force, t - step, t)
        y, rate, *_ = lift(leaves)

        def height(t, leaves=leaves, y=y, rate=rate):
            return rest + (y - rest) * np.cos(w * (t - leaves)) + rate / w * np.sin(w * (t - leaves))

        grid = leaves + np.arange(10 * step, 0.2, step)
        t = grid[np.argmax(height(grid) < lift(grid)[0])]
        t = brentq(lambda t, height=height: height(t) - lift(t)[0], t - step, t)
        yield leaves, t, height


def comparison(run):
    """Return height of the roller and force of the cam, and these by hand; the force in kN."""
    times = np.linspace(0, 1.45, 2001)
    height, pressed = lift(times)[0], force(times)
    for leaves, lands, flight in flights():
        flies = (times > leaves) & (times < lands)
        height[flies], pressed[flies] = flight(times[flies]), 0.0
    found = run.at(times)
    return np.array([found["y"], found["contact_force cam z"] / 1e3]), np.array([height, pressed / 1e3])


def draw(run, ax):
    """Draw cam and follower at three times of a turn, the force between them, and the gap."""
    for k, t in enumerate((1.335, 1.356, 1.39)):
        at, x = run.at(t), 0.19 * k
        turned = SLOW * t + GAIN / 2 * t**2
        middle = (x + OFF * np.cos(turned), OFF * np.sin(turned))
        ax.add_patch(Circle(middle, DISC, fc="orange", ec="black"))
        ax.plot(x, 0, "o", color="dimgray", ms=7)
        ax.plot(*middle, "+", color="black", ms=7)
        ax.add_patch(Circle((x, at["y"]), ROLLER, fc="steelblue", ec="black"))
        ax.add_patch(Rectangle((x - 0.005, at["y"]), 0.01, 0.09, fc="steelblue", ec="black"))
        pressed = at["contact_force cam z"]
        if pressed > 0:
            along = (np.array([x, at["y"]]) - middle) / (DISC + ROLLER)
            start = middle + DISC * along
            ax.annotate(
                "", start, start - 1.2e-3 * pressed * along, arrowprops={"color": "crimson", "width": 2}
            )
        text = f"{pressed:.0f} N" if pressed > 0 else f"gap {1e3 * at['gap cam']:.1f} mm"
        ax.text(x, -0.085, f"{SLOW + GAIN * t:.0f} rad/s\n{text}", ha="center", va="top")
    ax.set(xlim=(-0.1, 0.48), ylim=(-0.13, 0.22), aspect="equal", xticks=[], yticks=[], frame_on=False)
    ax.set_title("Pressed, about to leave, in flight")
