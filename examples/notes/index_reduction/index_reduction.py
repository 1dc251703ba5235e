"""Index reduction and initial conditions.

Description
    A crank on a pivot, a slider on the vertical through it, and a rod without mass between them: six
    coordinates, five constraints, five reactions.
Concepts
    Newton's equations of first order with constraints have index 3; three steps of LUMethod bring out
    fifteen hidden constraints; the same from the structure of the equations; initial accelerations and
    reactions from one linear system; drift of what is integrated as it is. Section 4.4 of the notes.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    GenerateMatrix,
    LUMethod,
    comp_X,
    comp_Y,
    comp_Z,
    diff,
    dot_prod,
    equation_set,
    euler_equations,
    first_order,
    ground,
    join_points,
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
Rx, Ry, N, T, Rd = reactions = list(dynamicsymbols("Rx Ry N T Rd"))
forces = [
    *(
        make_FORCE(ground, 0, -m * g, 0, origin(RF), body)
        for m, RF, body in ((m1, RF1, body1), (m2, RF2, body2))
    ),
    make_FORCE(ground, Rx, Ry, 0, P1, body1),
    *(make_FORCE(ground, N, 0, 0, P3, body2), make_TORQUE(ground, 0, 0, T, body2)),
    *(make_FORCE(along * (Rd / L2), P2, body1), make_FORCE(-along * (Rd / L2), P3, body2)),
]
eq = []
for body in (body1, body2):
    neq, eeq = newton_equations([body, *forces]), euler_equations([body, *forces], body)
    eq += [comp_X(neq), comp_Y(neq), comp_Z(eeq)]

newvars, eq_first = first_order(eq, q)
complete_equations = eq_first + Phi
newq = newvars + reactions
print(len(complete_equations), "equations in", len(newq), "unknowns")
dae1, alg1 = LUMethod(complete_equations, diff(newq, t))
dae2, alg2 = LUMethod(dae1, diff(newq, t))
ode, alg3 = LUMethod(dae2, diff(newq, t))
alg_constr = [*alg1, *alg2, *alg3]
print(len(alg_constr), "hidden constraints; alg2:", *alg2, sep="\n")

# Simulation

set_gravity(make_VECTOR(ground, 0, -g, 0))
multipliers = list(dynamicsymbols("lambda1:6"))
eqs = equation_set([body1, body2, make_CONSTRAINT(Phi, multipliers)], q, parameters=data)
reduced = sb.reduce_index(eqs)
ics = {"theta1": 0.2, "theta1_dot": 0.1}
state = sb.assemble(eqs, fixed=ics, guess={"y20": 4, "x10": 0.5, "y10": 0.1})  # all fifteen at once
print("initial conditions:", state.q, state.u)

AA, BB = GenerateMatrix(eq + diff(Phi, t, t), diff(q, t, t) + reactions)
now = {sp.Symbol(name): value for name, value in data.items()}
now |= {x: state[x.name] for x in q} | {x.diff(t): state[f"{x.name}_dot"] for x in q}
first = np.linalg.solve(*(np.array(matrix.subs(now), dtype=float) for matrix in (AA, BB)))[:, 0]
print("initial accelerations and reactions:", first)

# The accelerations as an ordinary differential equation: nothing holds the constraints, so they drift.
f = sb.compile(eqs, "xdot")
phi = sb.compile(eqs, "constraints")
x0 = [state[name] for name in eqs.state_names]
times = np.linspace(0, 10, 501)
free = solve_ivp(f.of_state, (0, 10), x0, t_eval=times, rtol=1e-6, atol=1e-6).y.T
drift = [np.abs(phi.of_state(time, x)).max() for time, x in zip(times, free, strict=True)]
kept = sb.simulate(eqs, 10.0, initial=ics, guess=dict(state.q), times=times, rtol=1e-6, atol=1e-6)
figure = Figure(layout="constrained")
ax = figure.subplots()
ax.semilogy(times[1:], drift[1:], label="as an ODE")
ax.semilogy(times[1:], np.maximum(kept.constraint_violation[1:], 1e-17), label="projected")
ax.set(xlabel="time [s]", ylabel="largest constraint [m, m^2, 1]", title="Drift from the constraints")
ax.legend()
sb.save_plot(ax, "index_reduction.png")

# Check

assert len(complete_equations) == len(newq) == 17 and [len(alg1), len(alg2), len(alg3)] == [5, 5, 5]
assert [len(level) for level in reduced.algebraic] == [5, 5, 5]
assert np.allclose(first[:6], [*state.udot.values()], atol=1e-10)
# They fulfil every hidden constraint.
rates = {v: state[v.name] for v in newvars} | dict(zip(reactions, first[6:], strict=True))
for constraint in alg_constr:
    assert abs(float(constraint.subs(now).subs(rates))) < 1e-9
print(f"open after 10 s: {drift[-1]:.1e} as an ODE, {kept.constraint_violation[-1]:.1e} projected")
assert drift[-1] > 1e-6 and kept.success and kept.constraint_violation.max() < 1e-6
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 4.4.
# E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, chapter VII: index and drift.
