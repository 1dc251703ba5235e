"""The kernel `solve_saddle` as an LLVM function.

Operation for operation the loops of `expr.saddle` and `expr.saddle_factors`, with the same names, so that all
give the same bits: no fast-math flag, no fused operation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from llvmlite import ir

from symbody.codegen.llvm.loops import (
    INTEGER,
    POINTER,
    REAL,
    Array,
    Matrix,
    absolute,
    add_product,
    count,
    count_down,
    integer,
    larger,
    larger_integer,
    loop,
    real,
    smaller_integer,
    square_root,
    subtract_product,
)
from symbody.expr.saddle_factors import CUT_FACTOR, EPSILON, EXPONENT_LIMIT, LIGHTEST, PIVOT_SHARE

NAME: Final = "symbody_solve_saddle"
STATUS: Final = ir.IntType(32)
ZERO: Final = real(0.0)
FIRST: Final = integer(0)
ONE: Final = integer(1)


@dataclass(frozen=True, slots=True, eq=False)
class _Kernel:
    """Arguments and scratch of the function being written; names as in `Factors` of the reference."""

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


def define_solve_saddle(module: ir.Module) -> ir.Function:
    """Add the kernel to a module and return it.

    ``int (int n, int m, const double *M, *J, *F, *gamma, double *result, double *work)`` returns 0, or 1 if
    the system cannot be solved; `result` takes n + m + 1 doubles, `work` as many as
    `saddle_c.saddle_work_size` says.
    """
    general = define_solve_saddle_cut(module)
    function = ir.Function(module, ir.FunctionType(STATUS, [STATUS, STATUS, *[POINTER] * 6]), name=NAME)
    function.linkage = "internal"
    b = ir.IRBuilder(function.append_basic_block("entry"))
    n, m, M, J, F, gamma, result, work = function.args
    rank_cut = b.fmul(b.fmul(real(CUT_FACTOR), b.sitofp(m, REAL)), real(EPSILON))
    b.ret(b.call(general, [n, m, M, J, F, gamma, rank_cut, result, work]))
    return function


def define_solve_saddle_cut(module: ir.Module) -> ir.Function:
    """Add the kernel whose rank cut, a double before `result`, is an argument."""
    signature = ir.FunctionType(STATUS, [STATUS, STATUS, *[POINTER] * 4, REAL, POINTER, POINTER])
    function = ir.Function(module, signature, name=f"{NAME}_cut")
    function.linkage = "internal"
    b = ir.IRBuilder(function.append_basic_block("entry"))
    n, m, M, J, F, gamma, rank_cut, result, work = function.args
    k = _layout(b, b.sext(n, INTEGER), b.sext(m, INTEGER), Array(b, M), Array(b, J), Array(b, work))
    udot = Array(b, result)
    multipliers = udot.after(k.n)
    _scales(k)
    _scale_matrices(k)
    finite, rank = _factor_rows(k, rank_cut)
    _rotate_mass(k, rank)
    definite = _factor_mass(k, rank)
    ok = b.and_(finite, b.icmp_signed("==", definite, k.n))
    with count(b, FIRST, b.add(k.n, k.m)) as i:
        udot.store(i, b.select(ok, ZERO, real(math.nan)))
    multipliers.store(k.m, b.sitofp(rank, REAL))
    with count(b, FIRST, b.select(ok, integer(2), FIRST)):  # the solution, then its refinement
        _scaled_residual(k, rank, Array(b, F), Array(b, gamma), udot, multipliers)
        _add_solution(k, rank, udot, multipliers)
    b.ret(b.select(ok, STATUS(0), STATUS(1)))
    return function


def _layout(b: ir.IRBuilder, n: ir.Value, m: ir.Value, M: Array, J: Array, work: Array) -> _Kernel:
    """Divide the scratch as `symbody_saddle_layout` of the C text does."""
    d = work
    order = d.after(n, INTEGER)
    diagonal = order.after(n)
    beta = diagonal.after(n)
    f = beta.after(n)
    y = f.after(n)
    r = y.after(n)
    size = r.after(m)
    share = size.after(m)
    g = share.after(m)
    A = Matrix(g.after(m), n)
    B = Matrix(A.row(m), n)
    return _Kernel(
        b, n, m, Matrix(M, n), Matrix(J, n), d, order, diagonal, beta, f, y, r, size, share, g, A, B
    )


def _scale(b: ir.IRBuilder, x: ir.Value, *, halved: bool = False) -> ir.Value:
    """Return 2^-e, halved 2^-floor(e/2), where 2^(e-1) <= x < 2^e; 1 if x is 0 or not finite."""
    biased = b.and_(b.lshr(b.bitcast(x, INTEGER), integer(52)), integer(0x7FF))
    e = b.sub(biased, integer(1022))
    e = smaller_integer(b, larger_integer(b, e, integer(-EXPONENT_LIMIT)), integer(EXPONENT_LIMIT))
    if halved:
        e = b.ashr(e, ONE)
    power = b.bitcast(b.shl(b.sub(integer(1023), e), integer(52)), REAL)
    regular = b.and_(b.fcmp_ordered(">", x, ZERO), b.fcmp_ordered("<", x, real(math.inf)))
    return b.select(regular, power, real(1.0))


def _scales(k: _Kernel) -> None:
    b = k.b
    with loop(b, FIRST, k.n, ZERO) as masses:
        masses.carry(larger(b, masses.value, k.M.load(masses.index, masses.index)))
    heaviest = masses.value
    floor = b.fmul(real(LIGHTEST), heaviest)
    with count(b, FIRST, k.n) as j:
        mass = k.M.load(j, j)
        raised = b.select(b.fcmp_ordered("<", mass, floor), floor, mass)
        massive = b.fcmp_ordered(">", mass, ZERO)
        k.d.store(j, _scale(b, b.select(massive, raised, heaviest), halved=True))
    with count(b, FIRST, k.m) as i:
        with loop(b, FIRST, k.n, ZERO) as row:
            entry = b.fmul(absolute(b, k.J.load(i, row.index)), k.d.load(row.index))
            row.carry(larger(b, row.value, entry))
        k.r.store(i, _scale(b, row.value))
    with count(b, FIRST, k.n) as j, b.if_then(b.not_(b.fcmp_ordered(">", k.M.load(j, j), ZERO))):
        with loop(b, FIRST, k.m, ZERO) as column:
            entry = b.fmul(absolute(b, k.J.load(column.index, j)), k.r.load(column.index))
            column.carry(larger(b, column.value, b.fmul(entry, k.d.load(j))))
        k.d.store(j, b.fmul(k.d.load(j), _scale(b, column.value)))


def _scale_matrices(k: _Kernel) -> None:
    b = k.b
    with count(b, FIRST, k.m) as i, count(b, FIRST, k.n) as j:
        k.A.store(i, j, b.fmul(b.fmul(k.J.load(i, j), k.r.load(i)), k.d.load(j)))
    with count(b, FIRST, k.n) as i, count(b, FIRST, k.n) as j:
        k.B.store(i, j, b.fmul(b.fmul(k.M.load(i, j), k.d.load(i)), k.d.load(j)))


def _factor_rows(k: _Kernel, rank_cut: ir.Value) -> tuple[ir.Value, ir.Value]:
    """Return whether A is finite, and the rank of J."""
    b = k.b
    with loop(b, FIRST, k.m) as rows:
        square = _tail_product(k, k.A.row(rows.index), k.A.row(rows.index), FIRST)
        k.size.store(rows.index, square)
        rows.leave_if(b.not_(b.fcmp_ordered("<", square, real(math.inf))))
    finite = b.icmp_signed("==", rows.index, k.m)
    most = b.select(finite, smaller_integer(b, k.n, k.m), FIRST)
    with loop(b, FIRST, most) as step:
        best = _largest_share(k, step.index)
        step.leave_if(b.not_(b.fcmp_ordered(">", best, b.fmul(rank_cut, rank_cut))))
        i = _earliest_row(k, best)
        k.order.store(step.index, i)
        k.size.store(i, ZERO)
        _reflect(k, i, step.index)
        _reflect_rows(k, i, step.index)
    return finite, step.index


def _tail_product(k: _Kernel, first: Array, second: Array, start: ir.Value) -> ir.Value:
    with loop(k.b, start, k.n, ZERO) as j:
        j.carry(add_product(k.b, j.value, first.load(j.index), second.load(j.index)))
    return j.value


def _largest_share(k: _Kernel, step: ir.Value) -> ir.Value:
    b = k.b
    with loop(b, FIRST, k.m, ZERO) as rows:
        i = rows.index
        size = k.size.load(i)
        k.share.store(i, ZERO)
        with b.if_then(b.fcmp_ordered(">", size, ZERO)):
            k.share.store(i, b.fdiv(_tail_product(k, k.A.row(i), k.A.row(i), step), size))
        rows.carry(larger(b, rows.value, k.share.load(i)))
    return rows.value


def _earliest_row(k: _Kernel, best: ir.Value) -> ir.Value:
    b = k.b
    enough = b.fmul(real(PIVOT_SHARE), best)
    with loop(b, FIRST, k.m) as rows:
        rows.leave_if(b.fcmp_ordered(">", k.share.load(rows.index), enough))
    return rows.index


def _reflect(k: _Kernel, i: ir.Value, step: ir.Value) -> None:
    b = k.b
    row = k.A.row(i)
    square = _tail_product(k, row, row, step)
    length = square_root(b, square)
    head = row.load(step)
    k.beta.store(step, b.fdiv(real(1.0), add_product(b, square, length, absolute(b, head))))
    negative = b.fcmp_ordered("<", head, ZERO)
    k.diagonal.store(step, b.select(negative, length, b.fneg(length)))
    row.store(step, b.select(negative, b.fsub(head, length), b.fadd(head, length)))


def _reflect_rows(k: _Kernel, i: ir.Value, step: ir.Value) -> None:
    b = k.b
    row = k.A.row(i)
    with count(b, FIRST, k.m) as other, b.if_then(b.fcmp_ordered(">", k.size.load(other), ZERO)):
        target = k.A.row(other)
        factor = b.fmul(_tail_product(k, row, target, step), k.beta.load(step))
        with count(b, step, k.n) as j:
            target.store(j, subtract_product(b, target.load(j), factor, row.load(j)))


def _rotate_mass(k: _Kernel, rank: ir.Value) -> None:
    b, p = k.b, k.y
    with count(b, FIRST, rank) as step:
        v, beta = k.A.row(k.order.load(step)), k.beta.load(step)
        with count(b, FIRST, k.n) as i:
            p.store(i, b.fmul(_tail_product(k, k.B.row(i), v, step), beta))
        half = b.fmul(real(0.5), b.fmul(_tail_product(k, p, v, step), beta))
        with count(b, step, k.n) as j:
            p.store(j, subtract_product(b, p.load(j), half, v.load(j)))
        with count(b, FIRST, step) as i, count(b, step, k.n) as j:
            entry = subtract_product(b, k.B.load(i, j), p.load(i), v.load(j))
            k.B.store(i, j, entry)
            k.B.store(j, i, entry)
        with count(b, step, k.n) as i, count(b, step, k.n) as j:
            change = add_product(b, b.fmul(p.load(i), v.load(j)), v.load(i), p.load(j))
            k.B.store(i, j, b.fsub(k.B.load(i, j), change))


def _factor_mass(k: _Kernel, rank: ir.Value) -> ir.Value:
    """Return how far the pivoted Cholesky factorization went."""
    b, B, order = k.b, k.B, k.order
    floor = b.fmul(b.fmul(real(CUT_FACTOR), b.sitofp(k.n, REAL)), real(EPSILON))
    with count(b, rank, k.n) as j:
        order.store(j, j)
    with loop(b, rank, k.n) as step:
        after = b.add(step.index, ONE)
        i = _largest_pivot(k, step.index)
        b_ii = B.load(i, i)
        step.leave_if(b.not_(b.fcmp_ordered(">", b_ii, floor)))
        root = square_root(b, b_ii)
        B.store(i, i, root)
        with count(b, after, k.n) as c:
            row = order.load(c)
            B.store(row, i, b.fdiv(B.load(row, i), root))
        with count(b, after, k.n) as a:
            row = order.load(a)
            factor = B.load(row, i)
            with count(b, after, k.n) as c:
                column = order.load(c)
                B.store(row, column, subtract_product(b, B.load(row, column), factor, B.load(column, i)))
    return step.index


def _largest_pivot(k: _Kernel, step: ir.Value) -> ir.Value:
    """Bring the largest remaining diagonal entry of B to place `step` of the order; return its index."""
    b, B, order = k.b, k.B, k.order
    with loop(b, b.add(step, ONE), k.n, step) as search:
        old, new = order.load(search.value), order.load(search.index)
        better = b.fcmp_ordered(">", B.load(new, new), B.load(old, old))
        search.carry(b.select(better, search.index, search.value))
    best = order.load(search.value)
    order.store(search.value, order.load(step))
    order.store(step, best)
    return best


def _scaled_residual(
    k: _Kernel, rank: ir.Value, F: Array, gamma: Array, udot: Array, multipliers: Array
) -> None:
    b = k.b
    with count(b, FIRST, k.n) as j:
        with loop(b, FIRST, rank, F.load(j)) as rows:
            i = k.order.load(rows.index)
            rows.carry(add_product(b, rows.value, k.J.load(i, j), multipliers.load(i)))
        with loop(b, FIRST, k.n, rows.value) as columns:
            i = columns.index
            columns.carry(subtract_product(b, columns.value, k.M.load(j, i), udot.load(i)))
        k.f.store(j, b.fmul(columns.value, k.d.load(j)))
    with count(b, FIRST, rank) as step:
        i = k.order.load(step)
        with loop(b, FIRST, k.n, gamma.load(i)) as columns:
            j = columns.index
            columns.carry(subtract_product(b, columns.value, k.J.load(i, j), udot.load(j)))
        k.g.store(i, b.fmul(columns.value, k.r.load(i)))


def _add_solution(k: _Kernel, rank: ir.Value, udot: Array, multipliers: Array) -> None:
    b = k.b
    with count(b, FIRST, rank) as step:
        _apply_reflection(k, step, k.f)
    _rotated_acceleration(k, rank)
    _scaled_multipliers(k, rank)
    with count_down(b, FIRST, rank) as step:
        _apply_reflection(k, step, k.y)
    with count(b, FIRST, k.n) as j:
        udot.store(j, add_product(b, udot.load(j), k.d.load(j), k.y.load(j)))
    with count(b, FIRST, rank) as step:
        i = k.order.load(step)
        multipliers.store(i, add_product(b, multipliers.load(i), k.r.load(i), k.g.load(i)))


def _rotated_acceleration(k: _Kernel, rank: ir.Value) -> None:
    b, y = k.b, k.y
    with count(b, FIRST, rank) as step:
        i = k.order.load(step)
        with loop(b, FIRST, step, k.g.load(i)) as known:
            j = known.index
            known.carry(subtract_product(b, known.value, k.A.load(i, j), y.load(j)))
        y.store(step, b.fdiv(known.value, k.diagonal.load(step)))
    with count(b, rank, k.n) as i:
        with loop(b, FIRST, rank, k.f.load(i)) as known:
            j = known.index
            known.carry(subtract_product(b, known.value, k.B.load(i, j), y.load(j)))
        y.store(i, known.value)
    _solve_mass(k, rank)


def _scaled_multipliers(k: _Kernel, rank: ir.Value) -> None:
    b = k.b
    with count_down(b, FIRST, rank) as step:
        with loop(b, FIRST, k.n, b.fneg(k.f.load(step))) as columns:
            j = columns.index
            columns.carry(add_product(b, columns.value, k.B.load(step, j), k.y.load(j)))
        with loop(b, b.add(step, ONE), rank, columns.value) as known:
            i = k.order.load(known.index)
            known.carry(subtract_product(b, known.value, k.A.load(i, step), k.g.load(i)))
        k.g.store(k.order.load(step), b.fdiv(known.value, k.diagonal.load(step)))


def _apply_reflection(k: _Kernel, step: ir.Value, x: Array) -> None:
    b = k.b
    v = k.A.row(k.order.load(step))
    factor = b.fmul(_tail_product(k, v, x, step), k.beta.load(step))
    with count(b, step, k.n) as j:
        x.store(j, subtract_product(b, x.load(j), factor, v.load(j)))


def _solve_mass(k: _Kernel, rank: ir.Value) -> None:
    b, y = k.b, k.y
    with count(b, rank, k.n) as step:
        i = k.order.load(step)
        known = b.fdiv(y.load(i), k.B.load(i, i))
        y.store(i, known)
        with count(b, b.add(step, ONE), k.n) as c:
            row = k.order.load(c)
            y.store(row, subtract_product(b, y.load(row), k.B.load(row, i), known))
    with count_down(b, rank, k.n) as step:
        i = k.order.load(step)
        with loop(b, b.add(step, ONE), k.n, y.load(i)) as later:
            row = k.order.load(later.index)
            later.carry(subtract_product(b, later.value, k.B.load(row, i), y.load(row)))
        y.store(i, b.fdiv(later.value, k.B.load(i, i)))
