"""Linearization.

Description
    A pendulum of mass m and length L, about the lower and about the upper equilibrium.
Concepts
    Equations of first order; equilibria; linear equations f(x0) + f'(x0) (x - x0) about any point; the
    form aa x' = bb x - cc; eigenvalues and what they tell, which is less than stability where they are
    imaginary; linear beside nonlinear motion. Section 4.10 of the notes.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from scipy.linalg import expm
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    first_order,
    ground,
    lagrange_equations,
    linearize,
    make_BODY,
    make_POINT,
    make_VECTOR,
    rotate,
    set_gravity,
    state_space,
)

# Modeling

t = dynamicsymbols._t
theta, theta_dot = dynamicsymbols("theta theta_dot")
L, m, g, theta0, dottheta0 = sp.symbols("L m g theta0 dottheta0")
G1 = make_POINT(rotate("Z", theta), 0, -L, 0)
set_gravity(make_VECTOR(ground, 0, -g, 0))
# The notes write make_BODY(G1, m, 0, iz): that is Iyy, which has no effect. With Izz it would be m
# L^2 + iz below.
pendulum = make_BODY(G1, m)
eqns = lagrange_equations({pendulum}, [theta], t)
print(eqns)

# Simulation

vars1, eqns1 = first_order(eqns, [theta], t)
print(*eqns1, sep="\n")
x = sp.Symbol("x")
still = eqns1[0].subs(theta_dot.diff(t), 0).subs(theta, x)
print("equilibria:", sp.solveset(still, x, sp.Interval.Ropen(0, 2 * sp.pi)))
eqns1_lin = linearize(eqns1, {theta: theta0, theta_dot: dottheta0})
print(*eqns1_lin, sep="\n")
aa, bb, cc = state_space(eqns1_lin, t, vars1)
A = sp.simplify(aa.inv() * bb)
print("A =", A)
data = {L: 1, m: sp.Rational(1, 10), g: sp.Rational(981, 100)}
poles = {at: [complex(e) for e in A.subs(theta0, at).subs(data).eigenvals()] for at in (0, sp.pi)}
print("eigenvalues:", poles)

times = np.linspace(0, 1, 101)
eqs = eqns.equation_set
numbers = {symbol.name: float(value) for symbol, value in data.items()}
real = sb.simulate(
    eqs, 1.0, {"theta": 0.1, "theta_dot": 0.1}, parameters=numbers, times=times, rtol=1e-10, atol=1e-12
)
linear = {}
for at in (0, sp.pi):
    lin = sb.linearize(eqs, at={"theta": float(at)}, parameters=numbers)
    print(f"about {at}: {lin.verdict}")
    place = np.array([float(at) if name == "theta" else 0.0 for name in lin.state_names])
    deviation = np.array([0.1, 0.1]) - place
    linear[at] = {
        name: [(place + expm(lin.A * time) @ deviation)[k] for time in times]
        for k, name in enumerate(lin.state_names)
    }

figure = Figure(layout="constrained", figsize=(6.4, 6.4))
above, below = figure.subplots(2, sharex=True)
above.plot(times, linear[0]["theta"], label="linear about 0")
above.plot(times[::5], real["theta"][::5], "k.", label="full equation")
below.plot(times, linear[sp.pi]["theta"], "C1", label="linear about pi")
below.plot(times[::5], real["theta"][::5], "k.", label="full equation")
above.set(ylabel="theta [rad]", title="From theta = 0.1: near one equilibrium, far from the other")
below.set(xlabel="time [s]", ylabel="theta [rad]")
for axes in (above, below):
    axes.legend()
sb.save_plot(above, "linearization.png")

# Check

assert sp.simplify(eqns[0] - (m * L**2 * theta.diff(t, 2) + m * sp.sin(theta) * L * g)) == 0
wanted = (
    m * L**2 * theta_dot.diff(t) + m * sp.sin(theta0) * L * g + m * sp.cos(theta0) * (theta - theta0) * L * g
)
assert sp.simplify(eqns1_lin[0] - wanted) == 0 and A == sp.Matrix([[0, 1], [-sp.cos(theta0) * g / L, 0]])
assert np.allclose(sorted(e.imag for e in poles[0]), [-3.132091953, 3.132091953], atol=5.1e-10)
assert np.allclose(sorted(e.real for e in poles[sp.pi]), [-3.132091953, 3.132091953], atol=5.1e-10)
ends = [[motion["theta"][-1], motion["theta_dot"][-1]] for motion in (real, linear[0], linear[sp.pi])]
print("theta and theta_dot after 1 s:", ends)
assert np.allclose(ends[:2], [[-0.09962075, -0.10364098], [-0.09969216, -0.10297115]], atol=5.1e-9)
assert np.allclose(ends[2], [-31.41904, -107.82711], atol=1.1e-5)
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course, section 4.10.
