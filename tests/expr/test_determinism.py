"""The same bytes in every process: hashes, fingerprints, derivatives, printed forms, sequences."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given

from symbody.expr import opcodes as op
from symbody.expr.calculus import gradient, jacobian
from symbody.expr.canonical import add, apply, div, mul, select, sub
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.trigonometry.normal_form import trigonometric_form
from tests.expr.strategies import Sample, both_tiers, built_shuffled, samples, sequence_of
from tests.tiers import cases

ROOT = Path(__file__).parents[2]


def report(seed: int) -> str:
    """Everything that must not depend on the process, for a random graph of the kind a mechanism makes."""
    rng = random.Random(seed)
    graph = Graph()
    q = [graph.symbol(Symbol(name, SymbolKind.COORDINATE)) for name in "xyz"]
    p = [graph.symbol(Symbol(f"m{k}")) for k in range(4)]
    nodes = [*p, *[apply(graph, code, a) for a in (*q, add(graph, q[0], q[1])) for code in (op.SIN, op.COS)]]
    products = [mul(graph, mul(graph, rng.choice(p), rng.choice(nodes)), rng.choice(nodes)) for _ in range(8)]
    total = products[0]
    for node in products[1:]:
        total = add(graph, total, node)
    for _ in range(100):
        rule = rng.choice([add, sub, mul, lambda g, a, b: apply(g, op.ATAN, a)])
        nodes.append(rule(graph, rng.choice(nodes), rng.choice(nodes)))
    below = apply(graph, op.LT, nodes[-1], nodes[-2])
    root = select(graph, below, nodes[-3], div(graph, nodes[-4], add(graph, nodes[-5], p[0])))
    roots = [root, total, *trigonometric_form(graph, [total]), *gradient(graph, root, q)]
    roots += [slope for row in jacobian(graph, products, q) for slope in row]
    values = fingerprints(graph, graph.reachable(roots))
    inputs = {node: Input(f"i{k}", "q", k) for k, node in enumerate([*q, *p])}
    sequence = build_sequence(graph, [Roots("f", (len(roots),), tuple(roots))], inputs)
    return f"{[(graph.hashes[k], values[k]) for k in roots]}\n{sequence}"


@pytest.mark.parametrize("seed", cases(range(2), fast=[1]))
def test_processes_agree_whatever_their_hash_seed(seed: int) -> None:
    code = f"from tests.expr.test_determinism import report; print(report({seed}))"
    reports = []
    for hash_seed in ("0", "1", "4242"):
        path = os.pathsep.join([str(ROOT / "src"), str(ROOT)])
        environment = {**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": path}
        run = subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, check=True, timeout=60
        )
        reports.append(run.stdout.strip())
    assert reports[0] == reports[1] == reports[2] == report(seed).encode()
    assert len(reports[0]) > 5_000


@both_tiers
@given(samples())
def test_sequences_depend_neither_on_the_order_of_building_nor_on_what_else_the_graph_holds(
    sample: Sample,
) -> None:
    found = []
    for seed in range(2):
        graph = Graph()
        root = built_shuffled(sample.program, graph, random.Random(seed))
        found.append(sequence_of(graph, [root]))
    assert found[0] == found[1]


@both_tiers
@given(samples(ops=(op.ADD, op.SUB, op.MUL, op.POW, op.SIN, op.COS, op.SQRT)))
def test_printed_forms_do_not_depend_on_the_order_of_building(sample: Sample) -> None:
    found = []
    for seed in range(2):
        graph = Graph()
        root = built_shuffled(sample.program, graph, random.Random(seed))
        found.append([graph.hashes[k] for k in trigonometric_form(graph, [root])])
    assert found[0] == found[1]


def test_one_call_after_another_gives_the_same() -> None:
    assert report(5) == report(5)
