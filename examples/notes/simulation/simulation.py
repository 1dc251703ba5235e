"""Simulation with Baumgarte's terms and in the form of index 1.

Description
    A crank on a pivot, a slider on the vertical through it, and a rod without mass between them: six
    coordinates, five constraints.
Concepts
    Baumgarte's stabilization Phi'' + 2 zeta omega Phi' + omega^2 Phi = 0 with omega = 20, zeta = 0.95;
    the form of index 1, solved for rates and reactions and integrated by any solver; pictures of states,
    of expressions in them, of reactions and of paths. Section 4.5 of the notes.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    comp_X,
    comp_Y,
    diff,
    dot_prod,
    equation_set,
    first_order,
    ground,
    join_points,
    lagrange_equations,
    make_BODY,
    make_CONSTRAINT,
    make_POINT,
    make_VECTOR,
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
set_gravity(make_VECTOR(ground, 0, -g, 0))
lvars = list(dynamicsymbols("lambda1:6"))
lgr_eq = lagrange_equations([body1, body2, make_CONSTRAINT(Phi, lvars)], q + lvars, t)

# By hand, as the notes write it: constraints of index 1 in place of Phi.
zeta, omega_n = sp.Rational(95, 100), 20
Phi_Baum = [
    a + 2 * zeta * omega_n * b + omega_n**2 * c
    for a, b, c in zip(diff(Phi, t, t), diff(Phi, t), Phi, strict=True)
]
newvars, dae_index1 = first_order(lgr_eq[:6] + Phi_Baum, q)

print("first constraint of index 1:", Phi_Baum[0])

# Simulation

Z_expl = sb.solve_index_1(dae_index1, diff(newvars, t), lvars, parameters=data)
eqs = equation_set([body1, body2, make_CONSTRAINT(Phi, lvars)], q, parameters=data)
ics = {"theta1": 0.2, "theta1_dot": 0.1}
guess = {"y20": 4, "x10": 0.5, "y10": 0.1}
state = sb.assemble(eqs, fixed=ics, guess=guess)
times = np.linspace(0, 4, 401)
x0 = [state[name] for name in Z_expl.state_names]
by_hand = solve_ivp(Z_expl, (0, 4), x0, method="DOP853", t_eval=times, rtol=1e-9, atol=1e-11)
reactions = dict(zip(Z_expl.reaction_names, Z_expl.reactions(by_hand.t, by_hand.y), strict=True))

runs = {
    "Baumgarte": sb.simulate(
        eqs, 4.0, ics, guess=guess, times=times, constraints=sb.Baumgarte(zeta=0.95, omega=20)
    ),
    "projection": sb.simulate(eqs, 4.0, ics, guess=guess, times=times),
    "minimal coordinates": sb.simulate(eqs, 4.0, ics, guess=guess, times=times, constraints=sb.Partition()),
}
run = runs["projection"]
sb.save_plot(
    sb.plot(run, "theta1", "theta1_dot", labels=["theta1 [rad]", "theta1_dot [rad/s]"], title="Crank"),
    "simulation.png",
)
tip = ("x10 + cos(theta1)/2", "y10 + sin(theta1)/2")
ax = sb.plot(run, tip, ("x20", "y20"), labels=["end of the crank", "slider"], title="Paths", equal=True)
ax.set(xlabel="x [m]", ylabel="y [m]")
sb.save_plot(ax, "simulation_paths.png")
figure = Figure(layout="constrained", figsize=(6.4, 6.4))
above, below = figure.subplots(2, sharex=True)
for name, each in runs.items():
    above.semilogy(times[1:], np.maximum(each.constraint_violation[1:], 1e-17), label=name)
above.set(
    ylabel="largest constraint [m, m^2, 1]", ylim=(1e-18, 1e-3),
    title="What keeps the constraints, and the reactions",
)  # fmt: skip
above.legend(loc="upper right", ncols=3)
for name in ("lambda1", "lambda2"):
    below.plot(by_hand.t, reactions[name], label=f"{name}, index 1 by hand")
    below.plot(times[::20], run[name][::20], "k.", label="of projection" if name == "lambda2" else None)
below.set(xlabel="time [s]", ylabel="force at the pivot [N]", ylim=(-70, 270))
below.legend()
sb.save_plot(above, "simulation_constraints.png")

# Check

angle = by_hand.y[Z_expl.state_names.index("theta1")]
apart = {name: np.abs(each["theta1"] - run["theta1"]).max() for name, each in runs.items()}
print(
    "crank's angle beside projection:",
    {name: f"{by:.0e}" for name, by in apart.items()},
    "by hand:",
    np.abs(angle - run["theta1"]).max(),
)
assert all(each.success for each in runs.values()) and max(apart.values()) < 1e-5
assert np.abs(angle - run["theta1"]).max() < 1e-5
assert np.abs(reactions["lambda1"] - run["lambda1"]).max() < 1e-3
print("open by at most", {name: f"{each.constraint_violation.max():.0e}" for name, each in runs.items()})
assert run.constraint_violation.max() < 1e-9 and runs["Baumgarte"].constraint_violation.max() < 1e-5
assert runs["Baumgarte"].constraint_violation.max() > 10 * run.constraint_violation.max()
assert run.energy_drift < 1e-6
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 4.5.
# J. Baumgarte, Comput. Methods Appl. Mech. Eng. 1 (1972) 1.
