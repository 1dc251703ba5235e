"""Articulated bodies where joints are coupled: each free motion by itself, then those that share a speed.

With all free motions apart, ``A u^' = f + C^T x`` by articulated bodies and ``C u^' = 0``, where a row of C
says that two of them have the same rate; so ``C A^-1 C^T x = -C A^-1 f``. That takes one more pass along the
tree for each coupling, linear in the number of links (Featherstone 2008, chapter 8).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symbody.equations.dynamics.linear_solve import TreeFactors, factor, solve_factored
from symbody.equations.recursive.aba import JointInertia, accelerations, articulated_inertias
from symbody.equations.recursive.links import KinematicTree
from symbody.expr.expression import Expr


@dataclass(frozen=True, slots=True)
class UncoupledMotions:
    """A tree whose free motions have a speed each.

    Attributes
    ----------
    leaders : mapping of int to int
        The speed of each free motion that shares one, by a key of its own.
    joints : list of list of JointInertia
        By link.
    passes : mapping of key to mapping of speed to Expr
        ``A^-1 C^T``, a column a coupling.
    factors : TreeFactors
        Of ``C A^-1 C^T``.
    """

    tree: KinematicTree
    leaders: Mapping[int, int]
    joints: list[list[JointInertia]]
    passes: Mapping[int, Mapping[int, Expr]]
    factors: TreeFactors

    @property
    def pivots(self) -> dict[int, Expr]:
        """``D`` of each free motion, by its speed."""
        return {joint.column.speed: joint.D for link in self.joints for joint in link}

    def accelerations(self, forces: Mapping[int, Expr]) -> dict[int, Expr]:
        """Return u' with ``M u' = forces``, by the node of u."""
        if not self.leaders:
            return accelerations(self.tree, self.joints, forces)
        zero = next(iter(forces.values())) * 0
        free = accelerations(self.tree, self.joints, {**forces, **dict.fromkeys(self.leaders, zero)})
        right = [free[speed] - free[key] for key, speed in self.leaders.items()]
        shares = solve_factored(self.factors, right)
        return {
            u: sum((x * column[u] for x, column in zip(shares, self.passes.values(), strict=True)), free[u])
            for u in forces
        }


def can_uncouple(tree: KinematicTree) -> bool:
    """Return whether every free motion that shares a speed is the only one of its joint."""
    shared = set(tree.followers.values())
    return all(
        len(link.motion.columns) == 1 or all(column.speed not in shared for column in link.motion.columns)
        for link in tree.links
    )


def uncouple_motions(tree: KinematicTree, rotors: Mapping[int, Expr]) -> UncoupledMotions:
    """Return a tree with its free motions apart; arguments as of `articulated_inertias`."""
    leaders = {}
    links = list(tree.links)
    for key, ((k, _), speed) in enumerate(tree.followers.items(), start=1):
        leaders[-key] = speed
        (column,) = links[k].motion.columns
        motion = replace(links[k].motion, columns=(replace(column, speed=-key),))
        links[k] = replace(links[k], motion=motion)
    apart = replace(tree, links=tuple(links))
    joints = articulated_inertias(apart, rotors)
    passes = _passes(apart, joints, leaders)
    rows = [
        {j: passes[one][two] - passes[one][leaders[two]] for j, two in enumerate(list(leaders)[: i + 1])}
        for i, one in enumerate(leaders)
    ]
    return UncoupledMotions(apart, leaders, joints, passes, factor(rows))


def _passes(
    tree: KinematicTree, joints: Sequence[Sequence[JointInertia]], leaders: Mapping[int, int]
) -> dict[int, dict[int, Expr]]:
    """Return the accelerations for a unit force along each follower and its opposite along the leader."""
    speeds = [column.speed for link in tree.links for column in link.motion.columns]
    if not leaders:
        return {}
    zero = joints[0][0].D * 0 if joints[0] else tree.links[0].inertia.mass * 0
    return {
        key: accelerations(tree, joints, dict.fromkeys(speeds, zero) | {key: zero + 1, leader: zero - 1})
        for key, leader in leaders.items()
    }
