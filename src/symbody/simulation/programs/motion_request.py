"""What a program of a simulation is to compute: nothing in it may need Python while it runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from numpy.typing import ArrayLike

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.equations.solving.modal_equations import ModalEquations, modal_equations
from symbody.errors import Problem, UsageError
from symbody.model.body import Body
from symbody.model.loads.forces import Force, Torque
from symbody.model.model import Model, resolve_parameters
from symbody.simulation.events.event_functions import gap_events, watched_outputs
from symbody.simulation.events.events import Event
from symbody.simulation.hybrid.rate_jumps import jump_parameters
from symbody.simulation.hybrid.switching import loose_modes, mode_ends
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints
from symbody.simulation.inputs.input_laws import InputLaws, Law, input_laws, laws_of_tables
from symbody.simulation.methods.closed_loops.change_point import is_change_point
from symbody.simulation.methods.closed_loops.overconstrained import is_overconstrained
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.motion import Motion, first_numbers
from symbody.simulation.sampling.held_signals import held_signals
from symbody.simulation.sampling.sampler import HeldValue
from symbody.simulation.simulate import pose_problem
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.sweeps.sweep_job import reason_for_python

Method = Explicit | FixedStep | GeneralizedAlpha

# Ends of the motion that are tried [s]: what depends on time is cut into at most so many pieces up to there.
_LAST: Final = (3600.0, 600.0, 60.0)
_MOST_PIECES: Final = 2000
ENDLESS: Final = 2**52  # more steps than any motion takes


@dataclass(frozen=True, slots=True)
class MotionRequest:
    """A motion, and what may be changed while it runs.

    Attributes
    ----------
    initial, guess, parameters, inputs : mappings
        As `simulate` takes them.
    tunable : tuple of str
        Parameters that may change.
    free_inputs : tuple of str
        Inputs that have a value of their own instead of a law, 0 at first.
    integrator : Explicit, FixedStep or GeneralizedAlpha, optional
    constraints : Projection or Baumgarte, optional
    rtol, atol, scales, max_steps
        As `simulate` takes them.
    span : (float, float)
        The first time, and the end of the motion whose scales the tolerances follow [s].
    last : float, optional
        Where the motion ends at the latest [s]; by default after an hour, or less where inputs change often.
    is_pulled : bool
        Whether a pointer may pull bodies.
    times : array, optional
        Samples that are stored.
    events : tuple of Event
        What happens where an expression passes zero.
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
    guess: Mapping[str, Value] | None = None
    scales: Mapping[str, float] | None = None
    max_steps: int = ENDLESS
    times: ArrayLike | None = None
    events: tuple[Event, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class PosedMotion:
    """A motion ready to be written as a program.

    Attributes
    ----------
    integration : Motion
        With the equations that are integrated, which the pointer pulls, and inputs that are free at 0.
    wrench : PointerWrench or None
        Inputs of the pointer.
    first : State
        Where it starts.
    formulas : mapping of input to formula
        Laws of the inputs that are not arguments.
    last : float
        Where it ends [s].
    breakpoints : Breakpoints
        Where what depends on time alone changes; none where steps are all of one length.
    held : tuple of HeldValue
        What is held between samples, by its place in `input_names`.
    modal : ModalEquations, optional
        The equations with the modes of joints, ropes and stops as inputs, which are integrated then.
    modeless : EquationSet, optional
        The same with modes left open.
    """

    request: MotionRequest
    integration: Motion
    wrench: PointerWrench | None
    first: State
    formulas: Mapping[str, Value]
    last: float
    breakpoints: Breakpoints
    held: tuple[HeldValue, ...] = ()
    modal: ModalEquations | None = None
    modeless: EquationSet | None = None

    @property
    def events(self) -> tuple[Event, ...]:
        """What happens where a value passes zero: events, closing gaps, then ends of modes."""
        ends = () if self.modal is None else mode_ends(self.modal)
        return (*self.request.events, *gap_events(self.integration.problem, self.method), *ends)

    @property
    def eqs(self) -> EquationSet:
        """The equations that are integrated."""
        return self.integration.eqs

    @property
    def tunable_values(self) -> tuple[float, ...]:
        """The first values of parameters that are arguments."""
        values = resolve_parameters(self.eqs.model, self.request.parameters)
        return tuple(float(values[name]) for name in self.request.tunable)

    @property
    def fixed_values(self) -> dict[str, Value]:
        """Values given for other parameters."""
        request = self.request
        return {name: value for name, value in request.parameters.items() if name not in request.tunable}

    @property
    def input_names(self) -> tuple[str, ...]:
        """Inputs that are arguments, in order."""
        return tuple(name for name in self.eqs.input_names if name not in self.formulas)

    @property
    def span(self) -> tuple[float, float]:
        """As requested."""
        return self.request.span

    @property
    def method(self) -> Method:
        """The integrator."""
        chosen = self.request.integrator
        return chosen if isinstance(chosen, Method) else Explicit()

    @property
    def has_one_length(self) -> bool:
        """Whether all steps have one length, but those that end at jumps."""
        method = self.method
        return (
            method.step is not None if isinstance(method, GeneralizedAlpha) else isinstance(method, FixedStep)
        )

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


def pose_motion(eqs: EquationSet, request: MotionRequest, laws: InputLaws) -> PosedMotion:
    """Return a motion ready to be written as a program; nothing in it may need Python."""
    made, wrench = add_pointer_wrench(eqs) if request.is_pulled else (eqs, None)
    if wrench is not None:
        laws = input_laws(made.input_names, {**laws_of_tables(eqs), **request.inputs}, request.span)
    start, scales, constraints = request.span[0], request.scales, request.constraints
    held = held_values(eqs, request)
    initial = {name: value for name, value in request.initial.items() if name not in held}
    first = assemble(
        made, initial, request.guess, parameters=request.parameters, inputs=laws.formulas, t=start,
        scales=scales,
    )  # fmt: skip
    problem = pose_problem(made, request.span, request.parameters, laws, scales, constraints, first)
    tolerances = request.rtol, request.atol, request.max_steps
    integration = Motion(problem, first_numbers(first), request.span, request.times, *tolerances)
    names = (*request.free_inputs, *held, *(() if wrench is None else wrench.names))
    formulas = {name: law for name, law in laws.formulas.items() if name not in names}
    last, pieces = _breakpoints(problem, request)
    motion = PosedMotion(request, integration, wrench, first, formulas, last, pieces)
    place = motion.input_names.index
    values = tuple(replace(value, slot=place(name)) for name, value in held.items())
    return replace(motion, held=values)


def with_modes(motion: PosedMotion) -> PosedMotion:
    """Return a motion whose equations have modes as inputs, if joints stick, ropes go slack or stops open."""
    problem = motion.integration.problem
    modal = modal_equations(problem.eqs)
    if not modal.modes:
        return motion
    laws = problem.laws.with_held(loose_modes(modal))
    integration = replace(motion.integration, problem=replace(problem, eqs=modal.eqs, laws=laws))
    return replace(motion, integration=integration, modal=modal, modeless=problem.eqs)


def held_values(eqs: EquationSet, request: MotionRequest) -> dict[str, HeldValue]:
    """Return the sampled signals of a motion by name, but those that are free inputs.

    Raises UsageError if they cannot be sampled: see `held_signals`.
    """
    signals = eqs.model.held_signals if isinstance(eqs.model, Model) else ()
    if all(signal.name in request.free_inputs for signal in signals):
        return {}
    found = held_signals(eqs, request.span, request.parameters, request.initial, request.inputs)
    return {value.name: value for value in found.active.values}


def _breakpoints(problem: SimulationProblem, request: MotionRequest) -> tuple[float, Breakpoints]:
    """Return where the motion ends, and the pieces of what depends on time up to there."""
    start, pieces = request.span[0], NO_BREAKPOINTS
    ends = [start + length for length in _LAST] if request.last is None else [request.last]
    for end in ends:
        pieces = problem.breakpoints((start, end), watched_outputs(request.events))
        if isinstance(request.integrator, FixedStep):
            pieces = pieces.jumps_alone()
        if len(pieces.longest) <= _MOST_PIECES:
            break
    return end, pieces


def check_request(eqs: EquationSet, request: MotionRequest) -> InputLaws:
    """Return the laws of the inputs of a motion that a page computes.

    Raises UsageError if the motion needs Python, an implicit integrator, or equations that change on the way.
    """
    laws = input_laws(eqs.input_names, {**laws_of_tables(eqs), **request.inputs}, request.span)
    inputs = {**request.inputs, **dict.fromkeys(request.free_inputs, 0.0)}
    held_values(eqs, replace(request, inputs=inputs, free_inputs=()))
    problems = _refusals(eqs, request, laws)
    if problems:
        raise UsageError(*problems)
    return laws


def reason_for_program(eqs: EquationSet, laws: InputLaws, integrator: object, constraints: object) -> str:
    """Return why no program computes a motion, empty if one does."""
    explicit = None if isinstance(integrator, GeneralizedAlpha) else integrator
    return reason_for_python(eqs, laws, explicit, constraints)


def _refusals(eqs: EquationSet, request: MotionRequest, laws: InputLaws) -> list[Problem]:
    """Return what a page does not compute, and sliders of parameters that say when something happens."""
    problems = [
        Problem("animation.live_input", name, f"input {name} is a Python function or a long table",
                "pages compute without Python", "give an expression, such as \"10*sin(t)\", or a slider")
        for name in laws.callbacks
    ]  # fmt: skip
    if not isinstance(request.integrator, Method | None):
        problems.append(
            Problem("animation.live_integrator", "integrator", f"{request.integrator!r} cannot run in a page",
                    "it needs Python", "give sb.Explicit(), sb.FixedStep(1e-3) or, for stiff mechanisms, "
                    "sb.GeneralizedAlpha(); or leave it out")
        )  # fmt: skip
    if not isinstance(request.constraints, Projection | Baumgarte | None):
        problems.append(
            Problem("animation.live_constraints", "constraints",
                    f"{request.constraints!r} cannot run in a page", "it needs Python",
                    "give sb.Projection() or sb.Baumgarte(), or leave it out")
        )  # fmt: skip
    if eqs.formed.elimination is not None:
        problems.append(
            Problem("animation.live_pivots", eqs.model.name,
                    "dependent speeds are eliminated, which fails where a pivot vanishes",
                    "a page does not monitor pivots", "form the equations without dependent_speeds")
        )  # fmt: skip
    decisive = {name: "the times at which prescribed rates jump" for name in jump_parameters(eqs)}
    for signal in eqs.model.held_signals if isinstance(eqs.model, Model) and request.tunable else ():
        names = signal.sample.names if signal.sample else ()
        decisive |= dict.fromkeys(names, f"the sample time of {signal.name}")
    return problems + [
        Problem("animation.slider_time", name, f"a slider cannot move {name}: it changes {decisive[name]}",
                "a page computes these times when it is written", "remove the slider")
        for name in request.tunable if name in decisive
    ]  # fmt: skip


def branch_problem(name: str, what: str) -> Problem:
    """Return what to say about a motion that only `Partition` keeps on its branch."""
    return Problem(
        "animation.live_branch", name, what,
        "a page corrects its states by projection, which does not determine the branch there",
        "animate a motion from simulate, which handles change points; or start elsewhere, or change a length",
    )  # fmt: skip


def check_branch(motion: PosedMotion) -> None:
    """Refuse a start from which `simulate` would go on by `Partition`.

    Raises UsageError if constraints are dependent there.
    """
    problem, t, eqs = motion.integration.problem, motion.span[0], motion.eqs
    if not eqs.multiplier_names or not eqs.speed_names:
        return
    x = motion.integration.state[: len(eqs.speed_names) + len(eqs.coordinate_names)]
    what = ""
    if is_overconstrained(problem, t, x):
        what = "some constraints are redundant in closed loops only"
    elif is_change_point(problem, t, x):
        what = "the start is a change point: constraints become dependent"
    if what:
        raise UsageError(branch_problem(eqs.model.name, what))


# A force and a torque on any one body: six inputs, and one for each body that is 1 while it is held.


_COMPONENTS: Final = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
# Of more bodies none can be held: each makes the equations longer.
MOST_BODIES: Final = 40


@dataclass(frozen=True, slots=True)
class PointerWrench:
    """Names of inputs: components of a wrench in ground's axes [N, N m], and weights of the bodies."""

    components: tuple[str, ...]
    weights: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.components, *self.weights)


def add_pointer_wrench(eqs: EquationSet) -> tuple[EquationSet, PointerWrench | None]:
    """Return equations in the same coordinates with a wrench on any body; without it where that cannot be.

    The wrench acts at the origin of a body's axes.
    """
    model = eqs.model
    if not isinstance(model, Model) or len(model.bodies) > MOST_BODIES or not eqs.speed_names:
        return eqs, None
    word = _unused_word(eqs)
    wrench = PointerWrench(
        tuple(f"{word}_{component}" for component in _COMPONENTS),
        tuple(f"{word}_{k}" for k in range(len(model.bodies))),
    )
    loads = [
        load for body, weight in zip(model.bodies, wrench.weights, strict=True)
        for load in _loads(body, weight, wrench.components)
    ]  # fmt: skip
    pulled = Model(
        model.name, [*model.elements, *loads], model.gravity, model.parameters,
        [*model.inputs, *wrench.names], model.initial, model.ground, (), model.ground_shapes,
    )  # fmt: skip
    dependent = eqs.formed.dependent_names
    made = form_equations(
        pulled,
        tree=eqs.formed.topology.trees,
        dependent_speeds=dependent or None,
        substitute=bool(eqs.formed.coupled.rows),
    )
    same = made.state_names == eqs.state_names and len(made.multiplier_names) == len(eqs.multiplier_names)
    return (made, wrench) if same else (eqs, None)


def _loads(body: Body, weight: str, components: tuple[str, ...]) -> tuple[Force, Torque]:
    terms = [f"{weight}*{component}" for component in components]
    return (
        Force(f"{weight} force", on=body.name, vector=terms[:3]),
        Torque(f"{weight} torque", on=body.name, vector=terms[3:]),
    )


def _unused_word(eqs: EquationSet) -> str:
    """Return a word with which no name of the model begins."""
    names = [
        *eqs.parameter_names, *eqs.input_names, *eqs.state_names, *(each.name for each in eqs.model.elements),
        *(name for joint in eqs.model.joints for name in joint.coordinates),
    ]  # fmt: skip
    word = "pointer"
    while any(name.startswith(word) for name in names):
        word += "_"
    return word
