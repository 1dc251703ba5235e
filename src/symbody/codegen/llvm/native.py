"""Machine code from a sequence: text, LLVM's code generator, the addresses of functions.

No optimization passes run: the graph the sequence comes from is folded and shared already, and
passes cost 80 % more time for no speed. The functions hold no state; what they need is passed in.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import llvmlite.binding as binding

from symbody.codegen.llvm.entries import (
    ALIGNMENT,
    all_declarations,
    batch_function,
    declaration,
    entry_function,
    lane_batch_function,
)
from symbody.codegen.llvm.items import ItemPlan, plan_items
from symbody.codegen.llvm.machine import QUICK, THOROUGH, lanes, object_codes
from symbody.codegen.llvm.numbers import words
from symbody.codegen.llvm.order import order_operations, order_pairs
from symbody.codegen.llvm.pairs.matching import find_pairs
from symbody.codegen.llvm.pairs.signs import PairPlan, plan_pairs
from symbody.codegen.llvm.runtime import called_functions, load
from symbody.codegen.llvm.stored_module import Module, key_of, read_module, store_module
from symbody.codegen.llvm.writing import GROUPS, piece_function
from symbody.codegen.lowering import constant_values, refuse_user_functions
from symbody.codegen.pieces import Plan, plan_pieces
from symbody.expr.deadline import begin, check
from symbody.expr.sequences.sequence import Sequence

NAME: Final = "symbody_f"
BATCH_NAME: Final = "symbody_f_batch"

# A tree of 30 joints, 20,000 operations, compiles in the same time for pieces of 500 to 8,000, in twice the
# time as one; calls take 5.2 us with pieces of 500, 3.5 us with 8,000.
PIECE_SIZE: Final = 8000
PARALLEL_ABOVE: Final = 12_000  # operations, about 0.3 s of compiling


@dataclass(frozen=True, slots=True, eq=False)
class NativeFunction:
    """Compiled code, valid as long as this object lives.

    Attributes
    ----------
    address : int
        Of ``int (const double *t, *q, *u, *r, *p, *c, double *out, double *work)``. All outputs one
        after the other, row-major, go to `out`. It returns 0, or k + 1 if kernel k could not be solved
        and its results are nan. Groups that are not read may be NULL and may overlap; `out` and `work`
        must not overlap anything. Reentrant with a `work` of its own for every thread. In lanes, entry k
        of each array begins at k times `width`, and a status other than 0 means that a lane failed.
    batch_address : int
        Of ``int (int64 count, const double *t, int64 t_stride, ..., double *out, int64 out_stride,
        double *work)``: the same for `count` points, strides in doubles, 0 for what all points share.
        It computes every point and returns the first status that is not 0. In lanes it computes `width`
        times `count` points, from rows like those of a scalar function.
    work_size : int
        Doubles in `work`; it may be NULL if this is 0.
    operations : int
        Operations of one evaluation.
    width : int
        Points computed at once.
    ir : str
        The LLVM text, empty unless it was asked for.
    """

    address: int
    batch_address: int
    work_size: int
    operations: int
    width: int
    ir: str = field(repr=False)
    library: binding.ResourceTracker = field(repr=False)


def compile_sequence(
    sequence: Sequence,
    *,
    piece_size: int = PIECE_SIZE,
    quick: bool = False,
    in_lanes: bool = False,
    keep_ir: bool = False,
) -> NativeFunction:
    """Compile `sequence` for this processor.

    Parameters
    ----------
    piece_size : int
        About how many operations go into one machine function; results do not depend on it.
    quick : bool
        Compile in less than half the time for calls that take 1.5 to 3 times as long; same results.
    in_lanes : bool
        Compute as many points at once as the registers of this processor hold; same results.
    keep_ir : bool
        Keep the LLVM text, about 80 bytes an operation.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    width = lanes() if in_lanes else 1
    refuse_user_functions(sequence)
    constant_values(sequence)  # refuses those that are too large
    level = QUICK if quick else THOROUGH
    key = key_of(sequence, piece_size, level, width, lanes())
    module, text = None if keep_ir else read_module(key), ""
    if module is None:
        module, text = _compile_text(sequence, piece_size, level, width)
        store_module(key, module)
    library = load(module, NAME, BATCH_NAME)
    return NativeFunction(
        library[NAME],
        library[BATCH_NAME],
        module.work_size,
        sequence.operation_count,
        width,
        text if keep_ir else "",
        library,
    )


def _compile_text(sequence: Sequence, piece_size: int, level: int, width: int) -> tuple[Module, str]:
    """Return the code of a sequence, and the text it was compiled from."""
    begin("order of operations")
    inner = order_operations(sequence)
    check()
    pairs = find_pairs(inner) if width == 1 and level == THOROUGH else {}
    if pairs:
        inner, pairs = order_pairs(inner, pairs)
        check()
    plan = plan_pieces(inner, piece_size)
    items = plan_items(inner, plan.needed, plan.outputs, plan.work_size, lanes() if width == 1 else 1)
    begin("writing LLVM's text")
    sizes = {group: sequence.group_size(group) for group in GROUPS} | {"out": sequence.output_size}
    texts = _module_texts(inner, plan, items, plan_pairs(inner, pairs), sizes, width)
    outside = sum(sizes.values()) if width > 1 else 0
    beyond = (items.end + outside) * width
    if beyond and (width > 1 or items.maps):
        beyond += 2 * ALIGNMENT  # the entry may move on what the batch has moved
    calls = {called for text in texts for called in called_functions(text) if not called.startswith(NAME)}
    begin("object code")
    codes = tuple(object_codes(texts, level))
    return Module(codes, beyond, tuple(sorted(calls))), "\n".join(texts)


def _module_texts(
    sequence: Sequence, plan: Plan, items: ItemPlan, pairs: PairPlan, sizes: dict[str, int], width: int
) -> list[str]:
    """Return the text of each module; the functions call each other across modules."""
    names = [f"{NAME}_{k}" for k in range(len(plan.pieces))]
    vocabulary, beside = words(width), words(lanes())
    functions = [
        piece_function(sequence, plan, items, piece, name, vocabulary, beside, pairs)
        for piece, name in zip(plan.pieces, names, strict=True)
    ]
    entry = entry_function(NAME, names, whole_lines=width > 1 or bool(items.maps))
    if width == 1:
        entry += batch_function(BATCH_NAME, NAME)
    else:
        entry += lane_batch_function(BATCH_NAME, NAME, sizes, width)
    if len(sequence.operations) <= PARALLEL_ABOVE:
        bodies = ["".join(functions) + entry]
    else:
        bodies = [*functions, "".join(declaration(name) for name in names) + entry]
    return [body + all_declarations(body) for body in bodies]
