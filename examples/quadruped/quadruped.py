"""Quadruped.

Description
    A robot of twelve motors on four feet, from a URDF file, trots under a PD controller of 1 kHz: its joints
    follow sines, diagonal legs together, and nothing measures whether it falls.
Concepts
    A robot from URDF with a floating base; one contact for all feet; a controller in Python by `Stepper`, and
    the same as formulas by `simulate`, which is drawn.
"""

import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import symbody as sb

# Modeling

robot = sb.load_urdf(Path(__file__).with_suffix(".urdf"), floating_base=True)
feet = sb.Contact(
    "feet",
    "ground",
    "*_shank.*_foot",
    ["plane", {"sphere": 0.02}],
    normal=sb.NormalForce(stiffness=2e4, exponent=1, dissipation=0.5),
    friction=sb.Friction(mu=0.8, v0=0.01),
)
model = sb.Model("quadruped", [*robot.elements, feet], gravity=robot.gravity, inputs=robot.inputs)
eqs = sb.form_equations(model)
print(f"{len(model.bodies)} bodies, {len(eqs.speed_names)} degrees of freedom, {len(eqs.input_names)} motors")
print(*model.notes, sep="\n")

# The gait: diagonal legs together. A thigh sweeps back while its foot is down, forward while its knee bends.
LEGS, PHASES = ("FL", "FR", "RL", "RR"), np.array([0, np.pi, np.pi, 0])
THIGH, KNEE, SWEEP, BEND, RATE = 0.7, -1.4, 0.25, 0.5, 2.5 * 2 * np.pi  # rad; rad/s
P, D = 80.0, 1.5  # N m/rad, N m s/rad
SEGMENT, FOOT, MASS = 0.2, 0.02, 11.2  # m; kg
stand = {f"{leg}_{joint}": angle for leg in LEGS for joint, angle in (("pitch", THIGH), ("knee", KNEE))}
stand["base_z"] = 2 * SEGMENT * np.cos(THIGH) + FOOT

# Simulation


def aims(t):
    """Return the angles that the motors aim at: roll, pitch and knee of each leg."""
    share, phase = min(1.0, t), RATE * t + PHASES
    pitch = THIGH + SWEEP * share * np.sin(phase)
    knee = KNEE - BEND * share * np.maximum(0.0, -np.cos(phase))
    return np.stack([np.zeros(4), pitch, knee], axis=1).ravel()


dt, end, period = 1e-3, 5.0, 2 * np.pi / RATE
stepper = sb.Stepper(eqs, dt, initial=stand)
pressures = [f"contact_force feet_{leg}_shank_{leg}_foot z" for leg in LEGS]
record = {name: [] for name in ("base_x", "base_y", "base_z", "base_qx", "base_qy", *pressures)}
times = []
began = time.process_time()
while stepper.t < end - dt / 2:
    torques = P * (aims(stepper.t) - stepper.q[7:]) - D * stepper.u[6:]
    stepper.step(**dict(zip(eqs.input_names, torques.tolist(), strict=True)))
    times.append(stepper.t)
    for name, values in record.items():
        values.append(stepper[name])
took = time.process_time() - began
t, record = np.array(times), {name: np.array(values) for name, values in record.items()}
lean = np.arccos(1 - 2 * (record["base_qx"] ** 2 + record["base_qy"] ** 2))
print(f"{record['base_x'][-1]:.2f} m in {end:g} s, computed in {took:.1f} s")

fig, (way, lower) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
way.plot(t, record["base_x"], label="forward [m]")
way.plot(t, record["base_z"], label="height [m]")
way.plot(t, lean, label="lean [rad]")
way.legend()
way.set_title("A trot under a PD controller, 1 kHz")
for place in range(4):
    down = record[pressures[place]] > 0
    lower.fill_between(t, place + 0.1, place + 0.9, where=down, color=f"C{abs(place - 1.5) > 1:d}", lw=0)
lower.set(xlabel="t [s]", xlim=(2, 4), yticks=np.arange(4) + 0.5, yticklabels=LEGS, title="Feet on the floor")
fig.savefig("quadruped_gait.png", dpi=120)

# The same controller without samples: formulas of the state.
laws = {}
for leg, phase in zip(LEGS, PHASES.tolist(), strict=True):
    pitch = f"{THIGH} + {SWEEP}*min(1, t)*sin({RATE}*t + {phase})"
    knee = f"{KNEE} - {BEND}*min(1, t)*max(0, -cos({RATE}*t + {phase}))"
    for joint, aim in (("roll", "0"), ("pitch", pitch), ("knee", knee)):
        laws[f"tau_{leg}_{joint}"] = f"{P}*({aim} - {leg}_{joint}) - {D}*{leg}_{joint}_dot"
run = sb.simulate(eqs, end, stand, inputs=laws, times=np.linspace(0, end, 501), rtol=1e-6)
contacts = [f"feet_{leg}_shank_{leg}_foot" for leg in LEGS]
view = {"view": (0.25, -1.0, 0.25), "vectors": contacts, "size": (1000, 300), "progress": False}
sb.save_animation(run, "quadruped.png", times=np.array([0.0, 2.1, 3.3, 4.2, 5.0]), **view)

# Check

# It went forward on its feet, about as fast as they sweep while they are down: motors lag a little.
sweep = 2 * SWEEP * 2 * SEGMENT * np.cos(THIGH)  # m, of a foot relative to its hip in half a period
speed = (record["base_x"][-1] - np.interp(2.0, t, record["base_x"])) / (end - 2.0)
print(
    f"{speed:.3f} m/s, its feet sweep {2 * sweep / period:.3f} m/s;",
    f"it leans {np.degrees(lean.max()):.1f} deg at most",
)
assert 0.7 < speed * period / (2 * sweep) < 1.05
assert lean.max() < 0.2 and record["base_z"].min() > 0.9 * stand["base_z"] and record["base_x"][-1] > 2

# Over whole periods the feet carry the weight: the momentum upward stays.
late = t > end - 5 * period
carried = sum(record[name][late].mean() for name in pressures)
print(f"the feet carry {carried:.1f} N, the weight is {9.81 * MASS:.1f} N")
assert abs(carried / (9.81 * MASS) - 1) < 0.02

# Without samples it trots alike, and what the motors do and the feet lose is what its energy changes by.
print(f"without samples {run['base_x'][-1]:.2f} m; energy and work differ by {run.energy_drift:.1e} J")
assert run.success and abs(run["base_x"][-1] / record["base_x"][-1] - 1) < 0.2

# References
#
# M. H. Raibert, Legged Robots That Balance, chapter 4: gaits in which diagonal legs work together.
