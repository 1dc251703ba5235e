"""Several entries or sums side by side, for hand-written LLVM functions.

A sum is a chain in which every addition waits for the one before. Four chains at once take the time of one;
each still adds its own terms in their order, so that it has the bits of a plain loop. Where entries are
vectors of several systems, these are the chains, and rows go one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from llvmlite import ir

from symbody.codegen.llvm.loops import (
    REAL,
    Array,
    add_product,
    count,
    integer,
    loop,
    number,
    subtract_product,
)

_SHIFT: Final = 2
_WIDTH: Final = 1 << _SHIFT
_PLACE: Final = ir.IntType(32)


def by_groups(
    b: ir.IRBuilder, kind: ir.Type, start: ir.Value, stop: ir.Value, write: Callable[[list[ir.Value]], None]
) -> None:
    """Write a loop from `start` to `stop`, four indices at a time, and one over those that are left.

    Vectors, the `kind` of the entries, go one at a time.
    """
    if isinstance(kind, ir.VectorType):
        with count(b, start, stop) as index:
            write([index])
        return
    width = integer(_WIDTH)
    groups = b.lshr(b.sub(stop, start), integer(_SHIFT))
    with count(b, integer(0), groups) as group:
        first = b.add(start, b.mul(group, width))
        write([b.add(first, integer(k)) for k in range(_WIDTH)])
    with count(b, b.add(start, b.mul(groups, width)), stop) as index:
        write([index])


def side_by_side(b: ir.IRBuilder, values: Sequence[ir.Value]) -> ir.Value:
    """Return several doubles as one vector, one as it is."""
    if len(values) == 1:
        return values[0]
    vector = ir.Constant(ir.VectorType(REAL, len(values)), ir.Undefined)
    for place, value in enumerate(values):
        vector = b.insert_element(vector, value, ir.Constant(_PLACE, place))
    return vector


def apart(b: ir.IRBuilder, vector: ir.Value, parts: int) -> list[ir.Value]:
    """Return the so many parts that `side_by_side` was made of."""
    if parts == 1:
        return [vector]
    return [b.extract_element(vector, ir.Constant(_PLACE, place)) for place in range(parts)]


def row_sums(
    b: ir.IRBuilder, rows: Sequence[Array], factors: Array, start: ir.Value, stop: ir.Value
) -> list[ir.Value]:
    """Return for each row the sum of its entries times `factors`, from `start` to `stop`."""
    width = len(rows)
    with loop(b, start, stop, side_by_side(b, [number(rows[0].element, 0.0)] * width)) as column:
        entries = side_by_side(b, [row.load(column.index) for row in rows])
        factor = side_by_side(b, [factors.load(column.index)] * width)
        column.carry(add_product(b, column.value, entries, factor))
    return apart(b, column.value, width)


def subtract_multiple(
    b: ir.IRBuilder, target: Array, factor: ir.Value, source: Array, start: ir.Value, stop: ir.Value
) -> None:
    """Write ``target[j] -= factor * source[j]`` from `start` to `stop`; the two do not overlap."""

    def write(places: list[ir.Value]) -> None:
        wide = side_by_side(b, [factor] * len(places))
        entries, others = (_together(b, array, places) for array in (target, source))
        _store(b, target, places, subtract_product(b, entries, wide, others))

    by_groups(b, target.element, start, stop, write)


def subtract_outer(
    b: ir.IRBuilder,
    target: Array,
    one: tuple[ir.Value, Array],
    two: tuple[ir.Value, Array],
    start: ir.Value,
    stop: ir.Value,
) -> None:
    """Write ``target[j] -= a x[j] + c y[j]`` for `one` = (a, x), `two` = (c, y), from `start` to `stop`."""

    def write(places: list[ir.Value]) -> None:
        wide = [side_by_side(b, [factor] * len(places)) for factor, _ in (one, two)]
        first, second, entries = (_together(b, array, places) for array in (one[1], two[1], target))
        change = add_product(b, b.fmul(wide[0], first), wide[1], second)
        _store(b, target, places, b.fsub(entries, change))

    by_groups(b, target.element, start, stop, write)


def _together(b: ir.IRBuilder, array: Array, places: Sequence[ir.Value]) -> ir.Value:
    """Return adjacent entries as one vector, one as it is."""
    kind = array.element if len(places) == 1 else ir.VectorType(REAL, len(places))
    return b.load(array.after(places[0]).pointer, align=8, typ=kind)


def _store(b: ir.IRBuilder, array: Array, places: Sequence[ir.Value], value: ir.Value) -> None:
    b.store(value, array.after(places[0]).pointer, align=8)
