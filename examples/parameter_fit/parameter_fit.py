"""Parameters of a four-bar linkage from a measured motion.

Description
    A crank-rocker whose rocker is held by a torsion spring with stiffness k and damping d is released from
    rest; gravity G points along -Y. The angle phi of the rocker is measured 200 times a second, with noise.
    Stiffness, damping and the coupler's mass m2 are to be found.
Concepts
    A fit by least squares around `simulate`: values of parameters are arguments of compiled code, so every
    trial costs what its motion costs. The spread of the estimates from the slopes at the end.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares

import symbody as sb

# Modeling

model = sb.load_model(Path(__file__).with_suffix(".toml"))
eqs = sb.form_equations(model)
names = ("k", "d", "m2")
truth = np.array([7.3, 0.062, 1.85])
start = np.array([5.0, 0.1, 1.2])  # the model's own values
times = np.linspace(0.0, 2.0, 401)


def rocker(values):
    """Return the angle of the rocker [rad] at the times."""
    return sb.simulate(eqs, 2.0, parameters=dict(zip(names, values, strict=True)), times=times)["phi"]


# Simulation

noise = np.radians(0.2)
measured = rocker(truth) + noise * np.random.default_rng(7).standard_normal(times.size)
fit = least_squares(lambda values: rocker(values) - measured, start, x_scale=start, diff_step=1e-5)
covariance = np.linalg.inv(fit.jac.T @ fit.jac) * noise**2
spread = np.sqrt(np.diag(covariance))
for name, value, width, exact in zip(names, fit.x, spread, truth, strict=True):
    print(f"{name:>2} = {value:.4f} +- {width:.4f}, in truth {exact}")
print(f"{fit.nfev} steps of the fit, {noise:.2g} rad of noise, {np.std(fit.fun):.2g} rad left")

run = sb.simulate(eqs, 2.0, parameters=dict(zip(names, fit.x, strict=True)), times=times)
fitted = run["phi"]
figure, axes = plt.subplots(layout="constrained")
axes.plot(times, np.degrees(measured), ".", ms=4, color="C1", label="measured")
axes.plot(times, np.degrees(rocker(start)), "--", color="C2", label="first guess")
axes.plot(times, np.degrees(fitted), lw=1, color="C0", label="fitted")
axes.set(xlabel="t [s]", ylabel="phi [deg]", title="Angle of the rocker")
axes.legend()
figure.savefig("parameter_fit_angle.png", dpi=150)
figure, axes = plt.subplots(layout="constrained")
axes.plot(times, np.degrees(fit.fun), ".", ms=3, color="C0")
axes.set(xlabel="t [s]", ylabel="fitted less measured [deg]", title="What is left is noise")
figure.savefig("parameter_fit_residual.png", dpi=150)

# Check

assert fit.success and np.all(np.abs(fit.x - truth) < 4 * spread)
assert abs(np.std(fit.fun) / noise - 1) < 0.15  # nothing but noise is left
assert np.all(spread < 0.05 * truth)

# References
#
# J. Nocedal, S. J. Wright, Numerical Optimization, 2nd edition, chapter 10.
# G. A. F. Seber, C. J. Wild, Nonlinear Regression, section 2.1.
