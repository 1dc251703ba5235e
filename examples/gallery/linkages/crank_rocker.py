"""Four-bar linkage, a crank-rocker.

The crank turns, the rocker swings: the shortest and the longest bar together are shorter than the two others
(Grashof). Wiper drives, oil pumps and steering linkages are four-bars.

Check: `K1 cos(phi) - K2 cos(theta) + K3 = cos(theta - phi)` with `K1 = d/a`, `K2 = d/c`,
`K3 = (a^2 - b^2 + c^2 + d^2)/(2 a c)`, F. Freudenstein, Approximate synthesis of four-bar linkages,
Trans. ASME 77 (1955), 853-861.
"""

import numpy as np

import symbody as sb

CRANK, COUPLER, ROCKER, POSTS = 0.2, 0.5, 0.4, 0.5  # m
TOLERANCE = 1e-9
LOOK = {"times": (0.0, 0.3, 0.6), "traces": ["Coupler.P"]}


def bar(name, length, **points):
    """Return a bar from a to b along its x axis, with further points."""
    frames = {"a": (-length / 2, 0, 0), "b": (length / 2, 0, 0), **points}
    return sb.Body(
        name, 1.0, (0, 0, length**2 / 12), frames={key: sb.Frame(at) for key, at in frames.items()}
    )


def model():
    """Return the mechanism."""
    parts = [
        *(bar("Crank", CRANK), bar("Coupler", COUPLER, P=(0, 0.25, 0)), bar("Rocker", ROCKER)),
        sb.Revolute("A", "ground", "Crank.a", coordinate="theta", motion="2*pi*t"),
        sb.Revolute("B", "Crank.b", "Coupler.a", coordinate="beta"),
        sb.Revolute("C", "Coupler.b", "Rocker.b"),
        sb.Revolute("D", "ground.D", "Rocker.a", coordinate="phi"),
    ]
    return sb.Model(
        "four-bar", parts, gravity=(0, -9.81, 0), ground={"D": sb.Frame((POSTS, 0, 0))},
        initial={"beta": "60 deg", "phi": "120 deg"},
    )  # fmt: skip


def motion():
    """Return two turns of the crank."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 201))


def comparison(run):
    """Return both sides of Freudenstein's equation."""
    theta, phi = run["theta"], run["phi"]
    k = (CRANK**2 - COUPLER**2 + ROCKER**2 + POSTS**2) / (2 * CRANK * ROCKER)
    return POSTS / CRANK * np.cos(phi) - POSTS / ROCKER * np.cos(theta) + k, np.cos(theta - phi)
