"""Slider-crank.

Description
    A crank of mass m1 and length L1 turns about A; a rod of mass m2 and length L2 joins it at B to a piston
    at C, which slides along X at D under the force F. Gravity G points along -Y. theta is the angle of the
    crank, beta that of the rod, s the place of the piston.
Concepts
    A closed loop: joint B is cut, which leaves three dynamic equations, two position constraints and two
    multipliers; reactions; assembly; other cuts and absolute coordinates for the same motion.
"""

from pathlib import Path

import numpy as np

import symbody as sb
from symbody.dynaflexpro import BuildEQs

# Modeling

file = Path(__file__).with_suffix(".toml")
Model = BuildEQs(file)
print(*Model.GetDynEQs(), sep="\n")
print(*Model.GetPosCons(), sep="\n")

# Simulation

eqs = Model.equations
print("at 45 degrees:", sb.assemble(eqs, {"theta": np.pi / 4}).q)
start = {"theta": "pi/6", "theta_dot": 5}  # what else moves follows
run = sb.simulate(eqs, 2.0, start, rtol=1e-11, atol=1e-12)
sb.save_plot(sb.plot(run, "theta", "beta", title="Crank and rod"), "slider_crank.png")
sb.save_plot(sb.plot(run, "s", title="Piston"), "slider_crank_piston.png")
ax = sb.plot(run, "reaction B Fx", "reaction B Fy", title="Force on the rod at B, in the axes of the crank")
sb.save_plot(ax, "slider_crank_reaction.png")

# The same with joint C cut, and with free bodies, whose 18 speeds are held by every joint.
model = sb.load_model(file)
other = sb.simulate(sb.form_equations(model, tree=sb.Trees("ABD", "ABD")), 2.0, start, rtol=1e-11, atol=1e-12)
absolute = sb.form_equations(model, tree="absolute")
print(len(absolute.speeds), "speeds,", len(absolute.multipliers), "multipliers")

# Check

print(f"loops open by {run.constraint_violation.max():.1e}, energy drift {run.energy_drift:.1e} J")
assert run.success and run.constraint_violation.max() < 1e-10 and run.energy_drift < 1e-8
p = eqs.model.values()
reach = p["L1"] * np.cos(run["theta"]) + np.sqrt(p["L2"] ** 2 - (p["L1"] * np.sin(run["theta"])) ** 2)
assert np.abs(run["s"] - reach).max() < 1e-9
assert abs(other["s"][-1] - run["s"][-1]) < 1e-7

# References
#
# E. J. Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, sections 5.1 and 8.1.
