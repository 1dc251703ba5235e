"""DC motor and arm.

Description
    A DC motor with its own current turns an arm under gravity; a PID controller sets the voltage, within the
    supply. theta is the angle of the arm from level, theta_ref where it is to be.
Concepts
    Signals: names of formulas, of outputs and of states; blocks; equilibrium and linear equations of the
    mechanism with motor and controller; limits of the voltage, with back-calculation of the integral.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import symbody as sb

# Modeling

model = sb.load_model(Path(__file__).with_suffix(".toml"))
eqs = sb.form_equations(model)
print(eqs)
print("states:", eqs.state_names)

# Equilibrium: all rates vanish, so the error is 0 and the integral holds the weight.
rest = sb.find_equilibrium(eqs, inputs={"theta_ref": 1.0})
print(rest)
print(rest.linearization)

# Simulation

times = np.linspace(0.0, 2.0, 1001)
step = sb.simulate(eqs, 2.0, inputs={"theta_ref": 1.0}, times=times)
free = sb.simulate(eqs, 2.0, inputs={"theta_ref": 1.0}, times=times, parameters={"Vmax": 1e3})

fig, (upper, middle, lower) = plt.subplots(3, 1, sharex=True, figsize=(7, 7), layout="constrained")
for run, label in ((step, "12 V"), (free, "without limits")):
    upper.plot(run.t, run["theta"], label=label)
    middle.plot(run.t, run["voltage"], label=label)
    lower.plot(run.t, run["motor_current"], label=label)
upper.axhline(1.0, color="0.5", lw=0.8)
upper.set(ylabel="theta [rad]", title="A step of 1 rad: DC motor, PID and arm")
middle.set(ylabel="voltage [V]", ylim=(-20, 45))
lower.set(ylabel="current [A]", xlabel="t [s]")
for ax in (upper, middle, lower):
    ax.grid(alpha=0.3)
upper.legend()
fig.savefig("dc_motor_arm.png", dpi=120)

curves = sb.plot(step, "theta", "height", "error", title="Angle, height of the tip and error")
sb.save_plot(curves, "dc_motor_arm_height.png")

# Check

# The arm stands where it should, the integral part bears its weight, and small deviations die out.
p = step.parameters
torque = p["m"] * p["g"] * p["l"] * np.cos(1.0)
assert abs(rest["theta"] - 1.0) < 1e-9 and rest.stable
assert abs(rest["motor_current"] - torque / p["K"]) < 1e-8
assert abs(rest["voltage_integral"] - p["R"] * torque / p["K"]) < 1e-8
assert abs(step["theta"][-1] - 1.0) < 2e-2 and np.abs(step["voltage"]).max() <= p["Vmax"]
assert np.allclose(step["height"], 2 * p["l"] * np.sin(step["theta"]))


# The same by hand, with another integrator.
def rates(t, x):
    """Return the rates of all states."""
    speed, theta, integral, filtered, current = x
    error = 1.0 - theta
    slope = (error - filtered) / p["Tf"]
    wanted = p["kp"] * error + integral + p["kd"] * slope
    voltage = np.clip(wanted, -p["Vmax"], p["Vmax"])
    moment = p["K"] * current - p["b"] * speed - p["m"] * p["g"] * p["l"] * np.cos(theta)
    return [
        moment / (p["J"] + p["m"] * p["l"] ** 2),
        speed,
        p["ki"] * error + (voltage - wanted) * p["ki"] / p["kp"],
        slope,
        (voltage - p["R"] * current - p["K"] * speed) / p["L"],
    ]


hand = solve_ivp(rates, (0, 2), np.zeros(5), method="Radau", rtol=1e-9, atol=1e-11, max_step=1e-3)
found = [step[name][-1] for name in eqs.state_names]
assert np.allclose(found, hand.y[:, -1], atol=1e-6), (found, hand.y[:, -1])

# References
#
# K. J. Astrom and T. Hagglund, PID Controllers, section 3.5: windup and back-calculation.
