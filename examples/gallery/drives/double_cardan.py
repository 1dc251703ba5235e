"""Double Cardan joint, forks right and wrong.

A drive shaft between two universal joints at equal angles: with the forks of the middle shaft in one
plane the second joint cancels the speed variation of the first, and parallel shafts turn at the same
speed; with one fork a quarter turn off (behind) the two add up. Cardan shafts are marked to prevent wrong
assembly.

Check: each joint obeys `tan(driven) = tan(driving) cos(beta)`, angles from where the arm of the cross in
the driving fork stands across the plane of the shafts; it follows from the arms, which stay at right
angles. Right: the second joint is the first one reversed, so the last angle is the first. Wrong: the
joints repeat, and `tan(last) = tan(first) cos(beta)^2`.
"""

import numpy as np

import symbody as sb

BEND = 0.6  # rad
TOLERANCE = 1e-8
LOOK = {"times": (0.08,), "view": {"direction": (0.3, -1.0, 0.9), "zoom": 1.08}}
GAP = 0.35  # m, from one drive to the other


def chain(name, second, y):
    """Return the parts and posts of a drive shaft, whose second joint has the axes `second`."""
    ends = {"tail": sb.Frame((-0.2, 0, 0)), "fork": sb.Frame((0.2, 0, 0))}
    parts = [sb.Body(f"{name}{k}", 1.0, (0.001, 0.01, 0.01), frames=ends) for k in range(3)]
    parts += [
        sb.Revolute(f"{name} input", f"ground.{name}_in", f"{name}0.tail", "x", f"{name}_first",
                    motion="2*pi*t"),
        sb.Universal(f"{name} front", f"{name}0.fork", f"{name}1.tail", axes=("y", "z"),
                     coordinates=[f"{name}_a", f"{name}_b"]),
        sb.Cylindrical(f"{name} output", f"ground.{name}_out", f"{name}2.fork", axis="x",
                       coordinates=[f"{name}_last", f"{name}_slide"]),
        sb.Universal(f"{name} back", f"{name}1.fork", f"{name}2.tail", axes=second, tree=False),
    ]  # fmt: skip
    step = (float(0.4 * np.cos(BEND)), y, float(-0.4 * np.sin(BEND)))
    posts = {f"{name}_in": sb.Frame((-0.4, y, 0)), f"{name}_out": sb.Frame((step[0] + 0.4, y, step[2]))}
    return parts, posts


def model():
    """Return the mechanism."""
    right, posts = chain("right", ("z", "y"), 0.0)
    wrong, others = chain("wrong", ("y", "z"), GAP)
    first = {"right_a": BEND, "wrong_a": BEND}
    return sb.Model("double Cardan joint", [*right, *wrong], ground={**posts, **others}, initial=first)


def motion():
    """Return one turn of the first shafts."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return both sides of the two relations, times the cosines, so that they have no poles."""
    first, right, wrong = run["right_first"], run["right_last"], run["wrong_last"]
    off = np.sin(wrong) * np.cos(first)
    return np.array([right, off]), np.array([first, np.sin(first) * np.cos(wrong) * np.cos(BEND) ** 2])
