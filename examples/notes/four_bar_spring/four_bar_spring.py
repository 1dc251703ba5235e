"""Exercise: a four-bar with a spring.

Description
    Crank a, coupler b, rocker c on a frame of length d, each bar with its mass in the middle, under
    gravity; a spring of stiffness K and free length l0 joins the end of the rocker to a post above.
Concepts
    Closed loop in the recursive approach; equilibrium, stable or not; small vibration about it by linear
    equations beside the full motion; the transmission of speeds along a turn.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from scipy.optimize import minimize_scalar
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    comp_X,
    comp_Y,
    dot_prod,
    equation_set,
    ground,
    join_points,
    make_BODY,
    make_CONSTRAINT,
    make_FORCE,
    make_POINT,
    make_VECTOR,
    project,
    rotate,
    set_gravity,
    translate,
)

# Modeling

data = {"a": 0.2, "b": 0.6, "c": 0.5, "d": 0.7, "ma": 1, "mb": 3, "mc": 2.5, "K": 400, "l0": 0.3, "g": 9.81}
a, b, c, d, ma, mb, mc, K, l0, g = sp.symbols(list(data))
alpha, beta, gamma = q = list(dynamicsymbols("alpha beta gamma"))
RF1 = rotate("Z", alpha)
RF2 = RF1 * translate(a, 0, 0) * rotate("Z", beta - alpha)  # beta is the coupler's angle against ground
RF3 = translate(d, 0, 0) * rotate("Z", gamma)
tip = make_POINT(RF3, c, 0, 0)
gap = project(join_points(make_POINT(RF2, b, 0, 0), tip), ground)
Phi = [comp_X(gap), comp_Y(gap)]
set_gravity(make_VECTOR(ground, 0, -g, 0))
bars = [
    make_BODY(make_POINT(RF, r / 2, 0, 0), m, 0, 0, m * r**2 / 12)
    for RF, r, m in ((RF1, a, ma), (RF2, b, mb), (RF3, c, mc))
]
post = make_POINT(ground, d, 1, 0)
pull = project(join_points(tip, post), ground)
length = sp.sqrt(dot_prod(pull, pull))
spring = make_FORCE(pull * (K * (length - l0) / length), tip, bars[2])
eqs = equation_set([*bars, spring, make_CONSTRAINT(Phi, dynamicsymbols("lambda1:3"))], q, parameters=data)

# Simulation

near = {"alpha": -1.0, "beta": 0.8, "gamma": 2.0}
rest = sb.find_equilibrium(eqs, guess=near)
lin = sb.linearize(eqs, rest, independent=["alpha"])
print("at rest:", rest.q, rest.verdict, "others:", len(rest.branches))
print("small vibration:", lin.eigenvalues)
small, large = (
    sb.simulate(eqs, 3.0, {"alpha": rest["alpha"] + by}, guess=dict(rest.q)) for by in (0.02, 0.6)
)
omega = abs(lin.eigenvalues[0].imag)
times = np.linspace(0, 3, 400)
figure = Figure(layout="constrained", figsize=(6.4, 6.4))
for axes, run, by in zip(figure.subplots(2, sharex=True), (small, large), (0.02, 0.6), strict=True):
    axes.plot(run.at(times).t, run.at(times)["alpha"] - rest["alpha"], label="full equations")
    axes.plot(times, by * np.cos(omega * times), "--", label="linear")
    axes.set(ylabel="deviation of alpha [rad]")
    axes.set_ylim(-1.2 * by, 2 * by)
    axes.legend(loc="upper right")
    below = axes
below.set(xlabel="time [s]")
figure.suptitle("Vibration of a four-bar about its equilibrium")
sb.save_plot(below, "four_bar_spring.png")
traced = sb.trace_positions(eqs, {"alpha": np.linspace(0, 2 * np.pi, 181)}, guess={"beta": 0.8, "gamma": 2.0})
figure = Figure(layout="constrained")
ax = figure.subplots()
ax.plot(traced["alpha"], traced["beta"], label="coupler")
ax.plot(traced["alpha"], traced["gamma"], label="rocker")
ax.set(xlabel="alpha of the crank [rad]", ylabel="angle [rad]", title="The crank turns, the rocker rocks")
ax.legend()
sb.save_plot(ax, "four_bar_spring_angles.png")

# Check


def energy(angle: float) -> float:
    """Potential energy, from the circles about the ends of crank and frame that meet in the rocker's end."""
    A = 0.2 * np.exp(1j * angle)
    along = 0.7 - A
    x = (0.6**2 - 0.5**2 + abs(along) ** 2) / (2 * abs(along))
    C = A + along / abs(along) * (x + 1j * np.sqrt(0.6**2 - x**2))
    weights = 9.81 * (1 * A.imag / 2 + 3 * (A.imag + C.imag) / 2 + 2.5 * C.imag / 2)
    return weights + 200 * (abs(0.7 + 1j - C) - 0.3) ** 2


lowest = minimize_scalar(energy, bracket=(rest["alpha"] - 0.3, rest["alpha"] + 0.3), tol=1e-12).x
print(f"alpha at rest {rest['alpha']:.9f}, where the energy is least {lowest:.7f}")
assert abs(np.sin(lowest - rest["alpha"])) < 1e-6 and rest.verdict == "marginal"
# Frequency from curvature of the energy over inertia of the crank's turn.
curvature = (energy(lowest + 1e-3) - 2 * energy(lowest) + energy(lowest - 1e-3)) / 1e-6
tau = sb.velocity_ratios(eqs, "alpha").at(rest)
q0 = [rest[name] for name in eqs.coordinate_names]
M = sb.compile(eqs, "mass_matrix")(0.0, q0, np.zeros(3))
rates = np.array([1.0, *tau[:, 0]])
print(f"frequency {omega:.6f} rad/s, by energies {np.sqrt(curvature / (rates @ M @ rates)):.6f} rad/s")
assert abs(omega - np.sqrt(curvature / (rates @ M @ rates))) < 1e-4 * omega
assert small.success and np.abs(small["alpha"] - rest["alpha"] - 0.02 * np.cos(omega * small.t)).max() < 2e-3
assert large.success and large.energy_drift < 1e-6 and traced.success
set_gravity(None)

# References
#
# R. L. Norton, Design of Machinery, chapters 4 and 10: four-bar linkages, positions and balance by energy.
