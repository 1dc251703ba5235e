"""What a program of a simulation is to compute, checked: nothing in it may need Python while it runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import assemble
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.model.model import resolve_parameters
from symbody.simulation.hybrid.switching import switches
from symbody.simulation.inputs.breakpoints import Breakpoints
from symbody.simulation.inputs.input_laws import InputLaws, Law, input_laws
from symbody.simulation.methods.change_point import is_change_point
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration_problem import IntegrationProblem
from symbody.simulation.methods.overconstrained import is_overconstrained
from symbody.simulation.programs.pointer_wrench import PointerWrench, add_pointer_wrench
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]

# Ends of the motion that are tried [s]: what depends on time is cut into at most so many pieces up to there.
_LAST: Final = (3600.0, 600.0, 60.0)
_MOST_PIECES: Final = 2000


@dataclass(frozen=True, slots=True)
class MotionRequest:
    """A motion, and what may be changed while it runs.

    Attributes
    ----------
    initial, parameters, inputs : mappings
        As `simulate` takes them.
    tunable : tuple of str
        Parameters that may change.
    free_inputs : tuple of str
        Inputs that have a value of their own instead of a law, 0 at first.
    integrator : Explicit or FixedStep, optional
    constraints : Projection or Baumgarte, optional
    rtol, atol : float
        As `simulate` takes them.
    span : (float, float)
        The first time, and the end of the motion whose scales the tolerances follow [s].
    last : float, optional
        Where the motion ends at the latest [s]; by default after an hour, or less where inputs change often.
    is_pulled : bool
        Whether a pointer may pull bodies.
    """

    initial: Mapping[str, Value] = field(default_factory=dict)
    parameters: Mapping[str, Value] = field(default_factory=dict)
    inputs: Mapping[str, Law] = field(default_factory=dict)
    tunable: tuple[str, ...] = ()
    free_inputs: tuple[str, ...] = ()
    integrator: Any = None
    constraints: Any = None
    rtol: float = 1e-8
    atol: float | None = None
    span: tuple[float, float] = (0.0, 10.0)
    last: float | None = None
    is_pulled: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class PosedMotion:
    """A motion ready to be written as a program.

    Attributes
    ----------
    integration : IntegrationProblem
        With the equations that the pointer pulls, and inputs that are free at 0.
    stabilized : EquationSet
        The equations that are integrated.
    wrench : PointerWrench or None
        Inputs of the pointer.
    first : State
        Where it starts.
    formulas : mapping of input to formula
        Laws of the inputs that are not arguments.
    """

    request: MotionRequest
    integration: IntegrationProblem
    stabilized: EquationSet
    wrench: PointerWrench | None
    first: State
    formulas: Mapping[str, Value]
    last: float
    breakpoints: Breakpoints

    @property
    def tunable(self) -> tuple[str, ...]:
        """Parameters that are arguments."""
        return self.request.tunable

    @property
    def tunable_values(self) -> tuple[float, ...]:
        """Their values at first."""
        values = resolve_parameters(self.stabilized.model, self.request.parameters)
        return tuple(float(values[name]) for name in self.tunable)

    @property
    def fixed_values(self) -> dict[str, Value]:
        """Values given for other parameters."""
        return {name: value for name, value in self.request.parameters.items() if name not in self.tunable}

    @property
    def input_names(self) -> tuple[str, ...]:
        """Inputs that are arguments, in order."""
        return tuple(name for name in self.stabilized.input_names if name not in self.formulas)

    @property
    def span(self) -> tuple[float, float]:
        """As requested."""
        return self.request.span

    @property
    def method(self) -> Explicit | FixedStep:
        """The integrator."""
        chosen = self.request.integrator
        return chosen if isinstance(chosen, Explicit | FixedStep) else Explicit()

    @property
    def projection(self) -> Projection:
        """How states are projected, if they are."""
        chosen = self.request.constraints
        return chosen if isinstance(chosen, Projection) else Projection()

    @property
    def is_closed(self) -> bool:
        """Whether states fulfil constraints."""
        return self.integration.problem.is_closed

    @property
    def is_projected(self) -> bool:
        """Whether states are projected after steps."""
        return self.is_closed and not isinstance(self.request.constraints, Baumgarte)

    @property
    def x0(self) -> Floats:
        """The first state (u, q), and the work done, 0."""
        return self.integration.x0


def pose_motion(eqs: EquationSet, request: MotionRequest) -> PosedMotion:
    """Return a motion ready to be written as a program.

    Raises
    ------
    UsageError
        If the motion needs Python, an implicit integrator, or equations that change on the way.
    """
    laws = input_laws(eqs.input_names, request.inputs, request.span)
    problems = [*_refusals(request, laws), *_switching_problems(eqs), *_pivot_problems(eqs)]
    if problems:
        raise UsageError(*problems)
    made, wrench = add_pointer_wrench(eqs) if request.is_pulled else (eqs, None)
    laws = input_laws(made.input_names, request.inputs, request.span)
    start = request.span[0]
    first = assemble(made, request.initial, None, request.parameters, laws.formulas, start)
    scales = mechanism_scales(made, dict(request.parameters), None, first.q).fit_span(*request.span)
    constraints = request.constraints
    stabilized = constraints.applied(made) if isinstance(constraints, Baumgarte) else made
    problem = SimulationProblem(stabilized, dict(request.parameters), laws, scales)
    x0 = np.array([*first.u.values(), *first.q.values(), 0.0])
    _check_branch(problem, start, x0[:-1])
    integration = IntegrationProblem(problem, x0, request.span, None, request.rtol, request.atol)
    names = (*request.free_inputs, *(() if wrench is None else wrench.names))
    formulas = {name: law for name, law in laws.formulas.items() if name not in names}
    last, pieces = _breakpoints(problem, request)
    return PosedMotion(request, integration, stabilized, wrench, first, formulas, last, pieces)


def _breakpoints(problem: SimulationProblem, request: MotionRequest) -> tuple[float, Breakpoints]:
    """Return where the motion ends, and the pieces of what depends on time up to there."""
    start = request.span[0]
    ends = _LAST if request.last is None else (request.last,)
    for end in ends:
        pieces = problem.breakpoints((start, max(end, start + end)))
        if len(pieces.longest) <= _MOST_PIECES:
            break
    return max(end, start + end) if request.last is None else end, pieces


def _refusals(request: MotionRequest, laws: InputLaws) -> list[Problem]:
    """Return what in a request cannot run without Python."""
    problems = [
        Problem("animation.live_input", name, f"input {name} is a Python function or a long table",
                "the page computes without Python", "give an expression, such as \"10*sin(t)\", or a slider")
        for name in laws.callbacks
    ]  # fmt: skip
    if not isinstance(request.integrator, Explicit | FixedStep | None):
        problems.append(
            Problem("animation.live_integrator", "integrator", f"{request.integrator!r} runs in no page",
                    "it is implicit", "give sb.Explicit() or sb.FixedStep(1e-3), or leave it out")
        )  # fmt: skip
    if not isinstance(request.constraints, Projection | Baumgarte | None):
        problems.append(
            Problem("animation.live_constraints", "constraints",
                    f"{request.constraints!r} runs in no page", "it needs Python",
                    "give sb.Projection() or sb.Baumgarte(), or leave it out")
        )  # fmt: skip
    return problems


def branch_problem(name: str, what: str) -> Problem:
    """Return what to say about a motion that only `Partition` keeps on its branch."""
    return Problem(
        "animation.live_branch", name, what,
        "a page projects its states, which does not choose the branch there",
        "animate a motion from simulate, which passes them; or start elsewhere, or change a length",
    )  # fmt: skip


def _check_branch(problem: SimulationProblem, t: float, x: Floats) -> None:
    """Refuse a start from which `simulate` would go on by `Partition`."""
    eqs = problem.eqs
    if not eqs.multiplier_names or not eqs.speed_names:
        return
    if is_overconstrained(problem, t, x):
        raise UsageError(
            branch_problem(eqs.model.name, "some constraints follow from others in closed loops only")
        )
    if is_change_point(problem, t, x):
        raise UsageError(
            branch_problem(eqs.model.name, "the start is a change point: constraints become dependent")
        )


def _pivot_problems(eqs: EquationSet) -> list[Problem]:
    if eqs.formed.elimination is None:
        return []
    return [
        Problem("animation.live_pivots", eqs.model.name,
                "dependent speeds are eliminated, which ends where a pivot vanishes",
                "a page does not watch pivots", "form the equations without dependent_speeds")
    ]  # fmt: skip


def _switching_problems(eqs: EquationSet) -> list[Problem]:
    if not switches(eqs.formed):
        return []
    return [
        Problem("animation.live_switching", eqs.model.name, "joints stick, or ropes become slack",
                "the equations change while it moves, which a page cannot do yet",
                "animate a motion from simulate, or give the friction a smooth law")
    ]  # fmt: skip
