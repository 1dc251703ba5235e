"""Virtual work: the force that holds a mechanism.

Description
    A slider-crank in the recursive approach: a crank of length L, a rod of length L2, a slider on the
    horizontal. The force fe on the slider holds the weights of crank, rod and slider.
Concepts
    Velocity ratios as virtual displacements; forces times velocities of their points; reactions do no
    work and stay out; the principle fails where dry friction acts. Section 4.6 of the notes.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    GenerateMatrix,
    comp_X,
    comp_Y,
    diff,
    dot_prod,
    equation_set,
    ground,
    join_points,
    make_BODY,
    make_CONSTRAINT,
    make_FORCE,
    make_POINT,
    make_VECTOR,
    origin,
    project,
    rotate,
    set_gravity,
    translate,
    velocity,
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
fe = dynamicsymbols("fe")

# Simulation

qI, qD = [theta1], [theta2, s]
JPhi_D, _ = GenerateMatrix(diff(Phi, t), diff(qD, t))
JPhi_I, _ = GenerateMatrix(diff(Phi, t), diff(qI, t))
tau = sp.simplify(-JPhi_D.inv() * JPhi_I)
vel_ratios = {x.diff(t): tau[k] * theta1.diff(t) for k, x in enumerate(qD)}

w1, w2, w3 = (make_VECTOR(ground, 0, -m * g, 0) for m in (m1, m2, m3))
Fe = make_VECTOR(ground, -fe, 0, 0)
VW = sum(dot_prod(velocity(P), w) for P, w in ((G1, w1), (G2, w2), (G3, w3), (G3, Fe)))
(sol_fe,) = sp.solve(VW.subs(vel_ratios), fe)
sol_fe = sp.simplify(sol_fe)
print("fe =", sol_fe)

sol_kine = {
    theta2: -sp.asin(L / L2 * sp.sin(theta1)) - theta1,
    s: L * sp.cos(theta1) + sp.sqrt(L2**2 - L**2 * sp.sin(theta1) ** 2),
}
X = sp.Symbol("X")
final_sol_fe = (
    sol_fe.subs(sol_kine).subs({sp.Symbol(name): value for name, value in data.items()}).subs(theta1, X)
)
angles = np.linspace(0.02, np.pi / 2, 100)
force = sp.lambdify(X, final_sol_fe)(angles)

figure = Figure(layout="constrained")
ax = figure.subplots()
ax.plot(angles, force)
ax.set(
    xlabel="theta1 [rad]", ylabel="fe [N]", title="Force on the slider that holds the weights", ylim=(0, 150)
)
sb.save_plot(ax, "virtual_work.png")

# Check

set_gravity(make_VECTOR(ground, 0, -g, 0))
objects = [*bodies, make_FORCE(Fe, G3, body3), make_CONSTRAINT(Phi, dynamicsymbols("lambda1:3"))]
eqs = equation_set(objects, q, parameters=data)
holding = sb.velocity_ratios(eqs, "theta1").holding("fe")
numbers = {sp.Symbol(name): value for name, value in data.items()}
for angle in (0.3, 0.8, 1.4):
    value = float(final_sol_fe.subs(X, angle))
    again = float(holding.subs(sol_kine).subs(numbers).subs(theta1, angle))
    held = sb.find_equilibrium(
        eqs, guess={"theta2": -angle, "s": 3}, unknowns=["fe"], fixed={"theta1": angle}
    )
    # By hand: weights of crank and rod, taken up by the crank, against the slope of the rod.
    lean = np.arcsin(np.sin(angle) / 3)
    by_hand = 9.81 * np.cos(angle) * (2 / 2 + 3 / 2) / (np.sin(angle) + np.cos(angle) * np.tan(lean))
    print(f"fe at {angle} rad: {value:.9f} N, holding {again:.9f} N, equilibrium {held.inputs['fe']:.9f} N")
    assert (
        abs(value - by_hand) < 1e-9
        and abs(again - by_hand) < 1e-9
        and abs(held.inputs["fe"] - by_hand) < 1e-6
    )
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 4.6.
