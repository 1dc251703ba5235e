"""Where a long sequence is cut, and what passes from piece to piece through the work array.

Compilers take more than linear time on one long function. A cut costs a store and a load for every
value alive across it, so each is put where few are. All compiled languages share this plan.

The work array holds, in this order: slots of crossing values, the results of every kernel, and the
arguments and scratch of the kernel that is running.
"""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass
from itertools import accumulate
from typing import Final

from symbody.codegen.lowering import constant_values, refuse_user_functions
from symbody.expr.opcodes import LEAVES, MAP, PICK, SADDLE
from symbody.expr.sequences.sequence import KernelNode, Sequence
from symbody.kernels.linear.solve_saddle import work_size as saddle_work_size

# LLVM takes the same time for 50,000 operations in pieces of 500 to 4,000, three times as long for one.
PIECE_SIZE: Final = 2000

# About what a program of derivatives takes to compile, in operations one after the other.
_MAP_WEIGHT: Final = 300

# Read where they are needed, again in every piece: they take no slot.
_REREAD: Final = LEAVES | {PICK, SADDLE, MAP}


@dataclass(frozen=True, slots=True)
class Piece:
    """Operations from `start` to `stop`; the slots of values it takes from and leaves to others."""

    start: int
    stop: int
    loads: Mapping[int, int]
    stores: Mapping[int, int]


@dataclass(frozen=True, slots=True)
class Plan:
    """Pieces in order, and places in the work array.

    Attributes
    ----------
    needed : sequence of bool
        For each value whether an output depends on it.
    constants : mapping of value number to double
    outputs : mapping of value number to places in `out`
    results : mapping of value number to place in the work array
        Where each SADDLE leaves udot, lambda and rank.
    arguments, scratch : int
        Where M, J, F, gamma of a running kernel begin, and its own scratch.
    work_size : int
        Doubles in the work array.
    """

    pieces: tuple[Piece, ...]
    needed: Items[bool]
    constants: Mapping[int, float]
    outputs: Mapping[int, Items[int]]
    results: Mapping[int, int]
    arguments: int
    scratch: int
    work_size: int


def argument_places(kernel: KernelNode, start: int) -> tuple[int, int, int, int]:
    """Return where M, J, F and gamma begin when stored one after the other from `start`."""
    jacobian = start + kernel.n * kernel.n
    force = jacobian + kernel.m * kernel.n
    return start, jacobian, force, force + kernel.n


def plan_pieces(sequence: Sequence, size: int = PIECE_SIZE) -> Plan:
    """Cut `sequence` into pieces of 0.75 to 1.25 times `size` operations; the last may have 1.5 times.

    Leaves count nothing, a kernel as many operations as it has arguments.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    refuse_user_functions(sequence)
    needed = _find_needed(sequence)
    last_use = _last_uses(sequence, needed)
    bounds = _bounds(sequence, last_use, size)
    crossing = _find_crossing_values(sequence, last_use, bounds)
    slots, taken = _assign_slots(crossing, last_use, bounds)
    pieces = _pieces(sequence, needed, bounds, slots)
    results: dict[int, int] = {}
    for value, operation in enumerate(sequence.operations):
        if operation.op == SADDLE and needed[value]:
            kernel = sequence.kernels[operation.datum]
            results[value] = taken
            taken += kernel.n + kernel.m + 1
    used = [sequence.kernels[sequence.operations[value].datum] for value in results]
    scratch = taken + max((argument_places(k, 0)[3] + k.m for k in used), default=0)
    work_size = scratch + max((saddle_work_size(k.n, k.m) for k in used), default=0)
    constants, outputs = constant_values(sequence), _output_places(sequence)
    return Plan(tuple(pieces), needed, constants, outputs, results, taken, scratch, work_size)


def _output_places(sequence: Sequence) -> dict[int, list[int]]:
    places: dict[int, list[int]] = {}
    for place, value in enumerate(k for output in sequence.outputs for k in output.values):
        places.setdefault(value, []).append(place)
    return places


def _find_needed(sequence: Sequence) -> list[bool]:
    needed = [False] * len(sequence.operations)
    for output in sequence.outputs:
        for value in output.values:
            needed[value] = True
    for k in range(len(needed) - 1, -1, -1):
        if needed[k]:
            for operand in sequence.operations[k].operands:
                needed[operand] = True
    return needed


def _last_uses(sequence: Sequence, needed: Items[bool]) -> list[int]:
    """Return the last needed operation that reads each value, itself if none does.

    What a program reads is put in its place when it is computed, so that reads nothing.
    """
    last = list(range(len(sequence.operations)))
    for k, operation in enumerate(sequence.operations):
        if needed[k] and operation.op != MAP:
            for operand in operation.operands:
                last[operand] = k
    return last


def _bounds(sequence: Sequence, last_use: Items[int], size: int) -> list[int]:
    """Return where the pieces begin, and the end."""
    operations = sequence.operations
    change = [0] * (len(operations) + 1)
    for k, operation in enumerate(operations):
        if operation.op not in _REREAD and last_use[k] > k:
            change[k + 1] += 1
            change[last_use[k] + 1] -= 1
    alive = list(accumulate(change))  # alive[k]: values that a cut before operation k would carry
    weight = list(
        accumulate((_weight(operation.op, operation.operands) for operation in operations), initial=0)
    )
    bounds, best = [0], 0
    total = weight[-1]
    for k in range(1, len(operations)):
        length = weight[k] - weight[bounds[-1]]
        if length > 1.25 * size and best > bounds[-1]:
            bounds.append(best)
            length = weight[k] - weight[best]
            best = 0
        if total - weight[bounds[-1]] <= 1.5 * size:
            break
        if length >= 0.75 * size and (best <= bounds[-1] or alive[k] < alive[best]):
            best = k
    bounds.append(len(operations))
    return bounds


def _weight(op: int, operands: tuple[int, ...]) -> int:
    return _MAP_WEIGHT if op == MAP else len(operands) if op == SADDLE else 0 if op in _REREAD else 1


def _find_crossing_values(sequence: Sequence, last_use: Items[int], bounds: Items[int]) -> list[list[int]]:
    """Return for each piece the values defined in it that later pieces read."""
    return [
        [k for k in range(start, stop) if last_use[k] >= stop and sequence.operations[k].op not in _REREAD]
        for start, stop in zip(bounds, bounds[1:], strict=False)
    ]


def _assign_slots(
    crossing: Items[Items[int]], last_use: Items[int], bounds: Items[int]
) -> tuple[dict[int, int], int]:
    """Return a slot for each crossing value, and the number of slots.

    A slot is free again in the piece after the one that reads its value last: within a piece no slot is
    both read and written, so the order of reading and writing does not matter.
    """
    slots: dict[int, int] = {}
    free: list[int] = []
    count = 0
    expiring: list[list[int]] = [[] for _ in crossing]
    piece_of = [0] * bounds[-1]
    for number, (start, stop) in enumerate(zip(bounds, bounds[1:], strict=False)):
        piece_of[start:stop] = [number] * (stop - start)
    for number, values in enumerate(crossing):
        if number:
            free.extend(expiring[number - 1])
        for value in values:
            if free:
                slots[value] = free.pop()
            else:
                slots[value] = count
                count += 1
            expiring[piece_of[last_use[value]]].append(slots[value])
    return slots, count


def _pieces(
    sequence: Sequence, needed: Items[bool], bounds: Items[int], slots: Mapping[int, int]
) -> list[Piece]:
    pieces: list[Piece] = []
    for start, stop in zip(bounds, bounds[1:], strict=False):
        loads: dict[int, int] = {}
        stores: dict[int, int] = {}
        for k in (k for k in range(start, stop) if needed[k]):
            if k in slots:
                stores[k] = slots[k]
            for operand in sequence.operations[k].operands:
                if operand < start and operand in slots:
                    loads[operand] = slots[operand]
        pieces.append(Piece(start, stop, loads, stores))
    return pieces
