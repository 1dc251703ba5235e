"""The kernel `solve_saddle` as an LLVM function.

Operation for operation the loops of `expr.saddle` and `expr.saddle_factors`, with the same names, so that all
give the same bits: no fast-math flag, no fused operation.
"""

from __future__ import annotations

import math
from typing import Final

from llvmlite import ir

from symbody.codegen.llvm.loops import (
    INTEGER,
    POINTER,
    REAL,
    Array,
    Matrix,
    add_product,
    count,
    count_down,
    integer,
    loop,
    spread,
    subtract_product,
)
from symbody.codegen.llvm.row_groups import (
    apart,
    by_groups,
    side_by_side,
    subtract_multiple,
)
from symbody.codegen.llvm.saddle_factors import (
    FIRST,
    FLAG,
    ONE,
    Kernel,
    cut,
    factor_mass,
    factor_rows,
    rotate_mass,
    scale_matrices,
    scales,
    tail_product,
)

NAME: Final = "symbody_solve_saddle"
STATUS: Final = ir.IntType(32)


def define_solve_saddle(module: ir.Module) -> ir.Function:
    """Add the kernel to a module and return it.

    ``int (int n, int m, const double *M, *J, *F, *gamma, double *result, double *work)`` returns 0, or 1 if
    the system cannot be solved; `result` takes n + m + 1 doubles, `work` as many as
    `saddle_work_size` returns.
    """
    return _define(module, NAME, REAL, is_cut_given=False)


def define_solve_saddles(module: ir.Module, width: int) -> ir.Function:
    """Add the kernel for `width` systems in lanes to a module and return it.

    As `define_solve_saddle`; entry k of an array begins at k times the width. It also returns 1 where the
    systems have different pivots or ranks, or one of them cannot be solved.
    """
    return _define(module, f"{NAME}_{width}", ir.VectorType(REAL, width), is_cut_given=False)


def define_solve_saddle_cut(module: ir.Module) -> ir.Function:
    """Add the kernel whose rank cut, a double before `result`, is an argument."""
    return _define(module, f"{NAME}_cut", REAL, is_cut_given=True)


def _define(module: ir.Module, name: str, kind: ir.Type, *, is_cut_given: bool) -> ir.Function:
    """Add the kernel for entries of a kind."""
    given = [STATUS, STATUS, *[POINTER] * 4, *[REAL] * is_cut_given, POINTER, POINTER]
    function = ir.Function(module, ir.FunctionType(STATUS, given), name=name)
    function.linkage = "internal"
    b = ir.IRBuilder(function.append_basic_block("entry"))
    n, m, M, J, F, gamma, *rank_cut, result, work = function.args
    M, J, F, gamma, udot, work = (Array(b, place, kind) for place in (M, J, F, gamma, result, work))
    k = _layout(b, b.sext(n, INTEGER), b.sext(m, INTEGER), M, J, work)
    multipliers = udot.after(k.n)
    scales(k)
    scale_matrices(k)
    finite, rank = factor_rows(k, rank_cut[0] if is_cut_given else cut(k, k.m))
    if isinstance(kind, ir.VectorType):
        with b.if_then(b.load(k.mixed, typ=FLAG)):
            b.ret(STATUS(1))
    rotate_mass(k, rank)
    definite = factor_mass(k, rank)
    ok = b.and_(finite, b.icmp_signed("==", definite, k.n))
    ok = b.and_(ok, b.not_(b.load(k.mixed, typ=FLAG)))
    with count(b, FIRST, b.add(k.n, k.m)) as i:
        udot.store(i, b.select(ok, k.number(0.0), k.number(math.nan)))
    multipliers.store(k.m, spread(b, kind, b.sitofp(rank, REAL)))
    with count(b, FIRST, b.select(ok, integer(2), FIRST)):  # the solution, then its refinement
        _scaled_residual(k, rank, F, gamma, udot, multipliers)
        _add_solution(k, rank, udot, multipliers)
    b.ret(b.select(ok, STATUS(0), STATUS(1)))
    return function


def _layout(b: ir.IRBuilder, n: ir.Value, m: ir.Value, M: Array, J: Array, work: Array) -> Kernel:
    """Divide the scratch as `symbody_saddle_layout` of the C text does."""
    kind, mixed = work.element, b.alloca(FLAG)
    b.store(FLAG(0), mixed)
    d = work
    order = d.after(n, INTEGER)
    diagonal = order.after(n, kind)
    beta = diagonal.after(n)
    f = beta.after(n)
    y = f.after(n)
    r = y.after(n)
    size = r.after(m)
    share = size.after(m)
    g = share.after(m)
    A = Matrix(g.after(m), n)
    B = Matrix(A.row(m), n)
    masses, slopes = Matrix(M, n), Matrix(J, n)
    return Kernel(
        kind, mixed, b, n, m, masses, slopes, d, order, diagonal, beta, f, y, r, size, share, g, A, B
    )


def _scaled_residual(
    k: Kernel, rank: ir.Value, F: Array, gamma: Array, udot: Array, multipliers: Array
) -> None:
    b = k.b

    def write(rows: list[ir.Value]) -> None:
        with loop(b, FIRST, rank, side_by_side(b, [F.load(j) for j in rows])) as kept:
            i = k.order.load(kept.index)
            slopes = side_by_side(b, [k.J.load(i, j) for j in rows])
            kept.carry(add_product(b, kept.value, slopes, side_by_side(b, [multipliers.load(i)] * len(rows))))
        with loop(b, FIRST, k.n, kept.value) as columns:
            i = columns.index
            masses = side_by_side(b, [k.M.load(j, i) for j in rows])
            columns.carry(
                subtract_product(b, columns.value, masses, side_by_side(b, [udot.load(i)] * len(rows)))
            )
        for j, total in zip(rows, apart(b, columns.value, len(rows)), strict=True):
            k.f.store(j, b.fmul(total, k.d.load(j)))

    by_groups(b, k.kind, FIRST, k.n, write)
    with count(b, FIRST, rank) as step:
        i = k.order.load(step)
        with loop(b, FIRST, k.n, gamma.load(i)) as columns:
            j = columns.index
            columns.carry(subtract_product(b, columns.value, k.J.load(i, j), udot.load(j)))
        k.g.store(i, b.fmul(columns.value, k.r.load(i)))


def _add_solution(k: Kernel, rank: ir.Value, udot: Array, multipliers: Array) -> None:
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


def _rotated_acceleration(k: Kernel, rank: ir.Value) -> None:
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


def _scaled_multipliers(k: Kernel, rank: ir.Value) -> None:
    b = k.b
    with count_down(b, FIRST, rank) as step:
        with loop(b, FIRST, k.n, b.fneg(k.f.load(step))) as columns:
            j = columns.index
            columns.carry(add_product(b, columns.value, k.B.load(step, j), k.y.load(j)))
        with loop(b, b.add(step, ONE), rank, columns.value) as known:
            i = k.order.load(known.index)
            known.carry(subtract_product(b, known.value, k.A.load(i, step), k.g.load(i)))
        k.g.store(k.order.load(step), b.fdiv(known.value, k.diagonal.load(step)))


def _apply_reflection(k: Kernel, step: ir.Value, x: Array) -> None:
    b = k.b
    v = k.A.row(k.order.load(step))
    factor = b.fmul(tail_product(k, v, x, step), k.beta.load(step))
    subtract_multiple(b, x, factor, v, step, k.n)


def _solve_mass(k: Kernel, rank: ir.Value) -> None:
    b, y = k.b, k.y
    with count(b, rank, k.n) as step:
        i = k.order.load(step)
        known = b.fdiv(y.load(i), k.B.load(step, step))
        y.store(i, known)
        with count(b, b.add(step, ONE), k.n) as c:
            row = k.order.load(c)
            y.store(row, subtract_product(b, y.load(row), k.B.load(c, step), known))
    with count_down(b, rank, k.n) as step:
        i = k.order.load(step)
        with loop(b, b.add(step, ONE), k.n, y.load(i)) as later:
            row = k.order.load(later.index)
            later.carry(subtract_product(b, later.value, k.B.load(later.index, step), y.load(row)))
        y.store(i, b.fdiv(later.value, k.B.load(step, step)))
