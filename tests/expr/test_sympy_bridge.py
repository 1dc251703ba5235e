"""SymPy at the border: what comes in, what goes out, and what is left of it after both."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from sympy.physics.vector import dynamicsymbols

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, add, apply, div, mul, neg, power, select, sub
from symbody.expr.evaluate import MPMATH, evaluate_sequence
from symbody.expr.expression import Expr, cos, sin, symbol
from symbody.expr.fingerprint import fingerprints
from symbody.expr.graph import TIME, Graph, Kernel, Kind, Symbol
from symbody.expr.rewrite import substitute, tree_size
from symbody.expr.sympy_bridge import (
    from_sympy,
    nodes_from_sympy,
    sympy_equations,
    sympy_matrix,
    to_sympy,
    to_sympy_with_definitions,
)
from tests.expr.strategies import ARITHMETIC, DIGITS, Sample, both_tiers, built, mpmath_values, samples, sequence_of

t = dynamicsymbols._t
x, y = dynamicsymbols("x y")
m, k, d, l = sp.symbols("m k d l")
NAMES = "I E S N O Q pi lambda Lambda beta gamma zeta re im sign test sum max True None nan oo e j".split()

# Operations that SymPy rearranges by identities of fields and circles only, which fingerprints know.
FIELD = (op.NEG, op.ADD, op.SUB, op.MUL, op.DIV, op.SIN, op.COS)


@pytest.fixture
def graph() -> Graph:
    return Graph()


def out(graph: Graph, node: int) -> sp.Expr:
    return to_sympy(graph, [node])[0]


def fingerprint(graph: Graph, node: int) -> tuple[int, int]:
    return fingerprints(graph, graph.reachable([0, ONE, node]))[node]


# --- laws -------------------------------------------------------------------------------------


@both_tiers
@given(samples(FIELD))
def test_out_and_in_again_is_the_same_function_and_then_the_same_node(sample: Sample) -> None:
    graph = Graph()
    node = built(sample.program, graph)[-1]
    again = from_sympy(out(graph, node), graph)
    assert fingerprint(graph, again) == fingerprint(graph, node)
    assert from_sympy(out(graph, again), graph) == again


@both_tiers
@given(samples(FIELD))
def test_in_and_out_again_is_the_same_object(sample: Sample) -> None:
    graph = Graph()
    expression = out(graph, built(sample.program, graph)[-1])
    other = Graph()
    assert out(other, from_sympy(expression, other)) == expression


@both_tiers
@given(samples())
def test_every_operation_keeps_its_value(sample: Sample) -> None:
    graph = Graph()
    node = built(sample.program, graph)[-1]
    again = from_sympy(out(graph, node), graph)
    with mpmath.workdps(DIGITS):
        point = [mpmath.mpf(value.numerator) / value.denominator for value in sample.point]
        exact = mpmath_values(sample.program, point)[-1]
        value = evaluate_sequence(sequence_of(graph, [again]), {"q": point}, MPMATH)[0][0]
    # Of 80 digits, 12 tame steps lose fewer than 40: each magnifies errors by at most 200/0.02 = 1e4 ... on
    # the way, and so do those of the rearranged formula.
    assert abs(value - exact) < mpmath.mpf(10) ** -30
