"""Bricard's linkage with three symmetries.

Six hinges in a ring, each perpendicular to the next: by a count of constraints it is rigid, but it turns
itself inside out like a ring of paper tetrahedra.

Check: in a ring with equal links and twists `a` and `-a` in turn, the hinges `t1 = t3 = t5` and
`t2 = t4 = t6` obey `(1 + cos(a)^2) cos(t1) cos(t2) + cos(a)^2 + sin(a)^2 (cos(t1) + cos(t2)) - 2 cos(a)
sin(t1) sin(t2) = 0`, Y. Chen, Z. You and T. Tarnai, Threefold-symmetric Bricard linkages for deployable
structures, Int. J. Solids and Structures 42 (2005); here `a` is a right angle, and
`cos(t1) + cos(t2) + cos(t1) cos(t2) = 0`.
"""

import numpy as np

import symbody as sb

LENGTH, TWIST = 0.3, np.pi / 2  # m, rad
TOLERANCE = 1e-8
LOOK = {"times": (0.1,), "view": (0.6, -1.0, 0.8)}
MIDDLE, SWING = 1.0, 0.7  # rad, of the first hinge


def link(name, twist):
    """Return a link with hinges along z at both ends, the outer turned from the inner by the twist."""
    ends = {
        "inner": sb.Frame((-LENGTH / 2, 0, 0)),
        "outer": sb.Frame((LENGTH / 2, 0, 0), rotate=[("x", twist)]),
    }
    return sb.Body(name, 1.0, (0.001, 0.008, 0.008), frames=ends)


def second(first):
    """Return the second angle for the first, from the relation for a right angle."""
    return float(np.arccos(-np.cos(first) / (1 + np.cos(first))))


def model():
    """Return the mechanism: the first link is the ground."""
    bodies = [link(f"Link{k}", TWIST * (-1) ** k) for k in range(1, 6)]
    names = ["ground", *(f"Link{k}.outer" for k in range(1, 6))]
    ends = [*(f"Link{k}.inner" for k in range(1, 6)), "ground.inner"]
    drive = [{"motion": f"{MIDDLE} + {SWING}*sin(2*pi*t)"}, {}, {}, {}, {}, {}]
    hinges = [
        sb.Revolute(f"hinge{k + 1}", names[k], ends[k], coordinate=f"t{k + 1}" if k < 5 else None, **drive[k])
        for k in range(6)
    ]
    first = {f"t{k}": second(MIDDLE) if k % 2 == 0 else MIDDLE for k in range(2, 6)}
    # The inner end of the ground's link, whose outer end, turned by the twist, is the origin.
    ground = {"inner": sb.Frame((-LENGTH, 0, 0), rotate=[("x", -TWIST)])}
    return sb.Model("Bricard's linkage", [*bodies, *hinges], ground=ground, initial=first)


def motion():
    """Return one swing."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 101))


def comparison(run):
    """Return both sides of the relation for the first two hinges, and of the two symmetries."""
    t1, t2 = run["t1"], run["t2"]
    square = np.cos(TWIST) ** 2
    left = (1 + square) * np.cos(t1) * np.cos(t2) + square + (1 - square) * (np.cos(t1) + np.cos(t2))
    return np.array([left, run["t3"], run["t5"], run["t4"]]), np.array(
        [2 * np.cos(TWIST) * np.sin(t1) * np.sin(t2), t1, t1, t2]
    )
