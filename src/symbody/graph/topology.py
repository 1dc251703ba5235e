"""The linear graph of a model and the trees that choose its coordinates.

The only file that knows both graphs and mechanics.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

from symbody.errors import Problem, TopologyError
from symbody.graph.curved_shifts import is_curved
from symbody.graph.linear_graph import Edge, LinearGraph
from symbody.graph.spanning_tree import SpanningTree, least_forest, spanning_tree
from symbody.graph.trees import Preference, TreeChoice, Trees, cycle_problem, preferences
from symbody.model.constraint import FrameConstraint
from symbody.model.contacts.contact import Contact
from symbody.model.joint import InTrees, Joint
from symbody.model.joints import Free
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.model.output_arguments import OutputScope, make_scope
from symbody.single_flight import SingleFlight


@dataclass(frozen=True, slots=True)
class Topology:
    """A model with its trees.

    Attributes
    ----------
    joints : tuple of Joint
        Those of the model, then a free joint for each body that a tree reaches by no other.
    rotation, translation : SpanningTree
        The trees; both span ground and all bodies.
    notes : tuple of str
        Each choice that was made, with its reason.
    """

    model: Model
    joints: tuple[Joint, ...]
    rotation: SpanningTree
    translation: SpanningTree
    notes: tuple[str, ...]
    # The joints, and all that connects frames, by name; filled on first use.
    _named: SingleFlight[None, dict[str, Joint]] = field(
        default_factory=SingleFlight, init=False, compare=False, repr=False
    )
    _links: SingleFlight[None, dict[str, Joint | FrameConstraint | Contact]] = field(
        default_factory=SingleFlight, init=False, compare=False, repr=False
    )
    _scope: SingleFlight[None, OutputScope] = field(
        default_factory=SingleFlight, init=False, compare=False, repr=False
    )
    # Names of the joints in each tree, filled on first use too: it is read for each joint.
    _inside: dict[str, frozenset[str]] = field(default_factory=dict, init=False, compare=False, repr=False)

    def joint(self, name: str) -> Joint:
        """Return the joint called `name`."""
        return self._named.get(None, lambda: {joint.name: joint for joint in self.joints})[name]

    @property
    def contacts(self) -> Mapping[str, FrameConstraint | Contact]:
        """The constraints between two frames, by name, with rigid contacts."""
        kinds = FrameConstraint | Contact
        return {part.name: part for part in self.model.constraints if isinstance(part, kinds)}

    def link(self, name: str) -> Joint | FrameConstraint | Contact | None:
        """Return what is called `name` and connects two frames, if it does."""
        return self._links.get(None, self._form_links).get(name)

    def _form_links(self) -> dict[str, Joint | FrameConstraint | Contact]:
        return {**self.contacts, **{joint.name: joint for joint in self.joints}}

    @property
    def output_scope(self) -> OutputScope:
        """What names of outputs refer to."""
        model = self.model
        elements = (*model.elements, *self.joints, *model.constraints)
        return self._scope.get(None, lambda: make_scope(elements, model.bodies, model.ground))

    @property
    def rotation_branches(self) -> frozenset[str]:
        """Names of the joints in the rotation tree."""
        return self._branch_names("rotation", self.rotation)

    @property
    def translation_branches(self) -> frozenset[str]:
        """Names of the joints in the translation tree."""
        return self._branch_names("translation", self.translation)

    @property
    def trees(self) -> Trees:
        """The choice that gives these trees again: the joints of the model in each."""
        names = [joint.name for joint in self.model.joints]
        return Trees(
            [name for name in names if name in self.rotation_branches],
            [name for name in names if name in self.translation_branches],
        )

    def _branch_names(self, kind: str, tree: SpanningTree) -> frozenset[str]:
        found = self._inside.get(kind)
        if found is None:
            found = self._inside[kind] = frozenset(branch.edge.name for branch in tree.branches)
        return found


def choose_topology(model: Model, choice: TreeChoice = None) -> Topology:
    """Return the model with its rotation and its translation tree.

    Parameters
    ----------
    choice : Trees, "joints", "absolute" or None
        The joints in the trees; those with the fewest coordinates, whatever the model's flags say;
        none; or, by default, the model's flags completed like "joints".

    Raises
    ------
    TopologyError
        If a choice has a cycle, names no joint, parts the coordinates of a joint that mixes them, or cuts one
        that shifts along a curve.
    """
    nodes = (GROUND, *(body.name for body in model.bodies))
    wishes = preferences(model, model.joints, choice)
    edges = tuple(Edge(joint.name, joint.start.body, joint.end.body) for joint in model.joints)
    graph = LinearGraph(nodes, edges)
    problems = [cycle_problem(kind, edges, wish.required) for kind, wish in wishes.items()]
    if any(problems):
        raise TopologyError(*(problem for problem in problems if problem))
    curved = {joint.name for joint in model.joints if is_curved(joint)}
    chosen = {
        kind: _forest(graph, model.joints, wish, curved if kind == "translation" else set())
        for kind, wish in wishes.items()
    }
    _check_curved(curved.difference(chosen["translation"]))
    loose = {kind: _loose(graph, names) for kind, names in chosen.items()}
    free = [
        _free(body.name, body.name in loose["rotation"], body.name in loose["translation"])
        for body in model.bodies
        if body.name in loose["rotation"] or body.name in loose["translation"]
    ]
    joints = (*model.joints, *free)
    trees = {kind: _tree(nodes, joints, {*chosen[kind], *loose[kind]}) for kind in chosen}
    topology = Topology(model, joints, trees["rotation"], trees["translation"], ())
    _check_mixing(topology)
    _check_count(topology)
    return Topology(model, joints, trees["rotation"], trees["translation"], _notes(topology, free))


def _forest(
    graph: LinearGraph, joints: Sequence[Joint], wish: Preference, first: Collection[str]
) -> tuple[str, ...]:
    """Return the required edges and as many of the allowed ones as the forest takes, cheapest first.

    Before all others those are taken that are named `first`.
    """
    names = {*wish.required, *wish.allowed}
    inside = LinearGraph(graph.nodes, tuple(edge for edge in graph.edges if edge.name in names))
    hops = inside.distances()
    weights: dict[str, tuple[float, ...]] = {}
    for edge, joint in zip(graph.edges, joints, strict=True):
        distance = min(hops.get(edge.start, len(hops)), hops.get(edge.end, len(hops)))
        weights[edge.name] = (
            edge.name not in wish.required,
            edge.name not in first,
            _cost(joint),
            distance,
        )
    return tuple(edge.name for edge in least_forest(inside, weights))


def _cost(joint: Joint) -> float:
    """Return how dear a joint is as a branch: its free coordinates; without names it would rather be cut."""
    known = 0 if joint.as_constraint else len(joint.motions)
    return len(joint.coordinates) - known + (0.0 if joint.has_named_coordinates else 0.5)


def _loose(graph: LinearGraph, names: Sequence[str]) -> tuple[str, ...]:
    """Return one body of each part that the edges `names` do not join to ground."""
    loose: list[str] = []
    joined = set(names)
    while missing := graph.unreached_nodes(joined, from_nodes=(graph.root, *loose)):
        loose.append(missing[0])
    return tuple(loose)


def _free(body: str, turns: bool, slides: bool) -> Free:
    """Return the virtual free joint of a body; it bears the body's name."""
    return Free(body, GROUND, body, tree=InTrees(turns, slides))


def _tree(nodes: tuple[str, ...], joints: Sequence[Joint], names: set[str]) -> SpanningTree:
    edges = tuple(Edge(joint.name, joint.start.body, joint.end.body) for joint in joints)
    return spanning_tree(LinearGraph(nodes, edges), names)


def _check_curved(cut: Collection[str]) -> None:
    """Refuse to cut joints that shift along a curve."""
    problems = [
        Problem("topology.curved_chord", f"joint {name}",
                "it translates along a curve, but the translation tree does not contain it",
                "such a joint must supply coordinates: loop-closure equations are valid for straight "
                "displacements only",
                "put it into the trees and cut another joint of its loop, or model the curve as a "
                "PointOnCurve")
        for name in sorted(cut)
    ]  # fmt: skip
    if problems:
        raise TopologyError(*problems)


def _check_mixing(topology: Topology) -> None:
    """Refuse a joint in one tree whose rotation and translation share a coordinate."""
    problems = [
        Problem("topology.mixed_joint", f"joint {joint.name}",
                f"it is in one tree only, but its rotation and translation share {shared}",
                "such a joint supplies all its coordinates or none", "put it in both trees or in neither")
        for joint in topology.joints
        if (joint.name in topology.rotation_branches) != (joint.name in topology.translation_branches)
        and (shared := _common_part(joint))
    ]  # fmt: skip
    if problems:
        raise TopologyError(*problems)


def _common_part(joint: Joint) -> str:
    """Return what rotation and translation of a joint have in common, or nothing."""
    both = joint.coupled_coordinates
    if joint.shift_in == "end":
        return "the axes of its end, along which it shifts"
    speeds = joint.translation_speeds
    if both or speeds is None or speeds.resolved_in == "start":
        return ", ".join(both)
    return "the axes of its end, in which the velocity is resolved"


def _check_count(topology: Topology) -> None:
    """Check that coordinates and locked directions of each tree make 3 for each body.

    Raises
    ------
    AssertionError
        If they do not: an error of the program, whatever the model is.
    """
    bodies = len(topology.model.bodies)
    locked: Mapping[str, Callable[[Joint], int]] = {
        "rotation": lambda joint: joint.locked_rotations,
        "translation": lambda joint: joint.locked_translations,
    }
    for kind, count in locked.items():
        tree: SpanningTree = getattr(topology, kind)
        joints = [topology.joint(branch.edge.name) for branch in tree.branches]
        freedoms = sum(3 - count(joint) for joint in joints)
        if freedoms + sum(map(count, joints)) != 3 * bodies:
            raise AssertionError(f"the {kind} tree does not reach all bodies")


def _notes(topology: Topology, free: Sequence[Free]) -> tuple[str, ...]:
    notes = []
    for joint in topology.model.joints:
        turns, slides = joint.name in topology.rotation_branches, joint.name in topology.translation_branches
        if not (turns or slides):
            reason = (
                "other joints of its loop lead to simpler equations"
                if joint.has_named_coordinates
                else "it names no coordinates"
            )
            reason = reason if joint.tree == InTrees() else "as the model says"
            notes.append(f"joint {joint.name} is cut: {reason}; the directions it locks become constraints")
        elif turns != slides:
            kind = "rotation" if turns else "translation"
            notes.append(f"joint {joint.name} is in the {kind} tree only")
        if (turns or slides) and not joint.has_named_coordinates:
            names = ", ".join(joint.coordinates)
            notes.append(f"joint {joint.name}: its unnamed coordinates are called {names}")
    for joint in free:
        parts = ["orientation"] if joint.tree.rotation else []
        parts += ["position"] if joint.tree.translation else []
        notes.append(f"body {joint.name} has absolute coordinates for its {' and '.join(parts)}")
    return tuple(notes)
