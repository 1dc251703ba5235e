"""Steps in the compiled loop: one call of machine code for each, and what it needs from time to time."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.codegen.kernel_call import kernel_call
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.codegen.llvm.native import NativeFunction
from symbody.equations.outputs.output_roots import OF_STEPS
from symbody.kernels import block as at
from symbody.kernels import stepping
from symbody.kernels.block import Run
from symbody.simulation.events.event_functions import EventFunctions, gap_events
from symbody.simulation.events.events import Occurrence
from symbody.simulation.inputs.breakpoints import Breakpoints
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.inputs.time_functions import function_of_time
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.motion import StateProjector
from symbody.simulation.native.blocks import NO_GAPS, make_block
from symbody.simulation.native.description import Projector, RightHandSide
from symbody.simulation.native.run import VERDICTS, RawRun, Statistics
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.step_problem import WINDOW, StepProblem

Floats = NDArray[np.float64]

_POINTER: Final = ctypes.c_void_p
_STEP: Final = ctypes.CFUNCTYPE(ctypes.c_int64, *[_POINTER] * 5, ctypes.c_int64)
# Operations during which the interpreter's lock may be kept: about a millisecond.
_LOCKED: Final = 1_000_000
# Steps of the integrator between two looks at Ctrl-C.
_SLICE: Final = 1000
# Numbers that change from step to step: a run's own ones and its counts; with them go the vectors of
# `_kept_vectors`. What its other records hold follows from the goal and from when a block was made.
KEPT: Final = np.array(
    [
        place
        for name, place in Run.layout.items()
        if (name in Run.fields and Run.fields[name].pointer is None) or name.startswith("counts.")
    ]
)


class StepKernel(NamedTuple):
    """Where the kernel lies, and a function that releases the interpreter's lock while it runs."""

    address: int
    unlocked: Callable[..., int]


@cache
def step_kernel(features: frozenset[str]) -> StepKernel:
    """Return the kernel for motions that have something, "GAPS" or nothing, ready to be called."""
    address = load_kernels("stepping", ("step",), features=features)["step"]
    return StepKernel(address, _STEP(address))


def bound_step(
    kernel: StepKernel, pointers: tuple[int, int, int, int, int], trials: int
) -> Callable[[], int]:
    """Return a function that tries so many steps of the integrator with numbers at these places."""
    quick = kernel_call(kernel.address, pointers, trials)

    def call_slowly() -> int:
        return kernel.unlocked(*pointers, trials)

    return call_slowly if quick is None else quick


@contextmanager
def python_laws(laws: CallbackFunction | None) -> Iterator[None]:
    """Let a loop call laws of inputs; what one of them raised is raised behind the loop."""
    if laws is None:
        yield
        return
    laws.error = None
    with laws.interruptible():
        yield
    if laws.error is not None:
        raise laws.error


class Ending(NamedTuple):
    """How a step ended, and why if not as usual."""

    status: Status
    note: str = ""


class Steps(Protocol):
    """What takes the steps of a stepper.

    Attributes
    ----------
    go_on : callable
        Takes a step, or a part of one; returns `at.FINISHED` where it came to its end.
    occurrences : tuple of Occurrence
        What happened in the last step.
    """

    occurrences: tuple[Occurrence, ...]

    @property
    def motion_problem(self) -> SimulationProblem:
        """The equations that move, with all inputs as they are at present."""
        ...

    @property
    def modes(self) -> dict[str, str]:
        """The modes of joints, ropes and stops in which the last step ended; none where nothing switches."""
        ...

    def at_present(self) -> AbstractContextManager[None]:
        """Let the modes be those of the present state and inputs, while outputs are computed."""
        ...

    @property
    def go_on(self) -> Callable[[], int]:
        """See above."""
        ...

    def check(self) -> None:
        """Refuse a step that must not be taken, before anything moves."""
        ...

    def restart(self, initial: Mapping[str, Value]) -> None:
        """Begin anew from the numbers of the stepper; other values of before samples are among `initial`."""
        ...

    def end(self, code: int) -> Ending:
        """Bring a step to its end after another code; return how it ended."""
        ...

    def snapshot(self) -> Floats:
        """Return the numbers beside those of the stepper on which further steps depend."""
        ...

    def resume(self, kept: Floats) -> None:
        """Go on from numbers that `snapshot` returned."""
        ...

    def follow(self, others: Steps) -> None:
        """Go on from what others computed with other values of parameters."""
        ...

    def copy(self, problem: StepProblem, numbers: StepNumbers) -> Steps:
        """Return what goes on from here with other numbers."""
        ...

    def rebind(self) -> None:
        """Go on with the same numbers of the stepper, which lie in another array now."""
        ...


class CompiledSteps:
    """Steps of an explicit method in the compiled loop.

    Parameters
    ----------
    problem : StepProblem
        What moves.
    numbers : StepNumbers
        Time, state and inputs, which are renewed by every step.
    moving : SimulationProblem, optional
        The equations that move, where more than these inputs changes on the way.
    """

    def __init__(
        self, problem: StepProblem, numbers: StepNumbers, moving: SimulationProblem | None = None
    ) -> None:
        self.occurrences: tuple[Occurrence, ...] = ()
        self.motion_problem = problem.problem if moving is None else moving
        self._problem = problem
        self._numbers = numbers
        laws = self.motion_problem.laws
        self._function: CompiledFunction = self.motion_problem.compile_outputs(OF_STEPS)
        self._closing = self._projection()
        self._gaps = self._watched_gaps()
        self._laws = CallbackFunction(self._function, laws) if laws.need_python else None
        numbers.array[stepping.INPUTS] = 0.0 if laws.need_python else numbers.inputs.size
        numbers.array[stepping.DERIVED] = 0.0
        self._window = self._window_end = numbers.t
        self._open_window(numbers.t)
        self._block = self._new_block()
        self._call = self._bind()
        self.go_on: Callable[[], int] = self._way()

    @property
    def modes(self) -> dict[str, str]:
        """No modes: nothing switches."""
        return {}

    def at_present(self) -> AbstractContextManager[None]:
        """Do nothing: there are no modes."""
        return nullcontext()

    def end(self, code: int) -> Ending:
        """Bring a step to its end after another code than `FINISHED`; return how it ended."""
        while code == at.RUNNING:
            code = self._run_unlocked()
        status = VERDICTS[code]
        return Ending(status, "" if status.success else self._raw(status).stop_note(self._state_names))

    def restart(self, initial: Mapping[str, Value]) -> None:
        """Begin anew from time and state at present."""
        self.occurrences = ()
        self._open_window(self._numbers.t)
        self._numbers.array[stepping.DERIVED] = 0.0
        self._use_block(self._new_block())

    def snapshot(self) -> Floats:
        """Return the numbers of the block that change, its vectors, and where its window begins and ends."""
        block = self._block
        return np.concatenate([[self._window, self._window_end], block[KEPT], *self._kept_vectors(block)])

    def resume(self, kept: Floats) -> None:
        """Go on from numbers that `snapshot` returned."""
        if kept[0] != self._window or kept[1] != self._window_end:
            self._window, self._window_end = float(kept[0]), float(kept[1])
            self._renew_block(self._new_block(), kept[2:])
        else:
            self._set_kept(self._block, kept[2:])

    def copy(self, problem: StepProblem, numbers: StepNumbers) -> CompiledSteps:
        """Return steps that go on from here with other numbers."""
        made = type(self)(problem, numbers)
        made.resume(self.snapshot())
        numbers.array[:] = self._numbers.array
        return made

    def rebind(self) -> None:
        """Go on with the numbers where they lie now."""
        self._use_block(self._block)

    def follow(self, others: Steps) -> None:
        """Go on with the step lengths of others, which computed with other values of parameters."""
        if isinstance(others, CompiledSteps):
            self._block[KEPT] = others._block[KEPT]

    @property
    def _state_names(self) -> tuple[str, ...]:
        return (*self._problem.settings.eqs.state_names, "work")

    def _projection(self) -> StateProjector | None:
        settings, numbers = self._problem.settings, self._numbers
        projection = settings.projection
        if projection is None:
            return None
        span = (numbers.t, numbers.t + settings.dt)
        return self._problem.integration(numbers.x, span, self.motion_problem).projection(projection)

    def _watched_gaps(self) -> EventFunctions | None:
        """Return what computes the gaps over which no step may pass; None without any."""
        gaps = gap_events(self.motion_problem, self._problem.settings.method)
        return EventFunctions(self.motion_problem, gaps, 0.0) if gaps else None

    def _way(self) -> Callable[[], int]:
        """Return the shortest way to take a step."""
        if self._laws is not None:
            return self._go_on_with_laws
        if self._problem.settings.bounded_tables:
            return self._go_on_with_tables
        if self._depends_on_time:
            return self._go_on_in_window
        return self._call

    @property
    def _depends_on_time(self) -> bool:
        """Whether steps have to be bounded by what happens at certain times."""
        functions = function_of_time(self._function, self.motion_problem.laws.tables)
        return functions is not None and bool(functions.moves.any())

    def _go_on_in_window(self) -> int:
        """Take a step, and before it look ahead where nobody has looked yet."""
        self._look_ahead()
        return self._call()

    def _go_on_with_tables(self) -> int:
        """Take a step whose inputs are tables, which it may not leave."""
        self.check()
        if self._depends_on_time:
            self._look_ahead()
        return self._call()

    def check(self) -> None:
        """Refuse a step that leaves a table which must not be left."""
        self._problem.check_tables(self._numbers)

    def _look_ahead(self) -> None:
        array = self._numbers.array
        # Half a step more: a jump at the very end of what is looked at is none.
        if array[stepping.NOW] + 1.5 * array[stepping.DURATION] > self._window_end:
            kept = self.snapshot()
            self._open_window(self._numbers.t)
            self._renew_block(self._new_block(), kept[2:])

    def _go_on_with_laws(self) -> int:
        """Take a step whose inputs are computed by functions of Python."""
        laws, array = self._laws, self._numbers.array
        assert laws is not None
        self.check()
        if not array[stepping.UNDER_WAY]:
            array[stepping.DERIVED] = 0.0
        with python_laws(laws):
            code = self._go_on_in_window()
            while code == at.RUNNING and laws.error is None:
                code = self._run_unlocked()
        return code

    def _open_window(self, t: float) -> None:
        """Set from when to when the next block looks at what depends on time."""
        step = max(self._problem.settings.dt, self._numbers.array.item(stepping.DURATION))
        self._window, self._window_end = t, t + WINDOW * step

    def _breakpoints(self) -> Breakpoints:
        settings = self._problem.settings
        window = self._window, self._window_end
        pieces = self._problem.integration(self._numbers.x, window, self.motion_problem).breakpoints
        return pieces.jumps_alone() if isinstance(settings.method, FixedStep) else pieces

    def _new_block(self) -> Floats:
        """Return the block of a motion from time and state at present."""
        numbers, method = self._numbers, self._problem.settings.method
        rhs = self.right_hand_side
        settings, span = self._problem.settings, (self._window, self._window_end)
        goal = make_goal(
            span, settings.rtol, np.array(self._problem.tolerances), method.max_step, self._breakpoints()
        )
        goal = goal._replace(max_trials=settings.max_steps)
        first = 0.0 if method.first_step is None else float(method.first_step)
        gaps = NO_GAPS
        if self._gaps is not None:
            rows = 4 + len(method.tableau.dense)
            gaps = self._gaps.make_gap_block(self._problem.settings.dt, rows)
        return make_block(rhs, self._projector, method.tableau, goal, numbers.x, numbers.t, first, gaps)

    @property
    def right_hand_side(self) -> RightHandSide:
        """The function that is integrated, with the parameters of this motion."""
        laws = self.motion_problem.laws
        return RightHandSide(
            self._right_hand_side, len(self._problem.settings.eqs.speed_names), laws.held_now(), np.zeros(0),
            self._function.constants(), self._function.work_size, laws.table_numbers(),
        )  # fmt: skip

    @property
    def lane_function(self) -> NativeFunction:
        """The same function for many motions side by side."""
        return self._function.in_lanes()

    @property
    def features(self) -> frozenset[str]:
        """What steps have, see `symbody.kernels.features`."""
        return frozenset() if self._gaps is None else frozenset(("GAPS",))

    @property
    def gap_function(self) -> int:
        """The address of what computes gaps; that of any function where there are none."""
        return self._right_hand_side if self._gaps is None else self._gaps.addresses[0]

    @property
    def code(self) -> tuple[int, ...]:
        """The addresses of all functions: what steps side by side have in common."""
        return self._right_hand_side, self.projects_by, self.gap_function

    @property
    def projects_by(self) -> int:
        """The address of what projects, 0 for none."""
        return self._projector.address

    @property
    def calls_python(self) -> bool:
        """Whether each step passes through Python."""
        return self._laws is not None

    @property
    def reads_time(self) -> bool:
        """Whether what depends on time has to be looked at before steps."""
        return self._depends_on_time

    @property
    def window_end(self) -> float:
        """Until when what depends on time has been looked at [s]."""
        return self._window_end

    @property
    def block(self) -> Floats:
        """The block of the motion."""
        return self._block

    def move_to(self, room: Floats) -> None:
        """Keep the block in the first part of an array from now on."""
        room[: self._block.size] = self._block
        self._use_block(room[: self._block.size])

    def look_ahead(self) -> None:
        """Look ahead for the next step where nobody has looked yet."""
        if self._depends_on_time:
            self._look_ahead()

    def _renew_block(self, block: Floats, kept: Floats) -> None:
        """Go on with another block of the same motion."""
        self._set_kept(block, kept)
        self._use_block(block)

    def _use_block(self, block: Floats) -> None:
        self._block = block
        self._call = self._bind()
        self.go_on = self._way()

    def _set_kept(self, block: Floats, kept: Floats) -> None:
        block[KEPT] = kept[: KEPT.size]
        place = KEPT.size
        for vector in self._kept_vectors(block):
            vector[:] = kept[place : place + vector.size]
            place += vector.size

    def _kept_vectors(self, block: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return views: the states at both ends of the last step, the derivative behind it, its inputs."""
        run = Run(block)
        arrays = (run.state_old, run.state_new, run.slopes, run.numbers.inputs)
        old, new, slopes, inputs = map(np.asarray, arrays)
        return old, new, slopes[: run.states], inputs[: self._numbers.inputs.size]

    @property
    def _right_hand_side(self) -> int:
        return self._function.address if self._laws is None else self._laws.address

    @property
    def _projector(self) -> Projector:
        if self._closing is None:
            return NOTHING_TO_PROJECT
        projector = self._closing.projector
        if isinstance(self._problem.settings.method, FixedStep):
            return projector._replace(limit=math.inf)
        return projector

    @property
    def _pointers(self) -> tuple[int, int, int, int, int]:
        functions = self._right_hand_side, self._projector.address, self.gap_function
        return *functions, address(self._block), address(self._numbers.array)

    def _bind(self) -> Callable[[], int]:
        stages = Run(self._block).method.stages
        trials = max(1, _LOCKED // (stages * max(1, self._function.operations)))
        return bound_step(step_kernel(self.features), self._pointers, trials)

    def _run_unlocked(self) -> int:
        """Go on with a long step, in slices between which Python sees Ctrl-C and other threads run."""
        return step_kernel(self.features).unlocked(*self._pointers, _SLICE)

    def _raw(self, status: Status) -> RawRun:
        """Return the step as a run that ended early."""
        block, numbers = self._block, self._numbers
        own = Run(block).counts
        counts = Statistics(int(own.accepted), int(own.rejected), int(own.evaluations), 0.0)
        blamed = status in (Status.STEP_COLLAPSE, Status.NOT_FINITE)
        return RawRun(
            np.array([numbers.t]), numbers.x[:, np.newaxis].copy(), status, counts, numbers.t,
            own.blamed_state if blamed else None,
            own.failed_kernel - 1 if status is Status.SINGULAR else None,
            None,
        )  # fmt: skip
