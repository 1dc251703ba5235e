"""RR robot.

Description
    Two links turn about parallel Z axes under the torques T1 and T2; gravity G points along -Y. beta_1 is the
    angle of the first link, beta_2 that of the second relative to the first. L3 and L4 lie before and behind
    the first centre of mass, L5 and L6 before and behind the second; the tip is P.
Concepts
    Torque drivers; a mass matrix that can be read; position of a frame; forward kinematics, inverse dynamics,
    forward dynamics.
"""

from pathlib import Path

import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb

# Modeling

eqs = sb.form_equations(sb.load_model(Path(__file__).with_suffix(".toml")))
print("mass matrix:", eqs.mass_matrix)
print("right-hand side:", eqs.forcing)
xP, yP, _ = eqs.frame_motion("r", "P", "ground", "ground")
print("tip:", xP, yP)

# Simulation

beta_1, beta_2, T1, T2 = dynamicsymbols("beta_1 beta_2 T1 T2")
t = dynamicsymbols._t
values = dict.fromkeys(sp.symbols("m1 m2 I1 I2 L3 L4 L5 L6"), 1) | {sp.Symbol("G"): 10}
motion = {beta_1: sp.pi * t**2, beta_2: sp.pi * t**2}

# Forward kinematics: the tip spirals in towards the first joint.
tip = [coordinate.subs(values).subs(motion) for coordinate in (xP, yP)]
for time in (0, 0.5, 1):
    print(f"t = {time} s: tip at {[round(float(entry.subs(t, time)), 6) for entry in tip]} m")

# Inverse dynamics: the torques of that motion, linear in T1 and T2.
equations = [equation.subs(values).subs(motion).doit() for equation in eqs.dynamic_equations()]
torques = sp.solve(equations, [T1, T2])
for time in (0, 0.25, 0.5, 0.75, 1):
    print(
        f"t = {time} s: T1 = {torques[T1].subs(t, time).evalf(9)}, T2 = {torques[T2].subs(t, time).evalf(9)}"
    )

# Forward dynamics: these torques bring the motion back.
run = sb.simulate(eqs, 1.0, inputs={"T1": str(torques[T1]), "T2": str(torques[T2])}, rtol=1e-11, atol=1e-13)
path = ("frame r P x", "frame r P y")
elbow = ("frame r Link1.tip x", "frame r Link1.tip y")
ax = sb.plot(run, path, elbow, labels=["tip", "elbow"], title="Paths in the plane")
sb.save_plot(ax, "rr_robot.png")
ax = sb.plot(run, str(torques[T1]), str(torques[T2]), labels=["T1 [N m]", "T2 [N m]"], title="Torques")
sb.save_plot(ax, "rr_robot_torques.png")

# Check

for time, (first, second) in {0: (140.530965, 47.699112), 0.75: (-90.293881, 57.002201)}.items():
    assert abs(torques[T1].subs(t, time) - first) < 1e-6 and abs(torques[T2].subs(t, time) - second) < 1e-6
assert abs(run["beta_1"][-1] - sp.pi) < 1e-8 and abs(run["beta_2"][-1] - sp.pi) < 1e-8

# References
#
# J. J. Craig, Introduction to Robotics: Mechanics and Control, chapter 6: manipulator dynamics.
