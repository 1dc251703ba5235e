"""Velocities that fit the constraints and given values, where eliminated speeds follow from the others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.constraint_evaluator import ConstraintEvaluator
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem
from symbody.kernels.configurations.closing import RESISTED
from symbody.manifold import least_solution, null_space, row_space
from symbody.tolerances import ASSEMBLED, RANK

Floats = NDArray[np.float64]
CURE: Final = (
    "name other dependent_speeds whose pivot does not vanish during the motion, or leave dependent_speeds "
    "out: multipliers have no such singularity"
)


def solve_speeds(
    evaluator: ConstraintEvaluator,
    q: Floats,
    fixed: Mapping[str, float],
    guess: Mapping[str, float],
    near: Floats | None = None,
) -> Floats:
    """Return u with ``J u + b = 0`` and the fixed rates, nearest to speeds `near` (n_u,), by default to rest.

    Rates with a guess, also those of cut joints, take it in the order of the guesses, as far as they are
    still free. The change of all others has the least kinetic energy: see `nearest_speeds`.

    Raises
    ------
    AssemblyError
        If dependent speeds do not follow from the others, or the fixed rates contradict the constraints or
        each other, naming the smallest set that does.
    """
    eqs = evaluator.eqs
    if evaluator.is_tree and eqs.formed.elimination is None and {*fixed, *guess} <= {*eqs.speed_names}:
        rest = (
            dict.fromkeys(eqs.speed_names, 0.0)
            if near is None
            else dict(zip(eqs.speed_names, near, strict=True))
        )
        return np.array([*({**rest, **guess, **fixed}.values())])
    check_pivots(evaluator, q)
    rows, right = _conditions(evaluator, q, fixed)
    is_still = near is None and not (fixed or right.any() or any(guess.values()))
    if is_still and guess.keys() <= {*evaluator.eqs.speed_names}:
        return np.zeros(len(evaluator.eqs.speed_names))  # at rest
    if not _fulfils(evaluator, least_solution(rows, right), rows, right):
        raise AssemblyError(_conflict(evaluator, q, fixed))
    basis = row_space(rows)
    for name, value_near in evaluator.split_values(guess)[1].items():
        condition, value = evaluator.speed_row(q, name, value_near)
        row, target = _scale_conditions(evaluator, condition[np.newaxis, :], np.array([value]))
        left = _project_out(basis, row[0])
        distance = float(np.linalg.norm(left))
        if distance > RANK:
            rows = np.vstack([rows, row])
            right = np.concatenate([right, target])
            basis = np.vstack([basis, _project_out(basis, left / distance)])
    return nearest_speeds(
        evaluator, q, (rows, right), np.zeros(len(eqs.speed_names)) if near is None else near
    )


def nearest_speeds(
    evaluator: ConstraintEvaluator, q: Floats, conditions: tuple[Floats, Floats], near: Floats
) -> Floats:
    """Return u that fulfils conditions ``A v = b``, v the speeds over their sizes, and is nearest to others.

    Speeds that the conditions determine have no part in the measure. Of all else the change has the least
    kinetic energy, and where no inertia resists it the least sum of squares over sizes: what
    `kernels.configurations.closing` computes.
    """
    rows, right = conditions
    sizes = evaluator.speed_sizes
    change = least_solution(rows, right - rows @ (near / sizes))
    free = null_space(rows, RANK)
    if free.shape[1] and change.any():
        own = np.abs(free).max(axis=1) > RANK
        mass = evaluator.compile("mass_matrix")(evaluator.t, q, np.zeros(sizes.size), s=evaluator.signals)
        momenta = (mass * np.outer(sizes, sizes) * np.outer(own, own)) @ free
        if np.isfinite(momenta).all():
            change = change - free @ least_solution(free.T @ momenta, momenta.T @ change, RESISTED)
    return np.asarray(near + change * sizes)


def _conditions(
    evaluator: ConstraintEvaluator, q: Floats, fixed: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Return A and b of all conditions ``A v = b``, v the speeds over their sizes."""
    return _scale_conditions(evaluator, *evaluator.velocity_rows(q, fixed))


def _scale_conditions(evaluator: ConstraintEvaluator, rows: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Return conditions on speeds over their sizes, with rows of length 1: they have no unit of length."""
    sized = rows * evaluator.speed_sizes
    lengths = np.linalg.norm(sized, axis=1)
    lengths[lengths == 0.0] = 1.0
    return sized / lengths[:, np.newaxis], right / lengths


def _fulfils(evaluator: ConstraintEvaluator, speeds: Floats, rows: Floats, right: Floats) -> bool:
    """Return whether all rows hold."""
    sizes = 1.0 / evaluator.mechanism.time + np.abs(right).max(initial=0.0) + np.abs(rows) @ np.abs(speeds)
    return bool((np.abs(rows @ speeds - right) <= ASSEMBLED * sizes).all())


def _project_out(basis: Floats, row: Floats) -> Floats:
    """Return the part of a row that is perpendicular to the basis."""
    return np.asarray(row - basis.T @ (basis @ row))


def _conflict(evaluator: ConstraintEvaluator, q: Floats, fixed: Mapping[str, float]) -> Problem:
    conflict = dict(fixed)
    for name in fixed:
        others = {key: value for key, value in conflict.items() if key != name}
        rows, right = _conditions(evaluator, q, others)
        if not _fulfils(evaluator, least_solution(rows, right), rows, right):
            conflict = others
    listed = ", ".join(f"{name} = {value:g}" for name, value in conflict.items()) or "the motions in time"
    return Problem(
        "assembly.velocity_conflict", "fixed", f"no motion from this configuration has {listed}",
        "the constraints couple these rates", "leave one of them out",
    )  # fmt: skip


def pivot_groups(eqs: EquationSet) -> list[list[str]]:
    """Return the dependent speeds that have a pivot which may vanish, those that share one together."""
    elimination = eqs.formed.elimination
    groups: dict[int, list[str]] = {}
    for name, pivot in () if elimination is None else elimination.pivots.items():
        groups.setdefault(pivot.index, []).append(name.removesuffix("_pivot"))
    return list(groups.values())


def check_pivots(evaluator: ConstraintEvaluator, q: NDArray[np.float64]) -> None:
    """Refuse a configuration at which dependent speeds do not follow from the others.

    Raises
    ------
    AssemblyError
        Naming the speeds.
    """
    groups = pivot_groups(evaluator.eqs)
    if not groups:
        return
    light = {speed.label for speed in evaluator.eqs.formed.light_balances}
    still = np.zeros(len(evaluator.eqs.speed_names))
    found = np.ravel(evaluator.compile([f"{names[0]}_pivot" for names in groups])(evaluator.t, q, still))
    lost = [names for names, value in zip(groups, found, strict=True) if not abs(value) > ASSEMBLED]
    if lost:
        raise AssemblyError(
            *((_no_balance if light & {*names} else _vanishing_pivot)(", ".join(names)) for names in lost)
        )


def _no_balance(names: str) -> Problem:
    return Problem(
        "assembly.massless", f"speed {names}", f"{names} has no mass, and forces do not determine it here",
        "its coefficient in the balance of forces is zero or undefined, as for a damper between coincident "
        "points, whose line has no direction",
        "start near this position, put the damper into a joint, as Drive(damping=..), or give mass to what "
        "moves there",
    )  # fmt: skip


def _vanishing_pivot(names: str) -> Problem:
    return Problem(
        "assembly.dependent_speeds", "dependent_speeds",
        f"at this configuration the other speeds do not determine {names}",
        "the coefficients of these speeds in the velocity constraints form a singular matrix", CURE,
    )  # fmt: skip
