"""Block and tackle of four falls.

A rope goes from the upper block around two sheaves below and two above to a weight: 52 kg lift 200 kg,
four times as slowly. The sheaves of a block turn at different speeds, as each passes on the rope that it
receives plus what the rising load frees.

Check: with sheaves of inertia `J` and radius `R` and no slip the load rises with `(4 m - M) g/(M + 16 m +
(1 + 4 + 9 + 16) J/R^2)`, `M` with the lower block, by Lagrange's equation in its height: the speeds of
the rope at the sheaves are 1, 2, 3 and 4 times its own.
"""

import numpy as np

import symbody as sb

LOAD, WEIGHT, INERTIA, RADIUS = 200.0, 52.0, 0.1, 0.12  # kg, kg, kg m^2, m
TOLERANCE = 1e-8
LOOK = {"times": (0.0, 1.6), "view": "front"}
FALLS = (-0.3, -0.06, 0.18, 0.42)  # m, where the falls hang; the rope to the weight hangs at 0.66


def sheave(name):
    """Return a sheave; a spoke shows how it turns."""
    marks = [sb.Cylinder(0.02, 0.05, at=(0.07, 0, 0), color="white")]
    return sb.Body(name, 1.0, (0, 0, "J"), shapes=[sb.Cylinder(RADIUS - 0.01, 0.04, color="orange"), *marks])


def rope(x, low, high):
    """Return a piece of rope as a thin cylinder along y."""
    return sb.Cylinder(0.012, high - low, at=(x, (low + high) / 2, 0), rotate=[("x", "pi/2")], color="sienna")


def model():
    """Return the mechanism: h is the rise of the load, y the fall of the weight."""
    first, second, third, fourth = FALLS
    hooks = {"one": sb.Frame((first + RADIUS, 0, 0)), "three": sb.Frame((third + RADIUS, 0, 0))}
    load = [
        sb.Box((0.8, 0.06, 0.1), at=(0.06, 0, -0.08), color="dimgray"),
        sb.Box((0.5, 0.4, 0.4), at=(0.06, -0.45, 0), color="steelblue"),
        rope(0.06, -0.3, 0.0), *(rope(x, 0.0, 1.55) for x in FALLS),
    ]  # fmt: skip
    weight = [sb.Box((0.22, 0.3, 0.22), color="seagreen"), rope(0, 0.0, 0.95)]
    beam = [sb.Box((1.5, 0.5, 0.5), at=(0.1, 0.42, -0.02), color="lightgray")]
    ground = {"two": sb.Frame((second + RADIUS, 0, 0)), "four": sb.Frame((fourth + RADIUS, 0, 0))}
    ground |= {"low": sb.Frame((0, -1.4, 0)), "side": sb.Frame((0.66, -0.4, 0))}
    parts = [
        sb.Body("Load", "M - 2*1.0", (1, 1, 1), frames=hooks, shapes=load),
        sb.Body("Weight", "m", (1, 1, 1), shapes=weight),
        *(sheave(f"Sheave{k}") for k in (1, 2, 3, 4)),
        sb.Prismatic("lift", "ground.low", "Load", axis="y", coordinate="h"),
        sb.Prismatic("fall", "ground.side", "Weight", axis=(0, -1, 0), coordinate="y"),
        sb.Revolute("axle1", "Load.one", "Sheave1", coordinate="a1"),
        sb.Revolute("axle2", "ground.two", "Sheave2", axis=(0, 0, -1), coordinate="a2"),
        sb.Revolute("axle3", "Load.three", "Sheave3", coordinate="a3"),
        sb.Revolute("axle4", "ground.four", "Sheave4", axis=(0, 0, -1), coordinate="a4"),
        # Rope without slip: what a sheave hands on is what it got, plus what the rising load frees.
        sb.Constraint(
            "rope", ["R*a1 - h", "R*a2 - R*a1 - h", "R*a3 - R*a2 - h", "R*a4 - R*a3 - h", "y - R*a4"]
        ),
    ]
    sizes = {"M": LOAD, "m": WEIGHT, "J": INERTIA, "R": RADIUS}
    return sb.Model(
        "block and tackle", parts, gravity=(0, -9.81, 0), parameters=sizes, ground=ground, ground_shapes=beam
    )


def motion():
    """Return the motion from rest."""
    return sb.simulate(sb.form_equations(model()), 1.6, times=np.linspace(0, 1.6, 81))


def comparison(run):
    """Return the rise of the load and the fall of the weight, and the formulas."""
    inertia = LOAD + 16 * WEIGHT + 30 * INERTIA / RADIUS**2
    rise = (4 * WEIGHT - LOAD) * 9.81 / inertia * run.t**2 / 2
    return np.array([run["h"], run["y"]]), np.array([rise, 4 * rise])
