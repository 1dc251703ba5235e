"""Bicycle.

Description
    The Whipple bicycle: a rear frame with a rigid rider, a front frame on an inclined steer axis, two wheels
    that roll without slipping. It rides at 4.6 m/s and is pushed to the side; nobody holds the handlebar.
Concepts
    Rolling discs: nonholonomic constraints beside holonomic ones; nine speeds, three degrees of freedom;
    stability of a motion; energy into forward speed.
"""

from pathlib import Path

import numpy as np

import symbody as sb

# Modeling

eqs = sb.form_equations(sb.load_model(Path(__file__).with_suffix(".toml")))
print(len(eqs.speeds), "speeds,", len(eqs.multipliers), "multipliers,", eqs.degrees_of_freedom, "freedoms")

# Simulation

fixed = dict.fromkeys(("x", "y", "yaw", "lean", "steer", "rear", "front", "steer_dot"), 0.0)
run = sb.simulate(eqs, 10.0, {**fixed, "lean_dot": 0.5, "rear_dot": "4.6/RR"})
sb.save_plot(sb.plot(run, "lean", "steer", title="Lean and steer"), "bicycle.png")
ax = sb.plot(run, ("frame r rear_tyre",), ("frame r front_tyre",), labels=["rear wheel", "front wheel"])
sb.save_plot(ax, "bicycle_tracks.png")

# Check

speed = 0.3 * run["rear_dot"]
lean = np.degrees(run["lean"])
print(f"largest lean {np.abs(lean).max():.2f} deg, at the end {lean[-1]:.2f} deg")
print(f"from {speed[0]:.3f} m/s to {speed[-1]:.3f} m/s, energy drift {run.energy_drift:.1e} J")
assert run.success and run.energy_drift < 1e-5
# The weave dies out and its energy goes into forward speed.
assert abs(run["lean"][-1]) < 0.05 * np.abs(run["lean"]).max() and speed[-1] > speed[0]
# The load on both tyres together is near the weight, 94 kg.
load = run["reaction rear_tyre Fz"] + run["reaction front_tyre Fz"]
assert abs(load.mean() / (94 * 9.81) - 1) < 0.01

# References
#
# J. P. Meijaard, J. M. Papadopoulos, A. Ruina, A. L. Schwab, Linearized dynamics equations for the balance
# and steer of a bicycle: a benchmark and review, Proc. R. Soc. A 463 (2007), 1955-1982.
