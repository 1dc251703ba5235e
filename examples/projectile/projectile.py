"""Projectile.

Description
    A body of mass m and inertia Inertia is thrown at 10 m/s and 30 degrees above the horizontal, spinning at
    10 rad/s; gravity G points along -Y. X and Y are the place of its centre of mass, theta its turn.
Concepts
    Planar joint; three uncoupled equations; initial values as formulas; paths in the plane and in space; the
    same body with a free joint, and with no joint at all.
"""

from pathlib import Path

import symbody as sb
from symbody.dynaflexpro import BuildEQs

# Modeling

file = Path(__file__).with_suffix(".toml")
eqs = sb.form_equations(sb.load_model(file))
print(*eqs.dynamic_equations(), sep="\n")

# Simulation

run = sb.simulate(eqs, 1.0)
ax = sb.plot(run, ("X", "Y"), title="Path of the centre of mass")
ax.set(adjustable="box", xlim=(0, 10), ylim=(0, 2))  # limits as given, a metre equally long on both axes
sb.save_plot(ax, "projectile.png")
sb.save_plot(sb.plot(run, ("frame r Body.CoM",), title="The same in space"), "projectile_3d.png")
ax = sb.plot(run, "theta_dot", title="Angular speed")
ax.set(ylim=(0, 20))
sb.save_plot(ax, "projectile_speed.png")

# In space, with Cardan angles, and without any joint: the same path.
free_file = file.with_name("projectile_free.toml")
free = sb.simulate(sb.form_equations(sb.load_model(free_file)), 1.0)
body = sb.load_model(free_file)
loose = BuildEQs(sb.Model("loose", body.bodies, gravity=body.gravity, parameters=body.parameters))
print("without a joint:", loose.equations.coordinate_names)

# Check

half = run.at(0.5)
print(f"apex {half['Y']:.6f} m, lands at X = {run['X'][-1]:.6f} m, turned by {run['theta'][-1]:.6f} rad")
assert abs(half["Y"] - 1.25) < 1e-12 and abs(run["Y"][-1]) < 1e-12
assert abs(run["X"][-1] - 5 * 3**0.5) < 1e-12 and abs(run["theta"][-1] - 10) < 1e-12
assert all(abs(free.at(0.5)[name] - half[name]) < 1e-12 for name in ("X", "Y", "theta"))
assert len(loose.vQ) == 6

# References
#
# J. L. Meriam, L. G. Kraige, Engineering Mechanics: Dynamics, section 2/4: projectile motion.
