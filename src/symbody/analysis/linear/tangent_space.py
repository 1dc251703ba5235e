"""Small deviations of a state that constraints admit: which determine the others, and how.

Deviations are differences between two motions at the same time, of u and of q, with each quaternion's four
numbers replaced by the rotation vector delta from the one attitude to the other, in end axes of the one:
``e = e* (1, delta / 2)``. Constraints demand

    dPhi/dq dq = 0,    J du + d(J u + b)/dq dq = 0,

so all deviations follow from independent ones, ``d(u, q) = R d(u_i, q_i)``; the dependent coordinates are
those of the largest pivots (Wehage & Haug, J. Mech. Des. 104 (1982), 247-255), each in units of its own size.

The axes of delta turn with the joint's angular velocity Omega: with L the map back, ``delta = L(e*) de``,

    delta' = L(e*) de' + L(e*') de = L(e*) de' - Omega x delta / 2,

and ``L(e*) de'`` is ``d omega - Omega x delta / 2``, with d omega the difference of both angular velocities,
each in its own end axes. In all, ``delta' = d omega - Omega x delta``.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem
from symbody.manifold import pivot_order, rank, unit_rows
from symbody.tolerances import NEGLIGIBLE, SHARP_RANK

Floats = NDArray[np.float64]

# A choice of independent coordinates this near to a singular one loses four digits.
_POOR: Final = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Rotations:
    """Coordinates with three rotation-vector components in place of each quaternion.

    Attributes
    ----------
    names : tuple of str
        Of the coordinates that are left, ``<joint>_rx, _ry, _rz`` for a quaternion.
    out : (n_q, n) array
        dq for deviations of these.
    back : (n, n_q) array
        The deviations for dq on the unit sphere.
    turning : (n, n) array
        Their own rates beyond ``back dq'``, per deviation: ``-Omega x`` / 2, as their axes turn.
    """

    names: tuple[str, ...]
    out: Floats
    back: Floats
    turning: Floats

    def sizes(self, sizes: Floats) -> Floats:
        """Return the size of deviations of each, from the sizes of q."""
        return np.array([sizes @ (column != 0.0) / max((column != 0.0).sum(), 1) for column in self.out.T])


def rotations(eqs: EquationSet, q: Floats, q_dot: Floats) -> Rotations:
    """Return rotation vectors for quaternions at a configuration that changes at a rate."""
    places = {name: k for k, name in enumerate(eqs.coordinate_names)}
    joints: dict[tuple[str, ...] | None, str] = {
        joint.quaternion: joint.name for joint in eqs.formed.topology.joints
    }
    inside = {name: four for four in eqs.quaternions for name in four}
    names: list[str] = []
    out, back, turning = [], [], []
    for name, k in places.items():
        four = inside.get(name)
        if four is None:
            names.append(name)
            unit = np.zeros((len(places), 1))
            unit[k] = 1.0
            out.append(unit)
            back.append(unit.T)
            turning.append(np.zeros((1, 1)))
        elif name == four[0]:
            stem = joints.get(four, four[0])
            names += _unused_names([f"{stem}_r{axis}" for axis in "xyz"], places)
            quaternion = [places[other] for other in four]
            block = np.zeros((len(places), 3))
            block[quaternion] = _turns(q[quaternion])
            out.append(block / 2.0)
            back.append(2.0 * block.T)
            turning.append(_turns(q_dot[quaternion]).T @ block[quaternion])
    width = np.zeros((len(places), 0))
    empty = np.zeros((0, 0))
    return Rotations(
        tuple(names),
        np.hstack([width, *out]),
        np.vstack([width.T, *back]),
        scipy.linalg.block_diag(empty, *turning),
    )


def displace(eqs: EquationSet, q: Floats, by: Floats) -> Floats:
    """Return coordinates after finite steps of these, rotation vectors in place of quaternions."""
    places = {name: k for k, name in enumerate(eqs.coordinate_names)}
    inside = {name: four for four in eqs.quaternions for name in four}
    result, at = q.copy(), 0
    for name, k in places.items():
        four = inside.get(name)
        if four is None:
            result[k] += by[at]
            at += 1
        elif name == four[0]:
            own, turn = [places[other] for other in four], by[at : at + 3] / 2.0
            half = float(np.linalg.norm(turn))
            e = np.cos(half) * q[own] + _turns(q[own]) @ turn * np.sinc(half / np.pi)
            result[own] = e / np.linalg.norm(e)
            at += 3
    return result


def _unused_names(names: list[str], taken: Collection[str]) -> list[str]:
    return [name if name not in taken else f"{name}_turn" for name in names]


def _turns(e: Floats) -> Floats:
    """Return what a quaternion times (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) is, as columns."""
    w, x, y, z = e
    return np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])


@dataclass(frozen=True, slots=True)
class Choice:
    """Places of independent and dependent unknowns, and the smallest pivot of the latter.

    Attributes
    ----------
    pivot : float
        Smallest singular value of the dependent columns; 1 if there are none.
    """

    independent: tuple[int, ...]
    dependent: tuple[int, ...]
    pivot: float

    @property
    def is_poor(self) -> bool:
        """Whether digits are lost because the choice is nearly singular."""
        return self.pivot < _POOR


def choose(rows: Floats, names: Sequence[str], kept: Collection[str], asked: Collection[str]) -> Choice:
    """Return independent unknowns of ``rows x = 0``.

    Parameters
    ----------
    rows : (m, n) array
        Columns in units of the size of each unknown.
    kept : names
        That have to be independent.
    asked : names
        That are independent if that leaves large pivots.

    Raises
    ------
    AssemblyError
        If the unknowns kept are not independent, naming them, or those that they leave are too few.
    """
    rows = unit_rows(rows)
    count = rank(rows, SHARP_RANK)
    others = [k for k, name in enumerate(names) if name not in kept]
    first = [k for k in others if names[k] not in asked]
    dependent = _pivots(rows[:, first], first, _POOR)
    if len(dependent) < count:
        left = rows - _project(rows, rows[:, list(dependent)])
        remaining = [k for k in others if k not in dependent]
        dependent += _pivots(left[:, remaining], remaining, SHARP_RANK)[: count - len(dependent)]
    if len(dependent) < count:
        raise AssemblyError(_not_independent(kept, len(names) - count))
    dependent = sorted(dependent)
    independent = tuple(k for k in range(len(names)) if k not in dependent)
    singular = np.linalg.svd(rows[:, dependent], compute_uv=False)
    return Choice(independent, tuple(dependent), float(singular[count - 1]) if count else 1.0)


def _pivots(columns: Floats, places: Sequence[int], least: float) -> list[int]:
    """Return the places of columns that are independent, the largest pivots first."""
    order, pivots = pivot_order(columns)
    return [places[k] for k in order[: int((pivots > least).sum())]]


def _project(rows: Floats, columns: Floats) -> Floats:
    """Return the part of rows within the span of columns."""
    if not columns.size:
        return np.zeros_like(rows)
    return np.asarray(columns @ np.linalg.lstsq(columns, rows, rcond=SHARP_RANK)[0])


def dependence_matrix(rows: Floats, choice: Choice, sizes: Floats) -> Floats:
    """Return R of ``x = R x_i`` for rows in units of sizes, (n, independent)."""
    result = np.zeros((rows.shape[1], len(choice.independent)))
    result[list(choice.independent)] = np.eye(len(choice.independent))
    if choice.dependent:
        result[list(choice.dependent)] = -solve_dependent(rows, choice, rows[:, list(choice.independent)])
        result *= sizes[:, np.newaxis] / sizes[list(choice.independent)]
    return result


def solve_dependent(rows: Floats, choice: Choice, right: Floats) -> Floats:
    """Return the dependent unknowns of ``rows_d x_d = right``, in units of their sizes."""
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    columns = (rows / lengths)[:, list(choice.dependent)]
    return np.asarray(np.linalg.lstsq(columns, right / lengths, rcond=NEGLIGIBLE)[0])


def _not_independent(names: Collection[str], count: int) -> Problem:
    return Problem(
        "linearize.singular_choice", "independent", f"{', '.join(names)} do not determine all other states "
            f"here",
        "the coefficients of the others in the constraints are singular at this configuration",
        f"name {count} other coordinates, or leave independent out: the best are then chosen by pivoting",
    )  # fmt: skip
