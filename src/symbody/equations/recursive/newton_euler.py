"""Recursive Newton-Euler: motion outward from ground, wrenches inward from the leaves.

Luh, Walker & Paul (1980) in the form of Khalil & Kleinfinger (1987): with ``U = alpha~ + w~ w~`` the points
of a link have the acceleration ``a + U r``, so that no linear velocity is formed. Gravity is an acceleration
of ground.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from symbody.equations.recursive.links import GROUND, Link, Tree
from symbody.equations.recursive.pseudo_inertia import Triple3, added, scaled, swirl, tuple_of
from symbody.equations.recursive.turned import to_child, to_parent
from symbody.expr.expression import Expr
from symbody.vectors.matrix import Triple, inner, opposite, outer


class LinkMotion(NamedTuple):
    """Motion of a link in its own axes.

    Attributes
    ----------
    w : (3,) Expr
        Angular velocity.
    u : (3, 3) Expr
        ``alpha~ + w~ w~``.
    a : (3,) Expr
        Acceleration of the origin less that of gravity.
    """

    w: Triple
    alpha: Triple
    u: Triple3
    a: Triple


class Carried(NamedTuple):
    """A force, and a moment about the origin of a link, in its axes."""

    force: Triple
    moment: Triple

    def plus(self, other: Carried) -> Carried:
        """Return the sum."""
        return Carried(added(self.force, other.force), added(self.moment, other.moment))

    @property
    def opposite(self) -> Carried:
        """The wrench of the same size in the opposite direction."""
        return Carried(opposite(self.force), opposite(self.moment))

    def moved(self, link: Link) -> Carried:
        """Return the same wrench in the axes of the link's parent, about its origin."""
        force = to_parent(link.steps, self.force)
        return Carried(force, added(to_parent(link.steps, self.moment), outer(link.arm, force)))

    def work(self, turn: Triple, slide: Triple) -> Expr:
        """Return the generalized force along a motion."""
        return inner(turn, self.moment) + inner(slide, self.force)


def link_motions(
    tree: Tree, gravity: Triple, accelerations: Mapping[int, Expr] | None = None
) -> list[LinkMotion]:
    """Return the motion of all links.

    Parameters
    ----------
    gravity : (3,) Expr
        In ground axes.
    accelerations : mapping of node to Expr, optional
        u' by the node of u; by default all are 0.
    """
    zero = gravity[0] * 0
    still = (zero, zero, zero)
    ground = LinkMotion(still, still, (still, still, still), opposite(gravity))
    found: list[LinkMotion] = []
    for link in tree.links:
        before = ground if link.parent == GROUND else found[link.parent]
        motion = link.motion
        w = to_child(link.steps, before.w)
        turning, shifting = motion.alpha, motion.a
        if accelerations is not None:
            for column in motion.columns:
                turning = added(turning, scaled(column.turn, accelerations[column.speed]))
                shifting = added(shifting, scaled(column.slide, accelerations[column.speed]))
        alpha = added(added(to_child(link.steps, before.alpha), outer(w, motion.w)), turning)
        a = to_child(link.steps, added(before.a, tuple_of(before.u, link.arm)))
        a = added(added(a, outer(scaled(w, 2), motion.v)), shifting)
        w = added(w, motion.w)
        found.append(LinkMotion(w, alpha, swirl(w, alpha), a))
    return found


def needed_wrenches(tree: Tree, motions: Sequence[LinkMotion]) -> list[Carried]:
    """Return what each link needs for its own motion."""
    return [
        Carried(*link.inertia.bias_wrench(motion.u, motion.a))
        for link, motion in zip(tree.links, motions, strict=True)
    ]


def generalized_forces(tree: Tree, needed: Sequence[Carried]) -> dict[int, Expr]:
    """Return, by the node of each speed, the force along it that gives all links what they need."""
    total, found = list(needed), {}
    for k in reversed(range(len(tree.links))):
        link = tree.links[k]
        for column in link.motion.columns:
            found[column.speed] = total[k].work(column.turn, column.slide)
        if link.parent != GROUND:
            total[link.parent] = total[link.parent].plus(total[k].moved(link))
    return found
