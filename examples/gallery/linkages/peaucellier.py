"""Peaucellier's inversor.

Eight bars and no slide: the first linkage that turned a rotation into an exact straight line (1864). Two
long arms and a rhombus keep the product of the distances of `B` and `D` from `O`; `B` moves on a circle
through `O`, so `D` moves on a line.

Check: `O`, `B` and `D` lie on a line by symmetry, and Pythagoras twice gives `OB OD = arm^2 - side^2`.
`B` goes round at `2 crank cos(b)` from `O` in the direction `b`, so `D` is at
`(arm^2 - side^2)/(2 crank cos(b))`, whose part along `x` is constant: `D` stays at
`x = (arm^2 - side^2)/(2 crank)`. A. B. Kempe, How to Draw a Straight Line, Macmillan 1877.
"""

import numpy as np

import symbody as sb

ARM, SIDE, CRANK = 2.2, 1.0, 0.8  # m; the posts are as far apart as the crank is long
TOLERANCE = 1e-9
LOOK = {"times": (0.25, 0.5, 0.75), "traces": ["Lower.b"]}


def bar(name, length):
    """Return a bar from a to b along its x axis."""
    frames = {"a": sb.Frame((-length / 2, 0, 0)), "b": sb.Frame((length / 2, 0, 0))}
    return sb.Body(name, 1.0, (0, 0, length**2 / 12), frames=frames)


def first_positions():
    """Return the angles of the symmetric position: B on the x axis, at 2 CRANK."""
    half = float(np.arccos((ARM**2 + (2 * CRANK) ** 2 - SIDE**2) / (4 * ARM * CRANK)))
    height, foot = ARM * np.sin(half), ARM * np.cos(half)
    inner = float(np.arctan2(-height, 2 * CRANK - foot))  # from A to B
    outer = float(np.arctan2(-height, foot - 2 * CRANK))  # from A to D
    return {"upper": half, "lower": -half, "a_b": inner - half, "a_d": outer - half,
            "c_b": half - inner, "c_d": half - outer}  # fmt: skip


def model():
    """Return the mechanism."""
    bars = {"Crank": CRANK, "ArmA": ARM, "ArmC": ARM, "AB": SIDE, "Upper": SIDE, "CB": SIDE, "Lower": SIDE}
    parts = [
        *(bar(name, length) for name, length in bars.items()),
        sb.Revolute("Q", "ground.Q", "Crank.a", coordinate="theta", motion="0.9*sin(2*pi*t)"),
        sb.Revolute("O1", "ground", "ArmA.a", coordinate="upper"),
        sb.Revolute("O2", "ground", "ArmC.a", coordinate="lower"),
        sb.Revolute("A1", "ArmA.b", "AB.a", coordinate="a_b"),
        sb.Revolute("A2", "ArmA.b", "Upper.a", coordinate="a_d"),
        sb.Revolute("C1", "ArmC.b", "CB.a", coordinate="c_b"),
        sb.Revolute("C2", "ArmC.b", "Lower.a", coordinate="c_d"),
        sb.Revolute("B1", "Crank.b", "AB.b"),
        sb.Revolute("B2", "Crank.b", "CB.b"),
        sb.Revolute("D", "Upper.b", "Lower.b"),
    ]
    posts = {"Q": sb.Frame((CRANK, 0, 0))}
    return sb.Model("Peaucellier's inversor", parts, ground=posts, initial=first_positions())


def motion():
    """Return one swing of the crank."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return the coordinate x of D, and that of the line."""
    x = run["frame r Lower.b ground ground"][0]
    return x, np.full_like(x, (ARM**2 - SIDE**2) / (2 * CRANK))
