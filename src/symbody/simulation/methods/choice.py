"""Which integrator a motion gets, and the change from an explicit one to `Stiff` on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from symbody.errors import Problem, UsageError
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.gear_gupta_leimkuhler import GGL, run_ggl
from symbody.simulation.methods.partition import Partition, run_partition
from symbody.simulation.methods.request import Request
from symbody.simulation.methods.stiff import Stiff, run_stiff
from symbody.simulation.native.run import RawRun
from symbody.simulation.status import Status

Integrator = Explicit | FixedStep | Stiff
Constraints = Projection | Baumgarte | GGL | Partition
Notes = tuple[str, ...]

DEFAULT: Final = Explicit()
# So many explicit steps take less than a second, and they are more exact than what `Stiff` does.
BEARABLE: Final = 20_000


def run_chosen(
    request: Request,
    integrator: Integrator | None,
    constraints: Constraints,
    explicit: Callable[[Explicit | FixedStep, bool], RawRun],
) -> tuple[RawRun, Notes]:
    """Return the run of a motion and what to note about it.

    Parameters
    ----------
    integrator : Explicit, FixedStep, Stiff or None
        None starts explicitly and goes on with `Stiff` where stability alone keeps the steps small.
    explicit : callable
        Runs the compiled loop by a method, with or without stopping where that happens.

    Raises
    ------
    UsageError
        If the integrator cannot hold the constraints in the way asked for.
    """
    is_closed = bool(request.eqs.multiplier_names)
    if isinstance(constraints, GGL):
        if isinstance(integrator, Explicit | FixedStep):
            raise _unfit("sb.GGL()", "are implicit equations", "sb.Stiff()")
        if is_closed:
            return run_ggl(request, integrator or Stiff())
        constraints = Projection()
    if isinstance(constraints, Partition):
        if not isinstance(integrator, Explicit | None):
            raise _unfit("sb.Partition()", "is integrated explicitly", "sb.Explicit()")
        if is_closed:
            return run_partition(request, constraints, integrator or DEFAULT)
        constraints = Projection()
    if isinstance(integrator, Stiff):
        return run_stiff(request, integrator, constraints), ()
    if integrator is not None:
        return explicit(integrator, False), ()
    raw = explicit(DEFAULT, True)
    if raw.status is Status.STIFF and request.watch is None and _steps_left(raw, request.span[1]) < BEARABLE:
        return explicit(DEFAULT, False), ()  # events would be told twice
    return _continued(request, raw, constraints)


def _steps_left(raw: RawRun, end: float) -> float:
    """Return how many steps like the last one lead to the end."""
    if raw.dense_output is None:
        return 0.0
    last, reached = raw.dense_output.breaks[-2:]
    return float((end - reached) / (reached - last))


def _continued(request: Request, first: RawRun, constraints: Projection | Baumgarte) -> tuple[RawRun, Notes]:
    """Return an explicit run, carried on by `Stiff` if it was broken off as stiff."""
    if first.status is not Status.STIFF or first.dense_output is None:
        return first, ()
    start, end = first.reached, request.span[1]
    times = None
    if request.times is not None:
        wanted = np.asarray(request.times)
        times = wanted[(wanted - start) * np.sign(end - start) > 0.0]
    rest = replace(
        request,
        x0=first.dense_output(start),
        span=(start, end),
        times=times,
        max_steps=request.max_steps - first.statistics.accepted - (first.statistics.rejected or 0),
        before=first,
    )
    note = f"from t = {start:.6g} s on the motion is stiff and sb.Stiff() integrates it"
    try:
        return run_stiff(rest, Stiff(), constraints), (note,)
    except KeyboardInterrupt:  # while it compiled: what came before is kept
        return replace(first, status=Status.INTERRUPTED), ()


def _unfit(constraints: str, why: str, fix: str) -> UsageError:
    what = f"this integrator cannot be combined with {constraints}"
    return UsageError(
        Problem("simulation.combination", "integrator", what, f"{constraints} {why}", f"use {fix}")
    )
