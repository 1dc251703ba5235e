"""`Trees`: which joints give the coordinates, and whether a choice of them is a forest."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from symbody.arguments import checked_arguments
from symbody.errors import Problem, TopologyError, nearest
from symbody.graph.linear_graph import Edge, breadth_first, closing_edges
from symbody.model.joint import Joint
from symbody.model.model import Model


@dataclass(frozen=True, slots=True, init=False)
class Trees:
    """The rotation and the translation tree, each as the joints whose coordinates are used.

    Bodies that a tree does not reach get the coordinates of a free body relative to ground.

    Parameters
    ----------
    rotation, translation : iterable of joint or name
        Joints in the tree; all others are cut: what they lock becomes constraints.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> trees = sb.Trees(rotation=["rail"], translation=["rail"])
    >>> sb.form_equations(sb.Model("cart", [rail]), tree=trees).coordinate_names
    ('x',)
    """

    rotation: tuple[str, ...]
    translation: tuple[str, ...]

    @checked_arguments
    def __init__(self, rotation: Iterable[Joint | str], translation: Iterable[Joint | str]) -> None:
        for field, joints in (("rotation", rotation), ("translation", translation)):
            object.__setattr__(self, field, tuple(j.name if isinstance(j, Joint) else str(j) for j in joints))


TreeChoice = Trees | Literal["joints", "absolute"] | None

KINDS: Final = ("rotation", "translation")


@dataclass(frozen=True, slots=True)
class Preference:
    """Which edges must be in a tree, and which may, dearest last."""

    required: tuple[str, ...]
    allowed: tuple[str, ...]


def preferences(model: Model, joints: Sequence[Joint], choice: TreeChoice) -> dict[str, Preference]:
    """Return the joints that a choice of trees names, for "rotation" and "translation".

    Raises
    ------
    TopologyError
        If a name is not that of a joint, or the choice is not one of trees.
    """
    names = tuple(joint.name for joint in joints)
    if isinstance(choice, Trees):
        _check_names(choice, [joint.name for joint in model.joints])
        return {kind: Preference(getattr(choice, kind), ()) for kind in KINDS}
    if choice == "absolute":
        return {kind: Preference((), ()) for kind in KINDS}
    if choice == "joints":
        return {kind: Preference((), names) for kind in KINDS}
    if choice is not None:
        raise TopologyError(
            Problem("topology.unknown_choice", "tree", f"{choice!r} is not a valid choice of trees", "",
                    'write "joints", "absolute", Trees(rotation=[...], translation=[...]), or leave it out')
        )  # fmt: skip
    flags = {kind: {joint.name: getattr(joint.tree, kind) for joint in joints} for kind in KINDS}
    return {
        kind: Preference(
            tuple(name for name in names if flags[kind][name]),
            tuple(name for name in names if flags[kind][name] is None),
        )
        for kind in KINDS
    }


def cycle_problem(kind: str, edges: Iterable[Edge], chosen: Collection[str]) -> Problem | None:
    """Return a problem that shows a cycle among the chosen edges, or None if they form a forest."""
    inside = [edge for edge in edges if edge.name in chosen]
    closing = next(closing_edges(inside), None)
    if closing is None:
        return None
    before = inside[: inside.index(closing)]
    ways = {node: (parent, edge.name) for parent, edge, node in breadth_first(before, closing.start)}
    trail, around = [closing.name], [closing.start, closing.end]
    while around[-1] != closing.start:
        parent, name = ways[around[-1]]
        trail.append(name)
        around.append(parent)
    names, bodies = ", ".join(reversed(trail)), " - ".join(reversed(around))
    return Problem(
        "topology.cycle", f"tree, {kind}", f"the joints {names} form a cycle: {bodies}",
        "a tree has one path from ground to each body", f"remove one of them from the {kind} tree",
    )  # fmt: skip


def _check_names(choice: Trees, names: Sequence[str]) -> None:
    problems = []
    for kind in KINDS:
        listed: tuple[str, ...] = getattr(choice, kind)
        problems += [
            Problem("topology.unknown_joint", f"tree, {kind}", f"there is no joint {name!r}", "",
                    nearest(name, names))
            for name in listed if name not in names
        ]  # fmt: skip
        problems += [
            Problem("topology.twice", f"tree, {kind}", f"{name!r} is listed twice", "", "list it once")
            for name in dict.fromkeys(listed) if listed.count(name) > 1
        ]  # fmt: skip
    if problems:
        raise TopologyError(*problems)
