"""Random mechanisms as models that a file can hold: their state among the initial values, inputs as parameters."""

from __future__ import annotations

import re
from typing import Any

import symbody as sb
from symbody.formats.native import from_data, to_data
from tests.laws.building import build_model
from tests.laws.consistent_states import consistent_state
from tests.laws.parts import Mechanism

START = "t_start"
# What stands in a file and is no formula.
_WORDS = ("name", "type", "between", "on", "reaction_on", "resolved_in", "angles", "speeds")


def model_with_state(mechanism: Mechanism) -> sb.Model:
    """The model of a mechanism with its pose and its speeds as initial values.

    Inputs become parameters with their values at the pose, and time starts at that of the pose.
    """
    model = build_model(mechanism)
    state = consistent_state(mechanism)
    eqs = sb.form_equations(model)
    data: dict[str, Any] = _later(to_data(model))
    data.pop("inputs", None)
    numbers = {**mechanism.inputs, START: mechanism.t}
    data["parameters"] = {
        **data.get("parameters", {}),
        **{name: repr(value) for name, value in numbers.items()},
    }
    names = (*eqs.coordinate_names, *eqs.speed_names)
    data["initial"] = {name: repr(state.known[name]) for name in names}
    return from_data(data)


def _later(part: Any) -> Any:
    """Data with t counted from the pose on in all formulas."""
    if isinstance(part, dict):
        return {key: value if key in _WORDS else _later(value) for key, value in part.items()}
    if isinstance(part, list):
        return [_later(value) for value in part]
    return re.sub(r"\bt\b", f"(t + {START})", part) if isinstance(part, str) else part
