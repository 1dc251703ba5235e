"""How a mechanism passes motion and torque on: velocity ratios, and what drives it at a constant speed."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.kinematics.velocity_ratios import velocity_ratios
from symbody.builder.task_failure import Report
from symbody.builder.tasks.json_values import finite
from symbody.builder.tasks.options import RatioOptions, TorqueOptions, read_options
from symbody.builder.tasks.reading import complete_model
from symbody.builder.tasks.simulation import draw_run, run_verdict
from symbody.equations.form import form_equations
from symbody.errors import Problem, UsageError
from symbody.simulation.simulate import simulate
from symbody.visual.scene import motion_to_json, scene_to_json

Answer = dict[str, Any]


def ratios(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return how fast all speeds are beside the independent ones, at the start."""
    options = read_options(RatioOptions, payload["options"])
    eqs = form_equations(complete_model(payload["data"], payload["folder"]))
    report("closing the loops", None)
    state = assemble(eqs)
    found = velocity_ratios(eqs, options.independent or None, at=state)
    values = found.at(state)
    return {
        "independent": list(found.independent),
        "ratios": {
            f"{dependent} / {independent}": finite(float(values[row, column]))
            for row, dependent in enumerate(found.dependent)
            for column, independent in enumerate(found.independent)
        },
        "notes": list(found.notes),
    }


def torque(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return what has to act on a coordinate so that its rate is constant, over one turn or a time.

    Raises
    ------
    UsageError
        If no joint has the coordinate as its only one.
    """
    options = read_options(TorqueOptions, payload["options"])
    model = complete_model(payload["data"], payload["folder"])
    eqs = form_equations(model)
    start = assemble(eqs)
    if options.coordinate not in start.q:
        raise _no_drive(options.coordinate)
    data = copy.deepcopy(payload["data"])
    name = _drive(data, model, options.coordinate, f"{start.q[options.coordinate]!r} + {options.rate!r}*t")
    report("prescribing the motion", None)
    driven = form_equations(complete_model(data, payload["folder"]))
    turns = eqs.units.get(options.coordinate, "") == "rad"
    t_end = options.t_end or (2.0 * math.pi / abs(options.rate) if turns else 1.0)
    guess = {each: value for each, value in start.q.items() if each in driven.coordinate_names}
    run = simulate(driven, t_end, guess=guess, times=np.linspace(0.0, t_end, options.samples))
    report("drawing", None)
    effort = f"effort {name}"
    values = np.ravel(run[effort])
    finished = draw_run(run, driven, "none", (effort,))
    return {
        "scene": scene_to_json(finished.scene),
        "motion": motion_to_json(finished.motion),
        "curves": [{"name": effort, "unit": driven.units.get(effort, "")}],
        "largest": finite(float(np.max(values))),
        "smallest": finite(float(np.min(values))),
        "mean": finite(float(np.trapezoid(values, run.t)) / t_end),
        "run": run_verdict(run, driven),
    }


def _drive(data: dict[str, Any], model: Any, coordinate: str, law: str) -> str:
    """Write a motion into the joint of a coordinate; return the name of the joint."""
    for entry, joint in zip(data.get("joint", []), model.joints, strict=False):
        if tuple(joint.coordinates) == (coordinate,):
            for word in ("torque", "force"):  # the drive takes their place
                entry.pop(word, None)
            entry["motion"] = law
            initial = data.get("initial", {})  # the motion says where the coordinate begins
            data["initial"] = {
                k: each for k, each in initial.items() if k not in (coordinate, f"{coordinate}_dot")
            }
            return str(entry["name"])
    raise _no_drive(coordinate)


def _no_drive(coordinate: str) -> UsageError:
    return UsageError(
        Problem("builder.no_drive", "coordinate", f"no joint has {coordinate!r} as its only coordinate",
                fix="choose that of a revolute or prismatic joint")
    )  # fmt: skip
