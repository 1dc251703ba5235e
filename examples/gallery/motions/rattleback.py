"""Rattleback.

Half an ellipsoid, whose axes of inertia are turned a little against those of its shape: spun one way it
keeps turning, spun the other way it begins to rattle, stops, and turns back. Its other name, celt, comes
from stone axes that behave like this.

Check: the equations of the turning alone, derived here: with `n` the upward normal in the axes of the
body and `r = -A n/sqrt(n.A n) + h` the point of contact, `A` the squared half-axes, rolling gives the
velocity of the centre of mass, `v = r cross w`, and the contact, whose moment about the centre turns
`L = I w`, gives `L' + w cross L = r cross m (v' + w cross v + g n)`, `n' = n cross w`: three equations
for `w'` without joints, multipliers or angles, of which all samples must be solutions. Sizes as in T. R.
Kane and D. A. Levinson, Realistic mathematical modeling of the rattleback, Int. J. Non-Linear Mechanics
17 (1982).
"""

import numpy as np

import symbody as sb

AXES, HEIGHT, MASS = (0.2, 0.03, 0.02), 0.01, 1.0  # m, m below the middle of the ellipsoid, kg
INERTIA, SKEW = (2.0e-4, 1.6e-3, 1.7e-3), -2.0e-5  # kg m^2
START = {"roll": 0.01, "pitch": 0.01, "yaw_dot": -5.0}
TOLERANCE = 1e-6  # rad/s^2
LOOK = {"times": (0.0,), "view": (0.6, -1.0, 0.5)}


def model():
    """Return the mechanism: a free body, the height and the velocity of whose point of contact are zero."""
    a, b, c = AXES
    # The normal in the axes of the body, after turns by yaw, pitch and roll about z, y, x.
    n = ("(-sin(pitch))", "(cos(pitch)*sin(roll))", "(cos(pitch)*cos(roll))")
    size = f"sqrt({a}^2*{n[0]}^2 + {b}^2*{n[1]}^2 + {c}^2*{n[2]}^2)"
    r = (f"(-{a}^2*{n[0]}/{size})", f"(-{b}^2*{n[1]}/{size})", f"({HEIGHT} - {c}^2*{n[2]}/{size})")
    w = ("(roll_dot - yaw_dot*sin(pitch))", "(pitch_dot*cos(roll) + yaw_dot*cos(pitch)*sin(roll))",
         "(yaw_dot*cos(pitch)*cos(roll) - pitch_dot*sin(roll))")  # fmt: skip
    slip = [
        f"({w[1]}*{r[2]} - {w[2]}*{r[1]})",
        f"({w[2]}*{r[0]} - {w[0]}*{r[2]})",
        f"({w[0]}*{r[1]} - {w[1]}*{r[0]})",
    ]
    # In the axes of yaw alone: forward and to the left.
    forward = f"cos(pitch)*{slip[0]} + sin(pitch)*(sin(roll)*{slip[1]} + cos(roll)*{slip[2]})"
    left = f"cos(roll)*{slip[1]} - sin(roll)*{slip[2]}"
    along, across = "(x_dot*cos(yaw) + y_dot*sin(yaw))", "(y_dot*cos(yaw) - x_dot*sin(yaw))"
    shapes = [sb.Box((0.36, 0.044, 0.004), at=(0, 0, HEIGHT - 0.002), color="orange"),
              *hull(), sb.Sphere(0.008, at=(0.15, 0, HEIGHT + 0.006), color="crimson")]  # fmt: skip
    parts = [
        sb.Body("Stone", MASS, INERTIA, products=(SKEW, 0, 0), shapes=shapes),
        sb.Cartesian("place", "ground", "Carrier", coordinates=["x", "y", "z"]),
        sb.Body("Carrier"),
        sb.Spherical("turning", "Carrier", "Stone", angles="321", coordinates=["yaw", "pitch", "roll"]),
        sb.Constraint("touches", f"z - {size} + {HEIGHT}*{n[2]}"),
        sb.Constraint("rolls", [f"{along} + {forward}", f"{across} + {left}"]),
    ]
    table = [sb.Box((0.5, 0.5, 0.01), at=(0, 0, -0.005), opacity=0.4)]
    return sb.Model(
        "rattleback", parts, gravity=(0, 0, -9.81), ground_shapes=table, initial={**START, "z": 0.01}
    )


def hull():
    """Return thin slices of the half ellipsoid."""
    for z in np.linspace(0.006, 0.018, 5):
        scale = float(np.sqrt(1 - (z / AXES[2]) ** 2))
        yield sb.Box(
            (1.7 * AXES[0] * scale, 1.4 * AXES[1] * scale, 0.004),
            at=(0, 0, float(HEIGHT - z)),
            color="steelblue",
        )


def motion():
    """Return ten seconds, spun the wrong way."""
    return sb.simulate(sb.form_equations(model()), 10.0, times=np.linspace(0, 10, 1001), rtol=1e-9)


def comparison(run):
    """Return the angular acceleration in the axes of the stone, and that of the equations by hand."""
    sines, cosines = (each([run["pitch"], run["roll"]]) for each in (np.sin, np.cos))
    n = np.transpose([-sines[0], cosines[0] * sines[1], cosines[0] * cosines[1]])
    w, squares = run["frame w Stone ground Stone"].T, np.square(AXES)
    inertia = np.diag(INERTIA) + SKEW * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])
    size = np.sqrt(np.sum(squares * n**2, axis=1, keepdims=True))
    r, n_rate = np.array([0, 0, HEIGHT]) - squares * n / size, np.cross(n, w)
    r_rate = squares * (n * np.sum(squares * n * n_rate, axis=1, keepdims=True) / size**3 - n_rate / size)
    turn = -np.cross(np.eye(3), r[:, None])  # turn @ w is r x w
    force = MASS * (np.cross(r_rate, w) + np.cross(w, np.cross(r, w)) + 9.81 * n)  # less that of w'
    moment = np.cross(r, force) - np.cross(w, w @ inertia)
    acceleration = np.linalg.solve(inertia + MASS * turn.mT @ turn, moment[..., None])[..., 0]
    return run["frame wdot Stone ground Stone"].T, acceleration


def draw(run, ax):
    """Draw speed and rattling over time."""
    ax.plot(run.t, run["pitch_dot"], color="C1", linewidth=0.7, label="rattling: pitch rate")
    ax.plot(run.t, run["yaw_dot"], color="C0", label="spin")
    ax.axhline(0, color="gray", linewidth=0.5)
    ax.set(xlabel="t [s]", ylabel="rate [rad/s]")
    ax.legend(loc="lower right")
