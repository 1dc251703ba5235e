"""Universal joint between two shafts.

Cardan's or Hooke's joint: two forks and a cross. The second shaft makes as many turns as the first, but
at a varying speed; the variation grows with the angle between the shafts.

Check: the two arms of the cross stay at right angles, which is `tan(phi2) = tan(phi1)/cos(beta)`, with
`phi1` from the position where the arm in the first fork lies in the plane of the shafts. Derived here.
"""

import numpy as np

import symbody as sb

BEND = np.pi / 5
TOLERANCE = 1e-8
LOOK = {"times": (0.1,), "view": {"direction": (0.5, -1.0, 1.2), "zoom": 1.1}}


def model():
    """Return the mechanism."""
    end = {"fork": sb.Frame((0.2, 0, 0)), "tail": sb.Frame((-0.2, 0, 0))}
    parts = [
        sb.Body("Drive", 1.0, (0.001, 0.01, 0.01), frames=end),
        sb.Body("Driven", 1.0, (0.001, 0.01, 0.01), frames=end),
        sb.Revolute("first bearing", "ground.first", "Drive.tail", "x", "phi1", motion="2*pi*t"),
        sb.Revolute("second bearing", "ground.second", "Driven.fork", "x", "phi2"),
        sb.Universal("cross", "Drive.fork", "Driven.tail", axes=("y", "z"), tree=False),
    ]
    far = sb.Frame((float(0.2 + 0.4 * np.cos(BEND)), float(0.4 * np.sin(BEND)), 0), rotate=[("z", BEND)])
    posts = {"first": sb.Frame((-0.2, 0, 0)), "second": far}
    return sb.Model("universal joint", parts, ground=posts)


def motion():
    """Return one turn of the first shaft."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return both sides of the relation, times the cosines, so that it has no poles."""
    phi1, phi2 = run["phi1"], run["phi2"]
    return np.sin(phi2) * np.cos(BEND) * np.cos(phi1), np.sin(phi1) * np.cos(phi2)
