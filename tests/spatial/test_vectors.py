"""Rotations, frame trees and vectors against scipy's rotations and NumPy's products."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Reference

from symbody.errors import FrameError
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import operation_count
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.spatial.frame import FrameTree
from symbody.spatial.rotation import AxisRotation, Rotation, Triple, compose_steps, rotation_matrix
from symbody.spatial.vector import Vector, components, cross, dot, express, vector

ANGLES = {"a": 0.3, "b": -1.1, "c": 2.4}
# Entries are sums of at most 81 products of numbers below 1, each operation rounding once.
ROUNDING = 200 * np.finfo(float).eps


def values(graph: Graph, expressions: Sequence[Expr]) -> np.ndarray:
    inputs = {}
    numbers = []
    for k, (name, value) in enumerate(ANGLES.items()):
        inputs[graph.symbol(Symbol(name, SymbolKind.COORDINATE))] = Input(name, "q", k)
        numbers.append(value)
    roots = Roots("out", (len(expressions),), tuple(e.index for e in expressions))
    return np.array(evaluate_sequence(build_sequence(graph, [roots], inputs), {"q": numbers})[0])


def axis(graph: Graph, x: float, y: float, z: float) -> Triple:
    return (number(graph, x), number(graph, y), number(graph, z))


def angle(graph: Graph, name: str) -> Expr:
    return symbol(graph, Symbol(name, SymbolKind.COORDINATE))


def general_axis(graph: Graph) -> tuple[Triple, np.ndarray]:
    unit = np.array([0.36, -0.48, 0.8])
    return axis(graph, *unit), unit


@pytest.mark.parametrize("letters", ["xyz", "zxz", "zyx", "yxy", "xzx"])
def test_body_sequences_agree_with_scipy(letters: str) -> None:
    graph = Graph()
    units = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    turns = [
        AxisRotation(axis(graph, *units[letter]), angle(graph, n))
        for letter, n in zip(letters, "abc", strict=True)
    ]
    matrix = rotation_matrix(graph, compose_steps(turns))
    found = values(graph, [entry for row in matrix for entry in row]).reshape(3, 3)
    expected = Reference.from_euler(letters.upper(), list(ANGLES.values())).as_matrix()
    assert np.abs(found - expected).max() < ROUNDING


def test_general_axis_agrees_with_scipy_and_inverse_is_the_transpose() -> None:
    graph = Graph()
    components_, unit = general_axis(graph)
    rotation = compose_steps([AxisRotation(components_, angle(graph, "a"))])
    matrix = rotation_matrix(graph, rotation)
    back = rotation_matrix(graph, rotation.inverse)
    found = values(graph, [entry for row in matrix for entry in row]).reshape(3, 3)
    assert np.abs(found - Reference.from_rotvec(0.3 * unit).as_matrix()).max() < ROUNDING
    transposed = values(graph, [back[j][i] for i in range(3) for j in range(3)]).reshape(3, 3)
    assert np.abs(found - transposed).max() < ROUNDING


def test_turns_about_parallel_axes_merge() -> None:
    graph = Graph()
    z, minus_z = axis(graph, 0, 0, 1), axis(graph, 0, 0, -1)
    a, b = angle(graph, "a"), angle(graph, "b")
    assert compose_steps([AxisRotation(z, a), AxisRotation(z, b)]).turns == (AxisRotation(z, a + b),)
    assert compose_steps([AxisRotation(z, a), AxisRotation(minus_z, a)]) == Rotation()
    there = compose_steps([AxisRotation(z, a), AxisRotation(axis(graph, 1, 0, 0), b)])
    assert there.then(there.inverse) == Rotation()


def chain(graph: Graph) -> FrameTree:
    z, x = axis(graph, 0, 0, 1), axis(graph, 1, 0, 0)
    return FrameTree(
        graph,
        {
            "A": ("ground", compose_steps([AxisRotation(z, angle(graph, "a"))])),
            "B": ("A", compose_steps([AxisRotation(x, angle(graph, "b"))])),
            "C": ("A", compose_steps([AxisRotation(general_axis(graph)[0], angle(graph, "c"))])),
            "fixed": ("B", Rotation()),
        },
    )


def test_relative_rotation_goes_along_the_tree_only() -> None:
    tree = chain(Graph())
    assert len(tree.rotation("B", "A").turns) == 1
    assert len(tree.rotation("B", "C").turns) == 2
    assert tree.rotation("A", "A") == Rotation()
    assert tree.orientation_frame("fixed") == "B"


def test_unknown_frame_is_named_with_the_nearest() -> None:
    with pytest.raises(FrameError, match="'fixd'") as caught:
        chain(Graph()).path("fixd")
    assert "fixed" in caught.value.problems[0].fix


def test_products_do_not_depend_on_the_frames_of_the_terms() -> None:
    graph = Graph()
    tree = chain(graph)
    p = vector("B", axis(graph, 1, 2, -3)) + vector("C", axis(graph, 0.5, 0, 2))
    q = vector("A", axis(graph, -1, 4, 1)) + vector("B", axis(graph, 2, 0, 0))
    p0 = values(graph, list(components(tree, p, "ground")))
    q0 = values(graph, list(components(tree, q, "ground")))
    assert values(graph, [dot(tree, p, q)])[0] == pytest.approx(p0 @ q0, abs=100 * ROUNDING)
    found = values(graph, list(components(tree, cross(tree, p, q), "ground")))
    assert np.abs(found - np.cross(p0, q0)).max() < 100 * ROUNDING


def test_a_vector_in_one_frame_squares_without_any_rotation() -> None:
    graph = Graph()
    tree = chain(graph)
    v = vector("B", axis(graph, 3, 0, 4))
    assert dot(tree, v, v).number == 25
    assert operation_count(graph, [dot(tree, v, v).index]) == 0


def test_zero_terms_vanish() -> None:
    graph = Graph()
    v = vector("A", axis(graph, 1, 2, 3))
    assert (v - v).is_zero
    assert vector("A", axis(graph, 0, 0, 0)) == Vector({})
    assert express(chain(graph), v - v, "ground").is_zero


def test_matrices_are_orthogonal_without_being_told() -> None:
    # The fingerprint finds R R^T = 1: twelve outputs, none of which needs an operation.
    graph = Graph()
    rows = chain(graph).matrix("ground", "C")
    products = [sum((rows[i][k] * rows[j][k] for k in range(1, 3)), rows[i][0] * rows[j][0]) for i in range(3)
                for j in range(3)]  # fmt: skip
    found = values(graph, products).reshape(3, 3)
    assert np.abs(found - np.eye(3)).max() < ROUNDING
    assert math.isclose(found[0, 0], 1.0)
