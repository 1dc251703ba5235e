"""The picture of a model after a change of its parameters: loops closed and shapes sized anew, no more.

A check forms equations and counts what they say. Of that a picture needs where the bodies stand and how large
they are; the equations, in which parameters are symbols, serve for all values.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from symbody.builder.task_failure import Report, TaskFailure
from symbody.builder.tasks.mechanisms import mechanism_of
from symbody.builder.tasks.placement import draw_at
from symbody.builder.tasks.reading import Data, complete_model
from symbody.errors import SymbodyError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.model import Model
from symbody.model.parts.expansion import own_content
from symbody.visual.scene.json_form import motion_to_json, scene_to_json

Answer = dict[str, Any]

_NOTHING: Final[Mapping[str, Any]] = {"picture": None, "values": {}}


def redraw_model(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return picture and coordinates of a model, as its check does.

    The picture is None where the model is not complete, or does not assemble: then the check says why.
    """
    data, folder = payload["data"], payload["folder"]
    try:
        return _redrawn(data, folder)
    except (SymbodyError, TaskFailure):
        return dict(_NOTHING)


def _redrawn(data: Data, folder: str) -> Answer:
    given = data.get("parameters") or {}
    mechanism = mechanism_of(data, folder, lambda: complete_model(data, folder))
    eqs = mechanism.eqs
    changed = changed_parameters(eqs.model, given)
    if changed is None:
        return dict(_NOTHING)
    positions = mechanism.solver(eqs, changed).positions({}, {})
    scene, motion = draw_at(eqs, positions, changed)
    return {
        "picture": {"scene": scene_to_json(scene), "motion": motion_to_json(motion)},
        "values": positions,
    }


def changed_parameters(model: Model, given: Mapping[str, Any]) -> dict[str, Formula] | None:
    """Return the parameters whose values differ from those of a model; None where one cannot be used.

    Parameters
    ----------
    given : mapping of name to number or text
        Of all parameters, as the model file holds them; those of parts stand in the files of these.
    """
    arguments = Arguments("parameters")
    written = own_content(model)[0].parameters if model.includes else model.parameters
    values = {
        name: arguments.formula(value, name) for name, value in given.items() if value not in ("", None)
    }
    usable = {*given, *model.parameters, "pi"}
    if arguments.problems or values.keys() != written.keys():
        return None
    if any(not usable.issuperset(formula.names) for formula in values.values()):
        return None
    return {name: formula for name, formula in values.items() if formula != model.parameters[name]}
