"""Quarter car on a road from a file.

Description
    A quarter of a car, body and wheel, goes at 20 m/s over a road whose heights stand in a CSV file. The tyre
    is a spring between road and wheel.
Concepts
    A table as the law of an input; outputs inside formulas; linear equations from the road to the body, their
    Bode plot; the comfort of a ride as the root mean square of the body's acceleration.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import symbody as sb

# Modeling

model = sb.load_model(Path(__file__).with_suffix(".toml"))
eqs = sb.form_equations(model)
print(eqs.text())
print(f"{len(model.tables[0].points)} heights of the road in {model.tables[0].file}")

# Simulation

times = np.linspace(0.0, 8.0, 1601)
run = sb.simulate(eqs, 8.0, times=times)
height, force, sag = "frame r Body ground ground z", "k_t*(road - z_w)", "(m_b + m_w)*g/k_t"
wheel = f"z_w + {sag}"  # from where it rests on a flat road
body = f"'{height}' + m_b*g/k_s + {sag}"
labels = ["road [m]", "wheel [m]", "body [m]", "tyre force [N]"]
title = "Over the road at 20 m/s, heights from rest on a flat road"
ax = sb.plot(run, "road", wheel, body, force, labels=labels, title=title)
sb.save_plot(ax, "quarter_car_ride.png")
acceleration = run["frame vdot Body ground ground z"]
comfort = float(np.sqrt(np.mean(acceleration**2)))
print(f"root mean square of the body's acceleration: {comfort:.3f} m/s^2")

# The road is an input: the linear equations lead from it to acceleration and tyre force.
outputs = ("frame vdot Body ground ground z", force)
lin = sb.linearize(eqs, sb.find_equilibrium(eqs).q, outputs=outputs)
frequencies = np.geomspace(0.2, 50.0, 400)
responses = np.array([
    lin.C @ np.linalg.solve(2j * np.pi * f * np.eye(len(lin.A)) - lin.A, lin.B) + lin.D for f in frequencies
])[:, :, 0]  # fmt: skip
fig, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(7, 5.5), layout="constrained")
for k, (name, color) in enumerate((("acceleration of the body [1/s²]", "C0"), ("tyre force [N/m]", "C3"))):
    upper.loglog(frequencies, np.abs(responses[:, k]), color, label=name)
    lower.semilogx(frequencies, np.degrees(np.unwrap(np.angle(responses[:, k]))), color)
upper.set(ylabel="gain for 1 m of road", title="From the road to body and tyre")
upper.legend()
lower.set(xlabel="frequency [Hz]", ylabel="phase [deg]")
for each in (upper, lower):
    each.grid(alpha=0.3, which="both")
fig.savefig("quarter_car_bode.png", dpi=120)

# Check

# Two modes: the body on the suspension, the wheel between suspension and tyre, about where springs alone
# would have them.
hertz = sorted({round(abs(float(root.imag)) / (2 * np.pi), 3) for root in lin.eigenvalues})
p = {name: float(formula.text) for name, formula in model.parameters.items()}
ride = np.sqrt(p["k_s"] * p["k_t"] / (p["k_s"] + p["k_t"]) / p["m_b"]) / (2 * np.pi)
hop = np.sqrt((p["k_s"] + p["k_t"]) / p["m_w"]) / (2 * np.pi)
print(f"modes at {hertz} Hz; ride and wheel hop without damping {ride:.3f} and {hop:.3f} Hz")
assert abs(hertz[0] - ride) < 0.15 * ride and abs(hertz[-1] - hop) < 0.1 * hop

# The gain by hand, from the equations of two masses.
s = 2j * np.pi * frequencies
suspension, tyre = p["k_s"] + p["d_s"] * s, p["k_t"]
body = p["m_b"] * s**2 + suspension
wheel = p["m_w"] * s**2 + suspension + tyre + p["d_t"] * s
gain = s**2 * tyre * suspension / (body * wheel - suspension**2)
assert np.abs(responses[:, 0] / gain - 1).max() < 1e-9

# The input follows the file, straight between its rows.
assert np.abs(run["road"] - np.interp(times, *np.transpose(model.tables[0].points))).max() < 1e-12
assert 0.3 < comfort < 3.0

# References
#
# D. Karnopp, Vehicle Dynamics, Stability and Control, chapter on vertical dynamics: the quarter car.
