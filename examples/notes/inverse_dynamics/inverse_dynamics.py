"""Inverse dynamics: the torque that a motion needs.

Description
    A slider-crank whose crank is to turn faster and faster, theta1 = pi t^2/2, by a torque Tm at its
    bearing.
Concepts
    The motion is known, so multipliers and controls are the unknowns: as many as equations of motion, the
    constraints are not needed; the kinematic solution put in afterwards. Section 4.9 of the notes.
"""

import numpy as np
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    GenerateMatrix,
    comp_X,
    comp_Y,
    equation_set,
    ground,
    join_points,
    lagrange_equations,
    make_BODY,
    make_CONSTRAINT,
    make_POINT,
    make_TORQUE,
    make_VECTOR,
    origin,
    project,
    rotate,
    set_gravity,
    translate,
)

# Modeling

t = dynamicsymbols._t
theta1, theta2, s = q = list(dynamicsymbols("theta1 theta2 s"))
L, L2, m1, m2, m3, iz1, iz2, g = sp.symbols("L L2 m1 m2 m3 iz1 iz2 g")
data = {"L": 1, "L2": 3, "m1": 2, "m2": 3, "m3": 1, "iz1": 0.2, "iz2": 2.3, "g": 9.81}
RF1 = rotate("Z", theta1)
RF2 = RF1 * translate(L, 0, 0) * rotate("Z", theta2)
RF3 = translate(s, 0, 0)
G1, G2, G3 = make_POINT(RF1, L / 2, 0, 0), make_POINT(RF2, L2 / 2, 0, 0), origin(RF3)
pin = project(join_points(G3, make_POINT(RF2, L2, 0, 0)), ground)
Phi = [comp_X(pin), comp_Y(pin)]
bodies = body1, body2, body3 = (
    make_BODY(G1, m1, 0, 0, iz1),
    make_BODY(G2, m2, 0, 0, iz2),
    make_BODY(RF3, m3, 0, 0, 1),
)
Tm = dynamicsymbols("Tm")
set_gravity(make_VECTOR(ground, 0, -g, 0))
lvars = list(dynamicsymbols("lambda1:3"))
objects = [*bodies, make_TORQUE(ground, 0, 0, Tm, body1), make_CONSTRAINT(Phi, lvars)]
lgr_eq = lagrange_equations(objects, q + lvars, t)
print("equations of motion:", *lgr_eq[:3], sep="\n")

# Simulation

# As the notes do it: the equations of motion solved for the unknowns, then motion and kinematic
# solution put in.
numbers = {sp.Symbol(name): value for name, value in data.items()}
motion = sp.pi * t**2 / 2
slope = sp.asin(L / L2 * sp.sin(theta1))
sol_kine = {theta2: -slope - theta1, s: L * sp.cos(theta1) + L2 * sp.cos(slope)}
A, b = GenerateMatrix(lgr_eq[:3], [*lvars, Tm])
moving = [
    (x, expression.subs(theta1, motion).subs(numbers))
    for x, expression in [*sol_kine.items(), (theta1, theta1)]
]
known = [(x.diff(t, k), value.diff(t, k)) for k in (2, 1, 0) for x, value in moving]
entries = sp.lambdify(t, [matrix.subs(numbers).subs(known) for matrix in (A, b)], cse=True)
times = np.linspace(0, 2, 201)
by_hand = np.array([np.linalg.solve(*entries(time))[:, 0] for time in times])

# The same by one call.
eqs = equation_set(objects, q, parameters=data)
need = sb.inverse_dynamics(eqs, {"theta1": "pi*t^2/2"}, ["Tm"], times, guess={"theta2": 0, "s": 4})
ax = sb.plot(need, "Tm", labels=["Tm [N m]"], title="Torque for theta1 = pi t^2/2")
sb.save_plot(ax, "inverse_dynamics.png")
pin = ["force on the slider, X [N]", "force on the slider, Y [N]"]
sb.save_plot(sb.plot(need, "lambda1", "lambda2", labels=pin, title="Multipliers"), "inverse_dynamics_pin.png")

# Check

print("Tm at 0, 1, 2 s:", need["Tm"][[0, 100, 200]], "by hand:", by_hand[[0, 100, 200], 2])
assert np.allclose(by_hand[:, 2], need["Tm"], rtol=0, atol=1e-8 * np.abs(need["Tm"]).max())
assert np.allclose(
    by_hand[:, :2].T, [need["lambda1"], need["lambda2"]], rtol=0, atol=1e-8 * np.abs(by_hand).max()
)
# The work of the torque is the energy gained.
work = np.trapezoid(need["Tm"] * need["theta1_dot"], times)
print(f"work {need.work[-1]:.6f} J, energy gained {need.energy[-1] - need.energy[0]:.6f} J")
assert abs(need.work[-1] - (need.energy[-1] - need.energy[0])) < 1e-3 * abs(work) and abs(
    work - need.work[-1]
) < 0.01 * abs(work)
# The torque put back in gives the motion back.
back = sb.simulate(
    eqs,
    1.0,
    initial={"theta1": 0, "theta1_dot": 0},
    guess={"theta2": 0, "s": 4},
    inputs={"Tm": sb.Table(times, need["Tm"], kind="cubic")},
)
assert back.success and abs(back["theta1"][-1] - np.pi / 2) < 1e-5
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 4.9.
