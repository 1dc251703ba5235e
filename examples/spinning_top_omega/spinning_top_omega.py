"""The same top in its angular velocity: a constant mass matrix, and rates that fail where sin(eta) = 0."""

from pathlib import Path

import symbody as sb

eqs = sb.form_equations(sb.load_model(Path(__file__).with_name("spin_top_omega.toml")))
print(eqs.mass_matrix)
for rate in eqs.kinematic_equations:
    print(rate)
print(*eqs.notes, sep="\n")

run = sb.simulate(eqs, 10.0)
print("centre of mass at the end:", run["frame r Top.CoM ground ground"][:, -1])
