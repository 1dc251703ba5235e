"""The same model with the ends of its joints exchanged."""

from __future__ import annotations

import re
from typing import Any

import symbody as sb
from symbody.formats.native import from_data, to_data

# Seen from the other side the end moves backwards along the axes: the coordinates stay what they are.
_SAME = ("weld", "revolute", "prismatic", "screw", "cylindrical")
# The ends of these may be exchanged too, but the coordinates become others: the joints are cut, so none matter.
_OTHER = ("planar", "spherical", "free", "gimbal", "cartesian", "rectangular")
_NEGATED = {"x": ["-1", "0", "0"], "y": ["0", "-1", "0"], "z": ["0", "0", "-1"]}
_TIED = ("force", "torque", "motion", "friction", "armature")


def with_reversed_joints(model: sb.Model) -> sb.Model | None:
    """The model with start and end of joints exchanged where the law stays the same; None if nowhere."""
    data = to_data(model)
    joints = data.get("joint", [])
    changed = [_reversed(data, entry) for entry in joints]
    if all(entry is None for entry in changed):
        return None
    data["joint"] = [new or old for new, old in zip(changed, joints, strict=True)]
    data.pop("initial", None)
    return from_data(data)


def _reversed(data: dict[str, Any], entry: dict[str, Any]) -> dict[str, Any] | None:
    found = {**entry, "between": entry["between"][::-1]}
    if entry["type"] in _SAME:
        if "axis" in entry:
            found["axis"] = _negative(entry["axis"])
        return found
    if entry["type"] == "universal":
        # R = A(a) B(b) turns back by B(-b) A(-a).
        found["axes"] = [_negative(axis) for axis in entry["axes"][::-1]]
        names = entry.get("coordinates") or [f"{entry['name']}_{k}" for k in (1, 2)]
        found["coordinates"] = names[::-1]
        return found
    if entry["type"] in _OTHER and not _is_read(data, entry):
        fresh = {key: value for key, value in found.items() if key not in ("coordinates", "speed_names")}
        return fresh | {"tree": False}
    return None


def _negative(axis: str | list[str]) -> list[str]:
    return _NEGATED[axis] if isinstance(axis, str) else [f"-({x})" for x in axis]


def _is_read(data: dict[str, Any], entry: dict[str, Any]) -> bool:
    """Whether anything depends on the coordinates of a joint."""
    if any(word in entry for word in _TIED):
        return True
    names = entry.get("coordinates", []) + entry.get("speed_names", []) + [entry["name"]]
    rest = {key: value for key, value in data.items() if key not in ("initial", "joint", "body", "name")}
    text = repr(rest) + repr([_laws(other) for other in data["joint"]])
    return any(re.search(rf"\b{re.escape(name)}(_|\b)", text) for name in names)


def _laws(entry: dict[str, Any]) -> dict[str, Any]:
    return {word: entry[word] for word in _TIED if word in entry}
