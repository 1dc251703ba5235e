"""Every joint of the library, made from what it declares."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symbody.graph.curved_shifts import is_curved
from symbody.model.joint import Joint
from symbody.model.registry import element_types


def joint_types() -> dict[str, type[Joint]]:
    """Return the classes of joints by their words in files."""
    return {word: kind for word, kind in element_types("joint").items() if issubclass(kind, Joint)}


def straight_joints(
    start: str, end: str, arguments: Mapping[str, Mapping[str, Any]] | None = None
) -> dict[str, Joint]:
    """Return joints J between two frames by their words in files, without those that cannot be cut.

    Coordinates are q1, q2, ...; what a joint requires, as a pitch, is 0.6; `arguments` by word come first.
    """
    joints: dict[str, Joint] = {}
    for word, kind in joint_types().items():
        values: dict[str, Any] = {name: 0.6 for name, field in kind.fields.items() if field.is_required}
        values |= {"name": "J", "start": start, "end": end, **(arguments or {}).get(word, {})}
        names = [f"q{k + 1}" for k in range(len(kind(**values).coordinates))]
        values |= {"coordinate": names[0]} if "coordinate" in kind.fields else {}
        values |= {"coordinates": names} if "coordinates" in kind.fields else {}
        joints[word] = kind(**values)
    return {word: joint for word, joint in joints.items() if not is_curved(joint)}
