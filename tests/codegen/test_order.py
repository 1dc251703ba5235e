"""The order of machine code: operands first, and few values alive at a time."""

from __future__ import annotations

import pytest

import symbody as sb
from benchmarks.mechanisms import spatial_chain
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.llvm.order import order_operations
from symbody.expr.opcodes import LEAVES
from symbody.expr.sequences.sequence import Sequence


def alive(sequence: Sequence) -> float:
    """How many values are still to be read, on average over all operations."""
    last = {j: k for k, operation in enumerate(sequence.operations) for j in operation.operands}
    waits = (last.get(k, k) - k for k, o in enumerate(sequence.operations) if o.op not in LEAVES)
    return sum(waits) / len(sequence.operations)


@pytest.fixture(scope="module")
def chain() -> sb.EquationSet:
    return sb.form_equations(spatial_chain(8).model())


@pytest.mark.parametrize("output", ["mass_matrix", "udot", "bias"])
def test_operands_come_first_and_outputs_stay_where_they_are(chain: sb.EquationSet, output: str) -> None:
    before, _ = form_sequence(chain, output)
    after = order_operations(before)
    assert all(j < k for k, operation in enumerate(after.operations) for j in operation.operands)
    assert [(o.name, o.shape) for o in after.outputs] == [(o.name, o.shape) for o in before.outputs]
    assert after.operation_count <= before.operation_count


def test_mass_matrices_begin_with_their_last_row(chain: sb.EquationSet) -> None:
    """Rows of the leaves need what is outward alone; from the first row on everything waits for the last."""
    before, _ = form_sequence(chain, "mass_matrix")
    after = order_operations(before)
    place = {value: k for k, value in enumerate(after.outputs[0].values)}
    first = min(value for value in place if after.operations[value].op not in LEAVES)
    assert place[first] // after.outputs[0].shape[1] > after.outputs[0].shape[0] // 2
    assert alive(after) < 0.6 * alive(before)
