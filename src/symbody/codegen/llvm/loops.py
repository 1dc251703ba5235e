"""Counted loops and arrays for LLVM functions written with llvmlite's builder.

Integers are 64 bits wide, reals are doubles, pointers are opaque. Numerical work stands in `symbody.kernels`;
these move numbers between kernels.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from llvmlite import ir

REAL: Final = ir.DoubleType()
INTEGER: Final = ir.IntType(64)
POINTER: Final = ir.PointerType()


def integer(value: int) -> ir.Constant:
    """Return a constant 64-bit integer."""
    return ir.Constant(INTEGER, value)


@dataclass(frozen=True, slots=True, eq=False)
class Array:
    """Doubles behind a pointer, which is a multiple of 8."""

    builder: ir.IRBuilder
    pointer: ir.Value

    def load(self, index: ir.Value) -> ir.Value:
        """Return the entry at `index`."""
        return self.builder.load(self._address(index), align=8, typ=REAL)

    def store(self, index: ir.Value, value: ir.Value) -> None:
        """Set the entry at `index`."""
        self.builder.store(value, self._address(index), align=8)

    def offset_by(self, count: ir.Value) -> Array:
        """Return the array that begins `count` entries further on."""
        return Array(self.builder, self._address(count))

    def _address(self, index: ir.Value) -> ir.Value:
        return self.builder.gep(self.pointer, [index], source_etype=REAL)


@contextmanager
def count(builder: ir.IRBuilder, start: ir.Value, stop: ir.Value) -> Iterator[ir.Value]:
    """Write the body of ``for index in range(start, stop)``."""
    entry = builder.block
    head, body, exit_ = (builder.append_basic_block(name) for name in ("head", "body", "exit"))
    builder.branch(head)
    builder.position_at_end(head)
    index = builder.phi(INTEGER)
    index.add_incoming(start, entry)
    builder.cbranch(builder.icmp_signed("<", index, stop), body, exit_)
    builder.position_at_end(body)
    yield index
    index.add_incoming(builder.add(index, integer(1)), builder.block)
    builder.branch(head)
    builder.position_at_end(exit_)
