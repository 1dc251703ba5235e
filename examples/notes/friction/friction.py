"""Dry friction.

Description
    A block of mass m lies on the floor and is pulled by a force that grows with time, Fe = c t, beside a
    smooth law of friction, and again with sticking told from sliding.
Concepts
    Coulomb's friction with mu_s at rest and mu_c in motion; the sign smoothed to sin(arctan(x/x0));
    break-away where Fe passes mu_s N; with Newton's equations the normal force is an unknown. Section 4.8
    of the notes, whose printed formula (4.8.1) lacks a square of v0.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    comp_X,
    comp_Y,
    equation_set,
    ground,
    make_BODY,
    make_FORCE,
    newton_equations,
    origin,
    translate,
)

# Modeling

t = dynamicsymbols._t
s, N, Fe = dynamicsymbols("s N Fe")
m, g, mu_s, mu_c, v0, x0 = sp.symbols("m g mu_s mu_c v0 x0")
smooth = sp.sin(sp.atan(s.diff(t) / v0))
dynafri = -mu_c * sp.Abs(N) * smooth
staticfric = -mu_s * sp.Abs(N) * sp.sin(sp.atan(Fe / x0))
print("sliding:", dynafri)
print("sticking:", staticfric)

RF = translate(s, 0, 0)
block = make_BODY(RF, m, 0, 0, 1)
weight = make_FORCE(ground, 0, -m * g, 0, origin(RF), block)
pull = make_FORCE(ground, Fe, 0, 0, origin(RF), block)
floor = make_FORCE(ground, dynafri, N, 0, origin(RF), block)
neq = newton_equations([block, weight, pull, floor])
(normal,) = sp.solve(comp_Y(neq), N)
print("Newton:", comp_X(neq), "= 0;", comp_Y(neq), "= 0")

# Simulation

data = {"m": 2, "g": 9.81, "mu_s": 0.5, "mu_c": 0.4}
push = make_FORCE(ground, Fe - mu_c * m * g * smooth, 0, 0, origin(RF), block)
eqs = equation_set([block, push], [s], parameters={"m": 2, "g": 9.81, "mu_c": 0.4, "v0": 0.001})
creeping = sb.simulate(eqs, 4.0, initial={"s": 0}, inputs={"Fe": "5*t"})

drive = sb.Friction(mu="mu_c", mu_static="mu_s")
slide = sb.Prismatic(
    "slide", "ground", "Block", axis="x", coordinate="s", force=sb.Drive(applied="Fe"), friction=drive
)
model = sb.Model(
    "block on the floor", [sb.Body("Block", mass="m"), slide],
    gravity=(0, "-g", 0), parameters=data, inputs=["Fe"],
)  # fmt: skip
stick_slip = sb.simulate(sb.form_equations(model), 4.0, inputs={"Fe": "5*t"})

figure = Figure(layout="constrained", figsize=(6.4, 7))
law_axes, force_axes, speed_axes = figure.subplots(3)
x = np.linspace(-1, 1, 2001)
for width in (0.1, 0.01):
    law_axes.plot(x, np.sin(np.arctan(x / width)), label=f"x0 = {width}")
law_axes.plot(x, np.sign(x), "k:", label="signum")
law_axes.set(xlabel="x", ylabel="sin(arctan(x/x0))", title="The smoothed sign")
times = np.linspace(0, 4, 200)
force_axes.plot(times, 5 * times, label="Fe")
force_axes.axhline(0.5 * 2 * 9.81, color="C1", label="mu_s N")
force_axes.set(xlabel="time [s]", ylabel="force [N]", title="Break-away")
speed_axes.plot(times, creeping.at(times)["s_dot"], label="smooth law")
speed_axes.plot(times, stick_slip.at(times)["s_dot"], label="stick and slip")
speed_axes.set(xlabel="time [s]", ylabel="speed [m/s]")
for axes in (law_axes, force_axes, speed_axes):
    axes.legend()
sb.save_plot(law_axes, "friction.png")

# Check

v, n = sp.symbols("v n")
plain = dynafri.subs(s.diff(t), v).subs(sp.Abs(N), n)
right = -mu_c * n * v / (v0 * sp.sqrt(1 + (v / v0) ** 2))  # printed without the square of v0
assert sp.simplify(plain - right) == 0
values = [float(sp.sin(sp.atan(a / 0.01))) for a in (0.01, 0.1, 1)]
assert np.allclose(values, [0.70710678, 0.99503719, 0.99995], atol=5.1e-6)
assert normal == m * g
# It breaks away where 5 t = mu_s m g, then m v' = 5 t - mu_c m g.
start = 0.5 * 2 * 9.81 / 5
end = 4.0 - start
speed = (2.5 * (16 - start**2) - 0.4 * 2 * 9.81 * end) / 2
moving = stick_slip.t[np.argmax(stick_slip["s_dot"] > 1e-9)]
print(f"breaks away at {start:.6f} s; end speed {stick_slip['s_dot'][-1]:.6f} m/s, by hand {speed:.6f} m/s")
assert stick_slip.success and abs(stick_slip["s_dot"][-1] - speed) < 1e-6 and moving >= start - 1e-6
# The smooth law knows no mu_s: it lets go where 5 t = mu_c m g, and creeps before.
early = (2.5 * (16 - (0.8 * start) ** 2) - 0.4 * 2 * 9.81 * (4 - 0.8 * start)) / 2
assert creeping.success and abs(creeping["s_dot"][-1] - early) < 1e-2

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 4.8.
