"""Crank, rod and piston: three equations, two constraints, and what the joints carry."""

from math import asin, cos, sin
from pathlib import Path

import symbody as sb

model = sb.load_model(Path(__file__).with_name("slider_crank.toml"))
eqs = sb.form_equations(model)
print(*eqs.dynamic_equations(), sep="\n")
print(eqs.constraints, eqs.multipliers)

# At one crank angle: positions, speeds, then accelerations and the force in the crank pin.
L1, L2, theta, rate = 0.4, 1.0, 0.5, 5.0
beta = asin(-L1 * sin(theta) / L2)
beta_rate = -L1 * cos(theta) * rate / (L2 * cos(beta))
q = [theta, beta, L1 * cos(theta) + L2 * cos(beta)]
u = [rate, beta_rate, -L1 * sin(theta) * rate - L2 * sin(beta) * beta_rate]
f = sb.compile(eqs, ["udot", "reaction B"])
print(f(0.0, q, u, [10.0]))

# The same mechanism with free bodies: 18 speeds, every joint a constraint, the same motion.
absolute = sb.form_equations(model, tree="absolute")
print(len(absolute.speeds), "speeds,", len(absolute.multipliers), "multipliers")
