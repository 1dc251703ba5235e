"""The independent states at a point, and the matrices from their deviations to all others."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from symbody.analysis.linear.slopes import Slopes
from symbody.analysis.linear.tangent_space import (
    Choice,
    Rotations,
    choose,
    dependence_matrix,
    rotations,
    solve_dependent,
)
from symbody.analysis.scales import Scales
from symbody.analysis.state import State
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, nearest
from symbody.manifold import rank
from symbody.tolerances import EXACT, SHARP_RANK

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """Independent states, speeds first, states of signals last.

    Attributes
    ----------
    names : tuple of str
        Of the independent states.
    speeds, coordinates : Choice
        Their places in u, and in the coordinates with rotation vectors.
    u_sizes, q_sizes : (n_u,), (n,) arrays
        Size of deviations of each: 1 for angles, the size of the mechanism [m] for lengths.
    notes : tuple of str
        Choices that were made.
    s_sizes : (n_s,) array
        Size of deviations of the states of signals.
    """

    names: tuple[str, ...]
    speeds: Choice
    coordinates: Choice
    u_sizes: Floats
    q_sizes: Floats
    notes: tuple[str, ...]
    s_sizes: Floats

    @property
    def sizes(self) -> Floats:
        """Sizes of deviations of the independent states."""
        return np.concatenate(
            [
                self.u_sizes[list(self.speeds.independent)],
                self.q_sizes[list(self.coordinates.independent)],
                self.s_sizes,
            ]
        )


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Matrices from deviations of the independent states to those of all, at a state.

    Attributes
    ----------
    out, back : arrays
        d(u, q, s) for their deviations, (n_u + n_q + n_s, n); and back, for those that keep the constraints.
    turning : (n, n) array
        Their rates beyond ``back d(u, q, s)'``, per deviation: axes of rotation vectors turn.
    all_names, recovery : tuple of str, array
        All speeds, coordinates and states of signals, and how their deviations follow.
    """

    out: Floats
    back: Floats
    turning: Floats
    all_names: tuple[str, ...]
    recovery: Floats


def select(
    eqs: EquationSet,
    state: State,
    slopes: Slopes,
    asked: Sequence[str] | None,
    cyclic: Collection[str],
    mechanism: Scales,
) -> Selection:
    """Return the independent states at a state, by the scales of the mechanism.

    Raises
    ------
    AssemblyError
        If names are unknown, too few or too many, or do not determine the others.
    """
    turned = _local_rotations(eqs, np.array(list(state.q.values())), slopes)
    _check_cyclic_names(turned, cyclic)
    q_sizes, u_sizes = turned.sizes(mechanism.coordinates(eqs)), mechanism.displacements(eqs)
    coordinates, speeds = _split_names(eqs, turned, asked)
    positions = slopes.position_jacobian @ turned.out
    q = _choose("coordinates", positions * q_sizes, turned.names, coordinates, cyclic, ())
    chosen = [turned.names[k] for k in q.independent]
    rates = {f"{name}_dot" for name in chosen}
    u = _choose("speeds", slopes.jacobian * u_sizes, eqs.speed_names, speeds, (), rates)
    names = (*(eqs.speed_names[k] for k in u.independent), *chosen, *eqs.signal_state_names)
    first = np.abs(np.array(list(state.s.values()), dtype=np.float64))
    s_sizes = np.where(first > EXACT, first, 1.0)  # less is what an equilibrium leaves of a state that is 0
    return Selection(names, u, q, u_sizes, q_sizes, _notes(q, u, names, asked), s_sizes)


def basis(eqs: EquationSet, q_values: Floats, slopes: Slopes, selection: Selection) -> Basis:
    """Return the matrices from deviations of independent states to all others at a configuration."""
    turned = _local_rotations(eqs, q_values, slopes)
    q, u, q_sizes, u_sizes = selection.coordinates, selection.speeds, selection.q_sizes, selection.u_sizes
    positions, rows = slopes.position_jacobian @ turned.out * q_sizes, slopes.jacobian * u_sizes
    R_q, R_u = dependence_matrix(positions, q, q_sizes), dependence_matrix(rows, u, u_sizes)
    bent = slopes.of_velocity_rows[:, len(u_sizes) : len(u_sizes) + len(q_values)] @ turned.out @ R_q
    W = np.zeros((len(u_sizes), R_q.shape[1]))
    if u.dependent:
        W[list(u.dependent)] = -solve_dependent(rows, u, bent) * u_sizes[list(u.dependent), np.newaxis]
    n_u, n_q = R_u.shape[1], R_q.shape[1]
    recovery = np.block([[R_u, W], [np.zeros((len(R_q), n_u)), R_q]])
    back = np.block(
        [
            [np.eye(len(u_sizes))[list(u.independent)], np.zeros((n_u, len(turned.out)))],
            [np.zeros((n_q, len(u_sizes))), turned.back[list(q.independent)]],
        ]
    )
    turning = np.zeros((n_u + n_q, n_u + n_q))
    turning[n_u:, n_u:] = turned.turning[list(q.independent)] @ R_q
    out = np.vstack([recovery[: len(u_sizes)], turned.out @ recovery[len(u_sizes) :]])
    alone = np.eye(selection.s_sizes.size)  # signals follow from nothing else
    out, back, recovery = (scipy.linalg.block_diag(part, alone) for part in (out, back, recovery))
    turning = scipy.linalg.block_diag(turning, 0.0 * alone)
    return Basis(out, back, turning, (*eqs.speed_names, *turned.names, *eqs.signal_state_names), recovery)


def _local_rotations(eqs: EquationSet, q: Floats, slopes: Slopes) -> Rotations:
    n_u = len(eqs.speed_names)
    return rotations(eqs, q, slopes.rates[n_u : n_u + len(q)])


def _split_names(
    eqs: EquationSet, turned: Rotations, asked: Sequence[str] | None
) -> tuple[list[str] | None, list[str] | None]:
    """Return the coordinates and the speeds that were named; None where none were."""
    if asked is None:
        return None, None
    names = (*turned.names, *eqs.speed_names)
    problems = [
        Problem("linearize.unknown_name", name, f"the equations have no coordinate or speed {name!r}", "",
                nearest(name, names))
        for name in asked if name not in names
    ]  # fmt: skip
    if problems:
        raise AssemblyError(*problems)
    coordinates = [name for name in asked if name in turned.names]
    speeds = [name for name in asked if name in eqs.speed_names]
    return coordinates, speeds or None


def _check_cyclic_names(turned: Rotations, cyclic: Collection[str]) -> None:
    problems = [
        Problem("linearize.unknown_name", name, f"the equations have no cyclic coordinate {name!r}", "",
                nearest(name, turned.names))
        for name in cyclic if name not in turned.names
    ]  # fmt: skip
    if problems:
        raise AssemblyError(*problems)


def _choose(
    word: str,
    rows: Floats,
    names: Sequence[str],
    asked: Sequence[str] | None,
    kept: Collection[str],
    liked: Collection[str],
) -> Choice:
    """Return a choice of independent unknowns, as named or by pivots."""
    if asked is None:
        return choose(rows, names, kept, liked)
    count = len(names) - rank(rows, SHARP_RANK)
    if len(asked) != count:
        raise AssemblyError(
            Problem("linearize.independent", "independent",
                    f"{count} {word} are independent here, but {len(asked)} are named"
                    + (f": {', '.join(asked)}" if asked else ""),
                    f"{len(names)} {word} satisfy {len(names) - count} independent constraints",
                    f"name {count} of {', '.join(names)}")
        )  # fmt: skip
    outside = [name for name in kept if name not in asked]
    if outside:
        raise AssemblyError(
            Problem("linearize.cyclic", "cyclic", f"{', '.join(outside)} is not among the independent "
                f"coordinates",
                    "a cyclic coordinate cannot depend on others",
                    "name cyclic coordinates in independent too")
        )  # fmt: skip
    return choose(rows, names, asked, ())


def _notes(q: Choice, u: Choice, names: tuple[str, ...], asked: Sequence[str] | None) -> tuple[str, ...]:
    notes = []
    if asked is None and (q.dependent or u.dependent):
        notes.append(f"independent states by pivoting: {', '.join(names)}")
    if q.is_poor or u.is_poor:
        notes.append(
            f"these states determine the others poorly: the smallest pivot is {min(q.pivot, u.pivot):.1e}; "
            f"the position is nearly singular, or other independent coordinates are better"
        )
    return tuple(notes)
