"""Accelerations by articulated bodies: linear in the number of links.

Featherstone (2008), chapter 7, for the equations ``M u' = F`` in which F holds all that u' = 0 leaves, so
that the bodies start from rest and no bias accelerations occur. A joint with several freedoms is a chain of
such with one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from symbody.equations.recursive.links import GROUND, Column, Link, Tree
from symbody.equations.recursive.newton_euler import Carried
from symbody.equations.recursive.pseudo_inertia import PseudoInertia, added, scaled
from symbody.equations.recursive.turned import (
    Steps,
    Symmetric,
    matrix_to_parent,
    symmetric,
    tensor_to_parent,
    to_child,
)
from symbody.expr.expression import Expr
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, inner, outer, product, transpose


class Articulated(NamedTuple):
    """``moment = turn alpha + mixed a``, ``force = mixed^T alpha + slide a``, about a link's origin."""

    turn: Symmetric
    mixed: Matrix
    slide: Symmetric

    def plus(self, other: Articulated) -> Articulated:
        """Return the sum."""
        rows = [added(a, b) for a, b in zip(self.mixed, other.mixed, strict=True)]
        mixed = (rows[0], rows[1], rows[2])
        return Articulated(self.turn.plus(other.turn), mixed, self.slide.plus(other.slide))

    def moved(self, steps: Steps, r: Triple) -> Articulated:
        """Return the same inertia in the parent's axes, about a point from which r leads to the origin."""
        slide = tensor_to_parent(steps, self.slide)
        mixed = matrix_to_parent(steps, self.mixed)
        skew = _skew(r)
        before = product(mixed, skew)
        found = [added(a, b) for a, b in zip(mixed, product(skew, slide.matrix), strict=True)]
        mixed = (found[0], found[1], found[2])
        lever = symmetric(product(skew, transpose(mixed)))
        turn = tensor_to_parent(steps, self.turn).plus(lever)
        turn = Symmetric(*(a - b for a, b in zip(turn, symmetric(before), strict=True)))
        return Articulated(turn, mixed, slide)

    def wrench(self, column: Column) -> Carried:
        """Return what a unit acceleration along a free motion needs."""
        force = added(apply_matrix(transpose(self.mixed), column.turn), self.slide.apply(column.slide))
        moment = added(self.turn.apply(column.turn), apply_matrix(self.mixed, column.slide))
        return Carried(force, moment)


@dataclass(frozen=True, slots=True)
class Freed:
    """One free motion given up: its column, what a unit of it needs, the pivot and its inverse."""

    column: Column
    unit: Carried
    pivot: Expr
    inverse: Expr


def freed(tree: Tree, rotors: Mapping[int, Expr]) -> list[list[Freed]]:
    """Return the free motions of all links, each with the inertia that resists it.

    Parameters
    ----------
    rotors : mapping of speed to Expr
        Inertia of what turns with a speed alone.
    """
    whole = [_rigid(link.inertia) for link in tree.links]
    found: list[list[Freed]] = [[] for _ in tree.links]
    for k in reversed(range(len(tree.links))):
        link, body = tree.links[k], whole[k]
        for column in reversed(link.motion.columns):
            unit = body.wrench(column)
            pivot = unit.work(column.turn, column.slide)
            rotor = rotors.get(column.speed)
            inverse = 1 / (pivot if rotor is None else pivot + rotor) if _resists(pivot, rotor) else pivot + 1
            own = Freed(column, unit, pivot if rotor is None else pivot + rotor, inverse)
            found[k].append(own)
            body = _without(body, own, clean=rotor is None)
        if link.parent != GROUND:
            whole[link.parent] = whole[link.parent].plus(body.moved(link.steps, link.arm))
    return [motions[::-1] for motions in found]


def accelerations(
    tree: Tree, motions: Sequence[Sequence[Freed]], forces: Mapping[int, Expr]
) -> dict[int, Expr]:
    """Return u' with ``M u' = forces``, by the node of u."""
    if not tree.links:
        return {}
    zero = tree.links[0].inertia.mass * 0
    still = (zero, zero, zero)
    rest = [Carried(still, still) for _ in tree.links]
    own: dict[int, Expr] = {}
    for k in reversed(range(len(tree.links))):
        link, carried = tree.links[k], rest[k]
        for motion in reversed(motions[k]):
            column = motion.column
            y = (forces[column.speed] - carried.work(column.turn, column.slide)) * motion.inverse
            own[column.speed] = y
            unit = motion.unit
            carried = carried.plus(Carried(scaled(unit.force, y), scaled(unit.moment, y)))
        if link.parent != GROUND:
            rest[link.parent] = rest[link.parent].plus(carried.moved(link))
    return _outward(tree, motions, own, still)


def _outward(
    tree: Tree, motions: Sequence[Sequence[Freed]], own: dict[int, Expr], still: Triple
) -> dict[int, Expr]:
    turns: list[Triple] = []
    slides: list[Triple] = []
    found = {}
    for k, link in enumerate(tree.links):
        alpha, a = _carried_by_parent(link, turns, slides, still)
        for motion in motions[k]:
            column, unit = motion.column, motion.unit
            back = inner(unit.moment, alpha) + inner(unit.force, a)
            value = own[column.speed] - back * motion.inverse
            found[column.speed] = value
            alpha = added(alpha, scaled(column.turn, value))
            a = added(a, scaled(column.slide, value))
        turns.append(alpha)
        slides.append(a)
    return found


def _carried_by_parent(
    link: Link, turns: Sequence[Triple], slides: Sequence[Triple], still: Triple
) -> tuple[Triple, Triple]:
    if link.parent == GROUND:
        return still, still
    alpha, a = turns[link.parent], slides[link.parent]
    return to_child(link.steps, alpha), to_child(link.steps, added(a, outer(alpha, link.arm)))


def _resists(pivot: Expr, rotor: Expr | None) -> bool:
    return not (pivot if rotor is None else pivot + rotor).is_zero


def _rigid(body: PseudoInertia) -> Articulated:
    k, m = body.second, body.mass
    zero = m * 0
    turn = Symmetric(k.yy + k.zz, k.xx + k.zz, k.xx + k.yy, -k.xy, -k.xz, -k.yz)
    return Articulated(turn, _skew(body.first), Symmetric(m, m, m, zero, zero, zero))


def _without(body: Articulated, motion: Freed, *, clean: bool) -> Articulated:
    """Return the inertia that is felt through a free motion.

    Along a motion that is one coordinate direction nothing is felt, which is set, not computed, if `clean`.
    """
    moment, force = motion.unit.moment, motion.unit.force
    x, y = scaled(moment, motion.inverse), scaled(force, motion.inverse)
    alone = _direction(motion.column) if clean else -1

    def left(i: int, j: int, before: Expr, product_: Expr) -> Expr:
        return before * 0 if alone in (i, j) else before - product_

    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    turn = Symmetric(*(left(i, j, body.turn.entry(i, j), x[i] * moment[j]) for i, j in pairs))
    slide = Symmetric(*(left(3 + i, 3 + j, body.slide.entry(i, j), y[i] * force[j]) for i, j in pairs))
    rows = [tuple(left(i, 3 + j, body.mixed[i][j], x[i] * force[j]) for j in range(3)) for i in range(3)]
    mixed = tuple((row[0], row[1], row[2]) for row in rows)
    return Articulated(turn, (mixed[0], mixed[1], mixed[2]), slide)


def _direction(column: Column) -> int:
    """Return which of the six directions a free motion is, or -1 if it is none."""
    parts = [k for k, part in enumerate((*column.turn, *column.slide)) if not part.is_zero]
    both = (*column.turn, *column.slide)
    return parts[0] if len(parts) == 1 and both[parts[0]].number in (1, -1) else -1


def _skew(r: Triple) -> Matrix:
    x, y, z = r
    zero = x * 0
    return ((zero, -z, y), (z, zero, -x), (-y, x, zero))
