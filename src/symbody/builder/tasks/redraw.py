"""The picture of a model after a change of its parameters: loops closed and shapes sized anew, no more.

A check forms equations and counts what they say. Of that a picture needs where the bodies stand and how large
they are; the equations, in which parameters are symbols, serve for all values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from symbody.analysis.constraint_evaluator import constraint_function
from symbody.analysis.positions import position_solver
from symbody.builder.task_failure import Report, TaskFailure
from symbody.builder.tasks.placement import placed_motion, scene_at, scene_bodies
from symbody.builder.tasks.reading import Data, Latest, complete_model, model_key
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.errors import SymbodyError
from symbody.expr.language.formula import Formula
from symbody.model.arguments import Arguments
from symbody.model.model import Model
from symbody.visual.scene.json_form import motion_to_json, scene_to_json

Answer = dict[str, Any]

_FORMING: Final = 10.0  # seconds; larger models wait for a job
_NOTHING: Final[Mapping[str, Any]] = {"picture": None, "values": {}}


@dataclass(frozen=True, slots=True, eq=False)
class _Mechanism:
    """What values of parameters do not change: equations, and the compiled constraints of all parameters."""

    eqs: EquationSet
    constraints: CompiledFunction


_MECHANISMS: Final[Latest[_Mechanism]] = Latest(4)


def redraw_model(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return picture and coordinates of a model, as its check does.

    The picture is None where the model is not complete, or does not assemble: then the check says why.
    """
    data, folder = payload["data"], payload["folder"]
    try:
        return _redrawn(data, folder)
    except (SymbodyError, TaskFailure):
        return dict(_NOTHING)


def formed_count() -> int:
    """Return how many sets of equations this process has formed for pictures."""
    return _MECHANISMS.count


def _redrawn(data: Data, folder: str) -> Answer:
    given = data.get("parameters") or {}
    structure = model_key({**data, "parameters": sorted(given)}, folder)
    mechanism = _MECHANISMS.get(structure, lambda: _form_mechanism(data, folder))
    eqs = mechanism.eqs
    changed = changed_parameters(eqs.model, given)
    if changed is None:
        return dict(_NOTHING)
    positions = position_solver(eqs, changed, mechanism.constraints).positions({}, {})
    scene = scene_at(eqs.model, positions, changed)
    motion = placed_motion(eqs, positions, scene_bodies(eqs.model), changed)
    return {
        "picture": {"scene": scene_to_json(scene), "motion": motion_to_json(motion)},
        "values": positions,
    }


def _form_mechanism(data: Data, folder: str) -> _Mechanism:
    eqs = form_equations(complete_model(data, folder), time_limit=_FORMING)
    return _Mechanism(eqs, constraint_function(eqs, {}, {}, eqs.parameter_names))


def changed_parameters(model: Model, given: Mapping[str, Any]) -> dict[str, Formula] | None:
    """Return the parameters whose values differ from those of a model; None where one cannot be used.

    Parameters
    ----------
    given : mapping of name to number or text
        Of all parameters, as the model file holds them.
    """
    arguments = Arguments("parameters")
    values = {name: arguments.angle(value, name) for name, value in given.items() if value not in ("", None)}
    usable = {*given, "pi"}
    if arguments.problems or values.keys() != model.parameters.keys():
        return None
    if any(not usable.issuperset(formula.names) for formula in values.values()):
        return None
    return {name: formula for name, formula in values.items() if formula != model.parameters[name]}
