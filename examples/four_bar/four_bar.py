"""Four-bar linkage.

Description
    A crank of length L1 turns about A; a coupler of length L2 joins it at B to a rocker of length L3 at C,
    which swings about D, the length L4 to the right of A. The torque T turns the crank; gravity G points
    along -Y. theta is the angle of the crank, beta that of the coupler from the crank, phi that of the
    rocker. The point P of the coupler, H above its middle, draws a coupler curve.
Concepts
    A crank-rocker by Grashof's condition; its closed loop: joint C is cut; position analysis over a turn;
    both branches; reactions and the torque that keeps the speed by inverse dynamics.
"""

from pathlib import Path

import numpy as np

import symbody as sb

# Modeling

model = sb.load_model(Path(__file__).with_suffix(".toml"))
eqs = sb.form_equations(model)
print(*eqs.constraints, sep="\n")
p = model.values()
lengths = sorted(p[name] for name in ("L1", "L2", "L3", "L4"))
print(
    "Grashof: shortest and longest", lengths[0] + lengths[-1], "m, the others", lengths[1] + lengths[2], "m"
)

# Simulation

run = sb.simulate(eqs, 2.0, rtol=1e-11, atol=1e-12)
sb.save_plot(sb.plot(run, "phi", title="Rocker"), "four_bar_rocker.png")
path = ("frame r Coupler.P x", "frame r Coupler.P y")
sb.save_plot(sb.plot(run, path, title="Coupler curve"), "four_bar_coupler.png")

# The torque that turns the crank evenly, a turn in half a second.
times = np.linspace(0.0, 0.5, 201)
even = sb.inverse_dynamics(eqs, {"theta": "4*pi*t"}, "T", times, guess={"phi": 2.0})
sb.save_plot(sb.plot(even, "T", title="Torque for an even speed"), "four_bar_torque.png")
print(f"torque from {even['T'].min():.2f} to {even['T'].max():.2f} N m")

# Check

print(f"loops open by {run.constraint_violation.max():.1e}, energy drift {run.energy_drift:.1e} J")
assert run.success and run.constraint_violation.max() < 1e-10 and run.energy_drift < 1e-8
assert lengths[0] + lengths[-1] <= lengths[1] + lengths[2] and lengths[0] == p["L1"]
assert np.ptp(run["theta"]) > 4 * np.pi and np.ptp(run["phi"]) < np.pi  # a crank, and a rocker

# Freudenstein's equation between the angles of crank and rocker.
k1, k2 = p["L4"] / p["L1"], p["L4"] / p["L3"]
k3 = (p["L1"] ** 2 - p["L2"] ** 2 + p["L3"] ** 2 + p["L4"] ** 2) / (2 * p["L1"] * p["L3"])
for motion in (run, even):
    theta, phi = motion["theta"], motion["phi"]
    assert np.abs(k1 * np.cos(phi) - k2 * np.cos(theta) + k3 - np.cos(theta - phi)).max() < 1e-9

# After a turn everything is as before, so the torque does no work in it.
assert np.abs(even["frame r Coupler.P"][:, 0] - even["frame r Coupler.P"][:, -1]).max() < 1e-9
assert abs(np.trapezoid(even["T"], even["theta"])) < 1e-6

# References
#
# F. Freudenstein, Approximate Synthesis of Four-Bar Linkages, Transactions of the ASME 77, 1955.
# R. L. Norton, Design of Machinery, sections 2.13 and 4.5.
