"""Spinning top.

Description
    A symmetric top of mass m turns about its tip, the frame Base, which rests at the origin; gravity G
    points along -Z. A is the moment of inertia across the spin axis and C that along it, both about the
    tip; L is the distance from there to the centre of mass. Released horizontally with a spin of 10 rad/s,
    it nods.
Concepts
    Spherical joint with 3-1-3 Euler angles: precession zeta, nutation eta, spin xi; three nonlinear
    equations; cusps; a path in space.
"""

from pathlib import Path

import numpy as np

import symbody as sb

# Modeling

eqs = sb.form_equations(sb.load_model(Path(__file__).with_suffix(".toml")))
print("mass matrix:", eqs.mass_matrix)
print(*eqs.dynamic_equations(), sep="\n")

# Simulation

run = sb.simulate(eqs, 10.0, rtol=1e-11, atol=1e-12)
print(f"10 s of motion in {run.statistics.loop_seconds * 1e3:.1f} ms")
ax = sb.plot(run, "eta*180/pi", labels=["nutation eta [deg]"], title="Nutation of the top")
sb.save_plot(ax, "spinning_top.png")
ax = sb.plot(run, ("frame r Top.CoM",), labels=["centre of mass"], title="Path of the centre of mass")
ax.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
sb.save_plot(ax, "spinning_top_path.png")

# Check

nutation = np.degrees(run["eta"])
end = run["frame r Top.CoM ground ground"][:, -1]
print(f"nutation {nutation.min():.4f} to {nutation.max():.4f} degrees, {nutation[-1]:.6f} at the end")
print(f"precession {run['zeta'][-1]:.8f} rad, centre of mass {end}, energy drift {run.energy_drift:.1e} J")
assert abs(nutation[-1] - 101.361144) < 1e-6 and nutation.max() < 110.198238
assert np.abs(end - [0.04280216, 0.97947023, -0.19699251]).max() < 1e-7
assert run.energy_drift < 1e-8

# References
#
# H. Goldstein, C. Poole, J. Safko, Classical Mechanics, section 5.7: the heavy symmetrical top.
