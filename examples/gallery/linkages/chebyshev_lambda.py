"""Chebyshev's lambda linkage, or Hoecken's.

A crank-rocker with bars of 1 : 2.5 : 2.5 and posts 2 apart, the coupler as long again beyond the rocker. Its
end draws a flat line for half a turn and comes back in an arc, as the foot of a walking machine does.

Check: the rocker's pin is equally far from crank pin, post and end, so the angle at the post is right
(Thales) and the height of the end is `(2 - cos(t)) sqrt(25/(5 - 4 cos(t)) - 1)`; it is 4 at `t = 90`, 180
and 270 degrees. Derived here; P. L. Chebyshev showed such a walking machine in Paris in 1878, and K.
Hoecken published the linkage in 1926.
"""

import numpy as np

import symbody as sb

CRANK, ROCKER, POSTS = 1.0, 2.5, 2.0  # m
TOLERANCE = 1e-8
LOOK = {"times": (0.25, 0.5, 0.75), "traces": ["Coupler.end"]}


def bar(name, length, **points):
    """Return a bar from a to b along its x axis, with further points."""
    frames = {"a": (-length / 2, 0, 0), "b": (length / 2, 0, 0), **points}
    return sb.Body(
        name, 1.0, (0, 0, length**2 / 12), frames={key: sb.Frame(at) for key, at in frames.items()}
    )


def model():
    """Return the mechanism."""
    parts = [
        *(
            bar("Crank", CRANK),
            bar("Coupler", 2 * ROCKER, end=(ROCKER, 0, 0), pin=(0, 0, 0)),
            bar("Rocker", ROCKER),
        ),
        sb.Revolute("A", "ground", "Crank.a", coordinate="theta", motion="2*pi*t"),
        sb.Revolute("B", "Crank.b", "Coupler.a", coordinate="beta"),
        sb.Revolute("C", "Coupler.pin", "Rocker.b"),
        sb.Revolute("D", "ground.D", "Rocker.a", coordinate="phi"),
    ]
    return sb.Model(
        "lambda linkage", parts, gravity=(0, -9.81, 0), ground={"D": sb.Frame((POSTS, 0, 0))},
        initial={"beta": "78 deg", "phi": "102 deg"},
    )  # fmt: skip


def motion():
    """Return one turn of the crank."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return the height of the coupler's end, and the formula."""
    cosine = np.cos(run["theta"])
    square = CRANK**2 + POSTS**2 - 2 * CRANK * POSTS * cosine  # of the distance from crank pin to post
    height = (POSTS - CRANK * cosine) * np.sqrt((2 * ROCKER) ** 2 / square - 1)
    return run["frame r Coupler.end ground ground"][1], height
