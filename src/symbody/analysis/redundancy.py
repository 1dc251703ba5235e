"""`redundancy`: which constraints say what others say already, on all configurations that close the loops.

Rows of J are compared at several assembled configurations off singular positions, each row over its largest
entry; a row is redundant if it lies in the span of rows kept before it at every one of them. Lengths are kept
before angles and earlier rows before later ones, so that of equal supports the first bears the load.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import assembled_configurations
from symbody.analysis.closure import Closure, closure
from symbody.analysis.named_values import refuse_unknown
from symbody.arguments import checked_arguments
from symbody.codegen.compile import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem

Floats = NDArray[np.float64]

_CONFIGURATIONS: Final = 4
# Assembly leaves 1e-9 of the mechanism's size; a row that differs by an angle of a thousandth counts.
_DEPENDENT: Final = 1e-6


@dataclass(frozen=True, slots=True)
class Redundancy:
    """What the constraints of a mechanism amount to.

    Attributes
    ----------
    degrees_of_freedom : int
        Speeds less independent constraints.
    kept, dropped : tuple of str
        Names of multipliers of independent rows, and of rows that follow from these.
    """

    degrees_of_freedom: int
    kept: tuple[str, ...]
    dropped: tuple[str, ...]


@checked_arguments
def redundancy(
    eqs: EquationSet,
    parameters: Mapping[str, Value] | None = None,
    guess: Mapping[str, Value] | None = None,
) -> Redundancy:
    """Return which constraints are independent for these values of the parameters.

    Parameters
    ----------
    guess : mapping of name to number or formula in parameters
        Near which the loops close; by default the model's initial values.

    Raises
    ------
    AssemblyError
        If the loops close nowhere near the guess.
    """
    refuse_unknown(eqs, guess or ())
    task = closure(eqs, dict(parameters or {}), {}, 0.0)
    if task.is_tree:
        return Redundancy(len(eqs.speed_names), (), ())
    places = assembled_configurations(task, guess or {}, parameters, _CONFIGURATIONS)
    if not places:
        raise AssemblyError(
            Problem("redundancy.open", eqs.model.name, "no configuration closes the loops", "",
                    "see assemble() for the joint that stays open, or give guess=")
        )  # fmt: skip
    ranks = [_independent(task, q) for q in places]
    generic = max(map(len, ranks))
    kept = next(rows for rows in ranks if len(rows) == generic)
    names = eqs.multiplier_names
    return Redundancy(
        len(eqs.speed_names) - generic,
        tuple(names[k] for k in sorted(kept)),
        tuple(name for k, name in enumerate(names) if k not in kept),
    )


def _independent(task: Closure, q: Floats) -> list[int]:
    """Return rows that span all others at a configuration, the preferred ones first."""
    rows = task.velocity_rows(q, {})[0]
    sizes = np.abs(rows).max(axis=1)
    order = sorted(range(len(rows)), key=lambda k: (task.eqs.formed.rows[k].force.is_zero, k))
    basis = np.zeros((0, rows.shape[1]))
    kept = []
    for k in order:
        if sizes[k] == 0.0:
            continue
        row = rows[k] / np.linalg.norm(rows[k])
        for _ in range(2):  # twice is enough (Golub & Van Loan 2013, section 5.2.9)
            row = row - basis.T @ (basis @ row)
        rest = float(np.linalg.norm(row))
        if rest > _DEPENDENT:
            basis = np.vstack([basis, row / rest])
            kept.append(k)
    return kept
