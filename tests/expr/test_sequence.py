"""Sequences: straight lines pruned to their outputs, split without a change of bits, portable."""

from __future__ import annotations

import pickle
import random
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.errors import CompileError
from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, TWO, ZERO, add, apply, div, mul, power, select, sub
from symbody.expr.graph import TIME, Graph, KernelNode, Symbol, SymbolKind
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Operation, Output, Roots, Sequence, build_sequence
from tests.expr.strategies import SYMBOLS, Sample, both_tiers, built, samples, sequence_of

GROUPS = ("q", "p", "u")


class Pen:
    """Three symbols read from the groups q, p and u."""

    def __init__(self) -> None:
        self.g = Graph()
        self.x, self.y, self.z = (self.g.symbol(symbol) for symbol in SYMBOLS)
        self.inputs = {
            node: Input(symbol.label, group, 0)
            for node, symbol, group in zip((self.x, self.y, self.z), SYMBOLS, GROUPS, strict=True)
        }

    def sequence(self, *roots: int) -> Sequence:
        return build_sequence(self.g, [Roots("f", (len(roots),), roots)], self.inputs)


def values(sequence: Sequence, x: float, y: float, z: float) -> list[str]:
    groups = {"q": [x], "p": [y], "u": [z]}
    return [float(value).hex() for output in evaluate_sequence(sequence, groups) for value in output]


def check_line(sequence: Sequence) -> None:
    """Operands come before their use, every value is used, conditions stay where conditions belong."""
    used = {k for output in sequence.outputs for k in output.values}
    for k, operation in enumerate(sequence.operations):
        assert all(j < k for j in operation.operands)
        used.update(operation.operands)
        for place, j in enumerate(operation.operands):
            if sequence.operations[j].op in op.CONDITIONS:
                assert operation.op in op.CONDITIONS or (operation.op == op.SELECT and place == 0)
    assert used == set(range(len(sequence.operations)))
    assert not any(sequence.operations[k].op in op.CONDITIONS for o in sequence.outputs for k in o.values)
    for operation in sequence.operations:
        if operation.op == op.SYMBOL:
            assert operation.datum < len(sequence.inputs)


@both_tiers
@given(samples())
def test_lines_are_straight_and_pruned(sample: Sample) -> None:
    graph = Graph()
    nodes = built(sample.program, graph)
    for merge in (True, False):
        for contract in (True, False):
            check_line(sequence_of(graph, nodes[-1:], merge=merge, contract=contract))


@both_tiers
@given(samples(), st.sets(st.sampled_from(GROUPS)))
def test_a_split_sequence_gives_the_same_bits(sample: Sample, groups: set[str]) -> None:
    pen = Pen()
    sequence = pen.sequence(*built(sample.program, pen.g)[-2:])
    head, tail = sequence.split(groups)
    check_line(head)
    check_line(tail)
    assert {entry.group for k, entry in enumerate(head.inputs) if _reads(head, k)} <= groups
    point = [float(x) for x in sample.point]
    by_group = {group: [x] for group, x in zip(GROUPS, point, strict=True)}
    by_group["c"] = evaluate_sequence(head, by_group)[0]
    found = [float(value).hex() for output in evaluate_sequence(tail, by_group) for value in output]
    assert found == values(sequence, *point)


def _reads(sequence: Sequence, place: int) -> bool:
    return any(o.op == op.SYMBOL and o.datum == place for o in sequence.operations)


def test_what_depends_on_the_groups_alone_is_computed_ahead() -> None:
    pen = Pen()
    g = pen.g
    early = apply(g, op.SIN, mul(g, pen.y, pen.y))
    head, tail = pen.sequence(add(g, mul(g, early, pen.x), early), early).split(["p"])
    assert {operation.op for operation in head.operations} == {op.SYMBOL, op.POW, op.RATIONAL, op.SIN}
    assert op.SIN not in {operation.op for operation in tail.operations}
    assert head.outputs[0].shape == (1,)
    assert [entry.name for entry in tail.inputs][-1] == "c0"
    assert tail.group_size("c") == 1


def test_conditions_are_not_handed_over_as_numbers() -> None:
    """A condition on the parameters alone is decided in the tail, from what the head computes."""
    pen = Pen()
    g = pen.g
    condition = apply(g, op.LT, apply(g, op.EXP, pen.y), g.constant(3))
    both = apply(g, op.AND, condition, apply(g, op.LT, ONE, pen.y))
    root = select(g, both, pen.x, mul(g, TWO, pen.x))
    sequence = pen.sequence(root, select(g, condition, pen.z, pen.y))
    head, tail = sequence.split(["p"])
    check_line(head)
    check_line(tail)
    assert op.EXP not in {operation.op for operation in tail.operations}
    for y in (0.5, 1.05, 2.0):
        numbers = {"q": [3.0], "p": [y], "u": [7.0]}
        numbers["c"] = evaluate_sequence(head, numbers)[0]
        assert evaluate_sequence(tail, numbers) == evaluate_sequence(sequence, numbers)


def test_kernels_are_split_at_their_results() -> None:
    pen = Pen()
    g = pen.g
    saddle = g.many(op.SADDLE, (pen.y, ONE), g.kernel(KernelNode(1, 0)))
    pick = g.node(op.PICK, saddle, 0)
    head, tail = pen.sequence(mul(g, pick, pen.x), pick).split(["p"])
    assert op.SADDLE in {operation.op for operation in head.operations}
    assert op.SADDLE not in {operation.op for operation in tail.operations}
    with_input = pen.sequence(g.node(op.PICK, g.many(op.SADDLE, (pen.y, pen.x), 0), 0)).split(["p"])
    assert op.SADDLE in {operation.op for operation in with_input[1].operations}


def test_splitting_off_nothing_leaves_everything() -> None:
    pen = Pen()
    sequence = pen.sequence(mul(pen.g, pen.x, pen.y))
    head, tail = sequence.split([])
    assert head.operations == ()
    assert head.outputs == (Output("c", (0,), ()),)
    assert tail.operations == sequence.operations


def test_constants_alone_can_be_split_off() -> None:
    pen = Pen()
    g = pen.g
    head, tail = pen.sequence(mul(g, apply(g, op.SIN, ONE), pen.x)).split([])
    assert {operation.op for operation in head.operations} == {op.RATIONAL, op.SIN}
    assert op.SIN not in {operation.op for operation in tail.operations}


@both_tiers
@given(samples())
def test_sequences_pickle(sample: Sample) -> None:
    graph = Graph()
    sequence = sequence_of(graph, built(sample.program, graph)[-1:])
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        back = pickle.loads(pickle.dumps(sequence, protocol))
        assert back == sequence
        assert hash(back) == hash(sequence)
        assert [type(value) for value in back.constants] == [type(value) for value in sequence.constants]


def test_missing_symbols_are_named_all_at_once() -> None:
    pen = Pen()
    g = pen.g
    k, rate = g.symbol(Symbol("k")), g.symbol(Symbol("q", SymbolKind.COORDINATE, 1))
    root = add(g, mul(g, k, pen.x), add(g, rate, g.symbol(TIME)))
    with pytest.raises(CompileError) as caught:
        pen.sequence(root)
    (problem,) = caught.value.problems
    assert problem.code == "compile.unknown_symbol"
    assert {"k", "q_dot", "t"} == set(problem.what.split(" for ")[1].split(", "))
    assert problem.fix


def test_inputs_that_are_not_needed_are_not_read() -> None:
    pen = Pen()
    sequence = pen.sequence(apply(pen.g, op.SIN, pen.z), ONE)
    assert sequence.inputs == (Input("z", "u", 0),)
    assert [sequence.group_size(group) for group in "qpu"] == [0, 0, 1]
    assert sequence.output_size == 2


def test_outputs_keep_name_shape_and_order() -> None:
    pen = Pen()
    g = pen.g
    outputs = [
        Roots("matrix", (2, 2), (pen.x, pen.y, pen.y, ZERO)),
        Roots("empty", (0,), ()),
        Roots("scalar", (), (mul(g, pen.x, pen.y),)),
    ]
    sequence = build_sequence(g, outputs, pen.inputs)
    assert [(o.name, o.shape) for o in sequence.outputs] == [
        ("matrix", (2, 2)),
        ("empty", (0,)),
        ("scalar", ()),
    ]
    assert evaluate_sequence(sequence, {"q": [2.0], "p": [3.0], "u": [0.0]}) == [
        [2.0, 3.0, 3.0, 0.0],
        [],
        [6.0],
    ]


def test_operations_are_counted_as_in_the_graph() -> None:
    pen = Pen()
    g = pen.g
    root = add(g, mul(g, pen.x, pen.y), power(g, apply(g, op.SIN, pen.z), g.constant(7)))
    fused = pen.sequence(root)
    plain = build_sequence(g, [Roots("f", (), (root,))], pen.inputs, contract=False)
    assert fused.operation_count == plain.operation_count == 7
    assert op.FMA in {operation.op for operation in fused.operations}
    assert op.FMA not in {operation.op for operation in plain.operations}
    kept = [k for k, operation in enumerate(plain.operations) if operation.op == op.RATIONAL]
    assert [plain.constant_value(k) for k in kept] == [7]
    assert plain.constant_value(len(plain.operations) - 1) is None


def test_operations_are_plain_tuples() -> None:
    assert Operation(op.ADD, (0, 1)) == (op.ADD, (0, 1), 0)


def test_the_graph_is_left_as_it_was() -> None:
    pen = Pen()
    root = sub(pen.g, div(pen.g, pen.x, pen.y), mul(pen.g, pen.x, pen.z))
    size = len(pen.g)
    pen.sequence(root)
    assert len(pen.g) == size


@pytest.mark.parametrize(
    "count", [20_000, *(pytest.param(many, marks=pytest.mark.exhaustive) for many in (100_000, 1_000_000))]
)
def test_depth_has_no_limit(count: int) -> None:
    """Built, merged, fused, split, pickled and evaluated: x becomes sin(x) + y, k times."""
    pen = Pen()
    g, node = pen.g, pen.x
    for _ in range(count // 2):
        node = add(g, apply(g, op.SIN, node), pen.y)
    sequence = pen.sequence(node)
    assert sequence.operation_count == 2 * (count // 2)
    plain = build_sequence(g, [Roots("f", (1,), (node,))], pen.inputs, merge=False, contract=False)
    point = (0.5, 0.25, 0.0)
    assert values(sequence, *point) == values(plain, *point)
    head, tail = sequence.split(["p"])
    assert (len(head.operations), len(tail.operations)) == (1, len(sequence.operations))  # y is handed over
    assert pickle.loads(pickle.dumps(sequence)) == sequence


def test_random_graphs_split_at_every_group_alike() -> None:
    """Large sums of shared products, where the cut has many values."""
    rng = random.Random(1)
    pen = Pen()
    nodes = [pen.x, pen.y, pen.z, pen.g.constant(Fraction(1, 3))]
    for _ in range(400):
        rule = rng.choice(
            [add, sub, mul, lambda g, a, b: apply(g, op.SIN, a), lambda g, a, b: apply(g, op.ATAN, a)]
        )
        nodes.append(rule(pen.g, rng.choice(nodes[-40:]), rng.choice(nodes[-40:])))
    bounded = [apply(pen.g, op.TANH, node) for node in nodes[-20:]]
    sequence = pen.sequence(*bounded)
    for group in GROUPS:
        head, tail = sequence.split([group])
        numbers = {"q": [0.5], "p": [0.75], "u": [-0.25]}
        numbers["c"] = evaluate_sequence(head, numbers)[0]
        assert evaluate_sequence(tail, numbers) == evaluate_sequence(sequence, numbers)
