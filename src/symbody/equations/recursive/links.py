"""The kinematic tree: links, each of bodies welded together, and how they move relative to their parents."""

from __future__ import annotations

from dataclasses import dataclass

from symbody.expr.expression import Expr
from symbody.spatial.inertia import RigidInertia
from symbody.spatial.matrix import Vector3
from symbody.spatial.transform import Transform
from symbody.spatial.twist import Twist, Wrench

GROUND = -1

LinkTransform = Transform[Expr]
LinkTwist = Twist[Expr]
LinkWrench = Wrench[Vector3[Expr]]
LinkInertia = RigidInertia[Expr]


@dataclass(frozen=True, slots=True)
class MotionSubspaceColumn:
    """One free motion of a joint: a column of Featherstone's S.

    Attributes
    ----------
    speed : int
        Node of u.
    twist : Twist
        Of the link relative to its parent for a unit of the speed, about the link's origin, in its axes.
    """

    speed: int
    twist: LinkTwist


@dataclass(frozen=True, slots=True)
class JointMotion:
    """How a link moves relative to its parent link, in its own axes.

    Attributes
    ----------
    columns : tuple of MotionSubspaceColumn
        The free motions.
    velocity : Twist
        ``v_J``, of the link's origin.
    bias : Twist
        Its rate as seen from the parent with all u' = 0.
    rotation : str
        "none", "z" or "any": the axes it turns about.
    has_displacements : bool
        Whether its origin moves.
    """

    columns: tuple[MotionSubspaceColumn, ...]
    velocity: LinkTwist
    bias: LinkTwist
    rotation: str
    has_displacements: bool


@dataclass(frozen=True, slots=True)
class TreeLink:
    """One link of the tree.

    Attributes
    ----------
    joint : str
        The joint inward of it.
    parent : int
        Number of its parent link; -1 is ground.
    transform : Transform
        Of its axes in those of the parent: Featherstone's X.
    motion : JointMotion
        Of the link relative to its parent: Featherstone's S.
    inertia : RigidInertia
        Of its bodies, in its axes about its origin.
    """

    joint: str
    parent: int
    transform: LinkTransform
    motion: JointMotion
    inertia: LinkInertia


@dataclass(frozen=True, slots=True)
class BodyPlacement:
    """Where a body stands on its link: number of the link, -1 for ground, and the body's frame in it."""

    link: int
    transform: LinkTransform


@dataclass(frozen=True, slots=True)
class KinematicTree:
    """All links, parents before children, and where the bodies stand on them."""

    links: tuple[TreeLink, ...]
    bodies: dict[str, BodyPlacement]

    @property
    def children(self) -> list[list[int]]:
        """The numbers of the links on each link."""
        children: list[list[int]] = [[] for _ in self.links]
        for k, link in enumerate(self.links):
            if link.parent != GROUND:
                children[link.parent].append(k)
        return children

    @property
    def followers(self) -> dict[tuple[int, int], int]:
        """The speeds of columns whose joints do not own them, by link and column: those of coupled joints."""
        speeds: set[int] = set()
        followers = {}
        for k, link in enumerate(self.links):
            for c, column in enumerate(link.motion.columns):
                if column.speed in speeds:
                    followers[k, c] = column.speed
                speeds.add(column.speed)
        return followers

    @property
    def depths(self) -> list[int]:
        """How many speeds each link is carried by, its own ones included."""
        depths: list[int] = []
        for link in self.links:
            before = 0 if link.parent == GROUND else depths[link.parent]
            depths.append(before + len(link.motion.columns))
        return depths
