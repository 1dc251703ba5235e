"""A configuration in which some coordinates have given values: what follows a drag in the picture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symbody.builder.page_problems import page_problems
from symbody.builder.task_failure import Report, TaskFailure
from symbody.builder.tasks.mechanisms import solver_of
from symbody.builder.tasks.placement import placed_motion, scene_bodies
from symbody.builder.tasks.reading import complete_model
from symbody.errors import SymbodyError


def find_pose(payload: Mapping[str, Any], report: Report) -> dict[str, Any]:
    """Return values of all coordinates, and where the bodies stand.

    Raises
    ------
    TaskFailure
        If the loops do not close there.
    """
    data, folder = payload["data"], payload["folder"]
    model = complete_model(data, folder)
    try:
        solver = solver_of(data, folder, model)
        eqs = solver.eqs
        names = set(eqs.coordinate_names)
        fixed = {name: value for name, value in payload["fixed"].items() if name in names}
        guess = {name: value for name, value in payload["guess"].items() if name in names - fixed.keys()}
        positions = solver.positions(fixed, guess)
        motion = placed_motion(eqs, positions, scene_bodies(model))
    except SymbodyError as error:
        raise TaskFailure(page_problems(error.problems, data)) from None
    return {
        "values": positions,
        "positions": motion.positions[0].tolist(),
        "quaternions": motion.quaternions[0].tolist(),
    }
