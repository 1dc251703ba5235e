"""Hopping leg.

A body on a springy leg hops on the spot. Landing, the foot loses all its speed, as its contact with the
floor is rigid and without rebound; what is lost is given back by a push along the leg, from where it is
shortest to where it is as long as the spring. The foot leaves the floor where the stretched spring lifts
its weight.

Check: on the floor the body swings about its rest with the frequency `sqrt(k/M)`; in the air body and foot
swing against each other with `sqrt(k/M + k/m)` about the length of the spring, while their centre of mass
falls freely. Of cosines and parabolas each hop is put together, from landing to shortest leg, to the end of
the push, to take-off where `k (s - L) = m g`, to landing. A leg that is all of a machine: M. H. Raibert,
Legged Robots That Balance (1986), chapter 2.
"""

import numpy as np
from matplotlib.patches import Rectangle
from scipy.optimize import brentq

import symbody as sb

BODY, FOOT = 8.0, 0.8  # kg
LENGTH, STIFFNESS, PUSH, HEIGHT, G = 0.6, 3000.0, 60.0, 0.25, 9.81  # m, N/m, N, m
TOLERANCE = 1e-5  # m
LOOK = {"view": "front", "vectors": ["foot"]}


def model():
    """Return body, leg and foot, which move up and down."""
    pushes = "if(s < L and s_dot > 0 and h < 1e-9, P, 0)"  # on the floor, while the leg extends
    parts = [
        sb.Body("Foot", FOOT, shapes=[sb.Sphere(0.03, at=(0, 0, 0.03), color="dimgray"),
                                      sb.Cylinder(0.012, 0.4, at=(0, 0, 0.22), color="gray")]),
        sb.Body("Body", BODY, shapes=[sb.Box((0.3, 0.16, 0.14), color="orange")]),
        sb.Prismatic("rail", "ground", "Foot", axis="z", coordinate="h"),
        sb.Prismatic("leg", "Foot", "Body", axis="z", coordinate="s",
                     force=sb.Drive(applied=pushes, stiffness="k", free="L")),
        sb.Contact("foot", "ground", "Foot", ["plane", "point"], normal="rigid"),
    ]  # fmt: skip
    values = {"L": LENGTH, "k": STIFFNESS, "P": PUSH}
    return sb.Model("hopper", parts, gravity=(0, 0, -G), parameters=values, initial={"h": HEIGHT, "s": "L"})


def motion():
    """Return some hops."""
    return sb.simulate(sb.form_equations(model()), 4.0, rtol=1e-10)


def hand(times):
    """Return height of the foot and length of the leg by cosines and parabolas, one phase after the other."""
    M, m, k, L = BODY, FOOT, STIFFNESS, LENGTH
    share, t, phase = M / (M + m), 0.0, "air"
    h, s, h_dot, s_dot = HEIGHT, L, 0.0, 0.0
    heights, lengths = np.empty(len(times)), np.empty(len(times))
    while t < times[-1]:
        air, push = phase == "air", PUSH * (phase == "push")
        w = np.sqrt(k / M + k / m * air)
        rest = L if air else L + (push - M * G) / k
        fall = (h + share * s, h_dot + share * s_dot) if air else (0.0, 0.0)

        def leg(d, a=s - rest, b=s_dot / w, w=w, rest=rest):
            return rest + a * np.cos(w * d) + b * np.sin(w * d), w * (b * np.cos(w * d) - a * np.sin(w * d))

        def foot(d, y=fall, air=air, leg=leg):
            return air * (y[0] + y[1] * d - G / 2 * d**2 - share * leg(d)[0])

        # What falls to zero where a phase ends.
        end = {
            "air": foot,
            "shrinks": lambda d, leg=leg: -leg(d)[1],
            "push": lambda d, leg=leg: L - leg(d)[0],
            "stretch": lambda d, leg=leg: L + m * G / k - leg(d)[0],
        }[phase]
        grid = np.linspace(1e-4, 1.0, 5001)
        last = np.argmax(end(grid) < 0)
        d = brentq(end, grid[last - 1], grid[last], xtol=1e-15)
        here = (times >= t) & (times <= t + d)
        heights[here], lengths[here] = foot(times[here] - t), leg(times[here] - t)[0]
        # Landing, the foot stops and the body keeps its velocity.
        s, s_dot = leg(d)[0], leg(d)[1] if not air else fall[1] - G * d + (1 - share) * leg(d)[1]
        t, h, h_dot = t + d, 0.0, 0.0
        shrinks = air and s_dot < 0
        stretched = "air" if s - L > 0.999999 * m * G / k else "stretch"
        phase = "shrinks" if shrinks else "push" if s < L - 1e-9 else stretched
    return heights, lengths


def comparison(run):
    """Return height of the foot and length of the leg, and these by hand."""
    times = np.linspace(0.0, 3.9, 1001)
    found = run.at(times)
    return np.array([found["h"], found["s"]]), np.array(hand(times))


def draw(run, ax):
    """Draw the paths of body and foot over time, and the leg at some times."""
    path = run.at(np.linspace(0.0, 2.0, 1001))
    ax.axhspan(-0.08, 0, color="0.85")
    ax.plot(path.t, path["h"] + path["s"], color="C1", lw=1)
    ax.plot(path.t, path["h"], color="0.4", lw=1)
    moments = run.at([0.0, 0.15, 0.315, 0.44, 0.65, 0.85, 0.98, 1.1, 1.32, 1.645, 1.9])
    turns = 0.02 * np.array([0, 0, 1, -1, 1, -1, 1, -1, 0, 0])
    for t, h, s in zip(moments.t, moments["h"], moments["s"], strict=True):
        ax.plot(t + turns, h + s * np.array([0, 0.2, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.8, 1]), "k-", lw=1)
        ax.plot(t, h, "o", color="0.3", ms=6)
        ax.add_patch(Rectangle((t - 0.045, h + s - 0.05), 0.09, 0.12, fc="orange", ec="black", lw=0.8))
    ax.set(xlabel="t [s]", ylabel="z [m]", xlim=(-0.08, 2.0), ylim=(-0.08, 1.15))
    ax.set_title("A leg that hops")
