"""Bicycle that rides by itself.

A rear frame with a rigid rider, a front frame on an inclined axis, two rolling wheels: between 4.3 and 6
m/s it stays upright with no hands on the handlebar, because it steers into each fall.

Check: lean and steer after a small push are those of the linear equations
`M q'' + v C1 q' + (g K0 + v^2 K2) q = 0`, by the matrix exponential, with the benchmark matrices of J. P.
Meijaard, J. M. Papadopoulos, A. Ruina and A. L. Schwab, Linearized dynamics equations for the balance and
steer of a bicycle: a benchmark and review, Proc. R. Soc. A 463 (2007), 1955-1982; the motion is that of
the whole nonlinear equations.
"""

import numpy as np
from scipy.linalg import expm

import symbody as sb

SPEED, PUSH = 4.6, 0.02  # m/s, rad/s
REAR, FRONT, BASE, TRAIL, TILT = 0.3, 0.35, 1.02, 0.08, np.pi / 10  # m, m, m, m, rad
# Of the paper, lean to the right and steer to the right.
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0.0, 76.59734589573222], [0.0, 2.65431523794604]])
C1 = np.array([[0.0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
TOLERANCE = 1e-3  # of the largest lean and steer
LOOK = {"times": (0.8,), "view": (0.6, -1.0, 0.13)}


def tube(start, end, at, color):
    """Return a tube between two points of the plane x z, of a body whose centre of mass is there too."""
    (x, z), (u, w) = np.array(start) - at, np.array(end) - at
    turn = float(np.arctan2(u - x, w - z))
    return sb.Capsule(0.022, float(np.hypot(u - x, w - z)), at=(float(x + u) / 2, 0, float(z + w) / 2),
                      rotate=[("y", turn)], color=color)  # fmt: skip


def wheel(name, mass, across, along, radius):
    """Return a wheel with two spokes, which show how it turns."""
    bars = [
        sb.Box((2 * radius - 0.04, 0.045, 0.025), rotate=[("y", a)], color="silver") for a in (0.0, np.pi / 2)
    ]
    rim = sb.Cylinder(radius, 0.035, rotate=[("x", "pi/2")], color="dimgray")
    return sb.Body(name, mass, (across, along, across), shapes=[rim, *bars])


def model():
    """Return the mechanism: x forward, y to the left, z up."""
    rider, fork = np.array([0.3, 0.9]), np.array([0.9, 0.7])  # centres of mass, x and z
    foot = np.array([BASE + TRAIL, 0.0])  # where the steer axis meets the ground
    top, crown = (foot + z * np.array([-np.tan(TILT), 1.0]) for z in (0.95, 0.7))
    frames = [{"axle": sb.Frame((x - at[0], 0, z - at[1])),
               "head": sb.Frame((float(crown[0] - at[0]), 0, float(crown[1] - at[1])))}
              for at, x, z in ((rider, 0.0, REAR), (fork, BASE, FRONT))]  # fmt: skip
    frame = [
        tube(*ends, rider, "steelblue")
        for ends in ([(0, REAR), (0.25, 0.85)], [(0, REAR), (0.42, 0.3)], [(0.42, 0.3), (0.22, 0.95)],
                     [(0.42, 0.3), crown], [(0.25, 0.85), crown])
    ]  # fmt: skip
    person = [
        tube((0.22, 0.98), (0.5, 1.35), rider, "orange"),
        sb.Sphere(0.11, at=(0.26, 0, 0.53), color="orange"),
    ]
    x, z = (float(each) for each in top - fork)
    bar = sb.Cylinder(0.018, 0.5, at=(x, 0, z), rotate=[("x", "pi/2")], color="crimson")
    front = [tube((BASE, FRONT), top, fork, "crimson"), bar]
    parts = [
        sb.Body("RearFrame", 85, (9.2, 11, 2.8), products=(0, -2.4, 0), frames=frames[0],
                shapes=frame + person),
        sb.Body("FrontFrame", 4, (0.05892, 0.06, 0.00708), products=(0, 0.00756, 0),
                frames=frames[1], shapes=front),
        wheel("RearWheel", 2, 0.0603, 0.12, REAR), wheel("FrontWheel", 3, 0.1405, 0.28, FRONT),
        sb.Free("frame", "ground", "RearFrame.axle", angles="312",
                coordinates=["x", "y", "z", "yaw", "lean", "pitch"]),
        sb.Revolute("rear hub", "RearFrame.axle", "RearWheel", axis="y", coordinate="rear"),
        sb.Revolute("steering", "RearFrame.head", "FrontFrame.head",
                    axis=(float(-np.sin(TILT)), 0, float(np.cos(TILT))), coordinate="steer"),
        sb.Revolute("front hub", "FrontFrame.axle", "FrontWheel", axis="y", coordinate="front"),
        sb.Rolling("rear tyre", "ground", "RearWheel", REAR, axis="y"),
        sb.Rolling("front tyre", "ground", "FrontWheel", FRONT, axis="y"),
    ]  # fmt: skip
    return sb.Model("riderless bicycle", parts, gravity=(0, 0, -9.81),
                    initial={"z": REAR, "rear_dot": SPEED / REAR, "lean_dot": PUSH})  # fmt: skip


def motion():
    """Return four seconds after the push."""
    first = dict.fromkeys(("x", "y", "yaw", "lean", "steer", "rear", "front", "steer_dot"), 0.0)
    first |= {"rear_dot": SPEED / REAR, "lean_dot": PUSH}
    return sb.simulate(sb.form_equations(model()), 4.0, first, times=np.linspace(0, 4, 201))


def comparison(run):
    """Return lean and steer over their largest values, and the solution of the linear equations."""
    rates = np.linalg.solve(M, np.hstack([-SPEED * C1, -9.81 * K0 - SPEED**2 * K2]))
    A = np.vstack([rates, np.eye(2, 4)])
    linear = np.array([expm(A * t)[2:, 0] * PUSH for t in run.t]).T
    sizes = np.abs(linear).max(axis=1, keepdims=True)
    return np.array([run["lean"], -run["steer"]]) / sizes, linear / sizes
