"""Bennett's linkage.

Four hinges in space whose axes are neither parallel nor meet: opposite links are equal, and their twists
are as `sin(alpha)/a = sin(beta)/b`. By a count of constraints it cannot move; but it does.

Check: `tan(t1/2) tan(t4/2) = sin((beta + alpha)/2)/sin((beta - alpha)/2)`, all around. G. T. Bennett, A
new mechanism, Engineering 76 (1903), 777-778.
"""

import numpy as np

import symbody as sb

A, B, ALPHA = 1.0, 0.7, np.pi / 3
BETA = float(np.arcsin(B / A * np.sin(ALPHA)))
TOLERANCE = 1e-8
LOOK = {"times": (0.0, 0.5), "view": (1.0, -1.2, 0.8)}


def link(name, length, twist):
    """Return a link with hinges at both ends, the outer turned from the inner by the twist."""
    frames = {
        "inner": sb.Frame((f"-{length}/2", 0, 0)),
        "outer": sb.Frame((f"{length}/2", 0, 0), rotate=[("x", twist)]),
    }
    return sb.Body(name, 1.0, (0.01, 0.1, 0.1), frames=frames)


def model():
    """Return the mechanism."""
    parts = [
        *(link("Input", "b", "beta"), link("Coupler", "a", "alpha"), link("Output", "b", "beta")),
        sb.Revolute("A", "ground.far", "Input.inner", coordinate="t1"),
        sb.Revolute("B", "Input.outer", "Coupler.inner", coordinate="t2"),
        sb.Revolute("C", "Coupler.outer", "Output.inner", coordinate="t3"),
        sb.Revolute("D", "Output.outer", "ground", coordinate="t4"),
    ]
    return sb.Model(
        "Bennett's linkage", parts, parameters={"a": A, "b": B, "alpha": ALPHA, "beta": BETA},
        ground={"far": sb.Frame(("a", 0, 0), rotate=[("x", "alpha")])},
        initial={"t1": 1.0, "t2": 2.9, "t4": -2.9, "t1_dot": 2.0},
    )  # fmt: skip


def motion():
    """Return three seconds of free motion from a first speed."""
    return sb.simulate(sb.form_equations(model()), 3.0, times=np.linspace(0, 3, 201))


def comparison(run):
    """Return both sides of Bennett's relation, times the cosines, so that it has no poles."""
    constant = np.sin((BETA + ALPHA) / 2) / np.sin((BETA - ALPHA) / 2)
    t1, t4 = run["t1"] / 2, run["t4"] / 2
    return np.sin(t1) * np.sin(t4), constant * np.cos(t1) * np.cos(t4)
