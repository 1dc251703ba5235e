"""Which inputs correspond: the coordinate of a left knee, say, and that of the right one.

An input is known by the shapes of the operations that read it, or read its sine and cosine. Shapes reach
from an operation down to the inputs of the mechanism, so that they differ from link to link of a limb, and
agree for two limbs of equal structure whatever their numbers are.
"""

from __future__ import annotations

from collections import Counter
from itertools import combinations, permutations
from typing import Final

from symbody.codegen.llvm.pairs.terms import Terms
from symbody.expr import opcodes as op
from symbody.expr.fingerprints.shapes import shape
from symbody.expr.sequences.sequence import Input, Sequence

# Shapes that more inputs than this share say nothing about limbs.
_MOST: Final = 8
# The part of the shapes of those that read an input which the other has to have, too; of a few all.
_ALIKE: Final = 0.3
_FEW: Final = 8


def corresponding_inputs(sequence: Sequence, terms: Terms) -> list[tuple[int, int]]:
    """Return pairs of inputs, and of the sines and cosines of paired angles, as numbers of values."""
    origins = _origins(sequence, terms)
    readers = _shapes_of_readers(sequence, origins)
    pairs = _best_pairs(sequence, readers, _read_together(sequence, origins))
    circles = {
        (origins[k], operation.op, shape_of_angle(terms, operation.operands[0])): k
        for k, operation in enumerate(sequence.operations)
        if operation.op in (op.SIN, op.COS) and origins[k] is not None
    }
    found = list(pairs)
    for first, second in pairs:
        for (origin, code, angle), k in circles.items():
            other = circles.get((second, code, angle)) if origin == first else None
            if other is not None:
                found.append((k, other))
    return found


def shape_of_angle(terms: Terms, k: int) -> int:
    """Return 0 for an input, 1 for a sum of one and a constant."""
    return int(terms.operations[terms.base(k)].op != op.SYMBOL)


def _origins(sequence: Sequence, terms: Terms) -> list[int | None]:
    """Return for each value the input that it is, up to a sign, a constant, and one sine or cosine.

    Circles of circles have none: pairs of an inner and an outer one could need each other.
    """
    origins: list[int | None] = []
    turned: set[int] = set()
    for k, (code, operands, _) in enumerate(sequence.operations):
        origin = None
        if code == op.SYMBOL:
            origin = k
        elif code in (op.NEG, op.ADD, op.SUB, op.SIN, op.COS):
            rest = [j for j in operands if j not in terms.constants]
            is_circle, has_circle = code in (op.SIN, op.COS), not turned.isdisjoint(rest)
            origin = origins[rest[0]] if len(rest) == 1 and not (is_circle and has_circle) else None
            if is_circle or has_circle:
                turned.add(k)
        origins.append(origin)
    return origins


def _shapes_of_readers(sequence: Sequence, origins: list[int | None]) -> dict[int, Counter[int]]:
    shapes: list[int] = []
    readers: dict[int, Counter[int]] = {}
    for k, (code, operands, _) in enumerate(sequence.operations):
        shapes.append(shape(code, tuple([shapes[j] for j in operands])))
        if origins[k] is None:
            for j in operands:
                origin = origins[j]
                if origin is not None:
                    readers.setdefault(origin, Counter())[shapes[k]] += 1
    return readers


def _read_together(sequence: Sequence, origins: list[int | None]) -> set[tuple[int, int]]:
    """Return inputs that one operation reads, which are in one limb, or in none."""
    together: set[tuple[int, int]] = set()
    for operation in sequence.operations:
        read = {origin for j in operation.operands if (origin := origins[j]) is not None}
        if len(read) > 1:
            together.update(permutations(read, 2))
    return together


def _best_pairs(
    sequence: Sequence, readers: dict[int, Counter[int]], together: set[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Return pairs of inputs that are alike.

    The links of a limb are counted one after the other, so that those of two limbs are all as far apart:
    pairs at the distance that most have come first. Fingers of one hand are alike, too, but fewer.
    """
    inputs = {k: sequence.inputs[sequence.operations[k].datum] for k in readers}
    common = _common_shapes(readers, inputs)
    likely = {
        (i, j): (inputs[i].group, inputs[j].position - inputs[i].position)
        for (i, j), count in common.items()
        if _is_alike(count, max(len(readers[i]), len(readers[j]))) and (i, j) not in together
    }
    votes = Counter(likely.values())
    paired: set[int] = set()
    pairs: list[tuple[int, int]] = []
    for i, j in sorted(likely, key=lambda p: (-votes[likely[p]], likely[p], inputs[p[0]].position)):
        if i not in paired and j not in paired:
            paired |= {i, j}
            pairs.append((i, j))
    return pairs


def _is_alike(common: int, count: int) -> bool:
    return common >= (_ALIKE * count if count >= _FEW else count)


def _common_shapes(readers: dict[int, Counter[int]], inputs: dict[int, Input]) -> Counter[tuple[int, int]]:
    """Return how many shapes of readers two inputs of a group have in common, the lower position first."""
    holders: dict[int, list[int]] = {}
    for value, shapes in readers.items():
        for name in shapes:
            holders.setdefault(name, []).append(value)
    common: Counter[tuple[int, int]] = Counter()
    for values in holders.values():
        if 1 < len(values) <= _MOST:
            values.sort(key=lambda k: inputs[k].position)
            common.update((i, j) for i, j in combinations(values, 2) if inputs[i].group == inputs[j].group)
    return common
