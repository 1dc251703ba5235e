"""The factorization of the kernel `solve_saddle` as LLVM code; the reference is `expr.saddle_factors`.

The same text writes it for one system and for several in lanes, see `Kernel.holds`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from llvmlite import ir

from symbody.codegen.llvm.loops import (
    INTEGER,
    REAL,
    Array,
    Matrix,
    absolute,
    add_product,
    count,
    integer,
    larger,
    larger_integer,
    loop,
    number,
    real,
    smaller_integer,
    spread,
    square_root,
    subtract_product,
)
from symbody.codegen.llvm.row_groups import (
    apart,
    by_groups,
    row_sums,
    side_by_side,
    subtract_multiple,
    subtract_outer,
)
from symbody.expr.saddle_factors import (
    CUT_FACTOR,
    EPSILON,
    EXPONENT_LIMIT,
    LIGHTEST,
    PIVOT_SHARE,
)

FIRST: Final = integer(0)
ONE: Final = integer(1)
FLAG: Final = ir.IntType(1)


@dataclass(frozen=True, slots=True, eq=False)
class Kernel:
    """Arguments and scratch of the function being written; names as in `Factors` of the reference.

    Attributes
    ----------
    kind : ir.Type
        Of all entries: a double, or a vector with one for each of several systems.
    mixed : pointer
        Whether the systems asked for different ways, so that all results are worthless.
    """

    kind: ir.Type
    mixed: ir.Value
    b: ir.IRBuilder
    n: ir.Value
    m: ir.Value
    M: Matrix
    J: Matrix
    d: Array
    order: Array  # integers
    diagonal: Array
    beta: Array
    f: Array
    y: Array
    r: Array
    size: Array
    share: Array
    g: Array
    A: Matrix
    B: Matrix

    def number(self, value: float) -> ir.Constant:
        """Return a constant entry."""
        return number(self.kind, value)

    def holds(self, condition: ir.Value) -> ir.Value:
        """Return whether a condition that decides the way holds: in lanes, whether it does in all of them.

        Where it holds in some alone, they are `mixed`.
        """
        if not isinstance(self.kind, ir.VectorType):
            return condition
        b, mask = self.b, ir.IntType(self.kind.count)
        found = b.bitcast(condition, mask)
        everywhere = b.icmp_unsigned("==", found, mask(2**self.kind.count - 1))
        somewhere = b.icmp_unsigned("!=", found, mask(0))
        b.store(b.or_(b.load(self.mixed, typ=FLAG), b.xor(everywhere, somewhere)), self.mixed)
        return everywhere


def _scale(k: Kernel, x: ir.Value, *, halved: bool = False) -> ir.Value:
    """Return 2^-e, halved 2^-floor(e/2), where 2^(e-1) <= x < 2^e; 1 if x is 0 or not finite."""
    b = k.b
    integers = ir.VectorType(INTEGER, k.kind.count) if isinstance(k.kind, ir.VectorType) else INTEGER

    def whole(value: int) -> ir.Constant:
        return ir.Constant(integers, [value] * k.kind.count if integers is not INTEGER else value)

    biased = b.and_(b.lshr(b.bitcast(x, integers), whole(52)), whole(0x7FF))
    e = b.sub(biased, whole(1022))
    e = smaller_integer(b, larger_integer(b, e, whole(-EXPONENT_LIMIT)), whole(EXPONENT_LIMIT))
    if halved:
        e = b.ashr(e, whole(1))
    power = b.bitcast(b.shl(b.sub(whole(1023), e), whole(52)), k.kind)
    regular = b.and_(b.fcmp_ordered(">", x, k.number(0.0)), b.fcmp_ordered("<", x, k.number(math.inf)))
    return b.select(regular, power, k.number(1.0))


def cut(k: Kernel, size: ir.Value) -> ir.Value:
    """Return below what share of the largest a pivot counts as zero, in a system of a size."""
    share = k.b.fmul(k.b.fmul(real(CUT_FACTOR), k.b.sitofp(size, REAL)), real(EPSILON))
    return spread(k.b, k.kind, share)


def scales(k: Kernel) -> None:
    """Write the scales of columns and rows, powers of 2."""
    b, zero = k.b, k.number(0.0)
    with loop(b, FIRST, k.n, zero) as masses:
        masses.carry(larger(b, masses.value, k.M.load(masses.index, masses.index)))
    heaviest = masses.value
    floor = b.fmul(k.number(LIGHTEST), heaviest)
    with count(b, FIRST, k.n) as j:
        mass = k.M.load(j, j)
        raised = b.select(b.fcmp_ordered("<", mass, floor), floor, mass)
        massive = b.fcmp_ordered(">", mass, zero)
        k.d.store(j, _scale(k, b.select(massive, raised, heaviest), halved=True))
    with count(b, FIRST, k.m) as i:
        with loop(b, FIRST, k.n, zero) as row:
            entry = b.fmul(absolute(b, k.J.load(i, row.index)), k.d.load(row.index))
            row.carry(larger(b, row.value, entry))
        k.r.store(i, _scale(k, row.value))
    with count(b, FIRST, k.n) as j, b.if_then(k.holds(b.not_(b.fcmp_ordered(">", k.M.load(j, j), zero)))):
        with loop(b, FIRST, k.m, zero) as column:
            entry = b.fmul(absolute(b, k.J.load(column.index, j)), k.r.load(column.index))
            column.carry(larger(b, column.value, b.fmul(entry, k.d.load(j))))
        k.d.store(j, b.fmul(k.d.load(j), _scale(k, column.value)))


def scale_matrices(k: Kernel) -> None:
    """Write A and B: J and M, scaled."""
    b = k.b
    with count(b, FIRST, k.m) as i, count(b, FIRST, k.n) as j:
        k.A.store(i, j, b.fmul(b.fmul(k.J.load(i, j), k.r.load(i)), k.d.load(j)))
    with count(b, FIRST, k.n) as i, count(b, FIRST, k.n) as j:
        k.B.store(i, j, b.fmul(b.fmul(k.M.load(i, j), k.d.load(i)), k.d.load(j)))


def factor_rows(k: Kernel, rank_cut: ir.Value) -> tuple[ir.Value, ir.Value]:
    """Return whether A is finite, and the rank of J."""
    b = k.b
    with loop(b, FIRST, k.m) as rows:
        square = tail_product(k, k.A.row(rows.index), k.A.row(rows.index), FIRST)
        k.size.store(rows.index, square)
        rows.leave_if(k.holds(b.not_(b.fcmp_ordered("<", square, k.number(math.inf)))))
    finite = b.icmp_signed("==", rows.index, k.m)
    most = b.select(finite, smaller_integer(b, k.n, k.m), FIRST)
    with loop(b, FIRST, most) as step:
        best = _largest_share(k, step.index)
        step.leave_if(k.holds(b.not_(b.fcmp_ordered(">", best, b.fmul(rank_cut, rank_cut)))))
        i = _earliest_row(k, best)
        k.order.store(step.index, i)
        k.size.store(i, k.number(0.0))
        _reflect(k, i, step.index)
        _reflect_rows(k, i, step.index)
    return finite, step.index


def tail_product(k: Kernel, first: Array, second: Array, start: ir.Value) -> ir.Value:
    """Return the sum of the products of the entries from `start` on."""
    with loop(k.b, start, k.n, k.number(0.0)) as j:
        j.carry(add_product(k.b, j.value, first.load(j.index), second.load(j.index)))
    return j.value


def _largest_share(k: Kernel, step: ir.Value) -> ir.Value:
    b, zero = k.b, k.number(0.0)

    def write(rows: list[ir.Value]) -> None:
        with loop(b, step, k.n, side_by_side(b, [zero] * len(rows))) as column:
            entries = side_by_side(b, [k.A.load(i, column.index) for i in rows])
            column.carry(add_product(b, column.value, entries, entries))
        for i, square in zip(rows, apart(b, column.value, len(rows)), strict=True):
            size = k.size.load(i)
            share = b.select(b.fcmp_ordered(">", size, zero), b.fdiv(square, size), zero)
            k.share.store(i, share)

    by_groups(b, k.kind, FIRST, k.m, write)
    with loop(b, FIRST, k.m, zero) as row:
        row.carry(larger(b, row.value, k.share.load(row.index)))
    return row.value


def _earliest_row(k: Kernel, best: ir.Value) -> ir.Value:
    b = k.b
    enough = b.fmul(k.number(PIVOT_SHARE), best)
    # Some row is found, the last if no other: lanes that are mixed may agree on none.
    with loop(b, FIRST, b.sub(k.m, ONE)) as rows:
        rows.leave_if(k.holds(b.fcmp_ordered(">", k.share.load(rows.index), enough)))
    return rows.index


def _reflect(k: Kernel, i: ir.Value, step: ir.Value) -> None:
    b = k.b
    row = k.A.row(i)
    square = tail_product(k, row, row, step)
    length = square_root(b, square)
    head = row.load(step)
    k.beta.store(step, b.fdiv(k.number(1.0), add_product(b, square, length, absolute(b, head))))
    negative = b.fcmp_ordered("<", head, k.number(0.0))
    k.diagonal.store(step, b.select(negative, length, b.fneg(length)))
    row.store(step, b.select(negative, b.fsub(head, length), b.fadd(head, length)))


def _reflect_rows(k: Kernel, i: ir.Value, step: ir.Value) -> None:
    b = k.b
    row, beta = k.A.row(i), k.beta.load(step)

    def write(rows: list[ir.Value]) -> None:
        targets = [k.A.row(other) for other in rows]
        sums = row_sums(b, targets, row, step, k.n)
        for other, target, total in zip(rows, targets, sums, strict=True):
            factor = b.fmul(total, beta)
            with b.if_then(k.holds(b.fcmp_ordered(">", k.size.load(other), k.number(0.0)))):
                subtract_multiple(b, target, factor, row, step, k.n)

    by_groups(b, k.kind, FIRST, k.m, write)


def rotate_mass(k: Kernel, rank: ir.Value) -> None:
    """Reflect B from both sides."""
    b, p = k.b, k.y
    with count(b, FIRST, rank) as step:
        v, beta = k.A.row(k.order.load(step)), k.beta.load(step)

        def write(rows: list[ir.Value], v: Array = v, beta: ir.Value = beta, step: ir.Value = step) -> None:
            for i, total in zip(rows, row_sums(b, [k.B.row(i) for i in rows], v, step, k.n), strict=True):
                p.store(i, b.fmul(total, beta))

        by_groups(b, k.kind, FIRST, k.n, write)
        half = b.fmul(k.number(0.5), b.fmul(tail_product(k, p, v, step), beta))
        subtract_multiple(b, p, half, v, step, k.n)
        with count(b, FIRST, step) as i, count(b, step, k.n) as j:
            entry = subtract_product(b, k.B.load(i, j), p.load(i), v.load(j))
            k.B.store(i, j, entry)
            k.B.store(j, i, entry)
        with count(b, step, k.n) as i:
            subtract_outer(b, k.B.row(i), (p.load(i), v), (v.load(i), p), step, k.n)


def factor_mass(k: Kernel, rank: ir.Value) -> ir.Value:
    """Return how far the pivoted Cholesky factorization went.

    Rows and columns of B from `rank` on are brought into the order of the pivots, which the reference leaves
    to `order`: entries that are read one after the other are then neighbours. `y` takes the column.
    """
    b, B, order, column = k.b, k.B, k.order, k.y
    floor = cut(k, k.n)
    with count(b, rank, k.n) as j:
        order.store(j, j)
    with loop(b, rank, k.n) as step:
        after = b.add(step.index, ONE)
        _bring_largest_pivot(k, rank, step.index)
        pivot = B.load(step.index, step.index)
        step.leave_if(k.holds(b.not_(b.fcmp_ordered(">", pivot, floor))))
        root = square_root(b, pivot)
        B.store(step.index, step.index, root)
        with count(b, after, k.n) as c:
            entry = b.fdiv(B.load(c, step.index), root)
            B.store(c, step.index, entry)
            column.store(c, entry)
        with count(b, after, k.n) as c:
            subtract_multiple(b, B.row(c), column.load(c), column, after, k.n)
    return step.index


def _bring_largest_pivot(k: Kernel, rank: ir.Value, step: ir.Value) -> None:
    """Exchange rows and columns of B so that the largest remaining diagonal entry stands at `step`."""
    b, B, order = k.b, k.B, k.order
    with loop(b, b.add(step, ONE), k.n, step) as search:
        entry, largest = (B.load(place, place) for place in (search.index, search.value))
        better = k.holds(b.fcmp_ordered(">", entry, largest))
        search.carry(b.select(better, search.index, search.value))
    best = search.value
    with b.if_then(b.icmp_signed("!=", best, step)):
        first = order.load(step)
        order.store(step, order.load(best))
        order.store(best, first)
        with count(b, rank, k.n) as j:
            entry = B.load(step, j)
            B.store(step, j, B.load(best, j))
            B.store(best, j, entry)
        with count(b, step, k.n) as i:
            entry = B.load(i, step)
            B.store(i, step, B.load(i, best))
            B.store(i, best, entry)
