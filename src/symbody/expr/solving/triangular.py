"""Closed loops solved unknown by unknown: lengths and angles that stand in equations linearly.

An angle enters by its cosine and sine. Whatever equations give alone is solved first: a length or an angle
that stands in one of them linearly, ``A cos + B sin + C = 0``; else two equations give cosine and sine of one
angle, and the sum of their squares is an equation for the others. So every planar dyad is solved (Wampler &
Sommese 2011, section 3), in both of its assemblies, where a search through polynomials would take long.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import sympy as sp


@dataclass(frozen=True, slots=True)
class LoopEquations:
    """Equations that are left, and what was solved, the last first.

    Attributes
    ----------
    equations : tuple of expressions
        Polynomials in the lengths and in cosines and sines of the angles that are left.
    lengths : tuple of symbols
        What is left of them.
    angles : mapping of symbol to (cosine, sine)
        What is left of them.
    given : mapping of symbol to (cosine, sine)
        Symbols for those of what is known.
    solved : tuple of (symbol, expression)
        Each in the unknowns solved before it; lengths, angles, and their cosines and sines.
    """

    equations: tuple[sp.Expr, ...]
    lengths: tuple[sp.Symbol, ...]
    angles: Mapping[sp.Symbol, tuple[sp.Symbol, sp.Symbol]]
    given: Mapping[sp.Expr, tuple[sp.Symbol, sp.Symbol]]
    solved: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()

    @property
    def unknowns(self) -> set[sp.Symbol]:
        """All symbols of unknowns that are left."""
        return {*self.lengths, *(part for pair in self.angles.values() for part in pair)}


def solve_triangular(
    equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]
) -> list[dict[sp.Symbol, sp.Expr]] | None:
    """Return all solutions, or None where the equations are not of this kind."""
    loop, turned = _as_polynomials(equations, unknowns)
    if loop is None:
        return None
    waiting, solved = [loop], []
    while waiting:
        loop = waiting.pop()
        loop = replace(loop, equations=_simplify_rows(loop))
        if not loop.lengths and not loop.angles:
            if not loop.equations:  # else what is left contradicts, or depends on numbers
                solved.append(_back(loop, turned))
            continue
        branches = _step(loop)
        if branches is None:
            return None
        waiting.extend(reversed(branches))
    return solved


def _as_polynomials(
    equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]
) -> tuple[LoopEquations | None, dict[sp.Symbol, sp.Expr]]:
    """Return the equations as polynomials, and the unknowns in the lengths and angles of these."""
    inside = {a for e in equations for f in e.atoms(sp.sin, sp.cos, sp.tan) for a in f.free_symbols}
    turning = [x for x in unknowns if x in inside]
    lengths = tuple(x for x in unknowns if x not in inside)
    parts, turned = _directions(equations, turning)
    if parts is None:
        return None, {}
    angles = {phi: _circle(k) for k, phi in enumerate(parts)}
    given: dict[sp.Expr, tuple[sp.Symbol, sp.Symbol]] = {}
    rows = []
    for equation in equations:
        row = equation.subs(turned, simultaneous=True) if turned else equation
        row = sp.expand_trig(sp.expand(row.rewrite(sp.cos) if row.has(sp.tan) else row))
        for phi, (c, s) in angles.items():
            row = row.subs({sp.cos(phi): c, sp.sin(phi): s})
        for argument in {f.args[0] for f in row.atoms(sp.sin, sp.cos)} - set(given):
            if not argument.free_symbols & set(angles):
                given[argument] = _circle(len(angles) + len(given))
        for argument, (c, s) in given.items():
            row = row.subs({sp.cos(argument): c, sp.sin(argument): s})
        row = sp.expand(row)
        if row.free_symbols & set(angles) or not row.is_polynomial(*lengths, *sum(angles.values(), ())):
            return None, {}
        rows.append(row)
    return LoopEquations(tuple(rows), lengths, angles, given), turned


def _circle(k: int) -> tuple[sp.Symbol, sp.Symbol]:
    """Return symbols for a cosine and a sine."""
    return sp.Dummy(f"c{k}", real=True), sp.Dummy(f"s{k}", real=True)


def _directions(
    equations: Sequence[sp.Expr], turning: Sequence[sp.Symbol]
) -> tuple[list[sp.Symbol] | None, dict[sp.Symbol, sp.Expr]]:
    """Return symbols for the angles of links, and the unknown angles in these: the differences of links'.

    With angles from link to link the equations hold sums of them; where these are as many as the angles, they
    are the better unknowns.
    """
    combined: list[sp.Expr] = []
    for equation in equations:
        for function in sorted(equation.atoms(sp.sin, sp.cos, sp.tan), key=sp.default_sort_key):
            argument = sp.expand(function.args[0])
            part = sum((argument.coeff(x) * x for x in turning), sp.S.Zero)
            if (argument - part).free_symbols & set(turning):
                return None, {}
            if part != 0 and part not in combined and -part not in combined:
                combined.append(part)
    if all(part.is_Symbol for part in combined) or len(combined) != len(turning):
        return list(turning), {}
    matrix = sp.Matrix([[part.coeff(x) for x in turning] for part in combined])
    if not all(entry.is_Integer for entry in matrix) or abs(matrix.det()) != 1:
        return list(turning), {}
    parts = [sp.Dummy(f"phi{k}", real=True) for k in range(len(combined))]
    return parts, dict(zip(turning, matrix.inv() * sp.Matrix(parts), strict=True))


def _simplify_rows(loop: LoopEquations) -> tuple[sp.Expr, ...]:
    """Return the equations without zeros and denominators, with ``s^2`` as ``1 - c^2``."""
    # What is known may stand below a line, as in y = x tan(beta): it is taken not to vanish.
    tops = [sp.fraction(sp.together(equation))[0] for equation in loop.equations]
    rows = [_on_circles(loop, top) for top in tops]
    return tuple(row for row in rows if row != 0)


def _step(loop: LoopEquations) -> list[LoopEquations] | None:
    """Return the loop with one unknown less, once for each of its values; None where no rule fits."""
    for rule in (_one_length, _cosine_and_sine, _one_angle, _square_length):
        for branches in rule(loop):
            return branches
    return None


def _one_length(loop: LoopEquations) -> Iterator[list[LoopEquations]]:
    """Solve for a length that stands linearly beside nothing unknown."""
    for k, row in enumerate(loop.equations):
        for x in loop.lengths:
            if sp.degree(row, x) == 1 and not row.coeff(x, 1).free_symbols & loop.unknowns:
                value = -row.coeff(x, 0) / row.coeff(x, 1)
                yield [_drop_rows(loop, (k,), {x: value}, ((x, value),))]


def _square_length(loop: LoopEquations) -> Iterator[list[LoopEquations]]:
    """Solve a quadratic equation in one length alone."""
    for k, row in enumerate(loop.equations):
        for x in loop.lengths:
            if row.free_symbols & loop.unknowns == {x} and sp.degree(row, x) == 2:
                a, b, c = (row.coeff(x, power) for power in (2, 1, 0))
                root = sp.sqrt(sp.expand(b**2 / 4 - a * c))
                values = [(-b / 2 + root) / a, (-b / 2 - root) / a]
                yield [_drop_rows(loop, (k,), {x: value}, ((x, value),)) for value in values]


def _cosine_and_sine(loop: LoopEquations) -> Iterator[list[LoopEquations]]:
    """Take cosine and sine of one angle from two equations; their squares give an equation for the rest."""
    for phi, (c, s) in loop.angles.items():
        rows = [k for k, row in enumerate(loop.equations) if _is_linear(row, c, s)]
        for i, j in combinations(rows, 2):
            first, second = loop.equations[i], loop.equations[j]
            (a1, b1, r1), (a2, b2, r2) = _parts(first, c, s), _parts(second, c, s)
            det = _on_circles(loop, a1 * b2 - a2 * b1)
            others = [row for k, row in enumerate(loop.equations) if k not in (i, j)]
            open_ = det.free_symbols & loop.unknowns
            if det == 0 or not open_ <= set(loop.lengths) or (open_ and any(row.has(c, s) for row in others)):
                continue
            above, beside = sp.expand(b1 * r2 - b2 * r1), sp.expand(a2 * r1 - a1 * r2)
            squares = _on_circles(loop, above**2 + beside**2) / _on_circles(loop, det**2)
            top, bottom = sp.fraction(sp.cancel(squares))
            circle = sp.expand(top - bottom)
            cosine, sine = sp.cancel(above / det), sp.cancel(beside / det)
            solved = ((phi, sp.atan2(sine, cosine)),)
            yield [_drop_rows(loop, (i, j), {c: cosine, s: sine}, solved, (circle,), phi)]


def _one_angle(loop: LoopEquations) -> Iterator[list[LoopEquations]]:
    """Solve ``A cos + B sin + C = 0`` for an angle."""
    for k, row in enumerate(loop.equations):
        for phi, (c, s) in loop.angles.items():
            if not row.free_symbols & loop.unknowns <= {c, s} or not _is_linear(row, c, s):
                continue
            a, b, rest = _parts(row, c, s)
            values = _solve_angle(a, b, rest, _on_circles(loop, a**2 + b**2))
            yield [
                _drop_rows(loop, (k,), {c: cosine, s: sine}, ((phi, value),), (), phi)
                for value, cosine, sine in values
            ]


def _solve_angle(
    a: sp.Expr, b: sp.Expr, constant: sp.Expr, square: sp.Expr
) -> list[tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Return both angles of ``a cos + b sin + constant = 0`` with cosine and sine; `square` is a^2 + b^2."""
    if a == 0:
        angle = sp.asin(sp.cancel(-constant / b))
        return [(angle, sp.cos(angle), sp.sin(angle)), (sp.pi - angle, -sp.cos(angle), sp.sin(angle))]
    if b == 0:
        angle = sp.acos(sp.cancel(-constant / a))
        return [(angle, sp.cos(angle), sp.sin(angle)), (-angle, sp.cos(angle), -sp.sin(angle))]
    if constant == 0:
        values = [sp.atan2(-a, b), sp.atan2(a, -b)]
    else:
        turn = sp.acos(-constant / sp.sqrt(square))
        values = [sp.atan2(b, a) + turn, sp.atan2(b, a) - turn]
    return [(value, sp.cos(value), sp.sin(value)) for value in values]


def _on_circles(loop: LoopEquations, row: sp.Expr) -> sp.Expr:
    """Return an expression with ``s^2`` as ``1 - c^2``."""
    row = sp.expand(row)
    for c, s in (*loop.angles.values(), *loop.given.values()):
        row = sp.expand(sp.rem(row, s**2 + c**2 - 1, s)) if row.has(s) and sp.degree(row, s) > 1 else row
    return row


def _drop_rows(
    loop: LoopEquations,
    rows: Sequence[int],
    values: Mapping[sp.Symbol, sp.Expr],
    solved: tuple[tuple[sp.Symbol, sp.Expr], ...],
    more: Sequence[sp.Expr] = (),
    angle: sp.Symbol | None = None,
) -> LoopEquations:
    """Return the loop without some rows and an unknown, which has its value in the others.

    The value of an angle is written out in what is left to solve only as far as it is needed there; the
    symbols of its cosine and sine stay in what is solved.
    """
    kept = [row for k, row in enumerate(loop.equations) if k not in rows]
    named = dict(values)
    later: tuple[tuple[sp.Symbol, sp.Expr], ...] = solved
    return LoopEquations(
        tuple(row.xreplace(named) for row in (*kept, *more)),
        tuple(x for x in loop.lengths if x not in values),
        {phi: pair for phi, pair in loop.angles.items() if phi is not angle},
        loop.given,
        (*((x, value) for x, value in values.items() if x not in dict(solved)), *later, *loop.solved),
    )


def _is_linear(row: sp.Expr, c: sp.Symbol, s: sp.Symbol) -> bool:
    return bool(row.has(c) or row.has(s)) and sp.Poly(row, c, s).total_degree() == 1


def _parts(row: sp.Expr, c: sp.Symbol, s: sp.Symbol) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return A, B and C of ``A c + B s + C``."""
    a, b = row.coeff(c, 1), row.coeff(s, 1)
    return a, b, sp.expand(row - a * c - b * s)


def _back(loop: LoopEquations, turned: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    """Return every unknown in what is known, from the last that was solved to the first."""
    known: dict[sp.Symbol, sp.Expr] = {}
    for angle, (c, s) in loop.given.items():
        known |= {c: sp.cos(angle), s: sp.sin(angle)}
    for symbol, value in loop.solved:
        known[symbol] = value.xreplace(known)
    return known | {angle: value.xreplace(known) for angle, value in turned.items()}
