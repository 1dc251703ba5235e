"""Geneva drive.

A pin on a turning crank enters a slot of a cross, turns it by a quarter and leaves it; until the pin comes to
the next slot a disc on the crank locks the cross. Film projectors pull the film on by it, picture by picture.

Check: with the pin in a slot the cross has turned by `atan2(a sin(phi), d - a cos(phi))` from where the
slot meets the crank, `a` the crank's radius and `d` the distance of the axes; it rests at multiples of a
quarter turn between. Engaged for `cos(phi) > a/d`, `d = a sqrt(2)`: a quarter of the crank's turn, and
the pin enters along the slot, without a shock. The model has no such formula: its pin is on the curve of
the two crossed slots, `x y = 0` in the axes of the cross, or the cross stands between two slots,
`cos(2 psi) = 0`.
"""

import numpy as np

import symbody as sb

CRANK = 0.1  # m
POSTS = float(CRANK * np.sqrt(2))
TOLERANCE = 1e-8
LOOK = {"times": (0.06,), "view": "front"}
SLOTS = 4


def cross():
    """Return the shapes of the cross: a disc, and its slots in dark."""
    yield sb.Cylinder(0.1, 0.01, color="steelblue")
    for a in 2 * np.pi * np.arange(SLOTS) / SLOTS:
        x, y = 0.068 * np.cos(a), 0.068 * np.sin(a)
        yield sb.Box(
            (0.066, 0.018, 0.011), at=(float(x), float(y), 0), rotate=[("z", float(a))], color="black"
        )


def model():
    """Return the mechanism."""
    x, y = f"({POSTS} - {CRANK}*cos(phi))", f"(-{CRANK}*sin(phi))"  # of the pin, from the cross's axis
    along, across = f"({x}*cos(psi) + {y}*sin(psi))", f"({y}*cos(psi) - {x}*sin(psi))"
    slots = f"{along}*{across}/{CRANK}^2"
    shapes = [
        sb.Cylinder(0.035, 0.01, color="orange"),
        sb.Box((CRANK, 0.02, 0.008), at=(CRANK / 2, 0, -0.012), color="orange"),
        sb.Cylinder(0.008, 0.03, at=(CRANK, 0, 0), color="crimson"),
    ]
    parts = [
        sb.Body("Crank", 0.5, (0, 0, 1e-3), shapes=shapes, frames={"pin": sb.Frame((CRANK, 0, 0))}),
        sb.Body("Cross", 0.5, (0, 0, 1e-3), shapes=list(cross())),
        sb.Revolute("crank shaft", "ground", "Crank", coordinate="phi", motion="2*pi*t"),
        sb.Revolute("cross shaft", "ground.post", "Cross", coordinate="psi"),
        sb.Constraint("slots", f"if(cos(2*pi*t) > {CRANK / POSTS}, {slots}, cos(2*psi))"),
    ]
    ground = {"post": sb.Frame((POSTS, 0, 0), rotate=[("z", np.pi)])}
    return sb.Model("Geneva drive", parts, ground=ground, initial={"psi": 0.0})


def motion():
    """Return two turns of the crank."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 401))


def comparison(run):
    """Return the angle of the cross, and the formula."""
    phi = 2 * np.pi * run.t
    turns = np.floor(run.t + 0.5)
    moving = -np.arctan2(CRANK * np.sin(phi), POSTS - CRANK * np.cos(phi))
    standing = np.where(run.t - turns > 0, -np.pi / 4, np.pi / 4)
    angle = np.where(np.cos(phi) > CRANK / POSTS, moving, standing)
    return run["psi"], angle - turns * np.pi / 2
