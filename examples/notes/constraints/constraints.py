"""Constraints: one expression that vanishes for each freedom that a joint takes.

Description
    A crank of length L on a pivot, a slider on a line inclined by beta1, and a rod of length L2 without
    mass between them; six coordinates in the global approach. Beside them a point on a line (cam), and a
    body in natural coordinates.
Concepts
    Constraints of the revolute, prismatic, rod and cam joint; counting freedoms; dependent coordinates in
    closed form, all assemblies and the choice of one; the same by numbers, each position from the one
    before. Section 2 of the notes.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    comp_X,
    comp_Y,
    dot_prod,
    ground,
    join_points,
    make_POINT,
    origin,
    project,
    rotate,
    translate,
    uvec_X,
    uvec_Y,
)

# Modeling

x10, y10, theta1, x20, y20, theta2 = dynamicsymbols("x10 y10 theta1 x20 y20 theta2")
L, L2, beta1 = sp.symbols("L L2 beta1")
RF1 = translate(x10, y10, 0) * rotate("Z", theta1)  # in the middle of the crank
RF2 = translate(x20, y20, 0) * rotate("Z", theta2)

pivot = project(join_points(origin(ground), make_POINT(RF1, -L / 2, 0, 0)), ground)
revolute = [comp_X(pivot), comp_Y(pivot)]
RFa, RF2aux = rotate("Z", beta1), RF2 * rotate("Z", beta1)  # X along the line, on both bodies
prismatic = [
    dot_prod(uvec_Y(RFa), uvec_X(RF2aux)),
    dot_prod(uvec_Y(RFa), join_points(origin(RFa), origin(RF2aux))),
]
along = project(join_points(make_POINT(RF1, L / 2, 0, 0), origin(RF2)), ground)
rod = [dot_prod(along, along) - L2**2]
Phi = revolute + prismatic + rod
print(*Phi, sep="\n")

cam = dot_prod(uvec_Y(RFa), project(join_points(origin(RFa), make_POINT(RF1, L / 2, 0, 0)), ground))
print("the crank's tip on the line:", cam)

# Simulation

qI, qD = [theta1], [x10, y10, x20, y20, theta2]
print(len(Phi), "constraints,", len(qI) + len(qD) - len(Phi), "freedom")
sol_kine_all = sb.solve_positions(Phi, qD)
print(len(sol_kine_all), "assemblies")
data = {L: 1, L2: 4, beta1: sp.pi / 2}
for assembly in sol_kine_all.evaluate({**data, theta1: 0.2}):
    print(assembly)
sol_kine = sol_kine_all.nearest({y20: 4, theta2: 0}, {**data, theta1: 0.2})

# By numbers: the slider led along its line, each position the guess for the next.
table, guess = [], {theta1: 0.2, x10: 0.5, y10: 0.1, x20: 0, theta2: 0}
for k in range(10):
    rows = [phi.subs(data).subs(y20, sp.Float(4.1) + 0.03 * k) for phi in Phi]
    found = sp.nsolve(rows, list(guess), list(guess.values()))
    guess = dict(zip(guess, found, strict=True))
    table.append([float(4.1 + 0.03 * k), *map(float, found)])
table = np.array(table)

figure = Figure(layout="constrained")
ax = figure.subplots()
angles = np.linspace(-np.pi, np.pi, 73)
branches = [sol_kine_all.evaluate({**data, theta1: angle}) for angle in angles]
for k, name in ((0, "slider above"), (1, "slider below")):
    ax.plot(angles, [branch[k]["y20"] for branch in branches], label=name)
ax.plot(table[:, 1], table[:, 0], "k.", label="by numbers")
ax.set(xlabel="theta1 [rad]", ylabel="y20 [m]", title="Both assemblies of the slider")
ax.legend()
sb.save_plot(ax, "constraints.png")

# Check

assert len(Phi) == 5 and len(sol_kine_all) == 4  # two places of the slider, each upright and upside down
place = sol_kine[y20].subs(data).subs(theta1, sp.Rational(1, 5))
by_hand = np.sin(0.2) + np.sqrt(16 - np.cos(0.2) ** 2)
print(f"slider at {float(place):.9f} m, by hand {by_hand:.9f} m")
assert abs(place - by_hand) < 1e-12
heights = np.sin(table[:, 1]) + np.sqrt(16 - np.cos(table[:, 1]) ** 2)
assert np.abs(heights - table[:, 0]).max() < 1e-12
# A revolute joint of two moving bodies, as the notes print it.
RF3 = translate(x20, y20, 0) * rotate("Z", theta2)
vec1 = project(join_points(make_POINT(RF1, -1, 0, 0), make_POINT(RF3, 1, 0, 0)), ground)
assert sp.simplify(comp_X(vec1) - (sp.cos(theta2) + x20 - x10 + sp.cos(theta1))) == 0
assert sp.simplify(comp_Y(vec1) - (sp.sin(theta2) + y20 - y10 + sp.sin(theta1))) == 0

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 2.
