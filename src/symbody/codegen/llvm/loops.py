"""Loops, arrays and matrices for hand-written LLVM functions.

A thin layer on llvmlite's builder, so that a numerical kernel reads like its reference. Integers are 64 bits
wide, reals are doubles, pointers are opaque. Values carried round a loop are phi nodes: no memory, no passes
needed.
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


def real(value: float) -> ir.Constant:
    """Return a constant double."""
    return ir.Constant(REAL, value)


def number(kind: ir.Type, value: float) -> ir.Constant:
    """Return a constant double, in every lane where `kind` is a vector."""
    return ir.Constant(kind, [value] * kind.count if isinstance(kind, ir.VectorType) else value)


def broadcast(builder: ir.IRBuilder, kind: ir.Type, value: ir.Value) -> ir.Value:
    """Return a double in every lane where `kind` is a vector, as it is elsewhere."""
    if not isinstance(kind, ir.VectorType):
        return value
    place = ir.IntType(32)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), value, place(0))
    zeros = ir.Constant(ir.VectorType(place, kind.count), [0] * kind.count)
    return builder.shuffle_vector(first, first, zeros)


def integer(value: int) -> ir.Constant:
    """Return a constant 64-bit integer."""
    return ir.Constant(INTEGER, value)


@dataclass(frozen=True, slots=True, eq=False)
class Array:
    """Elements of one type behind a pointer, which is a multiple of 8."""

    builder: ir.IRBuilder
    pointer: ir.Value
    element: ir.Type = REAL

    def load(self, index: ir.Value) -> ir.Value:
        """Return the element at `index`."""
        return self.builder.load(self._address(index), align=8, typ=self.element)

    def store(self, index: ir.Value, value: ir.Value) -> None:
        """Set the element at `index`."""
        self.builder.store(value, self._address(index), align=8)

    def offset_by(self, count: ir.Value, element: ir.Type | None = None) -> Array:
        """Return the array that begins `count` elements further on, of the same elements or others."""
        return Array(self.builder, self._address(count), self.element if element is None else element)

    def _address(self, index: ir.Value) -> ir.Value:
        return self.builder.gep(self.pointer, [index], source_etype=self.element)


@dataclass(frozen=True, slots=True, eq=False)
class Matrix:
    """Doubles or vectors of them, row after row."""

    entries: Array
    columns: ir.Value

    def row(self, i: ir.Value) -> Array:
        """Return row `i`."""
        return self.entries.offset_by(self.entries.builder.mul(i, self.columns))

    def load(self, i: ir.Value, j: ir.Value) -> ir.Value:
        """Return entry (i, j)."""
        return self.row(i).load(j)

    def store(self, i: ir.Value, j: ir.Value, value: ir.Value) -> None:
        """Set entry (i, j)."""
        self.row(i).store(j, value)


class LoopBuilder:
    """One counted loop while it is being written, its outcome afterwards.

    Attributes
    ----------
    index : ir.Value
        The counter; behind the loop the value at which it ended: the stop, or where `leave_if` left it.
    value : ir.Value
        What is carried from step to step; behind the loop the last value (after `leave_if` that of the step
        left).
    """

    __slots__ = ("_builder", "_exit", "_next", "index", "value")

    def __init__(self, builder: ir.IRBuilder, index: ir.Value, value: ir.Value, exit_: ir.Block) -> None:
        self._builder = builder
        self._exit = exit_
        self._next: ir.Value = value
        self.index = index
        self.value = value

    def carry(self, value: ir.Value) -> None:
        """Set what the next step finds in `value`."""
        self._next = value

    def leave_if(self, condition: ir.Value) -> None:
        """End the loop here if `condition` holds."""
        stay = self._builder.append_basic_block("stay")
        self._builder.cbranch(condition, self._exit, stay)
        self._builder.position_at_end(stay)

    def carried_value(self) -> ir.Value:
        """Return the value that the step just written passes to the next."""
        return self._next


@contextmanager
def loop(
    builder: ir.IRBuilder, start: ir.Value, stop: ir.Value, initial: ir.Value | None = None
) -> Iterator[LoopBuilder]:
    """Write the body of ``for index in range(start, stop)``, carrying a value that begins as `initial`."""
    entry = builder.block
    head = builder.append_basic_block("head")
    body = builder.append_basic_block("body")
    exit_ = builder.append_basic_block("exit")
    builder.branch(head)
    builder.position_at_end(head)
    index = builder.phi(INTEGER)
    index.add_incoming(start, entry)
    value = index
    if initial is not None:
        value = builder.phi(initial.type)
        value.add_incoming(initial, entry)
    builder.cbranch(builder.icmp_signed("<", index, stop), body, exit_)
    builder.position_at_end(body)
    step = LoopBuilder(builder, index, value, exit_)
    yield step
    index.add_incoming(builder.add(index, integer(1)), builder.block)
    if initial is not None:
        value.add_incoming(step.carried_value(), builder.block)
    builder.branch(head)
    builder.position_at_end(exit_)


@contextmanager
def count(builder: ir.IRBuilder, start: ir.Value, stop: ir.Value) -> Iterator[ir.Value]:
    """Write the body of ``for index in range(start, stop)``."""
    with loop(builder, start, stop) as step:
        yield step.index


@contextmanager
def count_down(builder: ir.IRBuilder, start: ir.Value, stop: ir.Value) -> Iterator[ir.Value]:
    """Write the body of ``for index in reversed(range(start, stop))``."""
    last = builder.sub(builder.add(start, stop), integer(1))
    with loop(builder, start, stop) as step:
        yield builder.sub(last, step.index)


def absolute(builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
    """Return the absolute value of a double, or of each in a vector."""
    return builder.call(_intrinsic(builder.module, "llvm.fabs", x.type), [x])


def square_root(builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
    """Return the correctly rounded square root of a double, or of each in a vector."""
    return builder.call(_intrinsic(builder.module, "llvm.sqrt", x.type), [x])


def _intrinsic(module: ir.Module, name: str, kind: ir.Type) -> ir.Function:
    if not isinstance(kind, ir.VectorType):
        return module.declare_intrinsic(name, [kind])
    full = f"{name}.v{kind.count}f64"
    return module.globals.get(full) or ir.Function(module, ir.FunctionType(kind, [kind]), name=full)


def add_product(builder: ir.IRBuilder, total: ir.Value, x: ir.Value, y: ir.Value) -> ir.Value:
    """Return ``total + x * y``, rounded twice."""
    return builder.fadd(total, builder.fmul(x, y))


def subtract_product(builder: ir.IRBuilder, total: ir.Value, x: ir.Value, y: ir.Value) -> ir.Value:
    """Return ``total - x * y``, rounded twice."""
    return builder.fsub(total, builder.fmul(x, y))


def larger(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return ``max(a, b)`` as Python does: b if it is larger, else a, also where b is NaN."""
    return builder.select(builder.fcmp_ordered(">", b, a), b, a)


def smaller_integer(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return ``min(a, b)`` of integers."""
    return builder.select(builder.icmp_signed("<", b, a), b, a)


def larger_integer(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return ``max(a, b)`` of integers."""
    return builder.select(builder.icmp_signed(">", b, a), b, a)
