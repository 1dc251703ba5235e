"""Ball with backspin.

A ball of rubber is thrown forward with backspin, bounces, and rolls back. Its contact is rigid: at each
bounce friction stops its lowest point where it can, else that slides through the impact; and when the bounces
have ended, a series with a last moment, the ball rolls.

Check: a bounce leaves `e` of the speed down, and changes that along by `2/7` of the slip, or by `mu(1 + e)`
times the speed down where that is less; each flight lasts `2 v/g`. When all has ended it rolls with
`5/7 v + 2/7 R w`, however it has bounced, as its angular momentum about any point of the floor is kept:
W. Goldsmith, Impact (1960), chapter 3.
"""

import matplotlib.pyplot as plt
import numpy as np

import symbody as sb

RADIUS, RESTITUTION, MU, HEIGHT = 0.1, 0.7, 0.15, 0.8
SPEED, SPIN = 1.5, -60.0  # m/s along x; rad/s, a ball that rolls along x turns forward
TOLERANCE = 1e-8  # m/s
LOOK = {"view": "front", "traces": ["Ball"]}


def model():
    """Return the ball and its floor."""
    stripe = sb.Cylinder(1.02 * RADIUS, 0.03, rotate=[("y", "pi/2")], color="white")
    inertia = 0.4 * 1.0 * RADIUS**2
    parts = [
        sb.Body("Ball", 1.0, (inertia,) * 3, shapes=[sb.Sphere(RADIUS, color="firebrick"), stripe]),
        sb.Planar("move", "ground", "Ball", axis="y", coordinates=["z", "x", "turn"]),
        sb.Contact("floor", "ground", "Ball", ["plane", {"sphere": RADIUS}], normal="rigid",
                   restitution=RESTITUTION, friction=sb.Friction(mu=MU)),
    ]  # fmt: skip
    floor = [sb.Box((4.0, 1.0, 0.05), at=(0.0, 0, -0.025), opacity=0.4)]
    first = {"z": HEIGHT + RADIUS, "x_dot": SPEED, "turn_dot": SPIN}
    return sb.Model("backspin", parts, gravity=(0, 0, -9.81), ground_shapes=floor, initial=first)


def motion():
    """Return four seconds from the throw."""
    return sb.simulate(sb.form_equations(model()), 4.0, rtol=1e-10)


def comparison(run):
    """Return the speeds along and of the spin after each of ten bounces and at the end, and the formulas."""
    bounces = [event for event in run.events if event.name == "floor impact"][:10]
    behind = [np.searchsorted(run.t, event.t, side="right") - 1 for event in bounces]
    v, w, down = SPEED, SPIN, np.sqrt(2 * 9.81 * HEIGHT)
    formula = []
    for _ in bounces:
        slip = v - RADIUS * w
        change = -np.sign(slip) * min(2 / 7 * abs(slip), MU * (1 + RESTITUTION) * down)
        v, w, down = v + change, w - 2.5 * change / RADIUS, RESTITUTION * down
        formula.append((v, RADIUS * w))
    rolls = 5 / 7 * SPEED + 2 / 7 * RADIUS * SPIN
    speeds = np.array([run["x_dot"], RADIUS * run["turn_dot"]]).T[[*behind, -1]]
    return speeds, np.array([*formula, (rolls, rolls)])


def draw(run, ax):
    """Draw the path of its centre, and the ball at some times with the stripe that shows its spin."""
    ax.fill_between([-0.4, 1.3], -0.12, 0, color="0.85")
    path = run.at(np.linspace(0.0, run.t[-1], 1001))
    ax.plot(path["x"], path["z"], color="C0", lw=1)
    moments = run.at([0.0, 0.2, 0.404, 0.69, 0.97, 1.36, 1.84, 2.4, 3.0])
    for x, z, turn in zip(moments["x"], moments["z"], moments["turn"], strict=True):
        ax.add_patch(plt.Circle((x, z), RADIUS, color="firebrick", alpha=0.6))
        stripe = RADIUS * np.array([np.sin(turn), np.cos(turn)])
        ax.plot([x - stripe[0], x + stripe[0]], [z - stripe[1], z + stripe[1]], color="white", lw=2)
    ax.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", xlim=(-0.4, 1.3), ylim=(-0.12, 1.05))
    ax.set_title("Thrown to the right, it rolls back")
