"""Which numbers of the second lane are held with the other sign.

Mirror images have some of their components with opposite signs, so that a sum in one limb is a difference
in the other. If the second lane holds the right ones of its values negated, both lanes do the same
operation. Negating is exact, and so is an operation on negated numbers: of the results, only the signs of
zeros can differ.

Whether a pair is held negated is 1 or 0. A product has the sum of its factors, modulo 2; the terms of a sum
have to agree. These are linear equations in the unknowns of inputs and of what a constant is a factor of,
written as the bits of an integer, bit 0 for the constant. An equation that contradicts those before it is
left out: there a sign is changed on the way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symbody.codegen.llvm.pairs.terms import Term, Terms
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Sequence

Slot = tuple[Term, Term]
"""An operand in both lanes."""


@dataclass(frozen=True, slots=True)
class PairPlan:
    """How pairs are computed.

    Attributes
    ----------
    places : mapping of value to (pair, lane)
        A pair is numbered as its value in lane 0.
    seconds : mapping of pair to value
        Its value in lane 1.
    slots : mapping of pair to slots
        What a computed pair reads, with the signs in front of the numbers that registers hold.
    negated : frozenset
        Pairs, and other (value, value) that are put into one register, whose second lane is held negated.
    """

    places: Mapping[int, tuple[int, int]]
    seconds: Mapping[int, int]
    slots: Mapping[int, tuple[Slot, ...]]
    negated: frozenset[tuple[int, int]]

    def source(self, slot: Slot) -> tuple[int, int]:
        """Return the values that a slot reads."""
        return slot[0][0], slot[1][0]


NO_PAIRS = PairPlan({}, {}, {}, frozenset())


def plan_pairs(sequence: Sequence, pairs: Mapping[int, int]) -> PairPlan:
    """Return how `pairs` are computed, each of whose values stands behind all that both read."""
    if not pairs:
        return NO_PAIRS
    terms = Terms(sequence)
    places = {k: (first, lane) for first, second in pairs.items() for lane, k in enumerate((first, second))}
    slots = {
        first: tuple(
            (a, b)
            for (_, a), (_, b) in zip(
                terms.align_terms(first, places), terms.align_terms(second, places), strict=True
            )
        )
        for first, second in pairs.items()
        if terms.can_pair(terms.operations[first])
    }
    signs = _Signs(terms)
    for first in sorted(slots):
        signs.add(first, pairs[first], slots[first])
    negated = signs.solve()
    held = {first: _as_held(terms, first, pairs[first], slots[first], negated) for first in slots}
    return PairPlan(places, dict(pairs), held, negated)


def _as_held(
    terms: Terms, first: int, second: int, slots: tuple[Slot, ...], negated: frozenset[tuple[int, int]]
) -> tuple[Slot, ...]:
    """Return slots with the signs in front of what registers hold, for the result as it is to be held."""

    def flip_lane(slot: Slot, change: bool) -> Slot:
        (a, sign), (b, other) = slot
        return (a, sign), (b, -other if change else other)

    result = (first, second) in negated
    held = [flip_lane(slot, (slot[0][0], slot[1][0]) in negated) for slot in slots]
    if result:
        held[0] = flip_lane(held[0], True)
        code = terms.operations[first].op
        if code in (op.ADD, op.SUB):
            held[1] = flip_lane(held[1], True)
        if code == op.FMA:
            held[2] = flip_lane(held[2], True)
    return tuple(held)


class _Signs:
    """Linear equations modulo 2, solved as they come."""

    def __init__(self, terms: Terms) -> None:
        self._terms = terms
        self._count = 1
        self._masks: dict[tuple[int, int], int] = {}
        self._solved: dict[int, int] = {}  # by the leading bit

    def add(self, first: int, second: int, slots: tuple[Slot, ...]) -> None:
        """Add the pair of an operation, whose operands come before it."""
        code = self._terms.operations[first].op
        masks = [self._mask(slot) for slot in slots]
        if code == op.POW:
            result: int | None = 0
        elif code in (op.ADD, op.SUB):
            result = self._agree_terms(masks[0], masks[1])
        elif code == op.FMA:
            result = self._agree_terms(_product(masks[0], masks[1]), masks[2])
        else:
            result = _product(masks[0], masks[1])
        self._masks[first, second] = self._unknown() if result is None else result

    def solve(self) -> frozenset[tuple[int, int]]:
        """Return what is held negated; what remains free is not."""
        return frozenset(pair for pair, mask in self._masks.items() if self._value(mask))

    def _mask(self, slot: Slot) -> int | None:
        """Return whether the lanes of an operand differ in sign; None if it is a constant, which may."""
        (a, sign), (b, other) = slot
        if a in self._terms.constants:
            return None
        if (a, b) not in self._masks:
            self._masks[a, b] = self._unknown()
        return self._masks[a, b] ^ int(sign != other)

    def _unknown(self) -> int:
        self._count += 1
        return 1 << self._count

    def _agree_terms(self, a: int | None, b: int | None) -> int | None:
        """Return the mask of a sum, whose terms are made to agree."""
        if a is None or b is None:
            return b if a is None else a
        rest = a ^ b
        while rest > 1:
            leading = rest.bit_length()
            if leading not in self._solved:
                self._solved[leading] = rest
                break
            rest ^= self._solved[leading]
        return b

    def _value(self, mask: int) -> bool:
        while mask > 1:
            leading = mask.bit_length()
            mask ^= self._solved.get(leading, 1 << leading - 1)
        return mask == 1


def _product(a: int | None, b: int | None) -> int | None:
    return None if a is None or b is None else a ^ b
