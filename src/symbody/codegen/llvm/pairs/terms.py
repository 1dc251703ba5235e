"""The operations of a sequence without its signs: a sign is a property of an operand."""

from __future__ import annotations

from typing import Final

from symbody.codegen.lowering import constant_values
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation, Sequence

# What registers do for two numbers in the time of one; of powers squares only.
PAIRED: Final = frozenset({op.ADD, op.SUB, op.MUL, op.DIV, op.FMA, op.POW})
_READ: Final = op.LEAVES | {op.NEG}

Term = tuple[int, int]
"""A value that is no NEG, and 1 or -1."""


class Terms:
    """What each operation reads, with the signs in front of it."""

    def __init__(self, sequence: Sequence) -> None:
        self.operations = sequence.operations
        self.constants = constant_values(sequence)
        self.stripped: list[Term] = []
        for k, (code, operands, _) in enumerate(sequence.operations):
            value, sign = self.stripped[operands[0]] if code == op.NEG else (k, -1)
            self.stripped.append((value, -sign))

    def is_work(self, k: int) -> bool:
        """Return whether value k is computed: neither read where it lies, nor another one's negative."""
        return self.operations[k].op not in _READ

    def base(self, k: int) -> int:
        """Return value k without its signs."""
        return self.stripped[k][0]

    def read_terms(self, operation: Operation) -> list[Term]:
        """Return the operands; those of a difference as of a sum."""
        terms = [self.stripped[k] for k in operation.operands]
        if operation.op == op.SUB:
            value, sign = terms[1]
            terms[1] = value, -sign
        return terms

    def can_pair(self, operation: Operation) -> bool:
        """Return whether there is an instruction that does such an operation twice."""
        if operation.op == op.POW:
            return self.constants.get(operation.operands[1]) == 2.0
        return operation.op in PAIRED

    def align_terms(self, k: int, places: dict[int, tuple[int, int]]) -> list[tuple[tuple[int, int], Term]]:
        """Return the terms of operation k, each behind what it is to a pair.

        That is ``(0, pair)``, ``(1, 0)`` for a constant or ``(2, value)`` for any other; terms and factors
        that may change places are sorted by it.
        """
        operation = self.operations[k]
        terms = [(self._kind(term[0], places), term) for term in self.read_terms(operation)]
        if operation.op in (op.ADD, op.SUB, op.MUL):
            return sorted(terms)
        if operation.op == op.FMA:
            return [*sorted(terms[:2]), terms[2]]
        return terms

    def _kind(self, value: int, places: dict[int, tuple[int, int]]) -> tuple[int, int]:
        if value in self.constants:
            return 1, 0
        place = places.get(value)
        return (2, value) if place is None else (0, place[0])
