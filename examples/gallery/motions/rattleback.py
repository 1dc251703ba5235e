"""Rattleback.

Half an ellipsoid, whose axes of inertia are turned a little against those of its shape: spun one way it goes
on turning, spun the other way it begins to rattle, stops, and turns back. Celts are such stones.

Check: the equations of the turning alone, derived here: with n the upward normal in the axes of the body and
r = -A n/sqrt(n.A n) + h the point of contact, A the squared half-axes, rolling gives the velocity of the
centre of mass, v = r x w, and with L = I w the moment about it gives L' + w x L = r x m (v' + w x v + g n),
n' = n x w: integrated on its own, without joints, angles or multipliers. Sizes as in T. R. Kane and D. A.
Levinson, Realistic mathematical modeling of the rattleback, Int. J. Non-Linear Mechanics 17 (1982).
"""

import numpy as np
from scipy.integrate import solve_ivp

import symbody as sb

AXES, HEIGHT, MASS = (0.2, 0.03, 0.02), 0.01, 1.0  # m, m below the middle of the ellipsoid, kg
INERTIA, SKEW = (2.0e-4, 1.6e-3, 1.7e-3), -2.0e-5  # kg m^2
START = {"roll": 0.01, "pitch": 0.01, "yaw_dot": -5.0}
TOLERANCE = 1e-4
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
    for z in np.linspace(0.002, 0.018, 5):
        scale = float(np.sqrt(1 - (z / AXES[2]) ** 2))
        yield sb.Box(
            (1.7 * AXES[0] * scale, 1.4 * AXES[1] * scale, 0.004),
            at=(0, 0, float(HEIGHT - z)),
            color="steelblue",
        )


def motion():
    """Return ten seconds, spun the wrong way."""
    return sb.simulate(
        sb.form_equations(model()), 10.0, times=np.linspace(0, 10, 401), rtol=1e-11, atol=1e-13
    )


def turning(run):
    """Return normal and angular velocity from the equations of the turning alone."""
    squares, below = np.square(AXES), np.array([0, 0, HEIGHT])
    inertia = np.diag(INERTIA)
    inertia[0, 1] = inertia[1, 0] = SKEW

    def rates(t, y):
        n, w = y[:3], y[3:]
        change = np.cross(n, w)
        size = np.sqrt(n @ (squares * n))
        r = below - squares * n / size
        slope = squares * (n * (n @ (squares * change)) / size**3 - change / size)  # of r
        turn = -np.cross(np.eye(3), r)  # turn @ w = r x w
        matrix = inertia + MASS * turn.T @ turn
        inertial = np.cross(slope, w) + np.cross(w, np.cross(r, w)) + 9.81 * n
        moment = np.cross(r, MASS * inertial) - np.cross(w, inertia @ w)
        return [*change, *np.linalg.solve(matrix, moment)]

    first = [*normal(run)[:, 0], *run["frame w Stone ground Stone"][:, 0]]
    return solve_ivp(rates, (0, run.t[-1]), first, "DOP853", run.t, rtol=1e-12, atol=1e-13).y


def normal(run):
    """Return the upward normal in the axes of the stone."""
    return np.array([-np.sin(run["pitch"]), np.cos(run["pitch"]) * np.sin(run["roll"]),
                     np.cos(run["pitch"]) * np.cos(run["roll"])])  # fmt: skip


def comparison(run):
    """Return normal and angular velocity, and those of the equations by hand."""
    return np.vstack([normal(run), run["frame w Stone ground Stone"]]), turning(run)


def draw(run, ax):
    """Draw speed and rattling over time."""
    by_hand = turning(run)
    ax.plot(run.t, run["pitch_dot"], color="C1", linewidth=0.7, label="rattling: pitch rate")
    ax.plot(run.t, run["yaw_dot"], color="C0", label="spin")
    ax.plot(run.t[::8], by_hand[5, ::8], ".", color="C3", label="spin, equations by hand")
    ax.axhline(0, color="gray", linewidth=0.5)
    ax.set(xlabel="t [s]", ylabel="rate [rad/s]")
    ax.legend(loc="best")
