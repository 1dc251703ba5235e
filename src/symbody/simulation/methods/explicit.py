"""Explicit integration of a compiled right-hand side: `Explicit` chooses the method, `integrate` runs it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.arguments import checked_fields
from symbody.errors import Problem, UsageError
from symbody.kernels.samples.sampling import ONE_INSTANT
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.hybrid.passed_jumps import PassedJumps
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import NO_TABLES, Goal, HeldValues, Projector, RightHandSide, Watch
from symbody.simulation.native.run import EVENT_SAMPLES, CompiledRun, NativeRun, fresh_record, run_loop
from symbody.simulation.native.run import Progress as Progress
from symbody.simulation.native.run import RawRun as RawRun
from symbody.simulation.native.runge_kutta import DORMAND_PRINCE_5, DORMAND_PRINCE_8, Tableau

Floats = NDArray[np.float64]

_NOTHING: Final = np.zeros(0)
NO_FUNCTION: Final = RightHandSide(0, 0, _NOTHING, _NOTHING, _NOTHING, 0)
NOTHING_TO_PROJECT: Final = Projector(
    0, 0, _NOTHING, _NOTHING, _NOTHING, 0, 0, _NOTHING, math.inf, _NOTHING, 0.0, 0
)

# From a right-hand side, and what makes a run, to a run with other functions.
RunMaker = Callable[[RightHandSide, Callable[[RightHandSide, Projector], NativeRun]], CompiledRun]

# An rtol below this is finer than rounding allows.
SMALLEST_RTOL: Final = 10.0 * EPSILON


@checked_fields
@dataclass(frozen=True, slots=True)
class Explicit:
    """A Runge-Kutta pair of Dormand and Prince, with steps that follow the local error.

    Attributes
    ----------
    order : int
        8 (the default, for smooth motions and tight tolerances) or 5.
    max_step : float, optional
        Longest step [s]; needed where a Python function as input has short or fast features, as it cannot be
        examined before the motion.
    first_step : float, optional
        First step [s]; by default it follows from the first accelerations.

    Raises
    ------
    UsageError
        Another order, or a step that is not positive.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], initial={"x_dot": 3}))
    >>> sb.simulate(eqs, 1.0, integrator=sb.Explicit(order=5, max_step=0.1)).success
    True
    """

    order: int = 8
    max_step: float | None = None
    first_step: float | None = None

    def __post_init__(self) -> None:
        if self.order not in (5, 8):
            fix = "sb.Explicit(order=8), or order=5 for loose tolerances and rough right-hand sides"
            raise _usage("order", f"there is no explicit method of order {self.order!r}", fix)
        for name, step in (("max_step", self.max_step), ("first_step", self.first_step)):
            if step is not None and not step > 0.0:
                raise _usage(
                    name, f"{name} = {step!r} is not a positive number", f"leave {name} out, or give seconds"
                )

    @property
    def tableau(self) -> Tableau:
        """Its coefficients."""
        return DORMAND_PRINCE_8 if self.order == 8 else DORMAND_PRINCE_5


def integrate(
    address: int,
    work_size: int,
    n_u: int,
    n_q: int,
    x0: ArrayLike,
    t_span: tuple[float, float],
    *,
    method: Explicit | FixedStep,
    inputs: ArrayLike = (),
    tables: Floats = NO_TABLES,
    parameters: ArrayLike = (),
    constants: ArrayLike = (),
    times: ArrayLike | None = None,
    rtol: float = 1e-8,
    atol: ArrayLike = 1e-10,
    max_steps: int = 1_000_000,
    dense: bool = True,
    stop_when_stiff: bool = False,
    progress: Progress | None = None,
    projector: Projector = NOTHING_TO_PROJECT,
    watch: Watch | None = None,
    breakpoints: Breakpoints = NO_BREAKPOINTS,
    held: HeldValues | None = None,
    make_run: RunMaker | None = None,
    jumps: PassedJumps | None = None,
) -> RawRun:
    """Integrate ``x' = f(t, x)``, x = (u, q), f given by its address; t_span [s] may run backwards.

    Parameters
    ----------
    address, work_size, tables : int, int, array
        A function of generated code, see `kernels.language.Function`, its scratch, and `kernels.tables`.
    times : array, optional
        The samples to store, in the order of the motion; by default every step is stored.
    rtol, atol : float, float or (n_u + n_q,) array
        Bound the root mean square of the local errors of a step.
    max_steps, dense, stop_when_stiff : int, bool, bool
        How many steps may be tried; whether to keep the motion between samples, at 7 (order 8) or 4 (order 5)
        more vectors a step; whether to stop with `Status.STIFF` when stability limits the steps.
    progress : callable, optional
        Called now and then with the share of the span that is done; returning False ends the run.
    projector, watch, breakpoints, held, jumps : Projector, Watch, Breakpoints, HeldValues, PassedJumps
        Bring states back onto the constraints; may cut runs that are `dense`; bound steps; change inputs, and
        speeds.

    Raises
    ------
    UsageError, SimulationError
        What does not fit: shapes, tolerances, times outside the span, more samples than the memory holds.
    """
    (start, end), x = check_span(t_span), _check_state(x0, n_u + n_q)
    bounds = breakpoints.jumps_alone() if isinstance(method, FixedStep) else breakpoints
    goal = make_goal((start, end), check_rtol(rtol), check_atol(atol, x.size), method.max_step, bounds)
    goal = goal._replace(max_trials=int(max_steps), stop_when_stiff=bool(stop_when_stiff))
    r, p, c = (np.array(group, dtype=np.float64).ravel() for group in (inputs, parameters, constants))
    rhs = RightHandSide(int(address), int(n_u), r, p, c, work_size, tables)
    new = partial(_new_run, method, goal, x, start, held, jumps)
    run = new(rhs, projector) if make_run is None else make_run(rhs, new)
    more = 0 if watch is None else EVENT_SAMPLES
    record = fresh_record(run, check_times(times, start, end), dense, more)
    return run_loop(run, record, progress, watch)


def _new_run(
    method: Explicit | FixedStep, goal: Goal, x: Floats, t: float, held: HeldValues | None,
    jumps: PassedJumps | None, rhs: RightHandSide, projector: Projector,
) -> NativeRun:  # fmt: skip
    """Return a run at its start."""
    block = make_block(rhs, projector, method.tableau, goal, x, t, float(method.first_step or 0.0))
    return NativeRun(rhs.address, projector.address, block, held, jumps)


def make_goal(
    span: tuple[float, float], rtol: float, atol: Floats, max_step: float | None, breakpoints: Breakpoints
) -> Goal:
    """Return the goal of a motion over a span; its steps are not limited in number."""
    direction = 1.0 if span[1] >= span[0] else -1.0
    longest = math.inf if max_step is None else float(max_step)
    return Goal(span[1], direction, rtol, atol, longest, 0, False, breakpoints.rows_along(direction))


def _usage(where: str, what: str, fix: str, why: str = "") -> UsageError:
    return UsageError(Problem(f"simulation.{where}", where, what, why, fix))


def check_span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Return both ends of a motion as finite numbers."""
    start, end = (float(t) for t in t_span)
    if not (math.isfinite(start) and math.isfinite(end)):
        raise _usage(
            "t_span", f"the motion cannot run from {start} to {end}", "give two finite times in seconds"
        )
    return start, end


def _check_state(x0: ArrayLike, size: int) -> Floats:
    x = np.array(x0, dtype=np.float64)
    if x.shape != (size,):
        fix = f"give the {size} values of (u, q)"
        raise _usage("initial", f"the initial state has shape {x.shape}, not ({size},)", fix)
    if not np.isfinite(x).all():
        places = ", ".join(map(str, np.flatnonzero(~np.isfinite(x))))
        raise _usage("initial", f"initial values are not finite: state {places}", "give finite numbers")
    return x


def check_rtol(rtol: float) -> float:
    """Return a relative tolerance that can be met."""
    value = float(rtol)
    if not (value == 0.0 or SMALLEST_RTOL <= value < math.inf):
        fix = f"give 0, or a value of {SMALLEST_RTOL:.1e} or more such as 1e-8"
        raise _usage("rtol", f"rtol = {value!r} cannot be achieved in double precision", fix)
    return value


def check_atol(atol: ArrayLike, size: int) -> Floats:
    """Return a positive absolute tolerance for each state."""
    values = np.array(atol, dtype=np.float64)
    if values.shape not in ((), (size,)):
        raise _usage(
            "atol", f"atol has shape {values.shape}", f"give one number, or {size}, one for each state"
        )
    if not (values > 0.0).all() or not np.isfinite(values).all():
        why = "atol sets the size below which a state no longer matters, so that states may pass through zero"
        raise _usage("atol", f"atol = {atol!r} is not positive", "give a positive number such as 1e-10", why)
    return values + np.zeros(size)


def check_single_atol(atol: float | None) -> float | None:
    """Return one positive absolute tolerance, or None."""
    return None if atol is None else float(check_atol(atol, 1)[0])


def check_times(times: ArrayLike | None, start: float, end: float) -> Floats | None:
    """Return the times to store as a new array, or None for every step; those at an end are that end."""
    if times is None:
        return None
    samples = np.array(times, dtype=np.float64)
    if samples.ndim != 1 or not np.isfinite(samples).all():
        raise _usage(
            "times", "times is not a list of finite numbers", "give for instance np.linspace(0, 10, 501)"
        )
    direction = 1.0 if end >= start else -1.0
    for bound in (start, end):  # 3*0.1 is 0.3 but for the last bit
        samples[np.abs(samples - bound) <= ONE_INSTANT * abs(bound)] = bound
    if not (direction * np.diff(samples) > 0.0).all():
        word = "increase" if direction > 0.0 else "decrease"
        raise _usage(
            "times", f"times do not {word} throughout", f"sort them so that they {word}, each only once"
        )
    if samples.size and (direction * (samples[[0, -1]] - [start, end]) * [1, -1] < 0.0).any():
        what = (
            f"times from {samples[0]:g} to {samples[-1]:g} lie outside the motion's span {start:g} to {end:g}"
        )
        raise _usage("times", what, "choose times inside the span, or a longer span")
    return samples
