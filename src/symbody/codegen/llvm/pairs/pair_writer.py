"""Pairs of operations as LLVM text: two doubles in a register."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

from symbody.codegen.llvm.numbers import words
from symbody.codegen.llvm.pairs.signs import PairPlan, Slot
from symbody.codegen.lowering import double_bits
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Sequence

_WORDS: Final = words(2)
_REAL: Final = _WORDS.real
_SIGN: Final = -(2**63)


class PairWriter:
    """Writes the pairs of one piece.

    Parameters
    ----------
    operand : callable
        Writes a value as a single number, if it is not yet, and returns its name.
    lines : list
        What is written is put at its end.
    """

    def __init__(
        self,
        sequence: Sequence,
        plan: PairPlan,
        constants: Mapping[int, float],
        operand: Callable[[int], str],
        lines: list[str],
    ) -> None:
        self._operations = sequence.operations
        self._plan = plan
        self._constants = constants
        self._operand = operand
        self._lines = lines
        self._vectors: dict[tuple[int, int], str] = {}
        self._signed: dict[tuple[str, int, int], str] = {}

    def begins(self, k: int, stop: int) -> bool:
        """Return whether a pair begins with operation k, and ends before `stop`."""
        return k in self._plan.slots and self._plan.seconds[k] < stop

    def has(self, k: int) -> bool:
        """Return whether value k has been computed in a pair."""
        place = self._plan.places.get(k)
        return place is not None and (place[0], self._plan.seconds[place[0]]) in self._vectors

    def lane(self, k: int) -> Iterator[str]:
        """Yield the lines that make ``%z<k>`` of value k of a pair."""
        first, lane = self._plan.places[k]
        pair = first, self._plan.seconds[first]
        name = f"%z{k}.n" if lane and pair in self._plan.negated else f"%z{k}"
        yield f"{name} = extractelement {_REAL} {self._vectors[pair]}, i32 {lane}"
        if name != f"%z{k}":
            yield f"%z{k} = fneg double {name}"

    def write(self, k: int) -> None:
        """Write the pair that begins with operation k."""
        slots, code, name = self._plan.slots[k], self._operations[k].op, f"%v{k}"
        if code in (op.ADD, op.SUB):
            code, operands = self._sum(slots[0], slots[1])
        elif code == op.POW:
            code, operands = op.MUL, [self._register(slots[0], 1, 1)] * 2
        else:
            operands = self._product(slots[0], slots[1])
            if code == op.FMA:
                operands.append(self._register(slots[2], *_signs(slots[2])))
        self._lines.append(f"{name} = {_WORDS.instructions[code].format(*operands)}")
        self._vectors[k, self._plan.seconds[k]] = name

    def _sum(self, a: Slot, b: Slot) -> tuple[int, list[str]]:
        """Return the operation and its operands."""
        for x, y in ((a, b), (b, a)):
            if _signs(y) == (-1, -1) and y[0][0] not in self._constants:
                return op.SUB, [self._register(x, *_signs(x)), self._register(y, 1, 1)]
        return op.ADD, [self._register(a, *_signs(a)), self._register(b, *_signs(b))]

    def _product(self, a: Slot, b: Slot) -> list[str]:
        """Return the factors, with all signs in front of one of them, of a constant if there is one."""
        (first, other), (second, last) = _signs(a), _signs(b)
        signs = first * second, other * last
        if a[0][0] in self._constants:
            return [self._register(a, *signs), self._register(b, 1, 1)]
        return [self._register(a, 1, 1), self._register(b, *signs)]

    def _register(self, slot: Slot, sign: int, other: int) -> str:
        """Return an operand with these signs in its lanes."""
        (a, _), (b, _) = slot
        if a in self._constants:
            x, y = sign * self._constants[a], other * self._constants[b]
            return f"<double 0x{double_bits(x):016X}, double 0x{double_bits(y):016X}>"
        plain = self._vectors.get((a, b)) or self._pack(a, b)
        if sign == other == 1:
            return plain
        known = self._signed.get((plain, sign, other))
        if known is None:
            known = self._signed[plain, sign, other] = (
                f"{plain}.{'n' if sign < 0 else 'p'}{'n' if other < 0 else 'p'}"
            )
            self._lines.extend(_with_signs(known, plain, sign, other))
        return known

    def _pack(self, a: int, b: int) -> str:
        """Put two single numbers into one register."""
        x, y, name = self._operand(a), self._operand(b), f"%k{a}.{b}"
        if (a, b) in self._plan.negated:
            self._lines.append(f"{name}.y = fneg double {y}")
            y = f"{name}.y"
        self._lines.append(f"{name}.x = insertelement {_REAL} undef, double {x}, i32 0")
        self._lines.append(f"{name} = insertelement {_REAL} {name}.x, double {y}, i32 1")
        self._vectors[a, b] = name
        return name


def _signs(slot: Slot) -> tuple[int, int]:
    return slot[0][1], slot[1][1]


def _with_signs(name: str, plain: str, sign: int, other: int) -> Iterator[str]:
    if sign == other:
        yield f"{name} = fneg {_REAL} {plain}"
        return
    masks = ", ".join(f"i64 {_SIGN if s < 0 else 0}" for s in (sign, other))
    yield f"{name}.i = bitcast {_REAL} {plain} to <2 x i64>"
    yield f"{name}.x = xor <2 x i64> {name}.i, <{masks}>"
    yield f"{name} = bitcast <2 x i64> {name}.x to {_REAL}"
