"""Linear graphs and spanning trees, on bare graphs."""

from __future__ import annotations

from symbody.graph.linear_graph import Edge, LinearGraph
from symbody.graph.spanning_tree import SpanningTree, least_forest, spanning_tree

FOUR_BAR = LinearGraph(
    ("ground", "crank", "rod", "rocker"),
    (
        Edge("A", "ground", "crank"),
        Edge("B", "crank", "rod"),
        Edge("C", "rocker", "rod"),
        Edge("D", "ground", "rocker"),
    ),
)


def least_tree(graph: LinearGraph, weights: dict[str, float]) -> SpanningTree:
    forest = least_forest(graph, {name: (weight,) for name, weight in weights.items()})
    return spanning_tree(graph, [edge.name for edge in forest])


def test_every_body_is_reached_once_and_parents_come_first() -> None:
    tree = least_tree(FOUR_BAR, {})
    children = [branch.child for branch in tree.branches]
    assert sorted(children) == ["crank", "rocker", "rod"]
    placed = {"ground"}
    for branch in tree.branches:
        assert branch.parent in placed
        placed.add(branch.child)
    assert len(tree.chords) == 1


def test_the_heaviest_joint_of_a_loop_is_cut() -> None:
    for name in "ABCD":
        tree = least_tree(FOUR_BAR, {name: 1.0})
        assert [edge.name for edge in tree.chords] == [name]


def test_direction_of_a_branch_is_told() -> None:
    tree = least_tree(FOUR_BAR, {"B": 1.0})
    forward = {branch.edge.name: branch.forward for branch in tree.branches}
    assert forward == {"A": True, "D": True, "C": True}
    tree = least_tree(FOUR_BAR, {"D": 1.0})
    assert {branch.edge.name: branch.forward for branch in tree.branches}["C"] is False


def test_parallel_edges_leave_the_later_as_chord() -> None:
    graph = LinearGraph(("ground", "a"), (Edge("first", "ground", "a"), Edge("second", "a", "ground")))
    assert [edge.name for edge in least_tree(graph, {}).chords] == ["second"]


def test_unreached_nodes_are_told() -> None:
    graph = LinearGraph(("ground", "a", "b", "c"), (Edge("e", "ground", "a"), Edge("f", "b", "c")))
    assert graph.unreached_nodes() == ("b", "c")
    assert graph.unreached_nodes(["f"]) == ("a", "b", "c")


def test_a_thousand_bodies_need_no_recursion() -> None:
    names = ("ground", *(f"b{k}" for k in range(1000)))
    edges = tuple(Edge(f"e{k}", names[k], names[k + 1]) for k in range(1000))
    tree = least_tree(LinearGraph(names, edges), {})
    assert [branch.child for branch in tree.branches] == list(names[1:])
