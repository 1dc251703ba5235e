"""Rolling coin.

A leaning coin rolls in a circle: the faster it rolls, the less it leans. Near the floor its centre hardly
moves while the point of contact runs around ever faster.

Check: with `W` the rate around, `h` the angle of the axle from the vertical and `w` the turning about the
axle, `(C + m a^2) w W sin(h) - A W^2 sin(h) cos(h) + m g a cos(h) = 0`, `C = 2 A = m a^2/2`: the moment
of weight and contact about the centre turns the angular momentum. The centre goes round with radius
`a w/W`. For `w = 0` this is `W^2 = 4 g/(a sin(h))`, H. K. Moffatt, Euler's disk and its finite-time
singularity, Nature 404 (2000).
"""

import numpy as np

import symbody as sb

RADIUS, MASS, LEAN, RATE = 0.1, 0.2, 1.1, 6.0  # m, kg, rad of the axle from the vertical, rad/s around
TOLERANCE = 1e-6
LOOK = {
    "times": (0.0, 0.16, 0.32, 0.48),
    "traces": ["Coin"],
    "view": {"direction": (0.7, -1.0, 0.75), "zoom": 1.15},
}


def turning():
    """Return the angular velocity about the axle in even rolling [rad/s]."""
    g = 9.81 / RADIUS
    return float((RATE**2 * np.sin(LEAN) / 4 - g) * np.cos(LEAN) / (1.5 * RATE * np.sin(LEAN)))


def model():
    """Return the mechanism."""
    shapes = [
        sb.Cylinder("a", 0.008, color="goldenrod"),
        sb.Box((0.15, 0.02, 0.012), color="sienna"),
        sb.Sphere(0.012, at=(0.08, 0, 0), color="crimson"),
    ]
    coin = sb.Body("Coin", "m", ("m*a^2/4", "m*a^2/4", "m*a^2/2"), shapes=shapes)
    names = ["x", "y", "z", "yaw", "lean", "spin"]
    parts = [
        sb.Free("flight", "ground", coin, angles="313", coordinates=names),
        sb.Rolling("contact", "ground", coin, radius="a", axis="z"),
    ]
    w = turning()
    path = w * RADIUS  # velocity of the centre along the line of contact, at first the x axis
    first = {
        "z": RADIUS * np.sin(LEAN),
        "lean": LEAN,
        "yaw_dot": RATE,
        "spin_dot": w - RATE * np.cos(LEAN),
        "x_dot": -path,
    }
    return sb.Model(
        "rolling coin",
        parts,
        gravity=(0, 0, -9.81),
        parameters={"a": RADIUS, "m": MASS},
        initial=first,
    )


def motion():
    """Return two seconds."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 201), rtol=1e-10, atol=1e-12)


def comparison(run):
    """Return angles and place of the centre, and the formulas."""
    circle = turning() * RADIUS / RATE
    around = RATE * run.t
    formula = [around, np.full_like(around, LEAN), -circle * np.sin(around), circle * (np.cos(around) - 1)]
    x, y = (run[name] - run[name][0] for name in "xy")
    return np.array([run["yaw"], run["lean"], x, y]), np.array(formula)
