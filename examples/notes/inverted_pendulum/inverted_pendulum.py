"""Exercise: an inverted pendulum on a cart with friction.

Description
    A cart of mass M on a rail carries a rod of mass m, whose centre of mass is l above its pivot. Viscous
    and dry friction, smooth with v0, hold the cart; a force F drives it.
Concepts
    Friction from the rail's reaction; equilibrium up and down; linear equations in closed form and by
    symbody; a feedback that holds the rod upright, found from the linear equations, in the full ones.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from scipy.linalg import solve_continuous_are
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    equation_set,
    ground,
    lagrange_equations,
    make_BODY,
    make_FORCE,
    make_POINT,
    make_VECTOR,
    origin,
    rotate,
    set_gravity,
    translate,
)

# Modeling

data = {"M": 1.5, "m": 0.4, "l": 0.5, "J": 0.034, "g": 9.81, "c": 0.3, "mu": 0.02, "v0": 0.1}
M, m, l, J, g, c, mu, v0 = sp.symbols(list(data))
x, theta, F = dynamicsymbols("x theta F")
t = dynamicsymbols._t
set_gravity(make_VECTOR(ground, 0, -g, 0))
RF1 = translate(x, 0, 0)
RF2 = RF1 * rotate("Z", theta)
cart, rod = make_BODY(RF1, M, 0, 0, 1), make_BODY(make_POINT(RF2, 0, l, 0), m, 0, 0, J)
# On a rail that carries the weight of both, whatever the rod does.
dry = -mu * (M + m) * g * sp.sin(sp.atan(x.diff(t) / v0))
rail = make_FORCE(ground, F - c * x.diff(t) + dry, 0, 0, origin(RF1), cart)
objects = [cart, rod, rail]
print(*lagrange_equations(objects, [x, theta], t), sep="\n")
eqs = equation_set(objects, [x, theta], parameters=data)

# The same drawn, with friction that reads the rail's reaction.
parts = [
    sb.Body("Cart", "M", (0, 0, 1)),
    sb.Body("Rod", "m", (0, 0, "J"), frames={"pivot": sb.Frame((0, "-l", 0))}),
    sb.Prismatic(
        "rail",
        "ground",
        "Cart",
        axis="x",
        coordinate="x",
        force=sb.Drive(applied="F", damping="c"),
        friction=sb.Friction(mu="mu", v0="v0"),
    ),
    sb.Revolute("pivot", "Cart", "Rod.pivot", coordinate="theta"),
]
drawn = sb.form_equations(
    sb.Model("inverted pendulum", parts, gravity=(0, "-g", 0), parameters=data, inputs=["F"])
)

# Simulation

upright = sb.linearize(eqs, at={"theta": 0.0})
hanging = sb.linearize(eqs, at={"theta": np.pi})
print("upright:", upright.verdict, upright.eigenvalues)
print("hanging:", hanging.verdict, hanging.eigenvalues)
weights = np.diag([1.0, 10.0, 1.0, 10.0])
S = solve_continuous_are(upright.A, upright.B, weights, [[0.1]])
gains = (upright.B.T @ S / 0.1)[0]
law = " ".join(f"{-gain:+.12g}*{name}" for gain, name in zip(gains, upright.state_names, strict=True))
print("F =", law)
held = {
    name: sb.simulate(each, 6.0, {"theta": 0.3}, inputs={"F": law})
    for name, each in (("by hand", eqs), ("drawn", drawn))
}
closed = sb.linearize(eqs, at={"theta": 0.0}, inputs={"F": law})

times = np.linspace(0, 6, 601)
rates, vectors = np.linalg.eig(closed.A)
first = np.array([0.3 if name == "theta" else 0.0 for name in closed.state_names])
linear = (vectors @ (np.linalg.solve(vectors, first)[:, None] * np.exp(np.outer(rates, times)))).real
figure = Figure(layout="constrained", figsize=(6.4, 6.4))
for axes, name, unit in zip(figure.subplots(2, sharex=True), ("theta", "x"), ("rad", "m"), strict=True):
    axes.plot(times, held["by hand"].at(times)[name], label="full equations")
    axes.plot(times, linear[closed.state_names.index(name)], "--", label="linear equations")
    axes.set(ylabel=f"{name} [{unit}]")
    axes.legend()
    below = axes
below.set(xlabel="time [s]")
figure.suptitle("An inverted pendulum is held upright")
sb.save_plot(below, "inverted_pendulum.png")

# Check

# (M + m) x'' - m l theta'' = F - k x', -m l x'' + (J + m l^2) theta'' = m g l theta, k that of both
# frictions.
mass = np.array([[1.9, -0.2], [-0.2, 0.034 + 0.1]])
damping = np.diag([-0.3 - 0.02 * 1.9 * 9.81 / 0.1, 0.0])
for found, sign in ((upright, 1), (hanging, -1)):
    coupled = mass * [[1, sign], [sign, 1]]
    stiffness = np.diag([0.0, sign * 0.4 * 9.81 * 0.5])
    A = np.block(
        [
            [np.linalg.solve(coupled, damping), np.linalg.solve(coupled, stiffness)],
            [np.eye(2), np.zeros((2, 2))],
        ]
    )
    assert found.state_names == ("x_dot", "theta_dot", "x", "theta") and np.abs(found.A - A).max() < 1e-9
other = sb.linearize(drawn, at={"theta": 0.0})
assert np.abs(other.A - upright.A).max() < 1e-8 and np.abs(other.B - upright.B).max() < 1e-9
assert upright.verdict == "unstable" and hanging.verdict == "drifting" and closed.verdict == "stable"
for name, run in held.items():
    print(f"{name}: theta after 6 s {run['theta'][-1]:.1e} rad")
    assert run.success and abs(run["theta"][-1]) < 2e-2
set_gravity(None)

# References
#
# K. J. Aström, R. M. Murray, Feedback Systems, example 2.1 and section 6.3: cart and pendulum,
# linear feedback.
