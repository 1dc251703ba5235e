"""Scissor lift.

Two stages of crossed bars; an actuator along the floor pulls the lower ends together and lifts the platform.
Close to the floor it has to pull many times the load.

Check: the platform is at `n l sin(a)` and the roller at `l cos(a)`, so that platform speed over actuator
speed is `n/tan(a)` for `n` stages; as power in is power out, the actuator pulls with `n W/tan(a)` against
a load `W`, bars without weight. H. M. Spackman, Mathematical Analysis of Scissor Lifts, Technical
Document 1550, Naval Ocean Systems Center, San Diego 1989.
"""

import numpy as np

import symbody as sb

LENGTH, STAGES = 1.0, 2
TOLERANCE = 1e-8
LOOK = {"times": (0.0, 1.0)}


def bar(name, length):
    """Return a bar from a to b along its x axis, m in its middle."""
    frames = {"a": sb.Frame((-length / 2, 0, 0)), "m": sb.Frame(), "b": sb.Frame((length / 2, 0, 0))}
    return sb.Body(name, 1.0, (0, 0, length**2 / 12), frames=frames)


def model():
    """Return the mechanism."""
    platform = sb.Body("Platform", 20.0, (1, 1, 1), shapes=[sb.Box((1.2, 0.05, 0.4), at=(0.45, 0.025, 0))])
    parts = [
        *(bar(name, LENGTH) for name in ("Rise1", "Fall1", "Rise2", "Fall2")),
        platform,
        sb.Revolute("foot", "ground", "Rise1.a", coordinate="rise"),
        sb.PinSlot(
            "roller", "ground", "Fall1.b", coordinates=["fall", "x"], motion={"x": "0.775 + 0.175*cos(pi*t)"}
        ),
        sb.Revolute("cross1", "Rise1.m", "Fall1.m"),
        sb.Revolute("left", "Fall1.a", "Rise2.a", coordinate="second_rise"),
        sb.Revolute("right", "Rise1.b", "Fall2.b", coordinate="second_fall"),
        sb.Revolute("cross2", "Rise2.m", "Fall2.m"),
        sb.Prismatic("height", "ground", platform, axis="y", coordinate="h"),
        sb.PointOnLine("top", platform, "Rise2.b"),
    ]
    low = float(np.arccos(0.95))
    first = {"rise": low, "fall": -low, "second_rise": 2 * low, "second_fall": -2 * low, "h": 2 * np.sin(low)}
    return sb.Model("scissor lift", parts, gravity=(0, -9.81, 0), initial=first)


def motion():
    """Return the lift going up by an actuator that starts and stops gently."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 101))


def comparison(run):
    """Return the speed of the platform, and n/tan(a) times that of the actuator."""
    return run["h_dot"], STAGES * 0.175 * np.pi * np.sin(np.pi * run.t) / np.tan(run["rise"])
