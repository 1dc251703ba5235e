"""Dynamics: Newton-Euler and Lagrange.

Description
    A crank of length L on a pivot, a slider on the vertical through it, and a rod of length L2 without
    mass between them: six coordinates, five constraints. Gravity g points along -Y; the force fe lifts
    the slider.
Concepts
    Bodies, forces, torques; Newton's and Euler's equations with reactions as unknowns, their matrices M,
    V, Fe; Lagrange's equations with multipliers; reactions from multipliers by the power that they would
    do. Sections 4.1 to 4.3 of the notes.
"""

import numpy as np
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    GenerateMatrix,
    angular_velocity,
    comp_X,
    comp_Y,
    comp_Z,
    diff,
    dot_prod,
    equation_set,
    euler_equations,
    ground,
    join_points,
    lagrange_equations,
    make_BODY,
    make_CONSTRAINT,
    make_FORCE,
    make_POINT,
    make_TORQUE,
    make_VECTOR,
    newton_equations,
    origin,
    project,
    rotate,
    set_gravity,
    translate,
    uvec_X,
    uvec_Y,
    velocity,
)

# Modeling

t = dynamicsymbols._t
q = x10, y10, theta1, x20, y20, theta2 = list(dynamicsymbols("x10 y10 theta1 x20 y20 theta2"))
L, L2, m1, m2, Iz1, Iz2, g = sp.symbols("L L2 m1 m2 Iz1 Iz2 g")
data = {"L": 1, "L2": 4, "m1": 2, "m2": 1, "Iz1": 0.2, "Iz2": 0.1, "g": 9.81}
RF1 = translate(x10, y10, 0) * rotate("Z", theta1)
RF2 = translate(x20, y20, 0) * rotate("Z", theta2)
P1, P2, P3 = make_POINT(RF1, -L / 2, 0, 0), make_POINT(RF1, L / 2, 0, 0), origin(RF2)
body1, body2 = make_BODY(RF1, m1, 0, 0, Iz1, name="crank"), make_BODY(RF2, m2, 0, 0, Iz2, name="slider")
pivot = project(join_points(origin(ground), P1), ground)
along = project(join_points(P2, P3), ground)
Phi = [
    *(comp_X(pivot), comp_Y(pivot)),
    *(dot_prod(uvec_X(ground), uvec_Y(RF2)), comp_X(project(P3, ground))),
    dot_prod(along, along) - L2**2,
]
fe = dynamicsymbols("fe")
push = make_FORCE(ground, 0, fe, 0, P3, body2)

# Newton-Euler: all forces on each body; two components of the pivot, a force and a torque of the
# line, one of the rod.
Rx, Ry, N, T, Rd = reactions = list(dynamicsymbols("Rx Ry N T Rd"))
fg_mbs = [
    push,
    *(
        make_FORCE(ground, 0, -m * g, 0, origin(RF), body)
        for m, RF, body in ((m1, RF1, body1), (m2, RF2, body2))
    ),
    make_FORCE(ground, Rx, Ry, 0, P1, body1),
    *(make_FORCE(ground, N, 0, 0, P3, body2), make_TORQUE(ground, 0, 0, T, body2)),
    *(make_FORCE(along * (Rd / L2), P2, body1), make_FORCE(-along * (Rd / L2), P3, body2)),
]
eq = []
for body, RF in ((body1, RF1), (body2, RF2)):
    neq, eeq = newton_equations([body, *fg_mbs]), euler_equations([body, *fg_mbs], origin(RF))
    eq += [comp_X(neq), comp_Y(neq), comp_Z(eeq)]
print(*eq, sep="\n")
M, rest = GenerateMatrix(eq, diff(q, t, t))
V, Fe = GenerateMatrix(list(rest), reactions)
print("M =", M)

# Lagrange: gravity from its field, constraints with multipliers.
set_gravity(make_VECTOR(ground, 0, -g, 0))
lvars = list(dynamicsymbols("lambda1:6"))
mbd = [body1, body2, push, make_CONSTRAINT(Phi, lvars)]
lgr_eq = lagrange_equations(mbd, q + lvars, t)
print(len(lgr_eq), "equations:", *lgr_eq, sep="\n")

# Simulation

eqs = equation_set(mbd, q, parameters=data)
start = {"theta1": 0.2, "theta1_dot": 0.1}
guess = {"y20": 4, "x10": 0.5, "y10": 0.1}
run = sb.simulate(eqs, 3.0, initial=start, guess=guess, inputs={"fe": 10})
sb.save_plot(sb.plot(run, "theta1", labels=["theta1 [rad]"], title="The crank falls"), "dynamics.png")
force = "2*4*lambda5"  # of the multiplier of a squared length, twice the length makes the force
ax = sb.plot(
    run, "lambda1", "lambda2", force, labels=["pivot, X [N]", "pivot, Y [N]", "rod [N]"], title="Reactions"
)
sb.save_plot(ax, "dynamics_reactions.png")

# Check

state = sb.assemble(eqs, fixed=start, guess=guess, inputs={"fe": 10})
now = {sp.Symbol(name): value for name, value in data.items()} | {fe: 10}
now |= {x: state[x.name] for x in q} | {x.diff(t): state[f"{x.name}_dot"] for x in q}


def numbers(matrix: sp.Matrix) -> np.ndarray:
    """Put the numbers in."""
    return np.array(matrix.subs(now), dtype=float)


# Newton-Euler: [M -V; Phi_q 0] for accelerations and reactions; Lagrange: the same with multipliers.
unknowns = diff(q, t, t)
newton = np.linalg.solve(*map(numbers, GenerateMatrix(eq + diff(Phi, t, t), unknowns + reactions)))[:, 0]
lagrange = np.linalg.solve(*map(numbers, GenerateMatrix(lgr_eq[:6] + diff(Phi, t, t), unknowns + lvars)))[
    :, 0
]
print("theta1'' by Newton-Euler, Lagrange and symbody:", newton[2], lagrange[2], state.udot["theta1_ddot"])
assert np.allclose(newton[:6], lagrange[:6], atol=1e-10) and np.allclose(
    newton[:6], [*state.udot.values()], atol=1e-10
)
assert np.allclose(numbers(M) @ newton[:6], numbers(V) @ newton[6:] - numbers(Fe)[:, 0], atol=1e-9)

# Reactions from multipliers: what reactions would do, JPsi^T R, is what multipliers do, Phi_q^T lambda.
power = sum(
    dot_prod(velocity(point), force)
    for point, force in zip((P1, P3, P2, P3), (fg_mbs[3], fg_mbs[4], fg_mbs[6], fg_mbs[7]), strict=True)
) + dot_prod(angular_velocity(RF2), fg_mbs[5])
JPsi, _ = GenerateMatrix([power.diff(R) for R in reactions], diff(q, t))
Phi_q, _ = GenerateMatrix(diff(Phi, t), diff(q, t))
found = np.linalg.lstsq(numbers(JPsi).T, numbers(Phi_q).T @ lagrange[6:], rcond=None)[0]
print("reactions:", dict(zip(("Rx", "Ry", "N", "T", "Rd"), found.tolist(), strict=True)))
assert np.allclose(found, newton[6:], atol=1e-9)
assert (
    np.allclose(lagrange[[6, 7, 9]], newton[[6, 7, 8]], atol=1e-9)
    and abs(abs(newton[10]) - abs(8 * lagrange[10])) < 1e-9
)
assert run.success and run.constraint_violation.max() < 1e-9
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course,
# sections 4.1 to 4.3.
