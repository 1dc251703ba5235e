"""Four legs.

Description
    A trunk trots on four legs in the plane X Z. One file describes a leg with its motors; the model includes
    it four times, with another phase of the rhythm for each diagonal.
Concepts
    Parts: prefixes, shared and overridden parameters, signals; outputs of the mechanism as signals in forces,
    here the height and speed of each foot over a ground that presses and rubs.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import symbody as sb

# Modeling

model = sb.load_model(Path(__file__).with_suffix(".toml"))
eqs = sb.form_equations(model)
legs = [include.prefix for include in model.includes]
print(f"{len(model.bodies)} bodies, legs {', '.join(legs)}: {len(eqs.coordinate_names)} coordinates")
print("phases:", {leg: model.parameters[f"{leg}_phase"].text for leg in legs})

# Simulation

times = np.linspace(0.0, 4.0, 801)
run = sb.simulate(eqs, 4.0, times=times, rtol=1e-6)
print(f"{run.status.name}: {run['x'][-1]:.3f} m in {times[-1]:g} s, {run.statistics.evaluations} evaluations")
labels = ["x [m]", "z [m]", "pitch [rad]", *(f"foot {leg} [N]" for leg in legs)]
pressures = [f"{leg}_N" for leg in legs]
ax = sb.plot(run, "x", "z", "pitch", *pressures, labels=labels, title="From rest to a trot")
sb.save_plot(ax, "four_legs_motion.png")

# One period of the rhythm in six pictures, side by side.
PERIOD = 2 * np.pi / 9.0
moments = run.at(2.5 + PERIOD * np.arange(6) / 6)
fig, ax = plt.subplots(figsize=(10, 1.9), layout="constrained")
for k in range(6):
    shift = 0.75 * k - moments["x"][k]
    for names, colors in (
        *(((f"{leg}_Thigh.top", f"{leg}_Shank.top", f"{leg}_Shank.foot"), ("C0", "C1")) for leg in legs),
        (("Trunk.rear_left", "Trunk.front_left"), ("0.25", "0.25")),
    ):
        x, _, z = np.transpose([moments[f"frame r {name} ground ground"][:, k] for name in names])
        color, is_trunk = colors[names[0][:2] in ("FR", "RL")], len(names) == 2
        ax.plot(x + shift, z, "-" if is_trunk else "o-", color=color, lw=6 if is_trunk else 2.5, ms=4)
    ax.text(0.75 * k, 0.42, f"t = {moments.t[k]:.2f} s", ha="center")
ax.axhline(0.0, color="0.5", lw=1)
ax.set(ylabel="z [m]", ylim=(-0.03, 0.48), xticks=[], aspect="equal")
ax.set_title("One period of the trot, a colour for each diagonal")
fig.savefig("four_legs.png", dpi=120)

# Check

# It went somewhere, on its feet, and each diagonal swings together.
assert run.success and abs(run["x"][-1]) > 0.2 and np.abs(run["pitch"]).max() < 0.5
assert run["z"].min() > 0.2
assert np.abs(run["FL_hip"] - run["RR_hip"]).max() == 0.0

# In the mean the ground carries the weight, over whole periods of the rhythm.
late = np.linspace(4.0 - 4 * PERIOD, 4.0, 4001)
carried = sum(run.at(late)[f"{leg}_N"].mean() for leg in legs)
weight = (8.0 + 4 * 0.8) * 9.81
print(f"mean pressure of the feet {carried:.1f} N, weight {weight:.1f} N")
assert abs(carried / weight - 1) < 0.02

# References
#
# M. H. Raibert, Legged Robots That Balance, chapter 4: gaits in which diagonal legs work together.
