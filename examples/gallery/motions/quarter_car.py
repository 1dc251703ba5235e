"""Quarter car on a shaker.

A wheel between a tyre and a suspension, a quarter of the car's body above: the model with which springs
and dampers of cars are chosen. A shaker lifts the tyre like a wavy road or a test rig.

Check: the motion from rest is `X exp(i w t)`, the answer to the shaker, and the free motion that makes up
for it at the start, by the matrix exponential: `X` solves `m_b s^2 X_b = -(k + d s)(X_b - X_w)`, `m_w s^2
X_w = (k + d s)(X_b - X_w) - (k_t + d_t s)(X_w - h)` at `s = i w`, two equations by hand. D. Karnopp,
Vehicle Dynamics, Stability, and Control, 2nd edition, CRC Press 2013, on the quarter car.
"""

import numpy as np
from scipy.linalg import expm

import symbody as sb

BODY, WHEEL, SPRING, DAMPER = 300.0, 40.0, 1.8e4, 1.2e3  # kg, kg, N/m, N s/m
TYRE, LOSS, LIFT, RATE = 1.8e5, 50.0, 0.03, 9.0  # N/m, N s/m, m, rad/s
TOLERANCE = 1e-9  # m
LOOK = {"times": (0.3,), "view": (0.45, -1.0, 0.2)}
AXLE, SEAT, GAP = 0.35, 0.42, 0.05  # m, of wheel and body at rest, and of the tyre's spring


def model():
    """Return the mechanism, at rest on the shaker."""
    beam = sb.Box((0.08, 0.3, 0.06), at=(0, -0.16, 0), color="dimgray")
    tyre = sb.Cylinder(AXLE - GAP, 0.2, rotate=[("x", "pi/2")], color="slategray")
    hub = sb.Cylinder(0.15, 0.22, rotate=[("x", "pi/2")], color="lightgray")
    springs = {"k": SPRING, "d": DAMPER, "kt": TYRE, "dt": LOSS, "g": 9.81, "mb": BODY, "mw": WHEEL}
    parts = [
        sb.Body("Plate", 1.0, shapes=[sb.Box((0.6, 0.5, 0.03), at=(0, 0, -0.015), color="seagreen")]),
        sb.Body("Wheel", "mw", shapes=[tyre, hub, beam], frames={"mount": sb.Frame((0, -0.28, 0))}),
        sb.Body("Body", "mb", frames={"mount": sb.Frame((0, -0.28, 0))},
                shapes=[sb.Box((1.2, 0.35, 0.18), at=(0, -0.28, 0.1), color="steelblue")]),
        sb.Prismatic("shaker", "ground", "Plate", axis="z", coordinate="h", motion=f"{LIFT}*sin({RATE}*t)"),
        sb.Prismatic("tyre", "Plate", "Wheel", axis="z", coordinate="w", force=sb.Drive(
            stiffness="kt", damping="dt", free=f"{AXLE} + (mb + mw)*g/kt")),
        sb.Prismatic("strut", "Wheel", "Body", axis="z", coordinate="s"),
        sb.SpringDamper("spring", "Wheel.mount", "Body.mount", stiffness="k", damping="d",
                        free=f"{SEAT} + mb*g/k"),
    ]  # fmt: skip
    post = [sb.Cylinder(0.09, 0.4, at=(0, 0, -0.3), color="gray")]
    return sb.Model("quarter car", parts, gravity=(0, 0, "-g"), parameters=springs, ground_shapes=post,
                    initial={"w": AXLE, "s": SEAT, "w_dot": f"-{LIFT * RATE}"})  # fmt: skip


def motion():
    """Return four seconds from rest."""
    return sb.simulate(sb.form_equations(model()), 4.0, times=np.linspace(0, 4, 401), rtol=1e-10, atol=1e-12)


def comparison(run):
    """Return the heights of body and wheel over those at rest, and the formula."""
    s, spring, tyre = 1j * RATE, SPRING + 1j * RATE * DAMPER, TYRE + 1j * RATE * LOSS
    both = np.array([[BODY * s**2 + spring, -spring], [-spring, WHEEL * s**2 + spring + tyre]])
    answer = np.linalg.solve(both, [0, tyre * LIFT])  # body, wheel; heights are the imaginary parts
    A = np.array([
        [0, 0, 1, 0], [0, 0, 0, 1], [-SPRING / BODY, SPRING / BODY, -DAMPER / BODY, DAMPER / BODY],
        [SPRING / WHEEL, -(SPRING + TYRE) / WHEEL, DAMPER / WHEEL, -(DAMPER + LOSS) / WHEEL],
    ])  # fmt: skip
    steady = np.concatenate([answer, s * answer])
    free = np.array([expm(A * t) @ -steady.imag for t in run.t])[:, :2].T
    wheel = run["h"] + run["w"] - AXLE
    return np.array([wheel + run["s"] - SEAT, wheel]), np.imag(np.outer(answer, np.exp(s * run.t))) + free
