"""Implicit integration of order 2: `GeneralizedAlpha` chooses it, `run_generalized_alpha` runs it.

``docs/derivations/generalized_alpha.md`` derives the method; the loop is `kernels.implicit.implicit_machine`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import checked_fields
from symbody.codegen.function import CompiledFunction
from symbody.equations.outputs.output_roots import OF_STEPS
from symbody.errors import Problem, UsageError
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.inputs.breakpoints import Breakpoints
from symbody.simulation.inputs.input_laws import called_laws
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, make_goal
from symbody.simulation.methods.implicit.state_jacobian import (
    STATE_JACOBIAN,
    drop_idle_rows,
    with_state_jacobian,
)
from symbody.simulation.motion import Motion, StateProjector
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Projector, RightHandSide
from symbody.simulation.native.implicit import (
    METHOD,
    ImplicitFunctions,
    ImplicitPart,
    make_array,
)
from symbody.simulation.native.run import EVENT_SAMPLES, NativeRun, RawRun, fresh_record, run_loop
from symbody.simulation.sampling.sampled_loop import SampledLoop

Floats = NDArray[np.float64]
Notes = tuple[str, ...]

# Steps that see the input at their ends alone are so much shorter than pieces in which it is a polynomial.
_SHARE_OF_PIECE: Final = 0.125


@checked_fields
@dataclass(frozen=True, slots=True)
class GeneralizedAlpha:
    """The implicit method of Chung and Hulbert, of order 2, for stiff motions at moderate accuracy.

    Its steps are as long as accuracy allows, regardless of the highest frequency of the mechanism: elastic
    segments, bushings, stiff contacts. A tolerance ten times as tight takes twice as many steps;
    ``rtol=1e-4`` or 1e-5 suits it. Closed loops are closed after every step.

    Attributes
    ----------
    rho : float
        What remains, after each step, of oscillations that are too fast for the steps: 1 damps nothing,
        0 most; slow motions are damped little.
    step : float, optional
        Length of all steps [s]; by default they follow the local error. Nothing shows whether it was short
        enough; rtol and atol then bound only the residual of the equations of each step.
    max_step : float, optional
        Longest step [s], where `step` is left out.

    Raises
    ------
    UsageError
        `rho` outside 0 to 1, or a step that is not positive.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x",
    ...                     force=sb.Drive(stiffness=100))
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], initial={"x": 0.1}))
    >>> sb.simulate(eqs, 1.0, integrator=sb.GeneralizedAlpha(rho=0.8), rtol=1e-4).success
    True
    """

    rho: float = 0.9
    step: float | None = None
    max_step: float | None = None

    def __post_init__(self) -> None:
        problems = []
        if not 0.0 <= self.rho <= 1.0:
            problems.append(
                Problem("simulation.rho", "rho", f"rho = {self.rho!r} is not between 0 and 1", "",
                        "give 0.9, 1 for no damping, or a smaller value to damp fast oscillations more")
            )  # fmt: skip
        for name, step in (("step", self.step), ("max_step", self.max_step)):
            if step is not None and not (step > 0.0 and math.isfinite(step)):
                problems.append(
                    Problem("simulation.implicit_step", name, f"{name} = {step!r} is not a valid time", "",
                            f"leave {name} out, or give seconds, such as {name}=1e-3")
                )  # fmt: skip
        if problems:
            raise UsageError(*problems)

    @property
    def note(self) -> str:
        """What it does to a motion."""
        if self.rho == 1.0:
            return f"{self.name} is of order 2 and adds no damping"
        return (
            f"{self.name} is of order 2 and adds damping: oscillations that are too fast for its steps "
            f"shrink by a factor of {self.rho:g} per step"
        )

    @property
    def name(self) -> str:
        """How it is written."""
        step = "" if self.step is None else f", step={self.step:g}"
        return f"sb.GeneralizedAlpha(rho={self.rho:g}{step})"


def run_generalized_alpha(
    motion: Motion,
    method: GeneralizedAlpha,
    closing: StateProjector | None,
    watch: EventWatch | None,
    work_tolerance: float,
) -> tuple[RawRun, Notes]:
    """Return the run of the compiled loop, and what to note about it.

    Raises
    ------
    SimulationError
        If the law of an input fails.
    """
    laws = motion.problem.laws
    compiled = _compile_functions(motion)
    with called_laws(compiled, laws) as addresses:
        run = _make_run(motion, method, closing, addresses, compiled, work_tolerance)
        sampler = motion.problem.sampler
        held = None if sampler is None else SampledLoop(motion.problem, sampler)
        run = run._replace(held=held, jumps=motion.passed_jumps(watch))
        record = fresh_record(run, _times(motion), True, 0 if watch is None else EVENT_SAMPLES)
        raw = run_loop(run, record, motion.progress, watch)
    return raw, (method.note,)


def _compile_functions(motion: Motion) -> tuple[CompiledFunction, ...]:
    """Return the slopes with the power, the rates of coordinates, and the derivatives of the slopes."""
    problem = motion.problem
    eqs = drop_idle_rows(motion.eqs, problem.parameters)
    wider = with_state_jacobian(eqs, problem.laws.formulas, problem.laws.callbacks)
    derivatives = replace(problem, eqs=wider).compile_outputs(STATE_JACOBIAN, quick=True)
    return problem.compile_outputs(OF_STEPS), problem.compile_outputs("qdot"), derivatives


def _make_run(
    motion: Motion,
    method: GeneralizedAlpha,
    closing: StateProjector | None,
    addresses: Sequence[int],
    compiled: Sequence[CompiledFunction],
    work_tolerance: float,
) -> NativeRun:
    """Return the run at its start."""
    laws, n_u = motion.problem.laws, motion.n_u
    inputs, tables = laws.held_now(), laws.table_numbers()
    functions = ImplicitFunctions(
        *(
            RightHandSide(place, n_u, inputs, np.zeros(0), function.constants(), function.work_size, tables)
            for place, function in zip(addresses, compiled, strict=True)
        )
    )
    tolerances = np.array([*motion.tolerances, work_tolerance])
    longest = method.max_step if method.step is None else method.step
    bounds = bounds_of_steps(motion.breakpoints, method)
    goal = make_goal(motion.span, motion.rtol, tolerances, longest, bounds)
    goal = goal._replace(max_trials=int(motion.max_steps))
    block = make_block(
        functions.slopes, _projector(closing, method), METHOD, goal, motion.x0, motion.span[0],
        float(method.step or 0.0),
    )  # fmt: skip
    n_q = len(motion.eqs.coordinate_names)
    array = make_array(functions, motion.x0.size, n_q, float(method.rho), one_length=method.step is not None)
    projecting = 0 if closing is None else closing.projector.address
    return NativeRun(functions.slopes.address, projecting, block, implicit=ImplicitPart(functions, array))


def _projector(closing: StateProjector | None, method: GeneralizedAlpha) -> Projector:
    """Return what closes the constraints; steps of one length never become shorter, however far one went."""
    if closing is None:
        return NOTHING_TO_PROJECT
    return closing.projector if method.step is None else closing.projector._replace(limit=math.inf)


def bounds_of_steps(bounds: Breakpoints, method: GeneralizedAlpha) -> Breakpoints:
    """Return what bounds the steps, from what depends on time: those of one length end at jumps alone."""
    if method.step is not None:
        return bounds.jumps_alone()
    return replace(bounds, longest=_SHARE_OF_PIECE * bounds.longest)


def _times(motion: Motion) -> Floats | None:
    return None if motion.times is None else np.asarray(motion.times, dtype=np.float64)
