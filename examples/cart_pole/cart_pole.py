"""Cart-pole.

Description
    A pole stands on a cart; a force F pushes the cart along X. theta is the angle of the pole from upright,
    positive to the left, so that a push to the right makes it grow.
Concepts
    Linear equations about the upright equilibrium; a linear-quadratic regulator; a motion in steps of the
    sampling time, whose input comes from Python and keeps its value between samples.
"""

import math
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import expm, solve_continuous_are

import symbody as sb

# Modeling

eqs = sb.form_equations(sb.load_model(Path(__file__).with_suffix(".toml")))
lin = sb.linearize(eqs, {"x": 0, "theta": 0})
A, B = lin.A, lin.B
print("states:", lin.state_names, "upright:", lin.verdict)

# The regulator: F = -K x for the least integral of x' Q x + F R F.
weights = {"x": 10.0, "theta": 10.0, "x_dot": 1.0, "theta_dot": 1.0}
Q, R = np.diag([weights[name] for name in lin.state_names]), np.array([[0.1]])
K = np.linalg.solve(R, B.T @ solve_continuous_are(A, B, Q, R))
print("gains:", dict(zip(lin.state_names, K[0].round(4).tolist(), strict=True)))

# Simulation

# 10,000 samples of a millisecond from a pole that leans. Speeds come first in the states, as `u` and `q` of
# the stepper.

dt, samples = 1e-3, 10_000
stepper = sb.Stepper(eqs, dt, initial={"theta": "20 deg"})
gain_u, gain_q = K[0, :2].copy(), K[0, 2:].copy()
record = np.empty((samples, 4))
began = time.process_time()
for k in range(samples):
    F = -float(gain_u @ stepper.u + gain_q @ stepper.q)
    record[k] = stepper.t, stepper["x"], stepper["theta"], F
    stepper.step(F=F)
print(f"{(time.process_time() - began) / samples * 1e6:.1f} us a sample, controller and record included")

fig, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
upper.plot(record[:, 0], record[:, 1], label="x [m]")
upper.plot(record[:, 0], record[:, 2], label="theta [rad]")
upper.legend()
upper.set_title("Cart-pole under a linear-quadratic regulator, 1 kHz")
lower.plot(record[:, 0], record[:, 3], color="C2")
lower.set(xlabel="t [s]", ylabel="F [N]")
for ax in (upper, lower):
    ax.grid(alpha=0.3)
fig.savefig("cart_pole.png", dpi=120)

# The same regulator without samples: its law is a formula of the states.
law = " + ".join(f"({gain!r})*{name}" for gain, name in zip(K[0].tolist(), lin.state_names, strict=True))
motion = sb.simulate(eqs, 5.0, {"theta": "20 deg"}, inputs={"F": f"-({law})"})
sb.save_plot(sb.plot(motion, "x", "theta", title="The same without samples"), "cart_pole_continuous.png")

# Check

# The regulator holds what would fall.
assert lin.verdict == "unstable" and np.linalg.eigvals(A - B @ K).real.max() < 0
assert abs(stepper["theta"]) < 1e-3 and abs(stepper["x"]) < 1e-2

# Small motions follow the linear equations, sampled: x(k+1) = (Ad - Bd K) x(k), Ad and Bd exact.
small = sb.Stepper(eqs, dt, initial={"theta": 1e-4})
x = np.array([0.0, 0.0, 0.0, 1e-4])
block = expm(np.block([[A, B], [np.zeros((1, 5))]]) * dt)
closed = block[:4, :4] - block[:4, 4:] @ K
for _ in range(2000):
    small.step(F=-float(gain_u @ small.u + gain_q @ small.q))
    x = closed @ x
assert np.abs(np.concatenate([small.u, small.q]) - x).max() < 1e-8

# Holding the force for a millisecond changes little.
assert abs(np.interp(2.0, record[:, 0], record[:, 1]) - motion.at(2.0)["x"]) < 0.01

# The same force over the same sample gives the motion of simulate.
run = sb.simulate(eqs, dt, {"theta": math.radians(20)}, inputs={"F": record[0, 3]})
first = sb.Stepper(eqs, dt, initial={"theta": "20 deg"}).step(F=float(record[0, 3]))
assert np.abs(first.u - run.u[:, -1]).max() < 1e-9

# References
#
# A. E. Bryson and Y.-C. Ho, Applied Optimal Control, section 5.4: the linear-quadratic regulator.
