"""A whole simulation as JavaScript: equations, integrator, projection, assembly, and numbers.

The text needs nothing else; `SimulationText.module` is an ES module for Node and browsers.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.codegen.texts.javascript_function import HELPERS, function_text
from symbody.equations.equation_set import EquationSet
from symbody.expr.evaluate import evaluate_sequence
from symbody.expr.folding import fold_constants
from symbody.expr.program import written_out
from symbody.kernels import assembly as assembly_block
from symbody.kernels import block
from symbody.model.model import resolve_parameters
from symbody.simulation.methods.constraints import PROJECTED, make_projector, residual_share
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import work_tolerance
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Projector, RightHandSide
from symbody.simulation.programs.motion_request import MotionRequest, PosedMotion, pose_motion

Floats = NDArray[np.float64]

_ASSEMBLED: Final = ("constraints", "position_jacobian", "velocity_residual", "jacobian")
_ENERGIES: Final = ("kinetic_energy", "potential_energy")
_PULL_INTERVAL: Final = 1.0 / 240.0  # seconds between changes of the wrench of a pointer
_KERNELS: Final = (
    ("step_machine", ("begin", "advance")),
    ("dense_output", ("interpolate",)),
    ("projection", ("project",)),
    ("assembly", ("assemble",)),
    ("solve_saddle", ("solve_saddle",)),
)
_PLACES: Final = (
    "TIME", "STEP", "T_NEW", "T_END", "FIRST_STEP", "MAX_STEP", "N", "N_U", "FUNCTION", "PROJECTOR", "METHOD",
    "DENSE_ROWS", "VECTORS", "STATE_OLD", "KERNEL", "STEPS", "SAMPLES", "AFTER_REJECTION", "STIFF_VOTES",
    "OTHER_VOTES", "UNJUDGED", "NEXT_BREAK", "FIRST_BREAK", "ACCEPTED", "REJECTED", "EVALUATIONS", "P_PLACE",
    "C_PLACE", "R_PLACE", "P_FUNCTION", "P_OUT", "P_SCALES", "P_RESIDUALS",
)  # fmt: skip
_CODES: Final = ("RUNNING", "FINISHED", "COLLAPSED", "NOT_FINITE", "SINGULAR", "TOO_MANY", "STIFF")


@dataclass(frozen=True, slots=True)
class ViewOutputs:
    """How the poses of bodies are computed.

    Attributes
    ----------
    outputs : tuple of str
        Positions of all bodies from those that each is placed from, then all rotation matrices.
    parents, order : tuple of int
        Of each body another one, or -1 for ground; the bodies, each after its parent.
    """

    outputs: tuple[str, ...]
    parents: tuple[int, ...]
    order: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class PointerSpring:
    """How strongly a pointer pulls.

    Attributes
    ----------
    mass : float
        Of all bodies [kg]: no point is taken as heavier.
    frequency : float
        Of a held point on its spring [rad/s].
    """

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


@dataclass(frozen=True, slots=True)
class _Function:
    """A function of the program: its text, scratch, numbers c, and the outputs' sizes."""

    text: str
    values_text: str
    values_work: int
    work: int
    constants: Floats
    sizes: tuple[int, ...]


def javascript_simulation(
    eqs: EquationSet, request: MotionRequest, view: ViewOutputs, spring: PointerSpring
) -> SimulationText:
    """Return a simulation as JavaScript.

    Raises
    ------
    UsageError
        If the request needs Python or an implicit integrator; see `MotionRequest`.
    """
    motion = pose_motion(eqs, request)
    functions = {
        "motion": _function(motion, ("xdot", "power"), "motion"),
        "view": _function(motion, (*view.outputs, *_ENERGIES), "view"),
    }
    if motion.is_projected:
        functions["projection"] = _function(motion, PROJECTED, "projection")
    if motion.is_closed:
        functions["assembly"] = _function(motion, _ASSEMBLED, "assembly")
    numbers = _numbers(motion, functions, view, spring)
    kernels: dict[str, Any] = {}
    for file, roots in _KERNELS:
        kernels |= read_kernels(file, *roots)
    driver = (files(__package__) / "simulation.js").read_text(encoding="utf-8")
    parts = [
        '"use strict";', kernel_text(kernels, JAVASCRIPT), HELPERS,
        *(text for f in functions.values() for text in (f.text, f.values_text)),
        _table(functions), f"const numbers = {_literal(numbers)};", driver,
    ]  # fmt: skip
    return SimulationText("\n".join(parts), motion)


def _function(motion: PosedMotion, outputs: Sequence[str], name: str) -> _Function:
    sequence, _ = form_sequence(
        motion.stabilized, tuple(outputs), motion.fixed_values, motion.tunable, motion.formulas
    )
    head, tail = fold_constants(written_out(sequence)).split("p")
    text, work = function_text(tail, f"{name}_f")
    values_text, values_work, constants = "", 0, np.zeros(0)
    if head.output_size:
        values_text, values_work = function_text(head, f"{name}_values")
        parts = evaluate_sequence(head, {"p": list(motion.tunable_values)})
        constants = np.concatenate([np.ravel(np.asarray(part, dtype=np.float64)) for part in parts])
    sizes = tuple(len(output.values) for output in sequence.outputs)
    return _Function(text, values_text, values_work, work, constants, sizes)


def _table(functions: Mapping[str, _Function]) -> str:
    entries = []
    for name in ("motion", "view", "projection", "assembly"):
        function = functions.get(name)
        entries.append(f"{name}: {'null' if function is None else name + '_f'}")
        has_values = function is not None and function.values_text
        values = (
            f"{{ call: {name}_values, work: {function.values_work} }}" if function and has_values else "null"
        )
        entries.append(f"{name}Values: {values}")
    return f"const functions = {{ {', '.join(entries)} }};"


def _numbers(
    motion: PosedMotion, functions: Mapping[str, _Function], view: ViewOutputs, spring: PointerSpring
) -> dict[str, Any]:
    """Return the data of a program."""
    names = motion.input_names
    wrench = motion.wrench
    pull = None
    if wrench is not None:
        pull = {
            "wrench": [names.index(name) for name in wrench.components],
            "weights": [names.index(name) for name in wrench.weights],
            "mass": spring.mass, "frequency": spring.frequency, "interval": _PULL_INTERVAL,
        }  # fmt: skip
    places = {name: getattr(block, name) for name in _PLACES}
    places |= {"ASSEMBLY_HELD": assembly_block.HELD, "ASSEMBLY_NUMBERS": assembly_block.NUMBERS}
    first_step = motion.method.first_step or 0.0
    return {
        "at": places,
        "codes": {name: getattr(block, name) for name in _CODES},
        "block": _block(motion, functions),
        "assembly": _assembly(motion, functions["assembly"]) if "assembly" in functions else None,
        "view": {
            "numbers": _call_numbers(motion, functions["view"]),
            "size": sum(functions["view"].sizes),
            "parents": list(view.parents), "order": list(view.order), "energies": 12 * len(view.parents),
        },
        "parameters": {"names": list(motion.tunable), "values": list(motion.tunable_values)},
        "inputs": {"names": list(names)},
        "states": list(motion.stabilized.state_names),
        "start": motion.x0, "startTime": motion.span[0],
        "isFixed": isinstance(motion.method, FixedStep), "firstStep": first_step,
        "closed": residual_share(motion.projection, motion.request.atol), "pull": pull,
    }  # fmt: skip


def _right_hand_side(motion: PosedMotion, function: _Function) -> RightHandSide:
    inputs, values = np.zeros(len(motion.input_names)), np.array(motion.tunable_values, dtype=np.float64)
    n_u = len(motion.stabilized.speed_names)
    return RightHandSide(1, n_u, inputs, values, function.constants, function.work)


def _block(motion: PosedMotion, functions: Mapping[str, _Function]) -> Floats:
    """Return the block of the motion at its first state."""
    integration, method = motion.integration, motion.method
    atol = np.array([*integration.tolerances, work_tolerance(integration)])
    bounds = motion.breakpoints
    goal = make_goal((motion.span[0], motion.last), integration.rtol, atol, method.max_step, bounds)
    goal = goal._replace(max_trials=2**52, stop_when_stiff=False)
    rhs = _right_hand_side(motion, functions["motion"])
    projector = NOTHING_TO_PROJECT
    if motion.is_projected:
        projector = _projector(motion, functions["projection"])
    made = make_block(
        rhs, projector, method.tableau, goal, motion.x0, motion.span[0], method.first_step or 0.0
    )
    made[block.KEEP_DENSE] = made[block.STEP_ROOM] = 1.0
    return made


def _projector(motion: PosedMotion, function: _Function) -> Projector:
    compiled = motion.integration.problem.compile_outputs(PROJECTED, quick=True)
    eqs, scales = motion.stabilized, motion.integration.problem.scales
    made = make_projector(compiled, eqs, scales, motion.projection, motion.request.atol)
    ours = _right_hand_side(motion, function)
    limit = math.inf if isinstance(motion.method, FixedStep) else made.limit
    return made._replace(
        address=1, inputs=ours.inputs, parameters=ours.parameters, constants=ours.constants,
        work_size=ours.work_size, limit=limit,
    )  # fmt: skip


def _call_numbers(motion: PosedMotion, function: _Function) -> Floats:
    """Return the numbers of a function, as a block holds them."""
    rhs = _right_hand_side(motion, function)
    places = block.R_PLACE + np.cumsum([rhs.inputs.size, rhs.parameters.size, rhs.constants.size])
    head = np.zeros(block.R_PLACE)
    head[[block.P_PLACE, block.C_PLACE, block.WORK_PLACE]] = places
    return np.concatenate([head, rhs.inputs, rhs.parameters, rhs.constants, np.zeros(rhs.work_size)])


def _assembly(motion: PosedMotion, function: _Function) -> Floats:
    """Return the block of `symbody.kernels.assembly`."""
    eqs, scales = motion.stabilized, motion.integration.problem.scales
    n_u, n_q = len(eqs.speed_names), len(eqs.coordinate_names)
    count, rows = function.sizes[0], function.sizes[2]
    four = [eqs.coordinate_names.index(name) for names in eqs.quaternions for name in names]
    sizes = np.concatenate([scales.displacements(eqs), scales.coordinates(eqs)])
    at = assembly_block
    matrices = at.matrices_size(max(n_q, n_u))
    parts = [
        np.zeros(at.HEADER), np.zeros(n_u + n_q), sizes, scales.constraints(eqs)[:count],
        np.zeros(sum(function.sizes)), np.zeros(matrices), _call_numbers(motion, function), np.zeros(n_q),
        np.array(four, dtype=np.float64),
    ]  # fmt: skip
    begins = np.cumsum([part.size for part in parts])
    head = parts[0]
    head[[at.SPEEDS, at.COORDINATES, at.RESIDUALS, at.ROWS]] = n_u, n_q, count, rows
    order = (at.HELD, at.SIZES, at.SCALES, at.OUT, at.MATRICES, at.NUMBERS, at.OLD, at.QUATERNION_PLACES)
    head[[*order]] = begins[:-1]
    head[at.QUATERNIONS] = len(eqs.quaternions)
    head[at.OUT_SIZE] = sum(function.sizes)
    # Each residual of a state that was projected is as small as this share; states that are shown stay.
    head[[at.SHARE, at.ENOUGH]] = math.sqrt(max(count, 1)) * residual_share(
        motion.projection, motion.request.atol
    )
    return np.concatenate(parts)


def resolve_values(eqs: EquationSet, given: Mapping[str, Any], names: Iterable[str]) -> tuple[float, ...]:
    """Return the values of some parameters."""
    values = resolve_parameters(eqs.model, given)
    return tuple(float(values[name]) for name in names)


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
