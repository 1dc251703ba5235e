"""Analyses from the page: rest, small motions about it, singular positions, inputs for a motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.equilibrium.find_equilibrium import find_equilibrium
from symbody.analysis.kinematics.singular_configurations import singular_configurations
from symbody.analysis.linear.linearization import Linearization
from symbody.analysis.linear.linearize import linearize
from symbody.analysis.linear.modes import Mode
from symbody.analysis.state import State
from symbody.builder.task_failure import Report
from symbody.builder.tasks.json_values import finite, finite_values
from symbody.builder.tasks.options import (
    EquilibriumOptions,
    InverseOptions,
    ModesOptions,
    SingularOptions,
    read_options,
)
from symbody.builder.tasks.placement import placed_motion, scene_bodies
from symbody.builder.tasks.reading import complete_model
from symbody.builder.tasks.simulation import draw_run, run_verdict
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.errors import SymbodyError
from symbody.simulation.inverse.inverse_dynamics import inverse_dynamics
from symbody.visual.scene import make_scene, motion_to_json, scene_to_json
from symbody.visual.scene.body_poses import of_one_sign
from symbody.visual.scene.scene import Scene, SceneMotion

Answer = dict[str, Any]

_FRAMES: Final = 24  # of one period of a mode
_ANGLE: Final = 0.3  # how far a mode swings [rad]
_SHARE: Final = 0.12  # how far it slides, of the mechanism's size


def equilibrium(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return the equilibrium nearest to the start, with others that were met."""
    options = read_options(EquilibriumOptions, payload["options"])
    eqs = _equations(payload)
    report("searching for equilibria", None)
    state = find_equilibrium(
        eqs, options.guess, inputs=options.inputs, unknowns=options.unknowns, fixed=options.fixed
    )
    others = [each for each in state.branches if isinstance(each, type(state))]
    return {
        **_describe_state(state),
        "notes": list(state.notes),
        "inputs": {name: _number(state.inputs[name]) for name in options.unknowns},
        "picture": _still(state),
        "branches": [{**_describe_state(each), "picture": _still(each)} for each in others[:8]],
    }


def _describe_state(state: Any) -> Answer:
    try:
        verdict = str(state.verdict)
    except SymbodyError:
        verdict = "undecided"
    return {"values": finite_values(state.q), "verdict": verdict}


def _number(value: Any) -> float | None:
    return finite(value) if isinstance(value, int | float) else None


def modes(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return frequencies, damping and shapes of small motions, the shapes as motions too."""
    options = read_options(ModesOptions, payload["options"])
    eqs = _equations(payload)
    report("searching for the position", None)
    if options.at == "equilibrium":
        state: State = find_equilibrium(eqs, inputs=options.inputs)
    else:
        state = assemble(eqs, inputs=options.inputs)
    report("linearizing", None)
    linear = linearize(eqs, state)
    scene = _scene(state)
    report("shapes", None)
    shown = [mode for mode in linear.modes if mode.eigenvalue.imag >= 0.0]
    return {
        "verdict": linear.verdict,
        "notes": list(linear.notes),
        "values": finite_values(state.q),
        "states": list(linear.state_names),
        "inputs": list(linear.input_names),
        "A": linear.A.tolist(),
        "B": linear.B.tolist(),
        "scene": scene_to_json(scene),
        "modes": [_mode(mode, linear, state, scene) for mode in shown],
    }


def _mode(mode: Mode, linear: Linearization, state: State, scene: Scene) -> Answer:
    motion = _mode_motion(mode, linear, state, scene)
    return {
        "real": finite(mode.eigenvalue.real),
        "imag": finite(mode.eigenvalue.imag),
        "frequency": finite(mode.frequency),
        "hertz": finite(mode.frequency / (2.0 * math.pi)),
        "damping": finite(mode.damping_ratio),
        "time_constant": finite(mode.time_constant),
        "shape": {name: [value.real, value.imag] for name, value in mode.shape.items()},
        "motion": None if motion is None else motion_to_json(motion),
    }


def _mode_motion(mode: Mode, linear: Linearization, state: State, scene: Scene) -> SceneMotion | None:
    """Return one period of a mode, large enough to be seen; loops follow. None where nothing moves."""
    eqs = state.eqs
    shape = {name: mode.shape[name] for name in linear.state_names if name in state.q and name in mode.shape}
    sizes = [
        abs(value) / (_ANGLE if eqs.units.get(name, "") == "rad" else _SHARE * scene.size)
        for name, value in shape.items()
    ]
    if not sizes or max(sizes) < 1e-12:
        return None
    size = 1.0 / max(sizes)
    times = np.linspace(0.0, 2.0 * math.pi / (abs(mode.eigenvalue.imag) or 2.0 * math.pi), _FRAMES + 1)
    frames: list[SceneMotion] = []
    near = state
    for phase in np.linspace(0.0, 2.0 * math.pi, _FRAMES + 1):
        turn = complex(math.cos(phase), math.sin(phase)) if mode.eigenvalue.imag else math.sin(phase)
        fixed = {name: state.q[name] + size * complex(value * turn).real for name, value in shape.items()}
        try:
            near = assemble(eqs, fixed, near.q, inputs=dict(state.inputs))
        except SymbodyError:
            return None
        frames.append(placed_motion(eqs, near.q, scene_bodies(eqs.model)))
    return join_motions(frames, times)


def join_motions(frames: Sequence[SceneMotion], times: Any) -> SceneMotion:
    """Return motions of one sample each as one motion."""
    positions = np.concatenate([frame.positions for frame in frames])
    quaternions = np.concatenate([frame.quaternions for frame in frames])
    return SceneMotion(np.asarray(times, dtype=np.float64), positions, of_one_sign(quaternions))


def singular_positions(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return where a choice of independent coordinates does not determine the others."""
    options = read_options(SingularOptions, payload["options"])
    eqs = _equations(payload)
    independent = options.independent or list(eqs.coordinate_names[:1])
    over = options.over or {independent[0]: (-math.pi, math.pi)}
    report("following the positions", None)
    places = singular_configurations(eqs, independent, over)
    return {
        "independent": independent,
        "over": {name: list(span) if isinstance(span, tuple) else span for name, span in over.items()},
        "places": [
            {
                "kind": place.kind,
                "values": finite_values(place.q),
                "joint": place.joint,
                "limits": dict(place.limits),
                "text": str(place),
                "picture": _state_answer(eqs, place.q),
            }
            for place in places[:40]
        ],
    }


def inverse(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return the inputs that make a motion, as curves of it."""
    options = read_options(InverseOptions, payload["options"])
    eqs = _equations(payload)
    report("following the motion", None)
    times = np.linspace(0.0, options.t_end, options.samples)
    run = inverse_dynamics(eqs, options.motion, options.unknowns, times)
    report("drawing", None)
    finished = draw_run(run, eqs, "none", tuple(options.unknowns))
    return {
        "scene": scene_to_json(finished.scene),
        "motion": motion_to_json(finished.motion),
        "run": run_verdict(run, eqs),
    }


def _equations(payload: Mapping[str, Any]) -> EquationSet:
    return form_equations(complete_model(payload["data"], payload["folder"]))


def _scene(state: State) -> Scene:
    return make_scene(state.eqs.model, motion={name: np.array([value]) for name, value in state.q.items()})


def _still(state: State) -> Answer:
    motion = placed_motion(state.eqs, state.q, scene_bodies(state.eqs.model))
    return {"scene": scene_to_json(_scene(state)), "motion": motion_to_json(motion)}


def _state_answer(eqs: EquationSet, values: Mapping[str, float]) -> Answer | None:
    try:
        return _still(assemble(eqs, guess=values))
    except SymbodyError:  # at the edge of what closes
        return None
