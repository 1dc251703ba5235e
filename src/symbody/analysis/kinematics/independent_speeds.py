"""Independent speeds: those named by the caller, or those from which the others follow best."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.kinematics.continuation import Continuation
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError, nearest, number_in_words
from symbody.manifold import pivot_order

Floats = NDArray[np.float64]

_DRIVEN: Final = 1e-3  # a speed with an input counts for so much less among candidates to depend


def coupled_notes(eqs: EquationSet) -> tuple[str, ...]:
    """Return a note on speeds that are no rows here, because couplings give them."""
    listed = ", ".join(f"{name}_dot" for name in eqs.formed.coupled.values)
    note = (
        f"{listed}: couplings determine them; in equations formed without substitute=True they remain "
        f"constraints"
    )
    return (note,) if listed else ()


def best_speeds(
    mechanism: Continuation, eqs: EquationSet, t: float, q: Floats, count: int
) -> tuple[str, ...]:
    """Return the speeds that are left when the others depend on them as well-conditioned as can be."""
    jacobian = mechanism.rows(t, q, np.zeros(mechanism.speed_sizes.size))[0]
    if not jacobian.size:
        return eqs.speed_names
    weights = [_DRIVEN if _has_input(eqs, name) else 1.0 for name in eqs.speed_names]
    order, _ = pivot_order(mechanism.scaled_rows(jacobian) * np.array(weights))
    places = sorted(int(k) for k in order[len(eqs.speed_names) - count :])
    return tuple(eqs.speed_names[k] for k in places)


def _has_input(eqs: EquationSet, speed: str) -> bool:
    """Return whether a drive with an input works along the coordinate of a speed."""
    name = speed.removesuffix("_dot")
    for role in eqs.formed.joint_roles:
        drive = role.joint.drives.get(name)
        if drive is not None and set(drive.applied.names).intersection(eqs.input_names):
            return True
    return False


def check_names(eqs: EquationSet, names: Sequence[str], count: int) -> tuple[str, ...]:
    """Return named speeds in the order of the equations.

    Raises
    ------
    UsageError
        If a name is no speed, or there are not as many as freedoms.
    """
    labels = [name if name in eqs.speed_names else f"{name}_dot" for name in names]
    problems = [
        _unknown_speed(eqs, name)
        for name, label in zip(names, labels, strict=True)
        if label not in eqs.speed_names
    ]
    if not problems and len(set(labels)) != count:
        problems = [
            Problem("kinematics.independent_count", "independent",
                    f"{len(set(labels))} speeds are named, but the mechanism has "
                    f"{number_in_words(count, 'degree of freedom')}", "",
                    f"name {count} of {', '.join(eqs.speed_names)}")
        ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return tuple(sorted(labels, key=eqs.speed_names.index))


def _unknown_speed(eqs: EquationSet, name: str) -> Problem:
    """Return the problem of a name that is no speed, or one that a coupling gives."""
    others = eqs.formed.coupled.sources(name.removesuffix("_dot"))
    if others:
        return Problem("kinematics.coupled_speed", f"independent {name}",
                       f"a coupling determines {name} from {', '.join(others)}",
                       "it was substituted in the equations and is no longer a speed",
                       f"name {others[0]}, or form the equations without substitute=True")  # fmt: skip
    return Problem("kinematics.unknown_speed", f"independent {name}",
                   f"{name} is not a speed of these equations", "coordinates of cut joints have no speeds",
                   nearest(name, (*eqs.coordinate_names, *eqs.speed_names)))  # fmt: skip
