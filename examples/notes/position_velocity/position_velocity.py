"""Position, velocity and singular configurations.

Description
    A crank of length L turns by theta1, a rod of length L2 inclined by theta2 joins it to a slider at the
    height s above the pivot. First the crank drives, then the slider.
Concepts
    Initial positions in closed form and by Newton's method, from guesses and within ranges; velocities
    from the differentiated solution and from the matrix tau = -J_D^-1 J_I; lock-up and bifurcation by the
    determinant of J_D together with the constraints. Section 3 of the notes.
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
    equation_set,
    ground,
    join_points,
    make_BODY,
    make_CONSTRAINT,
    make_POINT,
    origin,
    project,
    rotate,
    translate,
)

# Modeling

t = dynamicsymbols._t
theta1, theta2, s = dynamicsymbols("theta1 theta2 s")
L, L2, m = sp.symbols("L L2 m")
RF1 = rotate("Z", theta1)
RF2 = translate(L * sp.cos(theta1), L * sp.sin(theta1), 0) * rotate("Z", theta2)
RF3 = translate(0, s, 0)
pin = project(join_points(origin(RF3), make_POINT(RF2, L2, 0, 0)), ground)
Phi = [comp_X(pin), comp_Y(pin)]
data = {L: 1, L2: 4}
objects = [
    make_BODY(RF1, m),
    make_BODY(RF2, m, 0, 0, m),
    make_BODY(RF3, m),
    make_CONSTRAINT(Phi, dynamicsymbols("lambda1:3")),
]
eqs = equation_set(objects, [theta1, theta2, s], parameters={"L": 1, "L2": 4, "m": 1})

# Simulation

qI, qD = [theta1], [theta2, s]
sol_kine = {
    theta2: sp.acos(-L * sp.cos(theta1) / L2),
    s: L * sp.sin(theta1) + sp.sqrt(L2**2 - L**2 * sp.cos(theta1) ** 2),
}
first = sb.assemble(eqs, fixed={"theta1": 0.2}, guess={"theta2": 1.8, "s": 4})
below = sb.assemble(eqs, fixed={"theta1": 0.2}, ranges={"s": (-6, 0)})
print("initial position:", first.q, "or, with the slider below,", below.q)

JPhi_D, _ = GenerateMatrix(diff(Phi, t), diff(qD, t))
JPhi_I, _ = GenerateMatrix(diff(Phi, t), diff(qI, t))
tau = sp.simplify(-JPhi_D.inv() * JPhi_I)
print("tau =", tau)
ratios = sb.velocity_ratios(eqs, "theta1")  # the same for any mechanism, and in numbers

turning = sb.simulate(eqs, 2 * np.pi, initial={"theta1": 0, "theta1_dot": 1}, guess={"theta2": 1.8, "s": 4})
print("J_D of a driving slider:", sb.velocity_ratios(eqs, "s").determinant)
locked = sb.singular_configurations(eqs, "s", over={"theta1": (-3, 3)}, guess={"theta2": 1.8, "s": 4})
print(*locked, sep="\n")
short = sb.singular_configurations(
    eqs, "theta1", over={"theta1": (-1, 1)}, guess={"theta2": 2.0, "s": 1}, parameters={"L2": 1}
)
print("with a rod as long as the crank:", *short, sep="\n")

figure = Figure(layout="constrained")
ax = figure.subplots()
angles = np.linspace(-np.pi, np.pi, 181)
traced = sb.trace_positions(eqs, {"theta1": angles}, guess={"theta2": 1.8, "s": 4})
numbers = np.array([ratios.at(dict(zip(eqs.coordinate_names, q, strict=True)))[:, 0] for q in traced.q.T])
ax.plot(angles, numbers, label=["theta2'/theta1'", "s'/theta1' [m]"])
for one in locked:
    ax.axvline(one.q["theta1"], color="gray", linestyle=":")
ax.set(
    xlabel="theta1 [rad]",
    ylabel="velocity ratio",
    title="Velocity ratios; dotted: the slider cannot drive the crank",
)
ax.legend()
sb.save_plot(ax, "position_velocity.png")

# Check


def close(a: sp.Expr, b: float) -> bool:
    """Compare a formula at 0.2 rad with a number."""
    return abs(sp.N(a.subs(sol_kine).subs(data).subs(theta1, 0.2)) - b) < 1e-10


assert close(theta2, first["theta2"]) and close(s, first["s"]) and below["s"] < 0
velocities = [sol_kine[x].diff(t).coeff(theta1.diff(t)) for x in qD]  # by differentiating the solution
for a, b, c, d in zip(
    tau, ratios.tau, velocities, ratios.at({"theta1": 0.2, "s": first["s"]})[:, 0], strict=True
):
    assert close(a, d) and close(b, d) and close(c, d)
assert turning.success
# All assemblies are followed; angles may be off by whole turns.
assert {one.kind for one in locked} == {"lock-up"}
assert {round(abs(one.q["theta1"]), 6) for one in locked} == {round(np.pi / 2, 6)}
assert {round(one.q["s"], 6) for one in locked} == {5, 3, -3, -5}
# theta1 = 0 puts the slider on the pivot: there the rod turns with the crank or stays, whichever.
assert {one.kind for one in short} == {"bifurcation"} and all(abs(one.q["theta1"]) < 1e-5 for one in short)
assert not sb.singular_configurations(eqs, "theta1", over={"theta1": (-1, 1)}, guess={"theta2": 1.8, "s": 4})

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 3.
# E. J. Haug, Computer-Aided Kinematics and Dynamics of Mechanical Systems, section 3.7: singular
# configurations.
