"""Stewart platform.

Description
    A platform on six legs. Each leg has a universal joint at the base, a prismatic drive with a spring in the
    middle and a ball joint at the platform. It is let go from a tilted position and bounces on its springs;
    nothing damps it.
Concepts
    Five loops in space; quaternions in ball joints; assembly from rough guesses; inverse kinematics; energy
    without losses.
"""

from pathlib import Path

import numpy as np

import symbody as sb

# Modeling

eqs = sb.form_equations(sb.load_model(Path(__file__).with_suffix(".toml")))
print(eqs.degrees_of_freedom, "degrees of freedom,", len(eqs.multipliers), "constraints")
lengths = {"L1": 1.0, "L2": 1.1, "L3": 1.05, "L4": 1.1, "L5": 1.0, "L6": 1.05}
pose = sb.assemble(eqs, lengths)
print("the platform stands at", pose["frame r Platform"])

# Simulation

run = sb.simulate(eqs, 1.0, lengths, times=np.linspace(0, 1, 201))
sb.save_plot(sb.plot(run, *lengths, title="Lengths of the legs"), "stewart_platform.png")
ax = sb.plot(run, ("frame r Platform",), labels=["platform"], title="Path of the platform")
sb.save_plot(ax, "stewart_platform_path.png")

# Check

print(f"loops open by {run.constraint_violation.max():.1e}, energy drift {run.energy_drift:.1e} J")
assert run.success and run.constraint_violation.max() < 1e-9 and run.energy_drift < 1e-4
# A leg is as long as the distance of its ends.
frames = eqs.model.ground
for k in range(1, 7):
    foot = np.array([float(x.text) for x in frames[f"a{k}"].at])
    distance = np.linalg.norm(run[f"frame r Platform.b{k}"] - foot[:, np.newaxis], axis=0)
    assert np.abs(distance - run[f"L{k}"]).max() < 1e-9

# References
#
# D. Stewart, A platform with six degrees of freedom, Proc. Inst. Mech. Eng. 180 (1965), 371-386.
# J.-P. Merlet, Parallel Robots, 2nd ed., chapter 3: inverse kinematics.
