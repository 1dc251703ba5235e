"""Dropped chair.

A chair falls askew onto one leg, rocks from leg to leg, turns a little and comes to rest. Each of its feet,
and the ends of its back, is a sphere that touches the floor compliantly, with friction; one line of the
model stands for the six of them.

Check: at rest the depths of four feet lie in a plane, so that they share the weight: with feet at `x` and
`-x` and the centre of mass `c` behind the middle each rear foot bears `W/4 (1 + c/x)` and each front foot
`W/4 (1 - c/x)`. Rigid feet would leave the shares undetermined, as L. Euler saw for tables: De pressione
ponderis in planum cui incumbit (1774). Here the chair also leans back, its centre of mass, `h` above those
of the feet, by `h D/(2 k x)`, where `D` is by how much more a rear foot bears.
"""

import numpy as np

import symbody as sb

WIDTH, DEPTH, LEG, BACK = 0.4, 0.42, 0.45, 0.45  # m: between the legs, their length, height of the back
SEAT_MASS, BACK_MASS, LEG_MASS, FOOT = 2.0, 1.5, 0.3, 0.02  # kg; m, radius of the feet
STIFFNESS = 4e4  # N/m, of a foot
TOLERANCE = 1e-4  # N
LOOK = {"times": (0.0, 0.3, 1.0, 4.0), "view": (1.0, -0.8, 0.35), "vectors": "all", "ghosts": 0.25}


def pieces():
    """Yield mass, edges and middle of each piece of wood, from the middle of the seat."""
    x, y = DEPTH / 2, WIDTH / 2
    yield SEAT_MASS, (DEPTH + 0.04, WIDTH + 0.04, 0.03), (0, 0, 0)
    yield BACK_MASS, (0.02, WIDTH + 0.04, BACK), (-x, 0, BACK / 2)
    for sx in (x, -x):
        for sy in (y, -y):
            yield LEG_MASS, (0.035, 0.035, LEG), (sx, sy, -LEG / 2)


def wood():
    """Return mass, centre of mass and moments of inertia about it."""
    masses, edges, places = map(np.array, zip(*pieces(), strict=True))
    center = masses @ places / masses.sum()
    squares = masses[:, None] * (edges**2 / 12 + (places - center) ** 2)
    return masses.sum(), center, squares.sum() - squares.sum(axis=0), masses, places - center


def model():
    """Return the chair above the floor; x is forward."""
    mass, center, turns, masses, places = wood()
    product = float(masses @ (places[:, 0] * places[:, 2]))
    x, y, z = DEPTH / 2, WIDTH / 2, -LEG + FOOT
    corners = {"front_left": (x, y, z), "front_right": (x, -y, z), "rear_left": (-x, y, z),
               "rear_right": (-x, -y, z), "top_left": (-x, y, BACK), "top_right": (-x, -y, BACK)}  # fmt: skip
    frames = {f"end_{name}": sb.Frame(tuple(np.subtract(at, center))) for name, at in corners.items()}
    shapes = [sb.Box(edges, at=tuple(np.subtract(at, center)), color="peru") for _, edges, at in pieces()]
    parts = [
        sb.Body("Chair", mass, tuple(turns), products=(0, 0, -product), frames=frames, shapes=shapes),
        sb.Free("fall", "ground", "Chair"),
        sb.Contact("on", "ground", "Chair.end_*", ["plane", {"sphere": FOOT}],
                   normal=sb.NormalForce(stiffness=STIFFNESS, exponent=1, restitution=0.3, speed=1.0),
                   friction=sb.Friction(mu=0.4, v0=0.01)),
    ]  # fmt: skip
    floor = [sb.Box((1.6, 1.6, 0.02), at=(0, 0, -0.01), opacity=0.4)]
    first = {"fall_z": 0.75, "fall_qw": np.cos(0.15), "fall_qx": np.sin(0.15) * 0.6,
             "fall_qy": np.sin(0.15) * 0.8, "fall_wz": 1.0}  # fmt: skip
    return sb.Model("dropped chair", parts, gravity=(0, 0, -9.81), ground_shapes=floor, initial=first)


def motion():
    """Return four seconds."""
    return sb.simulate(sb.form_equations(model()), 4.0, rtol=1e-7)


def comparison(run):
    """Return what each foot bears in the last half second, and the shares of the weight."""
    mass, center, *_ = wood()
    weight, x, height = 9.81 * mass, DEPTH / 2, LEG - FOOT + center[2]
    more = -weight * center[0] / (2 * x - weight * height / (2 * STIFFNESS * x))
    late = run.at(np.linspace(3.5, 4.0, 11))
    loads = [
        late[f"contact_force on_Chair_end_{end}_{side} z"]
        for end in ("front", "rear")
        for side in ("left", "right")
    ]
    shares = weight / 4 + more / 2 * np.array([-1, -1, 1, 1])
    return np.array(loads), np.repeat(shares, 11).reshape(4, 11)
