"""Simplest walking machine.

Two legs without mass, a heavy hip and two feet as light as can be walk down a slope with no motor. A step is
a pendulum under an inverted pendulum; where the swinging foot comes down the legs change their parts, which
is an event. The foot swings through the floor once, in the middle of a step, which only a knee could avoid.

Check: Newton's method on the state behind a step finds the gait, in which each step is as the one before.
At a slope of 0.009 its angle is 0.2003109005, in programs by M. Garcia (1998) and P. A. Bhounsule (2013)
too. Its multipliers, by which small errors change from step to step, are -0.1901 +- 0.5576i, 0.589 in
magnitude, so that it is stable; a note in Garcia's program has -0.1912 +- 0.5563i. M. Garcia, A.
Chatterjee, A. Ruina, M. Coleman, The simplest walking model: stability, complexity, and scaling, J.
Biomech. Eng. 120(2) (1998) 281; P. A. Bhounsule, Numerical accuracy of two benchmark models of walking: the
rimless spoked wheel and the simplest walker, Dynamics of Continuous, Discrete and Impulsive Systems B 21
(2014) 137.
"""

import numpy as np

import symbody as sb

SLOPE, FOOT = 0.009, 1e-11  # rad; mass of a foot over that of the hip
ANGLE, RATE = 0.2003109005, -0.1998324730  # lengths of a leg and g are 1
STEPS = 8
TOLERANCE = 1e-7  # rad
LOOK = {"times": (0.0, 4.0, 8.0, 12.0, 16.0, 20.0), "view": "front"}

# The legs are at equal angles to the floor; a foot lands only once the hip has passed the other one.
LANDING = sb.Event(
    "phi - 2*theta - 10*max(theta, 0)", 1, name="lands",
    action={
        "theta": "-theta", "phi": "-2*theta", "x": "x - 2*sin(theta)", "theta_dot": "cos(2*theta)*theta_dot",
        "phi_dot": "cos(2*theta)*(1 - cos(2*theta))*theta_dot",
    },
)  # fmt: skip


def model():
    """Return the machine; axes x down the slope, y away from it, angles against the clock."""
    bar = sb.Capsule(0.02, 1.0, at=(0, -0.5, 0), rotate=[("x", "pi/2")], color="steelblue")
    other = sb.Capsule(0.02, 1.0, at=(0, 0.5, 0), rotate=[("x", "pi/2")], color="darkorange")
    ends = {"foot": sb.Frame((0, -1, 0))}
    parts = [
        sb.Body("Foot"),
        sb.Body("Hip", 1.0, frames=ends, shapes=[sb.Sphere(0.12), bar]),
        sb.Body("Swing", FOOT, frames={"hip": sb.Frame((0, 1, 0))}, shapes=[sb.Sphere(0.05), other]),
        sb.Prismatic("slope", "ground", "Foot", axis="x", coordinate="x"),
        sb.Constraint("foot stands", "x_dot"),
        sb.Revolute("stance", "Foot", "Hip.foot", axis="z", coordinate="theta"),
        sb.Revolute("hip", "Hip", "Swing.hip", axis=(0, 0, -1), coordinate="phi"),
    ]
    gravity = (np.sin(SLOPE), -np.cos(SLOPE), 0)
    floor = [sb.Box((5.5, 0.06, 0.6), at=(1.6, -0.08, 0), opacity=0.4)]
    return sb.Model("walker", parts, gravity=gravity, ground_shapes=floor)


def behind_landing(angle, rate):
    """Return the state behind a landing, which these two determine."""
    swing = (1 - np.cos(2 * angle)) * rate
    return {"x": 0.0, "theta": angle, "phi": 2 * angle, "theta_dot": rate, "phi_dot": swing}


def step(eqs, behind):
    """Return angle and rate behind the next landing, and how long the step lasts."""
    run = sb.simulate(eqs, 6.0, behind_landing(*behind), events=[LANDING], rtol=1e-12, atol=1e-13)
    t = run.events[0].t
    angle, rate = (float(run.events[0].state[name]) for name in ("theta", "theta_dot"))
    return np.array([-angle, np.cos(2 * angle) * rate]), t


def gait(eqs, guess=(0.2, -0.2)):
    """Return the state that a step leads back to, by Newton's method, its multipliers and its period."""
    behind = np.array(guess)
    for _ in range(8):
        ahead, t = step(eqs, behind)
        jacobian = np.transpose(
            [(step(eqs, behind + d)[0] - step(eqs, behind - d)[0]) / 2e-5 for d in 1e-5 * np.eye(2)]
        )
        change = np.linalg.solve(np.eye(2) - jacobian, ahead - behind)
        behind = behind + change
        if np.abs(change).max() < 1e-10:
            break
    return behind, np.linalg.eigvals(jacobian), t


def motion():
    """Return eight steps of the gait."""
    eqs = sb.form_equations(model())
    behind, _, t = gait(eqs)
    return sb.simulate(
        eqs, (STEPS + 0.5) * t, behind_landing(*behind), events=[LANDING], rtol=1e-12, atol=1e-13
    )


def comparison(run):
    """Return the angles before landings and rates behind, and those of the literature."""
    angles = [-event.state["theta"] for event in run.events]
    rates = [np.cos(2 * event.state["theta"]) * event.state["theta_dot"] for event in run.events]
    return np.array([*angles, *rates]), np.repeat([ANGLE, RATE], len(angles))
