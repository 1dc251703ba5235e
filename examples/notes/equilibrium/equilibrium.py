"""Equilibrium.

Description
    A slider-crank whose slider leans on a spring: a crank of length L, a rod of length L2, a slider on
    the horizontal, held by a spring of stiffness K that is undeformed at s0.
Concepts
    All rates and accelerations 0 in the equations of motion: with the positions put in, one equation in
    one unknown whose every root counts; or all equations for everything, where the assembly has to be
    looked at afterwards. Reactions at rest; stability. Section 4.7 of the notes.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from scipy.optimize import brentq
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    comp_X,
    comp_Y,
    equation_set,
    ground,
    join_points,
    lagrange_equations,
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
K, s0 = sp.symbols("K s0")
data |= {"K": 60, "s0": 2.6}
set_gravity(make_VECTOR(ground, 0, -g, 0))
lvars = list(dynamicsymbols("lambda1:3"))
spring = make_FORCE(ground, -K * (s - s0), 0, 0, G3, body3)
objects = [*bodies, spring, make_CONSTRAINT(Phi, lvars)]
dae = lagrange_equations(objects, q + lvars, t)

# Simulation

numbers = {sp.Symbol(name): value for name, value in data.items()}
eq_cond = {x.diff(t, 2): 0 for x in q} | {x.diff(t): 0 for x in q}
equilibrium_eq = [e.subs(eq_cond).subs(numbers) for e in dae]
print(*equilibrium_eq, sep="\n")

# First way: positions put in, multipliers solved for, and every root of what is left.
sol_kine = {
    theta2: -sp.asin(L / L2 * sp.sin(theta1)) - theta1,
    s: L * sp.cos(theta1) + sp.sqrt(L2**2 - L**2 * sp.sin(theta1) ** 2),
}
forces = sp.solve(equilibrium_eq[1:3], lvars)
X = sp.Symbol("X")
left = equilibrium_eq[0].subs(forces).subs(sol_kine).subs(numbers).subs(theta1, X)
balance = sp.lambdify(X, left)
angles = np.linspace(-np.pi + 1e-3, np.pi + 1e-3, 200)
moments = balance(angles)
roots = [
    brentq(balance, a, b, xtol=1e-13)
    for a, b, c, d in zip(angles[:-1], angles[1:], moments[:-1], moments[1:], strict=True)
    if c * d < 0
]
print("equilibria at theta1 =", roots)

# Second way: everything at once, from a guess, with other equilibria beside it.
eqs = equation_set(objects, q, parameters=data)
rests = [sb.find_equilibrium(eqs, guess={"theta1": angle, "theta2": -angle, "s": 3}) for angle in roots]
for rest in rests:
    print(f"theta1 = {rest['theta1']:.6f}, s = {rest['s']:.6f}: {rest.verdict}, {dict(rest.multipliers)}")

swing = sb.simulate(eqs, 6.0, initial={"theta1": roots[0] + 0.1}, guess={"theta2": -roots[0], "s": 3})
figure = Figure(layout="constrained")
ax = figure.subplots()
ax.plot(angles, -moments)
ax.plot(roots, np.zeros(len(roots)), "ko")
ax.axhline(0, color="gray", linewidth=0.8)
ax.set(
    xlabel="theta1 [rad]", ylabel="moment on the crank [N m]", title="Equilibria: weights and spring balance"
)
sb.save_plot(ax, "equilibrium.png")

# Check

for root, rest in zip(roots, rests, strict=True):
    assert abs(np.sin(rest["theta1"] - root)) < 1e-8 and abs(np.cos(rest["theta1"] - root) - 1) < 1e-8
    residual = [
        float(e.subs({x: rest[x.name] for x in q} | {x: rest.multipliers[x.name] for x in lvars}))
        for e in equilibrium_eq
    ]
    assert np.abs(residual).max() < 1e-7
# Stable where the moment of weights and spring drives back.
slopes = [(balance(root + 1e-6) - balance(root - 1e-6)) / 2e-6 for root in roots]
print("stiffness against turning:", slopes)
assert [rest.verdict for rest in rests] == ["marginal" if slope > 0 else "unstable" for slope in slopes]
assert swing.success and (np.abs(swing["theta1"] - roots[0]).max() < 0.2) == (slopes[0] > 0)
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 4.7.
