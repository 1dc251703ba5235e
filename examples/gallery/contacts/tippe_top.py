"""Tippe top.

A ball whose centre of mass is below its middle is spun about its axis, nearly upright. Friction on the
floor, which slows it down, also turns it over: in the end it spins with the centre of mass on top, in the
same sense as seen from above, so that about its own axis it turns the other way. The ball touches the floor
as a rigid contact; its friction is smooth.

Check: for any friction, the product of angular momentum and the vector from the centre of mass to the
contact, `L r`, is constant: J. H. Jellett, A Treatise on the Theory of Friction (1872), chapter 8. So the
spin at the end is `(R - a)/(R + a)` of that at the start; without friction it would stay as it is and not
turn over. Sizes as in S. Rauch-Wojciechowski, M. Skoldstam, T. Glad, Mathematical analysis of the tippe
top, Regul. Chaotic Dyn. 10 (2005) 333.
"""

import numpy as np
from matplotlib.patches import Circle, Wedge

import symbody as sb

RADIUS, MASS, OFF = 0.015, 0.006, 0.3  # m, kg; the centre of mass below the middle, over the radius
INERTIA = (131 / 350, 2 / 5)  # over m R^2: across the axis, about it
MU, SMOOTH, SPIN, LEAN = 0.3, 0.01, 155.0, 0.1  # -, m/s, rad/s, rad
TOLERANCE = 1e-8  # of the product
LOOK = {"view": "isometric", "vectors": ["floor"]}


def model():
    """Return the top; its axis is z, about which it turns last."""
    across, about = (each * MASS * RADIUS**2 for each in INERTIA)
    middle = sb.Frame((0, 0, OFF * RADIUS))
    ball = sb.Sphere(RADIUS, at=(0, 0, OFF * RADIUS), color="steelblue", opacity=0.5)
    heavy = sb.Cylinder(0.8 * RADIUS, 0.5 * RADIUS, at=(0, 0, -0.05 * RADIUS), color="firebrick")
    peg = sb.Cylinder(0.2 * RADIUS, 0.75 * RADIUS, at=(0.0, 0, (OFF + 0.6) * RADIUS), color="gold")
    parts = [
        sb.Body("Top", MASS, (across, across, about), frames={"middle": middle}, shapes=[ball, heavy, peg]),
        sb.Free("flight", "ground", "Top"),
        sb.Contact("floor", "ground", "Top.middle", ["plane", {"sphere": RADIUS}], normal="rigid",
                   friction=sb.Friction(mu=MU, v0=SMOOTH)),
    ]  # fmt: skip
    first = {
        "flight_z": RADIUS * (1 - OFF * np.cos(LEAN)),
        "flight_qw": np.cos(LEAN / 2), "flight_qx": np.sin(LEAN / 2), "flight_wz": SPIN,
    }  # fmt: skip
    floor = [sb.Box((0.3, 0.3, 0.004), at=(0, 0, -0.002), opacity=0.4)]
    return sb.Model("tippe top", parts, gravity=(0, 0, -9.81), ground_shapes=floor, initial=first)


def motion():
    """Return three seconds."""
    return sb.simulate(sb.form_equations(model()), 3.0, times=np.linspace(0, 3, 601), rtol=1e-10)


def lean(run):
    """Return the angle of the axis to the vertical, in which the middle is above the centre of mass at 0."""
    return np.arccos(1 - 2 * (run["flight_qx"] ** 2 + run["flight_qy"] ** 2))


def comparison(run):
    """Return the product of angular momentum and arm over time, and that of the start, over the latter."""
    turns, rates = np.moveaxis(run["frame R Top"], -1, 0), run["frame w Top ground Top"].T
    momentum = np.array([INERTIA[0], INERTIA[0], INERTIA[1]]) * MASS * RADIUS**2 * rates
    arm = RADIUS * (np.array([0, 0, OFF]) - turns[:, 2])  # in the axes of the top, to the contact
    first = INERTIA[1] * MASS * RADIUS**3 * SPIN * (OFF - np.cos(LEAN))
    return np.sum(momentum * arm, axis=1) / first, np.ones(len(run.t))


def draw(run, ax):
    """Draw the top at six times, seen so that its axis leans in the picture."""
    moments = run.at([0.0, 0.4, 0.6, 0.75, 0.9, 2.5])
    thin = {"lw": 1, "ec": "black"}
    for k, (t, angle) in enumerate(zip(moments.t, lean(moments), strict=True)):
        middle = np.array([3 * (k % 3), 1 - 3.6 * (k // 3)])
        up, turn = np.array([np.sin(angle), np.cos(angle)]), -np.degrees(angle)
        ax.add_patch(Circle(middle, 1, fc="lightsteelblue", **thin))
        ax.add_patch(Wedge(middle, 1, turn + 180, turn, fc="firebrick", **thin))
        ax.plot(*np.transpose([middle + 0.45 * up, middle + 0.95 * up]), color="goldenrod", lw=8)
        ax.plot(*(middle - OFF * up), "o", color="black", ms=6)
        ax.plot(middle[0] + np.array([-1.3, 1.3]), [middle[1] - 1] * 2, color="0.5")
        text = f"{t:g} s, {moments['flight_wz'][k]:.0f} rad/s"
        ax.text(middle[0], middle[1] - 1.15, text, ha="center", va="top")
    ax.set(xlim=(-1.4, 7.4), ylim=(-4.4, 2.3), aspect="equal", xticks=[], yticks=[], frame_on=False)
    ax.set_title("It turns over: times, and the spin about its own axis")
