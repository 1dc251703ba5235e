"""Cases that are computed by `simulate`, one after the other: whatever the loop over many cases cannot do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.ropes import ropes
from symbody.errors import SymbodyError
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.hybrid.switching import switches
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.native import places
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.sweeps.job import NOT_STARTED, Records

# Code of a case whose verdict the loop over many cases does not know: this one plus the place in `Status`.
OTHERS: Final = 100


def why_single(
    eqs: EquationSet, laws: InputLaws, integrator: object, constraints: object, has_events: bool
) -> str:
    """Return why cases have to be computed one by one, empty if they need not."""
    reasons = {
        "events are watched": has_events,
        f"inputs {', '.join(laws.asked)} are asked in Python": bool(laws.asked),
        f"{type(integrator).__name__} takes its steps in Python": not isinstance(
            integrator, Explicit | FixedStep | None
        ),
        f"{type(constraints).__name__} takes its steps in Python": not isinstance(
            constraints, Projection | Baumgarte | None
        ),
        "joints stick and slip, or ropes slacken": switches(eqs.formed) or bool(ropes(eqs.formed)),
        "prescribed rates may jump": may_jump(eqs),
        "dependent speeds are watched": bool(
            eqs.formed.elimination is not None and eqs.formed.elimination.pivots
        ),
    }
    return "; ".join(reason for reason, holds in reasons.items() if holds)


def compute_single(
    move: Callable[[int], Trajectory], case: int, records: Records, notes: dict[int, str]
) -> None:
    """Compute one case and write down how it ended; faults of one case are no faults of the sweep."""
    row = case - records.first
    try:
        run = move(case)
    except SymbodyError as error:
        records.codes[row] = NOT_STARTED
        notes[case] = str(error)
        return
    kept = run.t.size
    records.x[row] = np.nan
    records.x[row, :kept] = np.concatenate([run.u, run.q]).T
    records.codes[row] = OTHERS + _place(run)
    spent = run.statistics
    counts = {
        places.ACCEPTED: spent.accepted,
        places.REJECTED: spent.rejected or 0,
        places.EVALUATIONS: spent.evaluations,
        places.SAMPLES: kept,
    }
    records.counts[row] = [counts.get(k, 0) for k in range(places.COUNTS)]
    records.reached[row] = run.t[-1] if kept else np.nan
    if run.notes:
        notes[case] = "; ".join(run.notes)


def _place(run: Trajectory) -> int:
    return list(type(run.status)).index(run.status)
