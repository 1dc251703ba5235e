"""Basics: frames, points and vectors.

Description
    Two bodies in the plane, placed in ground by three coordinates each (global approach), one from the
    other (recursive approach), and by a point and a direction (natural approach). Points on them, and the
    vectors between.
Concepts
    Frames are 4 x 4 matrices that compose with ``*``; a point has 1 as its fourth number, a vector 0; the
    same point by matrices and by make_POINT and project; scalar and vector products. Section 1 of the
    notes.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    Describe,
    comp_X,
    comp_Y,
    comp_Z,
    cross_prod,
    dot_prod,
    ground,
    join_points,
    make_POINT,
    origin,
    project,
    rotate,
    show,
    translate,
    uvec_X,
)

# Modeling

x10, y10, theta1, x20, y20, theta2, s = dynamicsymbols("x10 y10 theta1 x20 y20 theta2 s")
RF1 = translate(x10, y10, 0) * rotate("Z", theta1)
RF2 = translate(x20, y20, 0) * rotate("Z", theta2)
print("global approach, RF1 =", RF1.matrix)

turned = RF1 * rotate("Z", theta2)  # recursive: a revolute joint, then a prismatic one
slid = turned * translate(s, 0, 0)
slid_origin = project(origin(slid), ground).coords
print("recursive approach, origin of the third body:", list(slid_origin))

u1_x, u1_y, x1, y1 = dynamicsymbols("u1_x u1_y x1 y1")
RFnatural1 = sp.Matrix([[u1_x, -u1_y, 0, x1], [u1_y, u1_x, 0, y1], [0, 0, 1, 0], [0, 0, 0, 1]])
Phi1_natural = [u1_x**2 + u1_y**2 - 1]
print("natural approach:", list(project(make_POINT(RFnatural1, 1, 2, 0), ground).coords))

# Simulation

P10 = RF1 * sp.Matrix([1, 2, 0, 1])  # a column by hand
P11 = make_POINT(RF1, 1, 2, 0)  # the same point
show(project(P11, ground))
show(project(uvec_X(RF1), ground))

half = sp.Rational(1, 2)
vec1 = join_points(make_POINT(RF1, 1, 1, 0), make_POINT(RF2, half, half, 0))
vec2 = join_points(origin(RF1), make_POINT(RF2, 3, 2, 0))
print("vec1 along X of RF1:", comp_X(vec1))
Describe(cross_prod)

numbers = {x10: 1.2, y10: -0.5, theta1: 0.3, x20: 2.1, y20: 0.8, theta2: 0.7, s: 0.45}
figure = Figure(layout="constrained")
ax = figure.subplots()
for name, frame in (("RF1", RF1), ("RF2", RF2), ("RF1 turned and slid", slid)):
    matrix = np.array(frame.matrix.subs(numbers), dtype=float)
    for k, color in enumerate(("C3", "C2")):
        ax.annotate(
            "",
            matrix[:2, 3] + 0.4 * matrix[:2, k],
            matrix[:2, 3],
            arrowprops={"arrowstyle": "->", "color": color},
        )
    ax.annotate(name, matrix[:2, 3], (4, -12), textcoords="offset points")
for name, start, vector in (("vec1", make_POINT(RF1, 1, 1, 0), vec1), ("vec2", origin(RF1), vec2)):
    tail = np.array(project(start, ground).coords.subs(numbers), dtype=float)[:2, 0]
    arrow = np.array(project(vector, ground).comps.subs(numbers), dtype=float)[:2, 0]
    ax.plot(*np.transpose([tail, tail + arrow]), marker=".", label=name)
ax.set(xlabel="x [m]", ylabel="y [m]", title="Frames (X red, Y green) and the vectors between points on them")
ax.set_aspect("equal", adjustable="datalim")
ax.legend()
sb.save_plot(ax, "basics.png")

# Check


def value(expression: sp.Expr) -> float:
    """Put the numbers in."""
    return float(expression.subs(numbers))


# The formulas printed in the notes, at the numbers above.
assert P10 == project(P11, ground).coords
assert np.allclose([value(e) for e in P10[:2]], [1.564296, 1.706193], atol=5.1e-7)
assert np.allclose([value(e) for e in slid_origin[:2]], [1.443136, -0.121338], atol=5.1e-7)
products = [value(e) for e in (comp_X(vec1), comp_Y(vec1), comp_X(vec2), comp_Y(vec2), dot_prod(vec1, vec2))]
print("vec1, vec2, their scalar product:", products)
assert np.allclose(products, [0.50980043, 0.63120892, 3.22832541, 3.98634626, 4.16201901], atol=5.1e-9)
assert abs(value(comp_Z(cross_prod(vec1, vec2)))) < 0.01 and cross_prod(vec1, vec1 * 2) == vec1 * 0
assert origin(RF1).coords[3] == 1 and uvec_X(RF1).comps[3] == 0 and (RF1 * uvec_X(ground)) == uvec_X(RF1)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 1.
