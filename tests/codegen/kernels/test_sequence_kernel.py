"""Sequences as kernels: whole or in pieces they give the same bits, those of the interpreter."""

from __future__ import annotations

import ctypes
import math

import numpy as np
import pytest

from symbody.codegen.kernels.sequence_kernel import GROUPS, sequence_kernels
from symbody.codegen.kernels.tree import KernelTree
from symbody.codegen.llvm.kernel_library import compile_trees
from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Sequence
from tests.codegen.sequences import EXACT, random_sequence
from tests.tiers import cases

Inputs = dict[str, list[float]]
# The interpreter rounds once where kernels, which fuse nothing, round twice.
CODES = tuple(code for code in EXACT if code != op.FMA)


def evaluate(sequence: Sequence, given: Inputs, piece_size: int, name: str) -> tuple[np.ndarray, int]:
    """The outputs from machine code of the kernels, and how many kernels the sequence became."""
    kernels, work_size = sequence_kernels(sequence, name, piece_size)
    place = compile_trees(kernels)[name]
    pointer = ctypes.POINTER(ctypes.c_double)
    function = ctypes.CFUNCTYPE(ctypes.c_int64, *[pointer] * len(GROUPS))(place)
    arrays = {group: np.array(given.get(group, ()), dtype=float) for group in GROUPS}
    arrays |= {"out": np.full(sequence.output_size, math.nan), "work": np.full(work_size, math.nan)}
    fault = function(*(arrays[group].ctypes.data_as(pointer) for group in GROUPS))
    assert fault == 0
    return arrays["out"], sum(own.startswith(name) for own in kernels)


@pytest.mark.parametrize("seed", cases(range(2), fast=[0]))
def test_pieces_give_the_bits_of_the_whole(seed: int) -> None:
    sequence, given = random_sequence(seed, 200, CODES)
    whole, count = evaluate(sequence, given, 10**6, f"whole_{seed}")
    cut, pieces = evaluate(sequence, given, 12, f"cut_{seed}")
    assert count == 1 and pieces > 10
    np.testing.assert_array_equal(cut, whole)
    parts = evaluate_sequence(sequence, given)
    np.testing.assert_array_equal(np.concatenate([np.ravel(part) for part in parts]), whole)


def test_a_kernel_that_calls_pieces_returns_the_first_fault() -> None:
    sequence, _ = random_sequence(1, 200, CODES)
    kernels, _ = sequence_kernels(sequence, "f", 12)
    tree = kernels["f"]
    assert isinstance(tree, KernelTree) and list(tree.variables) == ["fault", "status"]
    assert [*kernels][-1] == "f" and f"in {sum(k.startswith('f_') for k in kernels)} pieces" in tree.summary
