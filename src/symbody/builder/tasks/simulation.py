"""Motions: computed, drawn, and kept in the process for further curves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from symbody.builder.task_failure import Report
from symbody.builder.tasks.json_values import curve, finite
from symbody.builder.tasks.options import SimulateOptions, read_options
from symbody.builder.tasks.reading import complete_model
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.errors import Problem, UsageError
from symbody.model.output_names import FRAMES, MULTIPLIERS, ListedOutput
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulate import simulate
from symbody.visual.scene import coordinate_courses, make_motion, make_scene, motion_to_json, scene_to_json
from symbody.visual.scene.scene import Scene, SceneMotion

Answer = dict[str, Any]

_SOLVERS: Final[Mapping[str, type[Explicit | Stiff]]] = MappingProxyType(
    {"explicit": Explicit, "stiff": Stiff}
)
_MOST_CURVES: Final = 24  # that come with the motion; others are computed when they are wanted


@dataclass(frozen=True, slots=True, eq=False)
class FinishedRun:
    """A motion with its picture."""

    run: Trajectory
    scene: Scene
    motion: SceneMotion


# The run of this process: one process computes one.
_FINISHED: Final[list[FinishedRun]] = []


class PipeProgress:
    """Reports how far a motion has come."""

    def __init__(self, report: Report, stage: str) -> None:
        self._report = report
        self._stage = stage
        self._percent = -1

    def __call__(self, share: float) -> None:
        """Report each percent once."""
        percent = int(100.0 * share)
        if percent > self._percent:
            self._percent = percent
            self._report(self._stage, percent)


def simulate_model(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return a motion with its scene, its curves, and how it ended.

    Raises
    ------
    TaskFailure, SymbodyError
        If options or model do not allow it.
    """
    options = read_options(SimulateOptions, payload["options"])
    report("reading the model", None)
    model = complete_model(payload["data"], payload["folder"])
    eqs = form_equations(model)
    report("compiling", None)
    run = simulate(
        eqs,
        options.t_end,
        inputs=options.inputs,
        times=_times(options),
        integrator=None if options.solver == "" else _SOLVERS[options.solver](),
        rtol=options.rtol,
        progress=PipeProgress(report, "integrating"),
    )
    report("drawing", None)
    finished = draw_run(run, eqs, options.vectors or None)
    _FINISHED[:] = [finished]
    return {
        "scene": scene_to_json(finished.scene),
        "motion": motion_to_json(finished.motion),
        "curves": curve_list(eqs),
        "run": run_verdict(run, eqs),
        "csv": None,
    }


def draw_run(
    run: Trajectory, eqs: EquationSet, vectors: str | None, extra: tuple[str, ...] = ()
) -> FinishedRun:
    """Return a motion with its picture; `extra` are curves beside coordinates and speeds."""
    scene = make_scene(eqs.model, motion=coordinate_courses(run))
    names = tuple(dict.fromkeys((*extra, *eqs.coordinate_names, *eqs.speed_names)))[:_MOST_CURVES]
    return FinishedRun(run, scene, make_motion(run, scene, curves=names, vectors=vectors))


def run_verdict(run: Trajectory, eqs: EquationSet) -> Answer:
    """Return how a motion ended, in words and figures."""
    has_samples = bool(run.t.size)
    return {
        "status": run.status.name,
        "success": run.success,
        "advice": run.status.value,
        "notes": [*eqs.notes, *run.notes],
        "t_end": finite(run.t[-1]) if has_samples else None,
        "energy_drift": finite(run.energy_drift) if has_samples else None,
        "violation": finite(np.max(run.constraint_violation)) if has_samples else None,
        "steps": run.statistics.accepted,
        "evaluations": run.statistics.evaluations,
        "seconds": finite(run.statistics.loop_seconds),
        "events": [{"name": event.name, "t": float(event.t)} for event in run.events],
    }


def curve_list(eqs: EquationSet) -> list[dict[str, str]]:
    """Return what can be drawn over time, in the order of the headings: all scalars but those of frames.

    Each has a name, a unit, the heading it stands under, and the element that it belongs to, if there are
    several outputs of one.
    """
    violation = [ListedOutput("constraint_violation", MULTIPLIERS)] if eqs.multiplier_names else []
    curves = [each for each in eqs.listed_outputs if each.is_number and each.title != FRAMES]
    return [
        {"name": name, "unit": eqs.units.get(name, ""), "title": title, "group": group}
        for name, title, group, _ in (*curves, *violation)
    ]


def more_curves(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return further curves of the run of this process, at the times of its motion.

    Raises
    ------
    UsageError
        If a name is neither an output nor an expression.
    """
    finished = kept_run()
    if finished is None:
        what = "this process has no motion"
        raise UsageError(Problem("builder.no_run", "outputs", what, fix="simulate again"))
    motion = make_motion(
        finished.run, finished.scene, times=finished.motion.times, curves=payload["names"], vectors="none"
    )
    return {"curves": [curve(each.name, each.unit, each.values) for each in motion.curves]}


def kept_run() -> FinishedRun | None:
    """Return the run of this process, None if it has computed none."""
    return _FINISHED[0] if _FINISHED else None


def _times(options: SimulateOptions) -> list[float] | None:
    if options.times is not None:
        return options.times
    return None if options.samples is None else np.linspace(0.0, options.t_end, options.samples).tolist()
