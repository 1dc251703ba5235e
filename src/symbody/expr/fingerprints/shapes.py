"""Shapes: what a formula is without its signs, numbers and names.

Values that mirror each other, such as those of a left and a right leg, have the same shape, although
structural hashes order their operands differently. Choices that go by shape are the same on both sides.
"""

from __future__ import annotations

from typing import Final

from symbody.expr.opcodes import ADD, FLOAT, FMA, MUL, NEG, PI, RATIONAL, SUB

_BITS: Final = (1 << 61) - 1
_CONSTANTS: Final = frozenset({RATIONAL, FLOAT, PI})


def shape(op: int, below: tuple[int, ...]) -> int:
    """Return the shape of a value from those of its operands; the order of terms and factors does not matter.

    A fused operation has the shape of the product and the sum that it stands for.
    """
    if op == NEG:
        return below[0]
    if op in (ADD, SUB, MUL):
        return _mix_pair(MUL if op == MUL else ADD, below[0], below[1])
    if op == FMA:
        return _mix_pair(ADD, _mix_pair(MUL, below[0], below[1]), below[2])
    value = 1 if op in _CONSTANTS else op + 2
    for other in below:
        value = (value * 0x1B873593CC9E2D51 + other) & _BITS
        value ^= value >> 29
    return value


def _mix_pair(op: int, a: int, b: int) -> int:
    value = ((a + b) * 0x2545F4914F6CDD1D + (a ^ b) * 0x1D8E4E27C47D124F + op) & _BITS
    return value ^ value >> 29
