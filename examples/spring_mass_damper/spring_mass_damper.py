"""Spring, mass and damper.

Description
    A mass m slides along X between a spring k, a damper d and a force F(t). Its displacement x is measured
    from where the spring is undeformed.
Concepts
    A force driver that holds spring, damper and applied force; one equation of motion and its closed form;
    inputs as expressions of time; plots over time.
"""

from pathlib import Path

import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb

# Modeling

eqs = sb.form_equations(sb.load_model(Path(__file__).with_suffix(".toml")))
(equation,) = eqs.dynamic_equations()
print(equation)

# Simulation

x, F = dynamicsymbols("x F")
t = dynamicsymbols._t
values = {"m": 1, "d": sp.Rational(1, 2), "k": 1}
at_first = {x.subs(t, 0): 1, x.diff(t).subs(t, 0): 0}
unforced = sp.dsolve(equation.subs(values).subs(F, 0), x, ics=at_first).rhs
print("unforced: x =", unforced)

free = sb.simulate(eqs, 10.0)
slow = sb.simulate(eqs, 10.0, inputs={"F": "sin(t)"})
fast = sb.simulate(eqs, 10.0, inputs={"F": "sin(10*t)"})
sb.save_plot(sb.plot(free, "x", "x_dot", title="Unforced displacement and speed"), "spring_mass_damper.png")
ax = sb.plot(slow, "x", labels=["x for F = sin(t)"], title="Displacement under two forces")
sb.plot(fast, "x", labels=["x for F = sin(10 t)"], ax=ax)
sb.save_plot(ax, "spring_mass_damper_forced.png")

# Check

for time in (1, 5, 10):
    found = free.at(time)["x"]
    print(f"x({time}) = {found:.8f} m, closed form {float(unforced.subs(t, time)):.8f} m")
    assert abs(found - unforced.subs(t, time)) < 1e-7
assert abs(slow["x"][-1] - 1.423815171) < 1e-7 and abs(fast["x"][-1] + 0.082332817) < 1e-7

# References
#
# S. S. Rao, Mechanical Vibrations, sections 2.6 and 3.4: damped motion, free and under a harmonic force.
