"""A loop in space: a crank drives a rocker through a rod on two ball joints."""

from pathlib import Path

import symbody as sb

eqs = sb.form_equations(sb.load_model(Path(__file__).with_name("spatial_four_bar.toml")))
print(eqs.coordinates, eqs.degrees_of_freedom, "degrees of freedom")
print(eqs.constraints)
print(eqs.frame_motion("r", "Rocker.pin"))
print(eqs.operation_count("udot", "lambda"), "operations for accelerations and multipliers")
