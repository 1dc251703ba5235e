"""Spatial four-bar.

Description
    A crank about z drives a rocker about y through a rod on two ball joints (RSSR). The mechanism has two
    freedoms: the turning crank, and the rod that spins about itself.
Concepts
    A closed loop in space; spherical joints in the tree and cut; paths in space.
"""

from pathlib import Path

import symbody as sb

# Modeling

eqs = sb.form_equations(sb.load_model(Path(__file__).with_suffix(".toml")))
print(eqs.coordinates, eqs.degrees_of_freedom, "degrees of freedom")
print(eqs.constraints)
print(eqs.operation_count("udot", "lambda"), "operations for accelerations and multipliers")

# Simulation

run = sb.simulate(eqs, 2.0)
sb.save_plot(sb.plot(run, "theta", "phi", title="Crank and rocker"), "spatial_four_bar.png")
ax = sb.plot(run, ("frame r Crank.pin",), ("frame r Rocker.pin",), labels=["crank pin", "rocker pin"])
sb.save_plot(ax, "spatial_four_bar_paths.png")

# Check

print(f"loops open by {run.constraint_violation.max():.1e}, energy drift {run.energy_drift:.1e} J")
assert run.success and run.constraint_violation.max() < 1e-9 and run.energy_drift < 1e-6

# References
#
# R. S. Hartenberg, J. Denavit, Kinematic Synthesis of Linkages, chapter 12: spatial linkages.
