"""A robot with two links: mass matrix, path of the tip, and the torques of a given motion."""

from pathlib import Path

import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb

eqs = sb.form_equations(sb.load_model(Path(__file__).with_name("rr_robot.toml")))
print(eqs.mass_matrix)
print(eqs.frame_motion("r", "P")[:2])

beta_1, beta_2, T1, T2 = dynamicsymbols("beta_1 beta_2 T1 T2")
t = dynamicsymbols._t
values = dict.fromkeys(sp.symbols("m1 m2 I1 I2 L3 L4 L5 L6"), 1) | {sp.Symbol("G"): 10}
motion = {beta_1: sp.pi * t**2, beta_2: sp.pi * t**2}
equations = [equation.subs(values).subs(motion).doit() for equation in eqs.dynamic_equations()]
torques = sp.solve(equations, [T1, T2])
for time in (0, 0.25, 0.5, 0.75, 1):
    print(f"t = {time}: T1 = {torques[T1].subs(t, time).evalf(9)}, T2 = {torques[T2].subs(t, time).evalf(9)}")
