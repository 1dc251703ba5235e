"""Implicit integration of stiff motions: `Stiff` chooses backward differentiation, `run_stiff` runs it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import checked_fields
from symbody.errors import Problem, UsageError
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.implicit.state_jacobian import (
    CALLBACK_JACOBIAN,
    STATE_JACOBIAN,
    STATE_RATES,
    drop_idle_rows,
    with_state_jacobian,
)
from symbody.simulation.methods.implicit.sundials import (
    MonitoredFunction,
    SundialsStepper,
    print_as_usual,
    solver_class,
)
from symbody.simulation.methods.stepping import NODES, SHARES, march
from symbody.simulation.motion import Motion, StateProjector
from symbody.simulation.native.run import RawRun

Floats = NDArray[np.float64]

# Between two projections the constraints are left to the solver; `Baumgarte` with this frequency, over the
# time of the mechanism, keeps their drift from growing. On the constraints it vanishes: it changes no motion.
DRIFT: Final = 5.0
# A new start costs dozens of small steps of low order: it waits for so many times the limit of `Projection`.
PATIENCE: Final = 100.0
# Steps that see the input at their end alone are so much shorter than pieces in which it is a polynomial.
SHARE_OF_PIECE: Final = 0.125


@checked_fields
@dataclass(frozen=True, slots=True)
class Stiff:
    """Backward differentiation with variable order and step, for fast damped motions.

    Attributes
    ----------
    max_order : int
        Highest order, 1 to 5; 2 is stable for every damped oscillation.
    max_step : float, optional
        Longest step [s].

    Raises
    ------
    UsageError
        Another order, or a step that is not positive.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x",
    ...                     force=sb.Drive(damping=1e5))
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], initial={"x_dot": 3}))
    >>> sb.simulate(eqs, 1.0, integrator=sb.Stiff(max_order=2)).success
    True
    """

    max_order: int = 5
    max_step: float | None = None

    def __post_init__(self) -> None:
        if self.max_order not in (1, 2, 3, 4, 5):
            what = f"backward differentiation has no order {self.max_order!r}"
            raise UsageError(Problem("simulation.order", "max_order", what, "", "give 1 to 5"))
        if self.max_step is not None and not self.max_step > 0.0:
            what = f"max_step = {self.max_step!r} is not a positive number"
            fix = "leave max_step out, or give seconds"
            raise UsageError(Problem("simulation.max_step", "max_step", what, "", fix))

    def options(self) -> dict[str, float | int]:
        """Return the options as the solvers take them."""
        longest = 0.0 if self.max_step is None else float(self.max_step)
        return {"max_order": int(self.max_order), "max_step": longest}


def run_stiff(
    motion: Motion,
    method: Stiff,
    constraints: Projection | Baumgarte,
    events: EventWatch | None,
) -> RawRun:
    """Integrate ``x' = f(t, x)`` by CVODE, with df/dx from the graph, and from differences of Python's laws.

    With `Projection` the ends of all steps and all samples are brought onto the constraints; a drift far
    beyond its limit starts the solver anew from there. So does a step whose end does not solve the equations.

    Raises
    ------
    SimulationError, EnvironmentFault
        If the solver does not start, or is not installed.
    """
    closing = motion.projection(constraints) if isinstance(constraints, Projection) else None
    eqs = drop_idle_rows(motion.eqs, motion.problem.parameters)
    if closing is not None and eqs.multiplier_names:
        eqs = Baumgarte(zeta=1.0, omega=DRIFT / motion.problem.scales.time).applied(eqs)
    laws = motion.problem.laws
    wider = with_state_jacobian(eqs, laws.formulas, laws.callbacks)
    rates = motion.compile_outputs(STATE_RATES, wider)
    slopes = motion.compile_outputs((STATE_JACOBIAN, CALLBACK_JACOBIAN), wider)
    watch = MonitoredFunction(rates)

    @print_as_usual
    def right_hand_side(t: float, x: Floats, out: Floats) -> None:
        out[:] = watch(t, x)

    def jacobian(t: float, x: Floats) -> Floats:
        by_state, by_callbacks = slopes(t, x)
        found: Floats = (
            by_state + by_callbacks @ laws.slopes(t, x, motion.n_u) if laws.callbacks else by_state
        )
        return found

    @print_as_usual
    def state_jacobian(t: float, x: Floats, rate: Floats, out: Floats) -> None:
        out[:] = jacobian(t, x)

    solved = SolvedSteps(watch, jacobian, motion.rtol, motion.tolerances)
    solver = solver_class("CVODE")(
        right_hand_side, method="BDF", jacfn=state_jacobian, rtol=motion.rtol,
        atol=motion.tolerances, **method.options(),
    )  # fmt: skip
    stepper = SundialsStepper(
        solver, solver.init_step, _Settling(closing, constraints), watch, motion.state, motion.span,
        motion.step_ends(SHARE_OF_PIECE), solved,
    )  # fmt: skip
    return march(stepper, motion.course(closing, events), events)


class _Settling:
    """Closes the end of a step, and requires a new start where the drift is large."""

    def __init__(self, closing: StateProjector | None, constraints: Projection | Baumgarte) -> None:
        self._closing = closing
        self._limit = PATIENCE * constraints.limit if isinstance(constraints, Projection) else np.inf

    def __call__(self, t: float, x: Floats) -> tuple[Floats, bool]:
        """Return the closed state, and whether the solver has to start from it."""
        if self._closing is None:
            return x, False
        closed, moved = self._closing.project_one(t, x)
        return (closed, moved > self._limit) if np.isfinite(moved) else (x, False)


# Whether the end of a step by CVODE solves its equations. CVODE keeps derivatives for up to fifty steps,
# whatever their length, and takes small corrections by them for a sign of convergence. Where the equations
# were far stiffer when the derivatives were computed, as beside a place where angles do not determine a
# rotation, corrections are small however wrong a state is, and so is the estimate of its error, which is
# the sum of the corrections. IDA needs no such look: it computes derivatives anew whenever its step
# changes.


# Iterations end within one or two tolerated errors, and a few are left where derivatives change much. Ten are
# what `Projection` takes for too much as well.
WRONG: Final = 10.0
# Formulas of order 1 to 5 are y' = (y - what is known) / (beta h) with beta from 1 down to 137/300, if steps
# have one length. By that factor the correction may differ at most.
SHARE_OF_STEP: Final = 2.0


def _end_slope() -> Floats:
    """Return what, times values at all `SHARES` but the first, is the slope at 1 of their polynomial.

    The first is left out: there a state may have been brought onto the constraints. The others are enough for
    the solver's polynomials, of degree 5 at most.
    """
    degrees = np.arange(NODES - 1)
    found = np.linalg.solve(np.vander(SHARES[1:], NODES - 1, increasing=True).T, degrees)
    return np.asarray(found, dtype=np.float64)


_END_SLOPE: Final = _end_slope()
_ROUNDED: Final = float(np.abs(_END_SLOPE).sum()) * EPSILON


@dataclass(frozen=True, slots=True, eq=False)
class SolvedSteps:
    """Looks at steps by the correction of Newton's method with the derivatives at their very end.

    Attributes
    ----------
    rates, jacobian : callable
        From t and x to x', and to dx'/dx.
    """

    rates: Callable[[float, Floats], Floats]
    jacobian: Callable[[float, Floats], Floats]
    rtol: float
    atol: float | Floats

    def __call__(self, t: float, length: float, nodes: Floats) -> bool:
        """Return whether the correction is small at the end t of a step with states at all `SHARES`."""
        x, slope = nodes[-1], _END_SLOPE @ nodes[1:] / length
        wrong = slope - self.rates(t, x)
        if not np.isfinite(wrong).all():
            return True  # whatever is wrong there shows in the next step
        rounded = np.abs(nodes).max(axis=0) + np.abs(t * slope)  # states, and the times they belong to
        weights = self.rtol * np.abs(x) + self.atol + _ROUNDED * rounded
        matrix = SHARE_OF_STEP / length * np.eye(x.size) - self.jacobian(t, x)
        try:
            correction = np.linalg.solve(matrix, wrong)
        except np.linalg.LinAlgError:
            return True  # the solver's own matrix could be solved
        return not float(np.sqrt(np.mean((correction / weights) ** 2))) > WRONG
