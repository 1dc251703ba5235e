"""`Link`: bodies welded together, and how they move relative to the link that carries them."""

from __future__ import annotations

from dataclasses import dataclass

from symbody.equations.recursive.pseudo_inertia import PseudoInertia
from symbody.equations.recursive.turned import Steps
from symbody.vectors.matrix import Matrix, Triple

GROUND = -1


@dataclass(frozen=True, slots=True)
class Column:
    """One free motion of a joint.

    Attributes
    ----------
    speed : int
        Node of u.
    turn, slide : (3,) Expr
        Partial angular velocity, and partial velocity of the link's origin, in the link's axes.
    """

    speed: int
    turn: Triple
    slide: Triple


@dataclass(frozen=True, slots=True)
class RelativeMotion:
    """How a link moves relative to its parent link, in its own axes.

    Attributes
    ----------
    columns : tuple of Column
        The free motions.
    w, v : (3,) Expr
        Angular velocity, velocity of the origin.
    alpha, a : (3,) Expr
        Their rates as seen from the parent with all u' = 0.
    turning : str
        "none", "z" or "any": about what it turns.
    sliding : bool
        Whether its origin moves.
    """

    columns: tuple[Column, ...]
    w: Triple
    v: Triple
    alpha: Triple
    a: Triple
    turning: str
    sliding: bool


@dataclass(frozen=True, slots=True)
class Link:
    """One link of the tree.

    Attributes
    ----------
    joint : str
        The joint inward of it.
    parent : int
        Number of its parent link; -1 is ground.
    steps : tuple of Step
        From the parent's axes to its own.
    arm : (3,) Expr
        From the parent's origin to its own, in the parent's axes.
    inertia : PseudoInertia
        Of its bodies, in its axes about its origin.
    """

    joint: str
    parent: int
    steps: Steps
    arm: Triple
    motion: RelativeMotion
    inertia: PseudoInertia


@dataclass(frozen=True, slots=True)
class Fixed:
    """Where a body stands on its link.

    Attributes
    ----------
    link : int
        Number of the link; -1 is ground.
    axes : Matrix
        Components in the body to components in the link.
    at : (3,) Expr
        From the link's origin to the body's center of mass, in the link's axes.
    """

    link: int
    axes: Matrix
    at: Triple


@dataclass(frozen=True, slots=True)
class Tree:
    """All links, parents before children, and where the bodies stand on them."""

    links: tuple[Link, ...]
    bodies: dict[str, Fixed]

    @property
    def children(self) -> list[list[int]]:
        """The numbers of the links on each link."""
        found: list[list[int]] = [[] for _ in self.links]
        for k, link in enumerate(self.links):
            if link.parent != GROUND:
                found[link.parent].append(k)
        return found

    @property
    def depths(self) -> list[int]:
        """How many speeds each link is carried by, its own ones included."""
        found: list[int] = []
        for link in self.links:
            before = 0 if link.parent == GROUND else found[link.parent]
            found.append(before + len(link.motion.columns))
        return found
