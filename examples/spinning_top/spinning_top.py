"""A spinning top released horizontally: it nods between 90 and 110.2 degrees, with cusps."""

from pathlib import Path

import numpy as np

import symbody as sb

eqs = sb.form_equations(sb.load_model(Path(__file__).with_name("spin_top.toml")))
print(eqs.mass_matrix)

run = sb.simulate(eqs, 10.0)
nutation = np.degrees(run["eta"])
print(f"nutation {nutation.min():.4f} to {nutation.max():.4f} degrees, precession {run['zeta'][-1]:.6f} rad")
print("centre of mass at the end:", run["frame r Top.CoM ground ground"][:, -1])
