"""A mass on a spring and a damper: its equation, its closed form, its motion."""

from pathlib import Path

import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb

eqs = sb.form_equations(sb.load_model(Path(__file__).with_name("spring_mass_damper.toml")))
(equation,) = eqs.dynamic_equations()
print(equation)

x, F = dynamicsymbols("x F")
t = dynamicsymbols._t
values = {"m": 1, "d": sp.Rational(1, 2), "k": 1}
print(sp.dsolve(equation.subs(values).subs(F, 0), x, ics={x.subs(t, 0): 1, x.diff(t).subs(t, 0): 0}))

run = sb.simulate(eqs, 10.0, inputs={"F": "sin(10*t)"})
print(f"x(10) = {run['x'][-1]:.9f} m under a fast force; energy drift {run.energy_drift:.1e} J")
