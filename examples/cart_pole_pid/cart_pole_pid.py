"""Cart-pole with a sampled PID controller.

Description
    A pole stands on a cart. A fast digital loop sets the force on the cart so that the pole leans as far as a
    slow one says, which brings the cart to its place. theta is the angle of the pole from upright, positive
    to the left; a push to the right makes it grow.
Concepts
    Signals and blocks with a sample time: their values are held between samples, and computed in the order
    of the file. Two sample times; limits with back-calculation; a sweep over the sample time; the continuous
    controller for linear equations.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import symbody as sb

# Modeling

model = sb.load_model(Path(__file__).with_suffix(".toml"))
eqs = sb.form_equations(model)
print("held between samples:", ", ".join(signal.name for signal in model.held_signals))

# Without samples the same controller is linear about upright, and stable.
lin = sb.linearize(sb.form_equations(sb.without_sampling(model)), {"x": 0.5, "theta": 0})
print("without samples:", lin.verdict, lin.eigenvalues.round(2))

# Simulation

run = sb.simulate(eqs, 10.0, {"theta": "15 deg"}, times=np.linspace(0.0, 10.0, 10_001))
print(run)
print("samples:", run.held_values.t.size, "of", ", ".join(run.held_values.names))

fig, (upper, middle, lower) = plt.subplots(3, 1, figsize=(7, 7), layout="constrained")
upper.plot(run.t, run["x"], label="x [m]")
upper.plot(run.t, run["theta"], label="theta [rad]")
upper.axhline(0.5, color="0.5", lw=0.8)
upper.set(title="Cart-pole under a sampled PID controller", xlabel="t [s]")
first = run.t <= 1.0
middle.plot(run.t[first], run["servo"][first], drawstyle="steps-post", label="force [N], every 10 ms")
lower.plot(run.t[first], run["theta"][first], label="theta [rad]")
lower.plot(run.t[first], run["lean"][first], drawstyle="steps-post", label="lean [rad], every 50 ms")
lower.set(xlabel="t [s]")
for ax in (upper, middle, lower):
    ax.grid(alpha=0.3)
    ax.legend()
fig.savefig("cart_pole_pid.png", dpi=120)
sb.save_animation(run, "cart_pole_pid_poses.png", times=[0.0, 0.4, 0.8, 1.2], progress=None)

# Slower samples: beyond some 80 ms the pole falls.
steps = [0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12]
sweep = sb.sweep(eqs, 3.0, {"dt": steps}, initial={"theta": np.radians(15)})
highest = np.abs(sweep["theta"]).max(axis=1)
for dt, angle in zip(steps, highest, strict=True):
    print(f"dt = {1e3 * dt:3.0f} ms: the pole leans {angle:.3g} rad at most")

# Check

# The pole stands, the cart is where it should be, and the force stayed within its limits.
p = run.parameters
assert lin.verdict == "stable"
assert abs(run["theta"][-1]) < 1e-3 and abs(run["x"][-1] - p["x_ref"]) < 0.05
assert np.abs(run["servo"]).max() == p["F_max"]
assert highest[0] < 0.3 and highest[-1] > 1.0


# The same by hand: a program of the controller, and the textbook's equations from sample to sample.
def rates(t, y, force):
    """Return the rates of x, theta and of their rates."""
    x, theta, v, w = y
    m, mp, length, g = (p[name] for name in ("m", "mp", "l", "g"))
    mass = [[m + mp, -mp * length * np.cos(theta)], [-mp * length * np.cos(theta), 4 / 3 * mp * length**2]]
    load = [force - mp * length * np.sin(theta) * w**2, mp * g * length * np.sin(theta)]
    return [v, w, *np.linalg.solve(mass, load)]


y, integral, before = np.array([0.0, np.radians(15), 0.0, 0.0]), 0.0, 0.0
forces = []
for k in range(100):
    if k % 5 == 0:
        lean = np.clip((0.8 * y[2] - 0.4 * (p["x_ref"] - y[0])) / p["g"], -0.2, 0.2)
    error = lean - y[1]
    wanted = 50 * error + integral + 6 * (error - before) / p["dt"]
    force = np.clip(wanted, -p["F_max"], p["F_max"])
    integral += p["dt"] * (20 * error + (force - wanted) * 20 / 50)
    before = error
    forces.append(force)
    ends = k * p["dt"], (k + 1) * p["dt"]
    y = solve_ivp(rates, ends, y, "DOP853", rtol=1e-12, atol=1e-13, args=(force,)).y[:, -1]

exact = sb.simulate(eqs, 1.0, {"theta": "15 deg"}, rtol=1e-12, atol=1e-13)
found = [exact[name][-1] for name in ("x", "theta", "x_dot", "theta_dot")]
assert np.abs(np.array(found) - y).max() < 1e-9
servo = exact.held_values.values[exact.held_values.names.index("servo")]
assert np.abs(servo[:-1] - forces).max() < 1e-7

# References
#
# K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, section 8.5: the digital PID controller.
