"""The linear graph of a model and the trees that choose its coordinates.

The only file that knows both graphs and mechanics.
"""

from __future__ import annotations

from dataclasses import dataclass

from symbody.errors import FormulationError, Problem
from symbody.graph.linear_graph import Edge, LinearGraph
from symbody.graph.spanning_tree import SpanningTree, spanning_tree
from symbody.model.joint import Joint
from symbody.model.model import Model


@dataclass(frozen=True, slots=True)
class Topology:
    """A model with its trees.

    Attributes
    ----------
    tree : SpanningTree
        Rotation and translation tree, at present the same.
    notes : tuple of str
        Each choice that was made, with its reason.
    """

    model: Model
    tree: SpanningTree
    notes: tuple[str, ...]

    def joint(self, name: str) -> Joint:
        """Return the joint called `name`."""
        return next(joint for joint in self.model.joints if joint.name == name)


def choose_topology(model: Model) -> Topology:
    """Return the model with the tree of its joints.

    Raises
    ------
    FormulationError
        If a body is joined to nothing, or joints close a loop.
    """
    nodes = ("ground", *(body.name for body in model.bodies))
    edges = tuple(Edge(joint.name, joint.start.body, joint.end.body) for joint in model.joints)
    graph = LinearGraph(nodes, edges)
    problems = [_free_body(name) for name in graph.unreached()]
    problems += [_prescribed(joint, name) for joint in model.joints for name in joint.motions]
    if problems:
        raise FormulationError(*problems)
    tree = spanning_tree(graph, {joint.name: float(len(joint.coordinates)) for joint in model.joints})
    if tree.chords:
        raise FormulationError(*(_loop(edge) for edge in tree.chords))
    return Topology(model, tree, ())


def _free_body(name: str) -> Problem:
    return Problem(
        "topology.free_body", f"body {name}", "no chain of joints leads from ground to this body",
        "bodies that move freely are not covered by this version", "join it to ground or to another body",
    )  # fmt: skip


def _loop(edge: Edge) -> Problem:
    return Problem(
        "topology.loop", f"joint {edge.name}", f"the joint closes a loop between {edge.start} and {edge.end}",
        "closed loops are not covered by this version", "leave out one joint of the loop",
    )  # fmt: skip


def _prescribed(joint: Joint, coordinate: str) -> Problem:
    return Problem(
        "topology.prescribed_motion", f"joint {joint.name}", f"the motion of {coordinate} is prescribed",
        "prescribed motions are not covered by this version", "leave motion out, or give a drive",
    )  # fmt: skip
