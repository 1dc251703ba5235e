"""Toggle press.

Two equal bars form a knee; as it is pushed straight, the ram at the end of the second moves ever more
slowly and presses ever harder. Stone crushers, locking pliers and moulding machines use this at the end
of their stroke.

Check: the ram is at `2 l cos(a)` and the knee at `l sin(a)` from its line, so ram speed over knee speed
is `2 tan(a)`, and the force ratio, its inverse because power in is power out, has no bound at the dead
point `a = 0`. Derived here.
"""

import numpy as np

import symbody as sb

LENGTH = 0.3  # m
TOLERANCE = 1e-8
LOOK = {"times": (0.0, 0.5, 0.9)}


def bar(name, length):
    """Return a bar from a to b along its x axis."""
    frames = {"a": sb.Frame((-length / 2, 0, 0)), "b": sb.Frame((length / 2, 0, 0))}
    return sb.Body(name, 1.0, (0, 0, length**2 / 12), frames=frames)


def model():
    """Return the mechanism."""
    parts = [
        *(bar("Upper", LENGTH), bar("Lower", LENGTH), sb.Body("Ram", 2.0, (0.01, 0.01, 0.01))),
        sb.Revolute("post", "ground", "Upper.a", coordinate="alpha", motion="0.4 + 0.5*cos(pi*t)"),
        sb.Revolute("knee", "Upper.b", "Lower.a", coordinate="bend"),
        sb.Prismatic("guide", "ground", "Ram", axis="x", coordinate="s"),
        sb.Revolute("wrist", "Ram", "Lower.b"),
    ]
    return sb.Model("toggle press", parts, initial={"bend": -1.8, "s": 0.37})


def motion():
    """Return the way from a bent knee through the dead point."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return speed and place of the ram; the speed of the knee times 2 tan(alpha), and 2 l cos(alpha)."""
    across = run["frame v Upper.b ground ground"][1]
    formula = [-2 * np.tan(run["alpha"]) * across, 2 * LENGTH * np.cos(run["alpha"])]
    return np.array([run["s_dot"], run["s"]]), np.array(formula)
