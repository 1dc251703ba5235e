"""Robot arm.

Description
    A column turns about the vertical, an upper arm lifts, a forearm slides out of it and carries a tool. The
    robot comes as a URDF file, the format of robotics. It is held by the efforts that statics asks for, then
    let go.
Concepts
    Robots from URDF; links fixed together are one body; inputs named after joints; the mass of a link as a
    symbol; energy of a fall.
"""

from pathlib import Path

import numpy as np

import symbody as sb

# Modeling

robot = sb.load_urdf(Path(__file__).with_suffix(".urdf"), symbolic=["tool"])
eqs = sb.form_equations(robot)
print("coordinates:", eqs.coordinate_names, "inputs:", eqs.input_names)
print("what acts along the slide:", eqs.forcing[2])

# Simulation

# What holds the arm raised by 0.3 rad and extended by 0.1 m, with a tool of 0.5 kg.
forcing = sb.compile(eqs, "forcing")
posture = {"turn": 0.0, "lift": 0.3, "reach": 0.1}
held = -forcing(0.0, [posture[name] for name in eqs.coordinate_names], np.zeros(3), np.zeros(3))
efforts = dict(zip(eqs.input_names, map(float, held), strict=True))
print("efforts:", efforts)
still = sb.simulate(eqs, 1.0, initial=posture, inputs=efforts)

# The lift alone is let go while the arm turns.
fall = sb.simulate(
    eqs, 0.8, initial={**posture, "turn_dot": 1.0}, inputs={"tau_reach": "-400*(reach - 0.1) - 20*reach_dot"}
)
path = ("frame r tool ground ground x", "frame r tool ground ground z")
sb.save_plot(sb.plot(fall, path, title="Path of the tool"), "robot_arm.png")
sb.save_plot(sb.plot(fall, "turn_dot", "lift_dot", title="Rates"), "robot_arm_rates.png")

# Check

# Statics: the moments of the weights about the lift, and their part along the slide.
moment = 9.81 * np.cos(0.3) * (3 * 0.25 + 2 * (0.6 + 0.15) + 0.5 * (0.6 + 0.3))
assert abs(efforts["tau_lift"] - moment) < 1e-12 * moment
assert abs(efforts["tau_reach"] - 9.81 * np.sin(0.3) * 2.5) < 1e-12 * 30
# The posture is unstable, but a second does not carry roundings far.
assert abs(still["lift"][-1] - 0.3) < 1e-9 and abs(still["reach"][-1] - 0.1) < 1e-9
# Nothing acts about the vertical: the angular momentum about it stays.
mass_matrix = sb.compile(eqs, "mass_matrix")
about_z = [mass_matrix(0.0, fall.q[:, k], fall.u[:, k], np.zeros(3))[0] @ fall.u[:, k] for k in (0, -1)]
print("angular momentum about the vertical:", about_z)
assert abs(about_z[1] - about_z[0]) < 1e-7 * abs(about_z[0])

# References
#
# The URDF elements: https://wiki.ros.org/urdf/XML.
