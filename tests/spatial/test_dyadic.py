"""Tensors split by symmetry against plain matrices, and the spinning top free of its spin."""

from __future__ import annotations

import numpy as np
import pytest

from symbody.expr.expression import Expr, cos, number
from symbody.expr.graph import Graph
from symbody.expr.rewrite import operation_count
from symbody.spatial.dyadic import Dyadic, gyroscopic, quadratic, symmetric_split, times_vector
from symbody.spatial.euler_angles import euler_rotations
from symbody.spatial.frame import FrameTree
from symbody.spatial.matrix import Matrix, symmetric_tensor
from symbody.spatial.rotation import AxisRotation, Rotation, compose_steps
from symbody.spatial.vector import Vector, components, vector
from tests.spatial.numbers import matrix_of, matrix_values, named, names_in, triple, values

EPS = np.finfo(float).eps
# Sums of some 100 products of numbers below 10 * 3 * 3, through at most six turns.
ROUNDING = 100 * 90 * EPS

AT = {"a": 0.4, "b": 1.1, "c": -2.2, "A": 3.0, "B": 5.0, "C": 7.0, "p": 0.3, "r": -0.6, "s": 0.9}


def tensor(graph: Graph, moments: str, products: str = "0 0 0") -> Matrix:
    xx, yy, zz, xy, xz, yz = (
        number(graph, 0) if word == "0" else named(graph, word)[0]
        for word in (moments + " " + products).split()
    )
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


TENSORS = [
    ("A A A", "0 0 0"), ("A A C", "0 0 0"), ("C A A", "0 0 0"), ("A C A", "0 0 0"), ("0 0 C", "0 0 0"),
    ("0 C 0", "0 0 0"), ("A A 0", "0 0 0"), ("A B C", "0 0 0"), ("A A C", "p 0 0"), ("A B C", "p r s"),
    ("0 0 0", "0 0 0"),
]  # fmt: skip


def spun_tree(graph: Graph) -> FrameTree:
    """Return 3-1-3 turns with a frame each, a frame at rest in the last, and a bent branch."""
    parents: dict[str, tuple[str, Rotation]] = {}
    up = "ground"
    for k, turn in enumerate(euler_rotations(graph, "313", named(graph, "a b c"))):
        parents[f"F{k + 1}"] = (up, compose_steps([turn]))
        up = f"F{k + 1}"
    parents["CoM"] = ("F3", Rotation())
    parents["G"] = ("F1", compose_steps([AxisRotation(triple(graph, 0.6, 0.0, 0.8), named(graph, "c")[0])]))
    return FrameTree(graph, parents)


def scattered(graph: Graph, seed: int) -> Vector:
    source = np.random.default_rng(seed)
    result = Vector({})
    for frame in ("F1", "F3", "G", "ground"):
        result = result + vector(frame, triple(graph, *source.uniform(-1, 1, 3).tolist()))
    return result


@pytest.mark.parametrize(("moments", "products"), TENSORS)
def test_products_agree_with_plain_matrices(moments: str, products: str) -> None:
    graph = Graph()
    tree = spun_tree(graph)
    plain = tensor(graph, moments, products)
    dyadic = symmetric_split("CoM", plain)
    a, b = scattered(graph, 1), scattered(graph, 2)
    r = matrix_values(graph, tree.matrix("ground", "CoM"), AT)
    d = r @ matrix_values(graph, plain, AT) @ r.T
    x, y = (values(graph, components(tree, v, "ground"), AT) for v in (a, b))
    assert (
        np.abs(values(graph, components(tree, times_vector(tree, dyadic, a), "ground"), AT) - d @ x).max()
        < ROUNDING
    )
    assert abs(values(graph, [quadratic(tree, a, dyadic, b)], AT)[0] - x @ d @ y) < ROUNDING
    swirl = components(tree, gyroscopic(tree, a, dyadic), "ground")
    assert np.abs(values(graph, swirl, AT) - np.cross(x, d @ x)).max() < 3 * ROUNDING


def test_symmetry_is_seen_on_the_graph() -> None:
    graph = Graph()
    a, c = named(graph, "A C")
    x, y, z = triple(graph, 1, 0, 0), triple(graph, 0, 1, 0), triple(graph, 0, 0, 1)
    zero = number(graph, 0)
    assert symmetric_split("F", tensor(graph, "A A A")) == Dyadic("F", a)
    assert symmetric_split("F", tensor(graph, "A A C")) == Dyadic("F", a, (c - a, z))
    assert symmetric_split("F", tensor(graph, "A C A")) == Dyadic("F", a, (c - a, y))
    assert symmetric_split("F", tensor(graph, "C A A")) == Dyadic("F", a, (c - a, x))
    assert symmetric_split("F", tensor(graph, "0 0 C")) == Dyadic("F", zero, (c, z))
    for moments, products in (("A B C", "0 0 0"), ("A A C", "p 0 0")):
        plain = tensor(graph, moments, products)
        assert symmetric_split("F", plain) == Dyadic("F", zero, unresolved=symmetric_tensor(plain))


def test_tensors_rest_where_they_stay_the_same() -> None:
    graph = Graph()
    tree = spun_tree(graph)
    for moments, frame in (
        ("A A A", "ground"),
        ("A A C", "F2"),
        ("0 0 C", "F2"),
        ("C A A", "F3"),
        ("A B C", "F3"),
    ):
        assert symmetric_split("CoM", tensor(graph, moments)).simplest_frame(tree) == frame


def test_turning_axes_may_point_either_way_but_not_elsewhere() -> None:
    graph = Graph()
    (a,) = named(graph, "a")
    four = compose_steps([AxisRotation(triple(graph, 0, 0, -1), a)])
    tree = FrameTree(
        graph, {"A": ("ground", four), "B": ("A", compose_steps([AxisRotation(triple(graph, 1, 0, 0), a)]))}
    )
    split = symmetric_split("A", tensor(graph, "A A C"))
    assert split.simplest_frame(tree) == "ground"
    assert symmetric_split("B", tensor(graph, "A A C")).simplest_frame(tree) == "B"
    assert symmetric_split("B", tensor(graph, "C A A")).simplest_frame(tree) == "A"


def spinning_top(graph: Graph) -> tuple[FrameTree, Vector, Dyadic]:
    tree = spun_tree(graph)
    rates = named(graph, "a' b' c'")
    w = Vector({})
    for k, (turn, rate) in enumerate(
        zip(euler_rotations(graph, "313", named(graph, "a b c")), rates, strict=True)
    ):
        x, y, z = turn.axis
        w = w + vector(f"F{k + 1}", (x * rate, y * rate, z * rate))
    return tree, w, symmetric_split("CoM", tensor(graph, "A A C"))


def test_the_top_never_sees_its_spin_angle() -> None:
    graph = Graph()
    tree, w, inertia = spinning_top(graph)
    energy = quadratic(tree, w, inertia, w)
    assert names_in(energy) == {"A", "C", "b", "a'", "b'", "c'"}
    angular_momentum = times_vector(tree, inertia, w)
    moment = gyroscopic(tree, w, inertia)
    for v in (angular_momentum, moment):
        # The term of the spin itself stands in F3, along the axis; no term is turned by c.
        assert names_in(*(x for triple_ in v.terms.values() for x in triple_)) <= {
            "A",
            "C",
            "b",
            "a'",
            "b'",
            "c'",
        }
        assert "c" not in names_in(*components(tree, v, "ground"))
    assert "CoM" not in moment.terms and "F3" not in moment.terms


def test_the_energy_of_the_top_is_the_one_of_the_books() -> None:
    graph = Graph()
    tree, w, inertia = spinning_top(graph)
    (a, c, eta, zeta_rate, eta_rate, xi_rate) = named(graph, "A C b a' b' c'")
    along = xi_rate + zeta_rate * cos(eta)
    across: Expr = zeta_rate * zeta_rate * (1 - cos(eta) * cos(eta)) + eta_rate * eta_rate
    at = AT | {"a'": 0.7, "b'": -1.2, "c'": 2.9}
    found, expected = values(graph, [quadratic(tree, w, inertia, w), a * across + c * along * along], at)
    # Sums of some ten terms below C * 4^2.
    assert abs(found - expected) < 20 * 7 * 16 * EPS


def test_isotropic_bodies_have_no_gyroscopic_moment() -> None:
    graph = Graph()
    tree = spun_tree(graph)
    split = symmetric_split("CoM", tensor(graph, "A A A"))
    assert gyroscopic(tree, scattered(graph, 1), split).is_zero
    v = scattered(graph, 2)
    assert list(times_vector(tree, split, v).terms) == list(v.terms)


def test_eulers_equations_of_principal_axes_need_three_products_each() -> None:
    graph = Graph()
    tree = spun_tree(graph)
    p, r, s = named(graph, "p r s")
    a, b, c = named(graph, "A B C")
    moment = gyroscopic(tree, vector("CoM", (p, r, s)), symmetric_split("CoM", tensor(graph, "A B C")))
    found = components(tree, moment, "CoM")
    assert found == ((c - b) * (r * s), (a - c) * (s * p), (b - a) * (p * r))
    assert operation_count(graph, [x.index for x in found]) == 9


def test_moments_of_rounded_numbers_split_too() -> None:
    graph = Graph()
    plain = matrix_of(graph, np.diag([0.25, 0.25, 2.0]).tolist())
    # Products given as 0.0 are rounded zeros, so nothing is taken for granted.
    assert symmetric_split("F", plain).unresolved is not None
    exact = number(graph, 0)
    clean = ((plain[0][0], exact, exact), (exact, plain[1][1], exact), (exact, exact, plain[2][2]))
    split = symmetric_split("F", clean)
    assert split.axial is not None and split.axial[0].number == 1.75
