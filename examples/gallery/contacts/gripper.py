"""Gripper that lifts a box.

Two fingers press a box from both sides, lift it off a table and hold it by friction alone. Then the grip is
loosened for half a second: the box slips, and is caught where it is tightened again. The fingers are rigid
contacts that stick, so that the box does not creep while it is held; the table is soft, since between rigid
ones nothing would say how much of the weight it bears.

Check: two fingers hold at most `2 mu N`. So the box follows the hand while `m (g + a) <= 2 mu N`, with `a`
the acceleration of the hand, and each finger carries half of `m (g + a)`, less what the table bears. It
slips where `2 mu N` falls to `m g`, from there with `z'' = 2 mu N/m - g` until its speed is zero again:
integrals by hand.
"""

import numpy as np
from scipy.optimize import brentq

import symbody as sb

MASS, MU, GRIP = 0.5, 0.6, 6.0  # kg, -, N
EDGES, TIP, G = (0.08, 0.08, 0.12), 0.012, 9.81  # m
RISE, LIFTS = 0.15, (0.4, 1.2)  # m; s, when the hand begins and ends to rise
LOOSE, SWING, RATE = (
    1.5,
    2.8,
    4 * np.pi,
)  # s; N; rad/s: the grip is GRIP - SWING (1 - cos(RATE (t - LOOSE)))/2
STIFFNESS = 2.5e3  # N/m, of the table under each corner
SINKS = MASS * G / 4 / STIFFNESS
TOLERANCE = 1e-6  # m, N
LOOK = {
    "times": (0.2, 1.3, 2.0),
    "view": (0.4, -1.0, 0.2),
    "vectors": ["left", "right", "floor"],
    "ghosts": 0.3,
}


def model():
    """Return hand, fingers and box; z is up, the fingers move along x."""
    begin, end = LIFTS
    share = f"min(1, max(0, (t - {begin})/{end - begin}))"
    swing = f"{SWING / 2}*(1 - cos({RATE}*(t - {LOOSE})))"
    grip = f"{GRIP} - if(t > {LOOSE} and t < {LOOSE + 2 * np.pi / RATE}, {swing}, 0)"
    a, _, h = EDGES
    post = sb.Cylinder(0.018, 0.12, at=(0, 0, 0.07), color="dimgray")
    parts = [
        sb.Body("Hand", 1.0, frames={"post": sb.Frame((0, 0, 0.14)), "rail": sb.Frame((0, 0, 0.01))},
                shapes=[sb.Box((0.26, 0.05, 0.03), color="dimgray"), post]),
        sb.Body("Box", MASS, (8e-4,) * 3, shapes=[sb.Box(EDGES, color="peru")]),
        sb.Prismatic("lift", "ground.post", "Hand.post", axis="z", coordinate="height",
                     motion=f"{RISE}*(1 - cos(pi*{share}))/2"),
        sb.Planar("move", "ground", "Box", axis="y", coordinates=["z", "x", "turn"]),
        sb.Contact("floor", "ground", "Box", ["plane", {"box": EDGES}],
                   normal=sb.NormalForce(stiffness=STIFFNESS, exponent=1)),
    ]  # fmt: skip
    for side, way in (("left", 1), ("right", -1)):
        finger = side.capitalize()
        pad = [sb.Sphere(TIP, color="steelblue"),
               sb.Box((0.016, 0.03, 0.12), at=(-way * 0.006, 0, 0.05), color="steelblue")]  # fmt: skip
        parts += [
            sb.Body(finger, 0.05, frames={"top": sb.Frame((0, 0, 0.13))}, shapes=pad),
            sb.Prismatic(f"slide {side}", "Hand.rail", f"{finger}.top", axis=(way, 0, 0),
                         coordinate=f"{side}_x", force=sb.Drive(applied=grip, damping=1.0)),
            sb.Contact(side, finger, "Box", [{"sphere": TIP}, {"box": EDGES}], normal="rigid",
                       friction=sb.Friction(mu=MU)),
        ]  # fmt: skip
    ground = {"post": sb.Frame((0, 0, h / 2 + 0.25))}
    open_by = -(a / 2 + TIP)
    first = {"z": h / 2 - SINKS, "left_x": open_by, "right_x": open_by}
    table = [sb.Box((0.5, 0.3, 0.02), at=(0, 0, -0.01), color="lightgray")]
    return sb.Model("gripper", parts, gravity=(0, 0, -G), ground=ground, ground_shapes=table, initial=first)


def motion():
    """Return two and a half seconds."""
    return sb.simulate(sb.form_equations(model()), 2.4, times=np.linspace(0, 2.4, 450), rtol=1e-10)


def comparison(run):
    """Return the height of the box and what a finger carries, and the formulas."""
    t, (begin, end) = run.t, LIFTS
    phase = np.pi * np.clip((t - begin) / (end - begin), 0, 1)
    rise = RISE * (1 - np.cos(phase)) / 2
    rises = RISE / 2 * (np.pi / (end - begin)) ** 2 * np.cos(phase) * ((t >= begin) & (t < end))
    table = 4 * STIFFNESS * np.maximum(0, SINKS - rise)  # the springs of the table
    carried = MASS * (G + rises) - table

    # It slips where 2 mu N falls to m g; speed and way from there, integrals of 2 mu N/m - g.
    slope, mean, swing, s = 2 * MU / MASS, GRIP - SWING / 2, SWING / 2, t - LOOSE
    first = np.arccos((G / slope - mean) / swing) / RATE

    def speed(s):
        grown = (np.sin(RATE * s) - np.sin(RATE * first)) / RATE
        return (slope * mean - G) * (s - first) + slope * swing * grown

    last = brentq(speed, np.pi / RATE, 2 * np.pi / RATE)
    slips, since = (s > first) & (s < last), np.clip(s, first, last) - first
    grown = (np.cos(RATE * first) - np.cos(RATE * (since + first))) / RATE - np.sin(RATE * first) * since
    way = (slope * mean - G) * since**2 / 2 + slope * swing * grown / RATE
    carried = np.where(slips, 2 * MU * (mean + swing * np.cos(RATE * s)), carried)
    height = EDGES[2] / 2 - SINKS + rise + way
    return np.array([run["z"], np.hypot(*run["contact_force left"][:2])]), np.array([height, carried / 2])
