"""A whole simulation as JavaScript: equations, integrator, projection, assembly, and numbers.

The text needs nothing else; `SimulationText.module` is an ES module for Node and browsers.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Final

import numpy as np

from symbody.codegen.kernels.dialect import PREFIX
from symbody.codegen.kernels.featured import without_unused
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.equations.equation_set import EquationSet
from symbody.kernels import block as codes
from symbody.kernels.block import FunctionNumbers, Run, StateProjection
from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.configurations.strike_problem import RateJumps, StrikeProblem
from symbody.kernels.events.event_monitor import ZEROS_PER_EVENT, EventMonitor
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.record_layout import RecordLayout
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.simulation.methods.constraints import residual_share
from symbody.simulation.native.closing import closing_of
from symbody.simulation.programs.happenings import (
    ACTIONS,
    DECIDING,
    EVENTS,
    FITTING,
    SAMPLES,
    STRIKE,
    Happenings,
    closing_numbers,
    kernel_calls,
    make_happenings,
)
from symbody.simulation.programs.motion_request import (
    MotionRequest,
    PosedMotion,
    check_branch,
    check_request,
    pose_motion,
    with_modes,
)
from symbody.simulation.programs.program_function import (
    DERIVATIVES,
    PROJECTION,
    RIGHT_HAND_SIDE,
    TURN,
    ProgramFunction,
    implicit_array,
    method_bounds,
    motion_block,
    motion_functions,
    program_function,
)

_ENERGIES: Final = ("kinetic_energy", "potential_energy")
_PULL_INTERVAL: Final = 1.0 / 240.0  # seconds between changes of the wrench of a pointer
_KERNELS: Final = (
    ("dense_output", ("interpolate",)),
    ("projection", ("project",)),
    ("closing", ("close_state", "note_followers")),
)
# Kernels of what happens on the way by which a motion goes on anew, after the user has changed it.
_ANEW: Final = {
    "events": ("event_interruptions", ("values_before", "watch_again", "rewind_events")),
    "samples": ("sampling", ("rewind_samples",)),
    "jumps": ("struck_motion", ("end_before_jump",)),
}
# What `simulation.js` calls a kernel of something that happens, and its name in `kernel_calls`.
_CALLS: Final = {
    "events": {"forget": "FORGET", "note": "NOTE", "watch": "WATCH", "rewindEvents": "REWIND_EVENTS"},
    "samples": {"rewindSamples": "REWIND_SAMPLES"},
    "jumps": {"bound": "BOUND"},
    "modes": {"forgetRows": "FORGET_ROWS", "rewindModes": "REWIND_MODES", "forgetModes": "FORGET_MODES"},
}
# What `simulation.js` calls a function, and its name in the program.
_ENTRIES: Final = {
    "motion": RIGHT_HAND_SIDE, "view": "view", "projection": PROJECTION, "assembly": "assembly",
    "events": EVENTS, "actions": ACTIONS, "samples": SAMPLES, "strike": STRIKE, "deciding": DECIDING,
    "fitting": FITTING, "turn": TURN, "derivatives": DERIVATIVES,
}  # fmt: skip
# Records that `simulation.js` reads, by what it calls the places of each.
_RECORDS: Final[Mapping[str, type[RecordLayout]]] = {
    "run": Run, "numbers": FunctionNumbers, "projection": StateProjection, "assembly": AssemblyProblem,
}  # fmt: skip
_RECORDS_OF_KINDS: Final[Mapping[str, Mapping[str, type[RecordLayout]]]] = {
    "events": {"monitor": EventMonitor},
    "samples": {"held": SampleHold},
    "jumps": {"jumps": RateJumps, "strike": StrikeProblem},
    "modes": {"modes": ModeSwitch},
}
_CODES: Final = (
    "RUNNING", "FULL", "FINISHED", "COLLAPSED", "NOT_FINITE", "SINGULAR", "TOO_MANY", "STIFF",
    "NO_EVENT_ROOM", "STOPPED", "CHATTERING", "EVENT_FAULT", "NO_SAMPLE_ROOM", "SAMPLE_FAULT", "SPOILED",
    "UNMET", "TORN_MOTION", "NO_IMPULSE", "NO_MODE_ROOM", "MODE_FAULT", "UNDECIDED", "UNMOVABLE", "TOO_LONG",
)  # fmt: skip
_HAPPENED: Final = 64  # room for what happens, at first


@dataclass(frozen=True, slots=True)
class PageView:
    """How the poses of bodies are computed, and how strongly a pointer pulls them.

    Attributes
    ----------
    outputs : tuple of str
        Positions of all bodies from those that each is placed from, then all rotation matrices.
    parents, order : tuple of int
        Of each body another one, or -1 for ground; the bodies, each after its parent.
    mass : float
        Of all bodies [kg]: no point is taken as heavier.
    frequency : float
        Of a held point on its spring [rad/s].
    """

    outputs: tuple[str, ...]
    parents: tuple[int, ...]
    order: tuple[int, ...]
    mass: float
    frequency: float


@dataclass(frozen=True, slots=True)
class SimulationText:
    """A simulation as JavaScript that defines ``makeSimulation()``.

    Attributes
    ----------
    body : str
        Declarations, for a scope of their own.
    motion : PosedMotion
        What is simulated.
    """

    body: str
    motion: PosedMotion

    @property
    def module(self) -> str:
        """The text as an ES module."""
        return f"{self.body}\nexport {{ makeSimulation }};\n"

    @property
    def script(self) -> str:
        """The text as a script of a page, which sets ``symbodySimulation``."""
        return f"(() => {{\n{self.body}\nglobalThis.symbodySimulation = makeSimulation;\n}})();\n"


def javascript_simulation(eqs: EquationSet, request: MotionRequest, view: PageView) -> SimulationText:
    """Return a simulation as JavaScript.

    Raises UsageError if the request needs Python or an implicit integrator; see `MotionRequest`.
    """
    posed = pose_motion(eqs, request, check_request(eqs, request))
    check_branch(posed)
    motion = with_modes(posed)
    functions = motion_functions(motion)
    functions["view"] = program_function(motion, (*view.outputs, *_ENERGIES), "view")
    close = closing_of(motion.eqs, holds=True)
    if close.is_needed:
        functions["assembly"] = program_function(motion, close.outputs, "assembly", close.eqs)
    block = motion_block(motion, functions)
    Run(block).room.keep_dense, Run(block).room.steps = 1.0, 1
    happens = make_happenings(motion, block, implicit_array(motion, functions), functions.get("assembly"))
    if happens.steps:
        Run(block).room.steps = happens.steps
    functions |= happens.functions
    kernels = dict(happens.kernels)
    if "events" in happens.kinds:
        kernels |= happens.loop_kernels("watch_anew")
    for file, roots in (*_KERNELS, *(_ANEW[kind] for kind in sorted(happens.kinds) if kind in _ANEW)):
        kernels |= read_kernels(file, *roots)
    kernels = without_unused(kernels)
    for function in functions.values():
        kernels |= function.kernels
    numbers = _numbers(motion, functions, view, happens)
    numbers |= {"block": block, **_happening_numbers(happens)}
    parts = [
        '"use strict";', kernel_text(kernels, JAVASCRIPT), _table(functions), _calls(happens, functions),
        f"const numbers = {_literal(numbers)};", _driver(),
    ]  # fmt: skip
    return SimulationText("\n".join(parts), motion)


def _driver() -> str:
    return (files(__package__) / "simulation.js").read_text(encoding="utf-8")


def _table(functions: Mapping[str, ProgramFunction]) -> str:
    """Return the functions by the names of `simulation.js`, null where there is none."""
    entries = []
    for entry, name in _ENTRIES.items():
        function = functions.get(name)
        values = function.values if function else ""
        work = function.values_size if function else 0
        entries.append(f"{entry}: {f'{PREFIX}{name}' if function else 'null'}")
        entries.append(
            f"{entry}Values: {f'{{ call: {PREFIX}{values}, work: {work} }}' if values else 'null'}"
        )
    return f"const functions = {{ {', '.join(entries)} }};"


def _calls(happens: Happenings, functions: Mapping[str, ProgramFunction]) -> str:
    """Return what `simulation.js` calls of kernels, with the arrays of a motion."""
    projection = PROJECTION if PROJECTION in functions else RIGHT_HAND_SIDE
    made = kernel_calls(happens, projection, "assembly", "m.{}, 0", 1)
    entries = {"begin": "BEGIN", "advance": "ADVANCE"}
    for kind in sorted(happens.kinds):
        entries |= _CALLS[kind]
    lines = [f"{name}: (m, time) => {made[call]}," for name, call in entries.items()]
    return "const kernels = {\n    " + "\n    ".join(lines) + "\n};"


def _happening_numbers(happens: Happenings) -> dict[str, Any]:
    """Return the data of what happens on the way, null where nothing of a kind does."""
    found: dict[str, Any] = {name: array if array.size else None for name, array in happens.arrays.items()}
    found["events"] = list(happens.labels)
    found["eventCount"] = len(happens.events)
    found["happenedRoom"] = _HAPPENED + ZEROS_PER_EVENT * len(happens.labels)
    return found


def _numbers(
    motion: PosedMotion, functions: Mapping[str, ProgramFunction], view: PageView, happens: Happenings
) -> dict[str, Any]:
    names = motion.input_names
    wrench = motion.wrench
    pull = None
    if wrench is not None:
        pull = {
            "wrench": [names.index(name) for name in wrench.components],
            "weights": [names.index(name) for name in wrench.weights],
            "mass": view.mass, "frequency": view.frequency, "interval": _PULL_INTERVAL,
        }  # fmt: skip
    records = dict(_RECORDS)
    for kind in sorted(happens.kinds):
        records |= _RECORDS_OF_KINDS[kind]
    if happens.implicit.size:
        records["implicit"] = ImplicitStep
    driver = _driver()
    places = {
        key: {name: place for name, place in record.layout.items() if name in driver}
        for key, record in records.items()
    }
    first_step = method_bounds(motion.method, motion.breakpoints)[1] or 0.0
    return {
        "at": places,
        "codes": {name: getattr(codes, name) for name in _CODES},
        "assembly": closing_numbers(motion, functions["assembly"]) if "assembly" in functions else None,
        "view": {
            "numbers": functions["view"].array,
            "size": functions["view"].size,
            "parents": list(view.parents), "order": list(view.order), "energies": 12 * len(view.parents),
        },
        "parameters": {"names": list(motion.request.tunable), "values": list(motion.tunable_values)},
        "inputs": {"names": list(names)},
        "states": list(motion.eqs.state_names),
        "start": motion.integration.x0, "startTime": motion.span[0],
        "isFixed": motion.has_one_length, "firstStep": first_step,
        "closed": residual_share(motion.projection, motion.request.atol), "pull": pull,
    }  # fmt: skip


def _literal(value: Any) -> str:
    """Return data as JavaScript in which nothing ends or begins an element of a page."""
    if isinstance(value, np.ndarray):
        return _literal(value.tolist())
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_literal(key)}: {_literal(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ",".join(_literal(each) for each in value) + "]"
    if isinstance(value, float) and not isinstance(value, bool):
        if math.isnan(value):
            return "NaN"
        if math.isinf(value):
            return "Infinity" if value > 0 else "-Infinity"
        return repr(int(value)) if value.is_integer() and abs(value) < 2**53 and value else repr(value)
    return json.dumps(value).replace("<", "\\u003c").replace("\u2028", "\\u2028")
