"""Single-track model of a car.

The two wheels of an axle are one, whose side force grows with its slip angle: the model with which
steering and most lane-keeping controllers are designed.

Check: side speed and yaw rate after a step of the steering wheel are those of the linear equations
`m (v' + U r) = F_f + F_r`, `I r' = a F_f - b F_r` by the matrix exponential, and end at
`r = U delta/(L + K U^2)` with `K = m (b/C_f - a/C_r)/L`, the understeer gradient, by setting
`v' = r' = 0`. Model: P. Riekert and T. E. Schunck, Zur Fahrmechanik des gummibereiften Kraftfahrzeugs,
Ingenieur-Archiv 11 (1940).
"""

import numpy as np
from scipy.linalg import expm

import symbody as sb

MASS, YAW, FRONT, REAR = 1500.0, 2500.0, 1.2, 1.5  # kg, kg m^2, m from the centre of mass to the axles
C_FRONT, C_REAR, SPEED, STEERING = 8.0e4, 9.0e4, 15.0, 0.12  # N/rad, m/s, rad
TOLERANCE = 1e-6
LOOK = {"times": (0.0, 1.0, 2.0, 3.0, 4.0), "traces": ["Car"]}


def model():
    """Return the mechanism."""
    side = "(cos(psi)*y_dot - sin(psi)*x_dot)"
    axles = {"front": sb.Frame((FRONT, 0, 0)), "rear": sb.Frame((-REAR, 0, 0))}
    tyre = {"color": "black", "rotate": [("x", "pi/2")]}
    shapes = [
        sb.Box((4.2, 1.7, 0.5), color="steelblue", at=(0, 0, 0.3)),
        sb.Box((1.6, 1.4, 0.4), color="lightblue", at=(-0.4, 0, 0.75)),
        *(sb.Cylinder(0.35, 1.9, at=(x, 0, 0), **tyre) for x in (FRONT, -REAR)),
    ]
    parts = [
        sb.Body("Car", MASS, (500.0, 2500.0, YAW), frames=axles, shapes=shapes),
        sb.Planar("road", "ground", "Car", coordinates=["x", "y", "psi"]),
        sb.Constraint("cruise", f"cos(psi)*x_dot + sin(psi)*y_dot - {SPEED}"),
        sb.Force("front tyre", "Car.front",
                 (0, f"-{C_FRONT}*(({side} + {FRONT}*psi_dot)/{SPEED} - {STEERING})", 0), "Car"),
        sb.Force("rear tyre", "Car.rear", (0, f"-{C_REAR}*({side} - {REAR}*psi_dot)/{SPEED}", 0), "Car"),
    ]  # fmt: skip
    return sb.Model("single track", parts, gravity=(0, 0, -9.81), initial={"x_dot": SPEED})


def motion():
    """Return four seconds after the step, at constant forward speed."""
    return sb.simulate(sb.form_equations(model()), 4.0, times=np.linspace(0, 4, 201))


def comparison(run):
    """Return side speed and yaw rate, and the solution of the linear equations; then the last yaw rate."""
    a, b, m, inertia, U = FRONT, REAR, MASS, YAW, SPEED
    A = np.array([
        [-(C_FRONT + C_REAR) / (m * U), (b * C_REAR - a * C_FRONT) / (m * U) - U],
        [(b * C_REAR - a * C_FRONT) / (inertia * U), -(a**2 * C_FRONT + b**2 * C_REAR) / (inertia * U)],
    ])  # fmt: skip
    final = -np.linalg.solve(A, np.array([C_FRONT / m, a * C_FRONT / inertia]) * STEERING)
    gradient = m * (b / C_FRONT - a / C_REAR) / (a + b)
    steady = U * STEERING / (a + b + gradient * U**2)
    formula = np.array([final - expm(A * t) @ final for t in run.t])
    side = run["frame v Car ground Car"][1]
    return np.append([side, run["psi_dot"]], final[1]), np.append(formula.T, steady)
