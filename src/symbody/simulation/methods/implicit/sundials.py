"""CVODE and IDA of SUNDIALS, step by step, through scikit-sundae.

Hindmarsh et al., SUNDIALS: Suite of nonlinear and differential/algebraic equation solvers, ACM Transactions
on Mathematical Software 31 (2005).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial, wraps
from importlib import import_module
from io import StringIO, TextIOBase
from threading import get_ident
from typing import Final, ParamSpec, Protocol, TextIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from symbody.errors import EnvironmentFault, Problem, SimulationError
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.methods.stepping import NODES, SHARES, Failure, Step, StepEnds
from symbody.simulation.status import Status
from symbody.single_flight import fork_safe_lock

Floats = NDArray[np.float64]
Answer = TypeVar("Answer")
P = ParamSpec("P")

# Return flags that the two solvers share. The others cannot come from a right-hand side that never raises.
COLLAPSED: Final = -3
VERDICTS: Final[Mapping[int, Status]] = {
    -1: Status.TOO_MANY_STEPS,
    -2: Status.STEP_COLLAPSE,
    COLLAPSED: Status.STEP_COLLAPSE,
    -4: Status.STEP_COLLAPSE,
    -6: Status.SINGULAR,
    -7: Status.SINGULAR,
}

# What a process prints to is one for all threads: held while it is replaced.
_ROUTING: Final = fork_safe_lock()

# A solver that has to start anew after every step, so many times, does not get on.
PATIENT: Final = 50

# Faults of one evaluation that a shorter step may avoid; others, as of a law that fails, end the run.
MENDABLE: Final[Mapping[str, Status]] = {
    "numerics.singular_mass": Status.SINGULAR,
}


class Result(Protocol):
    """What a call of a solver returns: a flag, negative on failure, the time, and the state there."""

    status: int
    t: float
    y: Floats


class Solver(Protocol):
    """CVODE or IDA."""

    def init_step(self, t0: float, *values: Floats) -> object:
        """Begin at a time with the state, for IDA also with its rate."""
        ...

    def step(self, t: float, method: str, tstop: float | None) -> Result:
        """Take one step ("onestep") towards t, or return the state at t inside the last one ("normal")."""
        ...


class MonitoredFunction:
    """A function of time and state that never raises, and remembers what was wrong with its values.

    Attributes
    ----------
    evaluations : int
        Calls so far.
    fault_of_call : Status or None
        What the last call that had no value means, if there was one since the last accepted step.
    fault : int or None
        The first entry of a value that was not finite since then.
    """

    def __init__(self, function: Callable[[float, Floats], Floats]) -> None:
        self._function = function
        self.evaluations = 0
        self.fault_of_call: Status | None = None
        self.fault: int | None = None

    def __call__(self, t: float, y: Floats) -> Floats:
        """Return the value; all NaN, which makes the solver try a shorter step, if there is none."""
        self.evaluations += 1
        try:
            value = self._function(t, y)
        except SimulationError as error:
            if error.problems[0].code not in MENDABLE:
                raise
            self.fault_of_call = MENDABLE[error.problems[0].code]
            return np.full_like(y, np.nan)
        if not np.isfinite(value).all():
            self.fault = int(np.flatnonzero(~np.isfinite(value))[0])
        return value

    def accept(self) -> None:
        """Forget the faults: a step was found in spite of them."""
        self.fault_of_call, self.fault = None, None

    def failure(self, flag: int) -> Failure:
        """Return what a flag means after these faults."""
        if self.fault_of_call is not None:
            return Failure(self.fault_of_call)
        if self.fault is not None:
            return Failure(Status.NOT_FINITE, self.fault)
        return Failure(VERDICTS.get(flag, Status.STEP_COLLAPSE))


class SundialsStepper:
    """A solver on its way.

    Parameters
    ----------
    begin : callable
        Starts the solver at a time and a state x = (u, q), with everything else that belongs to it.
    settled : callable
        From the end of a step to the state to keep there, and whether the solver has to start anew from it.
    watch : Watch
        What the solver calls.
    ends : StepEnds
        How far steps may lead; behind a jump the solver starts anew.
    solved : callable
        From the end of a step, its length and the states at `SHARES` of it to whether its end solves the
        equations. Where it does not, the solver starts anew from the step's start, with new derivatives.
    """

    def __init__(
        self,
        solver: Solver,
        begin: Callable[[float, Floats], object],
        settled: Callable[[float, Floats], tuple[Floats, bool]],
        watch: MonitoredFunction,
        x0: Floats,
        span: tuple[float, float],
        ends: StepEnds,
        solved: Callable[[float, float, Floats], bool] = lambda t, length, nodes: True,
    ) -> None:
        self._solver, self._begin, self._settled, self._watch = solver, begin, settled, watch
        self._solved, self._in_vain, self._ends = solved, 0, ends
        self._x, (self._t, self._end) = x0, span
        self._is_fresh = True

    @property
    def evaluations(self) -> int:
        """How often the equations were evaluated."""
        return self._watch.evaluations

    def advance(self, end: float) -> Step | Failure:
        """Take one step, not beyond an end; the state inside it is the solver's own polynomial."""
        self._end = end
        begin, stop, said = self._ends(self._t, end)
        self._is_fresh |= begin != self._t
        was_fresh = self._is_fresh
        step = self._try_step()
        if isinstance(step, Step) and not was_fresh:
            step = self._check_step(step)
        if isinstance(step, Failure):
            return step
        nodes = step.nodes
        nodes[-1], self._is_fresh = self._settled(step.t, nodes[-1])
        is_there = abs(step.t - stop) <= 0.5 * abs(said - stop)  # but for the solver's rounding
        self._x, self._t = nodes[-1], said if is_there else step.t
        self._watch.accept()
        return Step(self._t, nodes)

    def _check_step(self, found: Step) -> Step | Failure:
        """Return a step that solves its equations, or the first one of a new start in its place."""
        if self._solved(found.t, found.t - self._t, found.nodes):
            self._in_vain = 0
            return found
        if self._in_vain == PATIENT:
            return self._watch.failure(COLLAPSED)
        self._in_vain, self._is_fresh = self._in_vain + 1, True
        return self._try_step()

    def _try_step(self) -> Step | Failure:
        """Take one step and return it as the solver found it."""
        begin, stop, _ = self._ends(self._t, self._end)
        if self._is_fresh:
            call_quietly(partial(self._begin, begin, self._x))
            self._is_fresh = False
        try:
            result = self._call_solver(self._end, "onestep", stop)
        except KeyError:  # a flag that scikit-sundae has no words for
            return self._watch.failure(COLLAPSED)
        if result.status < 0:
            return self._watch.failure(result.status)
        n, length = self._x.size, result.t - begin
        if abs(length) <= 10.0 * EPSILON * abs(self._t) and result.t != self._end:
            return self._watch.failure(COLLAPSED)
        nodes = np.empty((NODES, n))
        nodes[0] = self._x
        for k in range(1, NODES - 1):
            nodes[k] = self._call_solver(begin + SHARES[k] * length, "normal", None).y[:n]
        # asking for the end last lets the next step start: the solver returns to it otherwise
        nodes[-1] = self._call_solver(result.t, "normal", None).y[:n]
        return Step(result.t, nodes)

    def restart(self, t: float, x: Floats) -> None:
        """Go on from another state."""
        self._t, self._x, self._is_fresh = t, x, True

    def _call_solver(self, t: float, method: str, stop: float | None) -> Result:
        return call_quietly(partial(self._solver.step, t, method, stop))


def call_quietly(function: Callable[[], Answer]) -> Answer:
    """Return what a function of scikit-sundae returns; it prints nothing and raises only what we do.

    Raises
    ------
    SimulationError
        With what it printed, if it fails otherwise than by a flag.
    """
    printed = None
    try:
        with _keep_prints() as printed:
            return function()
    except (RuntimeError, ValueError, TypeError) as error:
        why = printed.getvalue().strip() if printed else ""
        raise SimulationError(
            Problem("simulation.sundials", "integrator", f"SUNDIALS cannot start: {error}", why,
                    "check rtol, atol, max_order and max_step, or use sb.Explicit()")
        ) from error  # fmt: skip


def print_as_usual(function: Callable[P, Answer]) -> Callable[P, Answer]:
    """Return a function that a solver calls: what it prints, as laws of users may, goes where it belongs."""

    @wraps(function)
    def call(*arguments: P.args, **named: P.kwargs) -> Answer:
        router, thread = sys.stdout, get_ident()
        printed = router.kept.pop(thread, None) if isinstance(router, _Router) else None
        try:
            return function(*arguments, **named)
        finally:
            if isinstance(router, _Router) and printed is not None:
                router.kept[thread] = printed

    return call


@contextmanager
def _keep_prints() -> Iterator[StringIO]:
    """Keep what this thread prints; threads do not wait for each other, as laws of users may do."""
    thread, printed = get_ident(), StringIO()
    with _ROUTING:
        router = sys.stdout if isinstance(sys.stdout, _Router) else _Router(sys.stdout)
        sys.stdout = router
        router.users += 1
        before, router.kept[thread] = router.kept.get(thread), printed
    try:
        yield printed
    finally:
        with _ROUTING:
            del router.kept[thread]
            if before is not None:
                router.kept[thread] = before
            router.users -= 1
            if not router.users and sys.stdout is router:
                sys.stdout = router.usual


class _Router(TextIOBase):
    """Standard output while solvers run: what threads in `kept` print is kept, all else goes on.

    Attributes
    ----------
    usual : text file or None
        Where it goes.
    kept : mapping of thread to text
    users : int
        How many solvers run.
    """

    def __init__(self, usual: TextIO) -> None:
        super().__init__()
        self.usual, self.users = usual, 0
        self.kept: dict[int, StringIO] = {}

    def write(self, text: str) -> int:
        """Write text to where this thread's goes."""
        place: TextIO | StringIO | None = self.kept.get(get_ident(), self.usual)
        return len(text) if place is None else place.write(text)

    def flush(self) -> None:
        """Flush the usual place."""
        usual: TextIO | None = self.usual
        if usual is not None:
            usual.flush()

    def isatty(self) -> bool:
        """Return whether the usual place is a terminal."""
        usual: TextIO | None = self.usual
        return usual is not None and usual.isatty()

    def fileno(self) -> int:
        """Return the descriptor of the usual place."""
        return self.usual.fileno()


def solver_class(kind: str) -> Callable[..., Solver]:
    """Return the class of "CVODE" or "IDA".

    Raises
    ------
    EnvironmentFault
        If scikit-sundae is not installed.
    """
    try:  # here, as most motions are not stiff
        found: Callable[..., Solver] = getattr(import_module(f"sksundae.{kind.lower()}"), kind)
    except ImportError as error:
        raise EnvironmentFault(
            Problem("simulation.no_sundials", "integrator", f"{kind} is not installed", str(error),
                    "pip install scikit-sundae, or use sb.Explicit()")
        ) from error  # fmt: skip
    return found
