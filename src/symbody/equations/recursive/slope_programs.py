"""Derivatives of inverse dynamics in closed form, as programs for links, columns and pairs of columns.

All vectors are in the axes of one frame, about its origin: motions ``(w, v)`` of the points that pass there,
forces ``(moment, force)``. With ``S`` the column of a joint, ``S'`` its rate, ``S"`` what it gives to
accelerations elsewhere, and mass, matrix B and force of all that a joint carries, for a joint j at or
outward of i::

    dD_i/dq_j = S_i . (2 B S'_j + I S"_j + S_j x f)      dD_j/dq_i = 2 B^T S_j . S'_i + I S_j . S"_i
    dD_i/du_j = S_i . (2 B S_j + 2 I S'_j)               dD_j/du_i = 2 B^T S_j . S_i + 2 I S_j . S'_i

The matrix B of Coriolis forces is ``sum of P^T P' dm``, with P from motions to velocities of points:
``B (w, v) = ((tr G) w - G w, w x p)`` with ``G = sum of V r^T dm`` and the momentum p.

Singh, Russell & Wensing, IEEE Robotics Autom. Lett. 7 (2022) 1776; Echeandia & Wensing, J. Comput. Nonlinear
Dyn. 16 (2021) 091004. Derived in docs/derivations/recursive.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from symbody.equations.recursive.pseudo_inertia import PseudoInertia, added, scaled
from symbody.equations.recursive.turned import Symmetric, dyad
from symbody.expr.expression import Expr
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, inner, outer, transpose


class Motion(NamedTuple):
    """A motion of points: of turning, and of the point in the origin."""

    w: Triple
    v: Triple

    def plus(self, other: Motion) -> Motion:
        """Return the sum."""
        return Motion(added(self.w, other.w), added(self.v, other.v))

    def times(self, factor: Expr | int) -> Motion:
        """Return the multiple."""
        return Motion(scaled(self.w, factor), scaled(self.v, factor))

    def carries(self, other: Motion) -> Motion:
        """Return the rate of a motion that is fixed in what moves so: ``self x other``."""
        return Motion(outer(self.w, other.w), added(outer(self.w, other.v), outer(self.v, other.w)))

    def power(self, force: Motion) -> Expr:
        """Return the product with a force (moment, force)."""
        return inner(self.w, force.w) + inner(self.v, force.v)


class Carried(NamedTuple):
    """What a joint carries: its mass and how that moves, all about the common origin.

    Attributes
    ----------
    mass : Expr
    first : (3,) Expr
        ``sum of r dm``.
    second : Symmetric
        ``sum of r r^T dm``.
    momentum : (3,) Expr
        ``p = sum of V dm``.
    swirl : Matrix
        ``G = sum of V r^T dm``.
    force, moment : (3,) Expr
        What the motion needs.
    """

    mass: Expr
    first: Triple
    second: Symmetric
    momentum: Triple
    swirl: Matrix
    force: Triple
    moment: Triple

    def plus(self, other: Carried) -> Carried:
        """Return both together."""
        a, b, c = (added(x, y) for x, y in zip(self.swirl, other.swirl, strict=True))
        return Carried(
            self.mass + other.mass,
            added(self.first, other.first),
            self.second.plus(other.second),
            added(self.momentum, other.momentum),
            (a, b, c),
            added(self.force, other.force),
            added(self.moment, other.moment),
        )

    def needs(self, motion: Motion) -> Motion:
        """Return the force ``I motion``."""
        turned = _moments(_trace(self.second.matrix), self.second.matrix, motion.w)
        return Motion(
            added(turned, outer(self.first, motion.v)),
            added(scaled(motion.v, self.mass), outer(motion.w, self.first)),
        )

    def coriolis(self, motion: Motion) -> Motion:
        """Return the force ``B motion``."""
        return Motion(_moments(_trace(self.swirl), self.swirl, motion.w), outer(motion.w, self.momentum))


def link(axes: Matrix, at: Triple, motion: Motion, acceleration: Motion, inertia: PseudoInertia) -> Carried:
    """Return what one link is and needs; `axes` and `at` lead from it to the common frame."""
    w, v = motion
    h, m = apply_matrix(axes, inertia.first), inertia.mass
    half = added(h, scaled(at, m / 2))
    first = added(h, scaled(at, m))
    second = _turned(axes, inertia.second).plus(dyad(at, half))
    momentum = added(scaled(v, m), outer(w, first))
    a0, a1, a2 = (added(scaled(v, first[k]), outer(w, second.matrix[k])) for k in range(3))
    swirl = transpose((a0, a1, a2))
    alpha, a = acceleration
    force = added(added(scaled(a, m), outer(alpha, first)), outer(w, momentum))
    turned = _moments(_trace(second.matrix), second.matrix, alpha)
    moment = added(added(outer(first, a), turned), _moments(_trace(swirl), swirl, w))
    return Carried(m, first, second, momentum, swirl, force, moment)


class ColumnForces(NamedTuple):
    """Of a column of what it carries: forces that its position and its rate cost, and what others meet there.

    Attributes
    ----------
    by_position, by_rate : Motion
        Forces that it costs to be elsewhere, to move.
    inertia : Motion
        ``I S``.
    coriolis : (3,) Expr
        ``2 B^T S``, whose lower half is zero.
    """

    by_position: Motion
    by_rate: Motion
    inertia: Motion
    coriolis: Triple


def column(carried: Carried, s: Motion, rate: Motion, second: Motion) -> ColumnForces:
    """Return the forces of a column S with its rate S' and what it gives to accelerations."""
    f = carried.force
    across = Motion(added(outer(s.w, carried.moment), outer(s.v, f)), outer(s.w, f))
    by_position = carried.coriolis(rate).times(2).plus(carried.needs(second)).plus(across)
    by_rate = carried.coriolis(s).plus(carried.needs(rate)).times(2)
    back = added(_moments(_trace(carried.swirl), transpose(carried.swirl), s.w), outer(carried.momentum, s.v))
    return ColumnForces(by_position, by_rate, carried.needs(s), scaled(back, 2))


def link_numbers(axes: Matrix, at: Triple, motions: Sequence[Motion], inertia: PseudoInertia) -> list[Expr]:
    """Return what `link_program` reads of a link: of motions its own, its acceleration, S and S'."""
    return [
        *(x for row in axes for x in row), *at, *(x for motion in motions for part in motion for x in part),
        inertia.mass, *inertia.first, *inertia.second,
    ]  # fmt: skip


def link_program(_: list[Expr], own: list[Expr]) -> list[Expr]:
    """Return S" of a link's column, then what the link is but for its mass; see `carried_from`."""
    read = _Reader(own)
    axes, at = read.matrix(), read.triple()
    motion, acceleration, s, rate = (read.motion() for _ in range(4))
    inertia = PseudoInertia(mass=read.one(), first=read.triple(), second=read.symmetric())
    own_part = link(axes, at, motion, acceleration, inertia)
    second = acceleration.carries(s).plus(motion.carries(rate))
    return [*second.w, *second.v, *_without_mass(own_part)]


def carried_from(mass: Expr, results: Sequence[Expr]) -> tuple[Motion, Carried]:
    """Return S" and what a link is from its mass and the results of `link_program`."""
    read = _Reader(results)
    second = read.motion()
    first, tensor, momentum, swirl = read.triple(), read.symmetric(), read.triple(), read.matrix()
    return second, Carried(mass, first, tensor, momentum, swirl, read.triple(), read.triple())


def column_numbers(s: Motion, rate: Motion, second: Motion, carried: Carried) -> list[Expr]:
    """Return what `column_forces` reads of a column."""
    return [
        *s.w, *s.v, *rate.w, *rate.v, *second.w, *second.v, carried.mass, *_without_mass(carried)
    ]  # fmt: skip


def column_forces(own: Sequence[Expr]) -> ColumnForces:
    """Return the forces of a column from its numbers."""
    read = _Reader(own)
    s, rate, second, mass = read.motion(), read.motion(), read.motion(), read.one()
    first, tensor, momentum, swirl = read.triple(), read.symmetric(), read.triple(), read.matrix()
    return column(
        Carried(mass, first, tensor, momentum, swirl, read.triple(), read.triple()), s, rate, second
    )


def forces_numbers(forces: ColumnForces) -> list[Expr]:
    """Return the numbers of the forces of a column, for `forces_from`."""
    motions = (x for motion in forces[:3] for part in motion for x in part)
    return [*motions, *forces.coriolis]


def forces_from(numbers: Sequence[Expr]) -> ColumnForces:
    """Return the forces of a column from their numbers."""
    read = _Reader(numbers)
    return ColumnForces(read.motion(), read.motion(), read.motion(), read.triple())


def outer_columns(shared: list[Expr], own: list[Expr]) -> list[Expr]:
    """Return (dD_i/dq_j, dD_i/du_j) for several i inward of a column j.

    Parameters
    ----------
    shared : the columns S_i
    own : `by_position` and `by_rate` of column j
    """
    read = _Reader(own)
    by_position, by_rate = read.motion(), read.motion()
    inward = _motions(shared)
    return [s.power(by_position) for s in inward] + [s.power(by_rate) for s in inward]


def inner_columns(shared: list[Expr], own: list[Expr]) -> list[Expr]:
    """Return (dD_j/dq_i, dD_j/du_i, M_ji) for several j outward of a column i.

    Parameters
    ----------
    shared : `inertia` and `coriolis` of the columns j
    own : S, S', S" of column i
    """
    read = _Reader(own)
    s, rate, second = read.motion(), read.motion(), read.motion()
    parts = _Reader(shared)
    outward = [(parts.motion(), parts.triple()) for _ in range(len(shared) // 9)]
    by_position = [inner(b, rate.w) + inertia.power(second) for inertia, b in outward]
    by_rate = [inner(b, s.w) + inertia.power(rate.times(2)) for inertia, b in outward]
    return [*by_position, *by_rate, *(inertia.power(s) for inertia, _ in outward)]


class _Reader:
    """Takes numbers apart, one after the other."""

    def __init__(self, numbers: Sequence[Expr]) -> None:
        self._numbers = iter(numbers)

    def one(self) -> Expr:
        return next(self._numbers)

    def triple(self) -> Triple:
        return (self.one(), self.one(), self.one())

    def motion(self) -> Motion:
        return Motion(self.triple(), self.triple())

    def matrix(self) -> Matrix:
        return (self.triple(), self.triple(), self.triple())

    def symmetric(self) -> Symmetric:
        return Symmetric(*(self.one() for _ in range(6)))


def motion_from(numbers: Sequence[Expr]) -> Motion:
    """Return a motion from its six numbers."""
    return _Reader(numbers).motion()


def _motions(numbers: Sequence[Expr]) -> list[Motion]:
    read = _Reader(numbers)
    return [read.motion() for _ in range(len(numbers) // 6)]


def _without_mass(carried: Carried) -> list[Expr]:
    swirl = (x for row in carried.swirl for x in row)
    return [
        *carried.first, *carried.second, *carried.momentum, *swirl, *carried.force, *carried.moment
    ]  # fmt: skip


def _trace(matrix: Matrix) -> Expr:
    return matrix[0][0] + matrix[1][1] + matrix[2][2]


def _moments(trace: Expr, matrix: Matrix, w: Triple) -> Triple:
    """Return ``(tr G) w - G w``."""
    x, y, z = apply_matrix(matrix, w)
    return (trace * w[0] - x, trace * w[1] - y, trace * w[2] - z)


def _turned(axes: Matrix, tensor: Symmetric) -> Symmetric:
    """Return ``R K R^T``, of which one half is formed."""
    left = [apply_matrix(tensor.matrix, row) for row in axes]

    def entry(i: int, j: int) -> Expr:
        return inner(left[i], axes[j])

    return Symmetric(entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2))
