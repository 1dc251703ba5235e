"""Loops whose frames all coincide: a drawing of bodies without lengths, which nothing can move."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from symbody.builder.page_problems import PageProblem, page_problem
from symbody.errors import Problem
from symbody.model.joint import Joint
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.visual.scene.basis import SAME_POINT
from symbody.visual.scene.numbers import model_numbers
from symbody.visual.scene.poses import frame_transforms

Data = Mapping[str, Any]

_LENGTH: Final = 1.0  # that the offered repair gives a body [m]


def coincidence_warnings(model: Model, data: Data) -> list[PageProblem]:
    """Return a warning for each set of joints in loops whose frames are one point on each body."""
    frames = frame_transforms(model, model_numbers(model, {}))
    places = {
        (joint.name, end): np.asarray(frames[reference].place)
        for joint in model.joints
        for end, reference in enumerate((joint.start, joint.end))
    }
    return [_warning(core, data) for core in _cores(model.joints) if _is_one_point(core, places)]


def _cores(joints: Sequence[Joint]) -> list[list[Joint]]:
    """Return the joints that stand in loops, in sets that hang together."""
    core = [joint for joint in joints if joint.start.body != joint.end.body]
    while True:
        ends = [body for joint in core for body in _bodies(joint)]
        inner = [joint for joint in core if all(ends.count(body) > 1 for body in _bodies(joint))]
        if len(inner) == len(core):
            return _components(core)
        core = inner


def _bodies(joint: Joint) -> tuple[str, str]:
    return joint.start.body, joint.end.body


def _components(joints: Iterable[Joint]) -> list[list[Joint]]:
    found: list[tuple[set[str], list[Joint]]] = []
    for joint in joints:
        bodies, members = set(_bodies(joint)), [joint]
        apart = []
        for other, own in found:
            if other & bodies:
                bodies, members = bodies | other, [*own, *members]
            else:
                apart.append((other, own))
        found = [*apart, (bodies, members)]
    return [members for _, members in found]


def _is_one_point(core: Sequence[Joint], places: Mapping[tuple[str, int], Any]) -> bool:
    """Return whether on each body, the ground too, the joints of a core meet in one point."""
    points: dict[str, list[Any]] = {}
    for joint in core:
        for end, body in enumerate(_bodies(joint)):
            points.setdefault(body, []).append(places[joint.name, end])
    reach = max(float(np.abs(each).max()) for each in places.values())
    spread = max(float(np.ptp(np.array(each), axis=0).max()) for each in points.values())
    return spread <= SAME_POINT * reach  # rounding alone; all zero where nothing has a length


def _warning(core: Sequence[Joint], data: Data) -> PageProblem:
    names = [joint.name for joint in core]
    problem = Problem(
        "builder.coincident",
        f"joint {names[-1]}",
        f"all frames of {_in_words(names)} coincide",
        "the bodies between them have no length, so they cannot move as intended",
        "give the bodies frames at their ends, and connect these frames",
    )
    return {**page_problem(problem, data, "warning"), "repair": _repair(core, data)}


def _in_words(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _repair(core: Sequence[Joint], data: Data) -> dict[str, Any] | None:
    """Return the change that gives each body two ends, None if one has frames or more joints."""
    entries = {entry["name"]: k for k, entry in enumerate(data["body"])}
    joints = {entry["name"]: k for k, entry in enumerate(data["joint"])}
    ends: dict[str, list[tuple[str, int]]] = {}
    for joint in core:
        for end, body in enumerate(_bodies(joint)):
            if body != GROUND:
                ends.setdefault(body, []).append((joint.name, end))
    simple = all(
        body in entries and not data["body"][entries[body]].get("frames") and len(own) == 2
        for body, own in ends.items()
    )
    if not simple:
        return None
    patch: list[dict[str, Any]] = []
    half = f"{_LENGTH / 2:g}"
    for body, own in ends.items():
        frames = {"A": {"at": [f"-{half}", "0", "0"]}, "B": {"at": [half, "0", "0"]}}
        patch.append({"op": "add", "path": f"/body/{entries[body]}/frames", "value": frames})
        for (name, end), frame in zip(own, frames, strict=True):
            path = f"/joint/{joints[name]}/between/{end}"
            patch.append({"op": "replace", "path": path, "value": f"{body}.{frame}"})
    return {"label": f"give each body a length of {_LENGTH:g} m", "patch": patch}
