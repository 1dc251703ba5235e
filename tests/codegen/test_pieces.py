"""Cuts and places, checked by running the plan with Python lists."""

from __future__ import annotations

import pytest

from symbody.codegen.pieces import Plan, plan_pieces
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Input, Operation, Output, Sequence
from tests.codegen.sequences import EXACT, LIBRARY, MECHANICAL, TRIGONOMETRIC, random_sequence

ALL = (*EXACT, *LIBRARY, *TRIGONOMETRIC)
REREAD = op.LEAVES | {op.PICK, op.SADDLE}


def check_flow(sequence: Sequence, plan: Plan) -> None:
    """Every piece finds in its slots the values it needs, and no kernel writes over them."""
    slots: dict[int, int] = {}
    for piece in plan.pieces:
        for value, slot in piece.loads.items():
            assert slots[slot] == value
        assert not set(piece.loads.values()) & set(piece.stores.values())
        here = range(piece.start, piece.stop)
        for k in here:
            if plan.needed[k]:
                for operand in sequence.operations[k].operands:
                    known = operand in here or operand in piece.loads
                    assert known or sequence.operations[operand].op in REREAD
        assert all(value in here for value in piece.stores)
        slots |= {slot: value for value, slot in piece.stores.items()}
    taken = [range(place, place + 1) for place in slots]
    for value, place in plan.results.items():
        kernel = sequence.kernels[sequence.operations[value].datum]
        taken.append(range(place, place + kernel.n + kernel.m + 1))
    places = [k for span in taken for k in span]
    assert len(places) == len(set(places))
    assert max(places, default=-1) < plan.arguments <= plan.scratch <= plan.work_size


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("size", [3, 20, 100])
def test_values_reach_the_pieces_that_need_them(seed: int, size: int) -> None:
    sequence, _ = random_sequence(seed, 400, ALL)
    check_flow(sequence, plan_pieces(sequence, size))


def test_pieces_cover_the_sequence_and_keep_their_size() -> None:
    sequence, _ = random_sequence(2, 5000, MECHANICAL)
    plan = plan_pieces(sequence, 200)
    assert [piece.start for piece in plan.pieces[1:]] == [piece.stop for piece in plan.pieces[:-1]]
    assert plan.pieces[0].start == 0
    assert plan.pieces[-1].stop == len(sequence.operations)
    sizes = [
        sum(operation.op not in op.LEAVES for operation in sequence.operations[piece.start : piece.stop])
        for piece in plan.pieces
    ]
    assert all(150 <= size <= 251 for size in sizes[:-1])  # one more: the cut goes before an operation
    assert sizes[-1] <= 300


def test_cuts_go_where_few_values_live() -> None:
    """Blocks that each end in one number: a cut in the right place carries that number alone."""
    operations = [Operation(op.SYMBOL, (), 0)]
    block = 23
    for _ in range(20):
        start = len(operations) - 1
        for _ in range(block):
            operations.append(Operation(op.SIN, (start,)))
            start += 1
        wide = list(range(start - block + 1, start + 1))
        while len(wide) > 1:
            operations.append(Operation(op.ADD, (wide.pop(0), wide.pop(0))))
            wide.append(len(operations) - 1)
    output = Output("y", (), (len(operations) - 1,))
    plan = plan_pieces(Sequence((Input("x", "q", 0),), (), (), (), tuple(operations), (output,)), 90)
    assert len(plan.pieces) > 8
    assert all(len(piece.stores) == 1 for piece in plan.pieces[:-1])
    assert plan.work_size <= 2  # slots are used again


def test_a_short_sequence_is_one_piece_without_work() -> None:
    sequence, _ = random_sequence(2, 300, MECHANICAL)
    plan = plan_pieces(sequence)
    assert len(plan.pieces) == 1
    assert plan.work_size == 0


def test_outputs_that_name_a_value_twice() -> None:
    operations = (Operation(op.SYMBOL, (), 0), Operation(op.NEG, (0,)))
    outputs = (Output("a", (2,), (1, 0)), Output("b", (), (1,)))
    plan = plan_pieces(Sequence((Input("x", "q", 0),), (), (), (), operations, outputs))
    assert plan.outputs == {1: [0, 2], 0: [1]}
