"""Spinning top in its angular velocity.

Description
    The top of the example spinning_top, released alike. Its speeds are now the components omega_x, omega_y,
    omega_z of its angular velocity in its own axes; zeta, eta and xi stay the coordinates.
Concepts
    Quasi-speeds resolved in the end frame of a spherical joint: a constant diagonal mass matrix; kinematic
    equations that give the angle rates, and where they are singular.
"""

from pathlib import Path

import numpy as np

import symbody as sb
from symbody.dynaflexpro import BuildEQs

# Modeling

Model = BuildEQs(Path(__file__).with_suffix(".toml"))
print("mass matrix:", Model.xM)
print("right-hand side:", Model.vF)
print(*Model.GetKinTrans(), sep="\n")
print("must not vanish:", Model.GetKinTransSingularities())

# Simulation

run = sb.simulate(Model.equations, 10.0, rtol=1e-11, atol=1e-12)
print(f"10 s of motion in {run.statistics.loop_seconds * 1e3:.1f} ms")
ax = sb.plot(run, "omega_x", "omega_y", "omega_z", title="Angular velocity in the axes of the top")
sb.save_plot(ax, "spinning_top_omega.png")
ax = sb.plot(run, ("frame r Top.CoM x", "frame r Top.CoM y"), title="Centre of mass from above")
sb.save_plot(ax, "spinning_top_omega_path.png")

# Check

end = run["frame r Top.CoM ground ground"][:, -1]
print(f"nutation {np.degrees(run['eta'][-1]):.6f} degrees, centre of mass {end}")
assert abs(np.degrees(run["eta"][-1]) - 101.361144) < 1e-6  # as in Euler angles
assert np.abs(end - [0.04280216, 0.97947023, -0.19699251]).max() < 1e-7
assert np.abs(run["omega_z"] - 10).max() < 1e-12  # nothing turns a symmetric top about its axis

# References
#
# H. Goldstein, C. Poole, J. Safko, Classical Mechanics, sections 4.9 and 5.5: Euler's equations.
