"""Pantograph.

A parallelogram of four bars on one fixed point: what the tracer draws, the pen draws larger. It copied
drawings, engraved letters, and carries the current collectors of trains.

Check: the bars from the tracer are parallel to the others, so that the triangles fixed point - elbow - pen
and fixed point - joint - tracer are similar: the pen is in the direction of the tracer, k times as far. C.
Scheiner, Pantographice, Rome 1631.
"""

import numpy as np

import symbody as sb

LONG, RATIO = 1.0, 2.5  # m
SHORT = LONG / RATIO
TOLERANCE = 1e-9
LOOK = {"times": (0.1, 0.35), "traces": ["Near.b", "Outer.b"]}


def bar(name, length, **points):
    """Return a bar from a to b along its x axis, with further points at a distance from a."""
    places = {"a": 0.0, "b": length, **points}
    frames = {key: sb.Frame((place - length / 2, 0, 0)) for key, place in places.items()}
    return sb.Body(name, 1.0, (0, 0, length**2 / 12), frames=frames)


def model():
    """Return the mechanism."""
    parts = [
        bar("Inner", LONG, joint=SHORT),  # from the fixed point to the elbow
        bar("Outer", LONG, joint=SHORT),  # from the elbow to the pen
        bar("Near", SHORT),  # parallel to Outer, ends in the tracer
        bar("Far", LONG - SHORT),  # parallel to Inner, from Outer to the tracer
        sb.Revolute("O", "ground", "Inner.a", coordinate="alpha", motion="1.9 + 0.3*sin(2*pi*t)"),
        sb.Revolute("elbow", "Inner.b", "Outer.a", coordinate="bend", motion="-1.6 + 0.35*sin(4*pi*t)"),
        sb.Revolute("E", "Inner.joint", "Near.a", coordinate="near"),
        sb.Revolute("F", "Outer.joint", "Far.a", coordinate="far"),
        sb.Revolute("tracer", "Near.b", "Far.b"),
    ]
    return sb.Model("pantograph", parts, initial={"near": -1.6, "far": -1.54})


def motion():
    """Return a figure that tracer and pen draw."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return the places of the pen, and those of the tracer times the ratio."""
    return run["frame r Outer.b ground ground"], RATIO * run["frame r Near.b ground ground"]
