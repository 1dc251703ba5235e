"""Frame trees that grow, and what relative rotations cost along them."""

from __future__ import annotations

import random

import numpy as np
import pytest

from symbody.errors import FrameError
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.spatial.euler_angles import euler_rotations
from symbody.spatial.frame import FrameTree
from symbody.spatial.matrix import Matrix3, Vector3, identity
from symbody.spatial.rotation import (
    AxisRotation,
    DirectionCosines,
    EulerParameters,
    Rotation,
    compose_steps,
    rotation_matrix,
)
from symbody.spatial.vector import components, dot, express_near, vector
from tests.spatial.numbers import matrix_of, matrix_values, named, names_in, triple, values

EPS = np.finfo(float).eps


def grow(tree: FrameTree, name: str, parent: str, rotation: Rotation) -> None:
    parents = tree.parents
    assert isinstance(parents, dict)
    parents[name] = (parent, rotation)


def random_axis(source: random.Random) -> tuple[float, float, float]:
    x, y, z = (source.gauss(0, 1) for _ in range(3))
    size = (x * x + y * y + z * z) ** 0.5
    return (x / size, y / size, z / size)


def random_tree(seed: int, size: int) -> tuple[FrameTree, dict[str, float]]:
    """Return a tree of turns about coordinate axes, quaternions, and frames that do not turn."""
    source = random.Random(seed)
    graph = Graph()
    at = {f"q{k}": source.uniform(-3, 3) for k in range(size)} | {"e0": 0.5, "e1": -0.1, "e2": 0.7, "e3": 0.5}
    four = EulerParameters(*named(graph, "e0 e1 e2 e3"))
    parents: dict[str, tuple[str, Rotation]] = {}
    tree = FrameTree(graph, parents)
    for k in range(size):
        (angle,) = named(graph, f"q{k}")
        axis = source.choice([(1, 0, 0), (0, 0, 1), (0, 0, -1), random_axis(source)])
        steps = source.choice(
            [(), (four,), (four.inverse,), *[(AxisRotation(triple(graph, *axis), angle),)] * 5]
        )
        grow(tree, f"f{k}", source.choice(["ground", *parents][-3:]), compose_steps(steps))
    return tree, at


@pytest.mark.parametrize("seed", range(4))
def test_every_pair_is_the_product_along_the_tree(seed: int) -> None:
    tree, at = random_tree(seed, 12)
    graph = tree.graph
    from_ground = {"ground": np.eye(3)}
    for name, (parent, rotation) in tree.parents.items():
        from_ground[name] = from_ground[parent] @ matrix_values(graph, rotation_matrix(graph, rotation), at)
    pairs = [(a, b) for a in from_ground for b in from_ground]
    random.Random(seed).shuffle(pairs)
    for a, b in pairs:
        found = matrix_values(graph, tree.matrix(a, b), at)
        # At most 24 factors with errors of some 10 eps each, on both sides; the norm of the parameters is 1.
        assert np.abs(found - from_ground[a].T @ from_ground[b]).max() < 500 * EPS
        assert tree.matrix(b, a) == tree.matrix(a, b).T
        assert tree.rotation(a, b).then(tree.rotation(b, a)) == Rotation()


def counted_products(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    count: list[int] = []

    multiply = Matrix3.__matmul__

    def product(a: Matrix3[Expr], b: Matrix3[Expr] | Vector3[Expr]) -> Matrix3[Expr] | Vector3[Expr]:
        if isinstance(b, Matrix3):
            count.append(1)
        return multiply(a, b)

    monkeypatch.setattr(Matrix3, "__matmul__", product)
    return count


def random_chain(size: int) -> FrameTree:
    source = random.Random(1)
    graph = Graph()
    parents: dict[str, tuple[str, Rotation]] = {}
    up = "ground"
    for k in range(size):
        turn = AxisRotation(triple(graph, *random_axis(source)), named(graph, f"q{k}")[0])
        parents[f"f{k}"] = (up, compose_steps([turn]))
        up = f"f{k}"
    return FrameTree(graph, parents)


def test_a_chain_costs_one_product_a_pair(monkeypatch: pytest.MonkeyPatch) -> None:
    count = counted_products(monkeypatch)
    tree = random_chain(20)
    frames = ["ground", *tree.parents]
    for frame in frames:
        tree.matrix("ground", frame)
    assert len(count) == 19  # the first needs none
    for frame in frames:
        tree.matrix(frame, "f19")
    assert len(count) == 19 + 18
    for a in frames:
        for b in frames:
            tree.matrix(a, b)
    assert len(count) == 19 * 20 / 2  # pairs of frames that are not neighbours


def test_many_frames_seen_from_one_far_end_cost_one_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    count = counted_products(monkeypatch)
    tree = random_chain(20)
    for frame in ["ground", *tree.parents]:
        tree.matrix(frame, "f19")
    assert len(count) == 19


def test_parallel_turns_merge_across_frames_and_branches(monkeypatch: pytest.MonkeyPatch) -> None:
    count = counted_products(monkeypatch)
    graph = Graph()
    a, b, c, d = named(graph, "a b c d")
    z = triple(graph, 0, 0, 1)
    tree = FrameTree(graph, {
        "A": ("ground", compose_steps([AxisRotation(z, a)])), "B": ("A", compose_steps([AxisRotation(z, b)])),
        "C": ("ground", compose_steps([AxisRotation(z, c)])), "D": ("C", compose_steps([AxisRotation(z, a - c)])),
        "E": ("B", compose_steps(euler_rotations(graph, "313", (d, c, a)))),
    })  # fmt: skip
    assert tree.rotation("ground", "B").turns == (AxisRotation(z, a + b),)
    assert tree.rotation("D", "A") == Rotation()
    assert tree.rotation("D", "B").turns == (AxisRotation(z, b),)
    assert tree.matrix("D", "B") is tree.matrix("A", "B")
    assert not count
    assert tree.rotation("A", "E").turns[0] == AxisRotation(z, b + d)
    # The third axis of E does not know of the last turn.
    assert names_in(*(row[2] for row in tree.matrix("A", "E"))) == {"b", "c", "d"}


def test_what_was_found_stays_right_while_frames_are_added() -> None:
    graph = Graph()
    a, b = named(graph, "a b")
    z = triple(graph, 0, 0, 1)
    tree = FrameTree(graph, {})
    with pytest.raises(FrameError, match="no frame 'A'"):
        tree.depth("A")
    grow(tree, "A", "ground", compose_steps([AxisRotation(z, a)]))
    before = tree.matrix("ground", "A")
    assert (tree.depth("A"), tree.orientation_frame("A"), tree.path("A")) == (1, "A", ("A", "ground"))
    grow(tree, "B", "A", Rotation())
    grow(tree, "C", "B", compose_steps([AxisRotation(z, b)]))
    assert (tree.depth("C"), tree.orientation_frame("B"), tree.orientation_frame("C")) == (3, "A", "C")
    assert tree.path("C") == ("C", "B", "A", "ground")
    assert tree.matrix("ground", "A") is before
    assert tree.rotation("ground", "C").turns == (AxisRotation(z, a + b),)


def test_long_chains_need_no_recursion() -> None:
    parents = {f"f{k + 1}": (f"f{k}", Rotation()) for k in range(5000)} | {"f0": ("ground", Rotation())}
    tree = FrameTree(Graph(), parents)
    assert tree.depth("f5000") == 5001 and tree.orientation_frame("f5000") == "ground"
    assert len(tree.path("f5000")) == 5002


def test_frames_that_lead_nowhere_are_refused() -> None:
    tree = FrameTree(Graph(), {"A": ("B", Rotation()), "B": ("A", Rotation()), "C": ("grond", Rotation())})
    with pytest.raises(FrameError, match="circle"):
        tree.place("A")
    with pytest.raises(FrameError, match="'grond'") as caught:
        tree.place("C")
    assert "'C'" in caught.value.problems[0].why and "ground" in caught.value.problems[0].fix


def test_products_commute_as_nodes() -> None:
    tree, _ = random_tree(1, 8)
    graph = tree.graph
    a = vector("f7", triple(graph, 1, 2, -3)) + vector("f3", triple(graph, 0.5, 0, 2))
    b = vector("f5", triple(graph, -1, 4, 1)) + vector("ground", triple(graph, 2, 0, 0))
    assert dot(tree, a, b) == dot(tree, b, a)


def test_vectors_of_many_terms_are_drawn_near() -> None:
    tree, at = random_tree(2, 6)
    graph = tree.graph
    a = vector("f5", triple(graph, 1, 2, -3)) + vector("f1", triple(graph, 0.5, 0, 2))
    short = express_near(tree, a, "f3")
    assert list(short.terms) == ["f3"]
    found = values(graph, components(tree, short, "ground"), at)
    # Components below 6 through at most 12 factors each way.
    assert np.abs(found - values(graph, components(tree, a, "ground"), at)).max() < 3000 * EPS


def test_a_single_term_across_parallel_turns_is_left() -> None:
    graph = Graph()
    zero, one = number(graph, 0), number(graph, 1)
    angles = [Expr(graph, graph.symbol(Symbol(name, SymbolKind.COORDINATE))) for name in "abc"]
    parents = {}
    for k, angle in enumerate(angles):
        parents[f"f{k}"] = (
            f"f{k - 1}" if k else "ground",
            Rotation((AxisRotation((zero, zero, one), angle),)),
        )
    tree = FrameTree(graph, parents)
    a = vector("f0", (one, zero, zero))
    assert express_near(tree, a, "f2") is a
    assert list(express_near(tree, a, "f1").terms) == ["f1"]


def test_cosines_enter_a_tree_as_they_are() -> None:
    graph = Graph()
    rows = [[0.0, -1.0, 0.0], [0.6, 0.0, -0.8], [0.8, 0.0, 0.6]]
    cosines = matrix_of(graph, rows)
    step = compose_steps([DirectionCosines(cosines)])
    tree = FrameTree(graph, {"A": ("ground", step), "B": ("A", step.inverse)})
    assert tree.matrix("ground", "A") == cosines
    assert tree.matrix("ground", "B") == identity(graph)
