"""The check that follows each change of a model: problems, what it is, and its picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from symbody.builder.formulas import model_formulas
from symbody.builder.page_problems import PageProblem, page_notes, page_problem, page_problems
from symbody.builder.task_failure import Report
from symbody.builder.tasks.coincidence import coincidence_warnings
from symbody.builder.tasks.mechanisms import mechanism_of, solver_of
from symbody.builder.tasks.placement import draw_at, draw_unassembled
from symbody.builder.tasks.reading import Data, Latest, ReadModel, model_key, read_model
from symbody.builder.tasks.summary import equation_summary, tree_summary
from symbody.builder.wires import model_wires
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SymbodyError
from symbody.graph.topology import choose_topology
from symbody.model.model import Model
from symbody.visual.scene import motion_to_json, scene_to_json

Answer = dict[str, Any]

_CHECKS: Final[Latest[Answer]] = Latest(8)


@dataclass(frozen=True, slots=True)
class Checked:
    """What was found out about a complete model, as far as it went.

    Attributes
    ----------
    positions : mapping of coordinate to float, optional
        Where it is assembled.
    eqs : EquationSet, optional
        Its equations.
    """

    summary: Answer | None
    positions: dict[str, float] | None
    problems: list[PageProblem]
    eqs: EquationSet | None = None


def check_model(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return problems, summary, picture, values of coordinates, formulas and wires of a model."""
    data, folder = payload["data"], payload["folder"]
    return _CHECKS.get(model_key(data, folder), lambda: _check(data, folder))


def _check(data: Data, folder: str) -> Answer:
    read = read_model(data, folder)
    checked = _check_model(read, data, folder)
    picture, problems = _picture(read.model, checked, data)
    return {
        "problems": [*read.problems, *checked.problems, *problems],
        "summary": checked.summary,
        "picture": picture,
        "values": checked.positions or {},
        "formulas": model_formulas(data),
        "wires": model_wires(data),
    }


def _check_model(read: ReadModel, data: Data, folder: str) -> Checked:
    """Return what follows from a model; an incomplete one is described by its trees only."""
    model = read.model
    if model is None:
        return Checked(None, None, [])
    if read.problems:
        try:
            return Checked({**_NO_EQUATIONS, **tree_summary(choose_topology(model))}, None, [])
        except SymbodyError:  # what is missing leads to this; it is said already
            return Checked(None, None, [])
    if not model.bodies:
        what, cure = "there is no body yet", "drag a body from the palette, or double-click the diagram"
        return Checked(None, None, [page_problem(Problem("builder.empty", "", what, fix=cure), data, "note")])
    return _check_formed(model, data, folder)


# Where equations are missing, the page finds the same keys.
_NO_EQUATIONS: Final[Mapping[str, Any]] = {
    "coordinates": [],
    "speeds": [],
    "units": {},
    "freedoms": None,
    "instant_freedoms": None,
    "constraints": 0,
    "unilateral": 0,
    "chords": [],
    "redundant": [],
    "counting": [],
}


def _check_formed(model: Model, data: Data, folder: str) -> Checked:
    try:
        eqs = mechanism_of(data, folder, lambda: model).with_values(model)
        summary = equation_summary(eqs)
        notes = [*coincidence_warnings(model, data), *page_notes(eqs.notes, data)]
    except SymbodyError as error:
        return Checked(_trees(model), None, page_problems(error.problems, data))
    try:
        solver = solver_of(data, folder, model)
        return Checked(summary, solver.positions({}, {}), notes, eqs)
    except SymbodyError as error:
        valueless = [name for name, value in model.parameters.items() if value is None]
        faults = [_missing_value(name, data) for name in valueless] or page_problems(error.problems, data)
        return Checked(summary, None, [*faults, *notes], eqs)


def _missing_value(name: str, data: Data) -> PageProblem:
    problem = Problem(
        "builder.no_value", f"#/parameters/{name}", f"{name} has no value", "the picture uses 1",
        "give it one to see the mechanism assembled, and to simulate"
    )  # fmt: skip
    return page_problem(problem, data, "warning")


def _trees(model: Model) -> Answer | None:
    try:
        return {**_NO_EQUATIONS, **tree_summary(choose_topology(model))}
    except SymbodyError:
        return None


def _picture(model: Model | None, checked: Checked, data: Data) -> tuple[Answer | None, list[PageProblem]]:
    """Return the mechanism as it stands at the start: assembled, or as its initial values say."""
    if model is None:
        return None, []
    eqs, positions = checked.eqs, checked.positions
    try:
        if eqs is None or positions is None:
            scene, motion = draw_unassembled(model)
        else:
            scene, motion = draw_at(eqs, positions)
    except SymbodyError as error:
        return None, page_problems(error.problems, data)
    notes = page_notes(scene.notes, data, "builder.drawing")
    return {"scene": scene_to_json(scene), "motion": motion_to_json(motion)}, notes
