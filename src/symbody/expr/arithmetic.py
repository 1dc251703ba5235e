"""Sums, products, quotients and whole powers in canonical form; see `canonical` for the rules."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

from symbody.errors import ExpressionError, Problem
from symbody.expr.constants import fold_power, fold_product, fold_quotient, fold_sum
from symbody.expr.graph import Constant, Graph
from symbody.expr.opcodes import ADD, DIV, FLOAT, MUL, NEG, POW, RATIONAL, SQRT, SUB

# Every graph begins with these three constants (Graph.__init__).
ZERO: Final = 0
ONE: Final = 1
TWO: Final = 2


def neg(g: Graph, a: int) -> int:
    """Return ``-a``."""
    if g.ops[a] == NEG:
        return g.left[a]
    return ZERO if a == ZERO else g.node(NEG, a)


def add(g: Graph, a: int, b: int) -> int:
    """Return ``a + b``."""
    ops = g.ops
    oa, ob = ops[a], ops[b]
    if oa <= NEG or ob <= NEG:
        return _add_special(g, a, b)
    if a == b:
        return mul(g, TWO, a)
    if (oa == MUL or ob == MUL) and (merged := _merge_terms(g, a, b, 1)) is not None:
        return merged
    hashes = g.hashes
    return g.node(ADD, a, b) if hashes[a] <= hashes[b] else g.node(ADD, b, a)


def sub(g: Graph, a: int, b: int) -> int:
    """Return ``a - b``; it shares its node with ``b - a`` up to sign."""
    ops = g.ops
    oa, ob = ops[a], ops[b]
    if oa <= NEG or ob <= NEG:
        return add(g, a, neg(g, b))
    if a == b:
        return ZERO
    if (oa == MUL or ob == MUL) and (merged := _merge_terms(g, a, b, -1)) is not None:
        return merged
    hashes = g.hashes
    if hashes[a] <= hashes[b]:
        return g.node(SUB, a, b)
    return g.node(NEG, g.node(SUB, b, a))


def mul(g: Graph, a: int, b: int) -> int:
    """Return ``a * b``."""
    ops = g.ops
    oa, ob = ops[a], ops[b]
    if oa <= POW or ob <= POW:
        return _mul_special(g, a, b)
    if a == b:
        return g.left[a] if oa == SQRT else g.node(POW, a, TWO)
    hashes = g.hashes
    return g.node(MUL, a, b) if hashes[a] <= hashes[b] else g.node(MUL, b, a)


def div(g: Graph, a: int, b: int) -> int:
    """Return ``a / b``.

    Raises
    ------
    ExpressionError
        If `b` is the constant zero.
    """
    ops = g.ops
    if ops[b] == NEG:
        return neg(g, div(g, a, g.left[b]))
    if ops[a] == NEG:
        return neg(g, div(g, g.left[a], b))
    divisor = g.number(b)
    if divisor is not None:
        if divisor == 0:
            raise ExpressionError(
                Problem("expression.division_by_zero", "", "an expression is divided by the constant 0",
                        "a divisor is zero, or identically zero", "remove the division")
            )  # fmt: skip
        dividend = g.number(a)
        if dividend is not None and (folded := fold_quotient(dividend, divisor)) is not None:
            return g.constant(folded)
        if ops[b] == RATIONAL:
            return mul(g, g.constant(1 / Fraction(divisor)), a)
    return ZERO if a == ZERO else g.node(DIV, a, b)


def integer_power(g: Graph, a: int, n: int) -> int:
    """Return ``a ** n``."""
    if n == 0:
        return ONE
    if n < 0:
        return div(g, ONE, integer_power(g, a, -n))
    base = g.number(a)
    if base is not None and (folded := fold_power(base, n)) is not None:
        return g.constant(folded)
    if g.ops[a] == NEG:
        result = integer_power(g, g.left[a], n)
        return neg(g, result) if n % 2 else result
    if n == 1:
        return a
    if g.ops[a] == SQRT:
        result = integer_power(g, g.left[a], n // 2)
        return mul(g, result, a) if n % 2 else result
    x, m = _base(g, a)
    return g.node(POW, x, g.constant(n * m))


def _add_special(g: Graph, a: int, b: int) -> int:
    """Return a sum of which a term is constant or carries a sign."""
    if a == ZERO or b == ZERO:
        return b if a == ZERO else a
    ops, left = g.ops, g.left
    x, y = g.number(a), g.number(b)
    if x is not None and y is not None and (total := fold_sum(x, y)) is not None:
        return g.constant(total)
    negative_a, negative_b = ops[a] == NEG, ops[b] == NEG
    if negative_a and negative_b:
        return neg(g, add(g, left[a], left[b]))
    if negative_a:
        return sub(g, b, left[a]) if ops[b] > FLOAT else neg(g, _constant_minus(g, left[a], b))
    if negative_b:
        return (
            sub(g, a, left[b]) if ops[left[b]] > FLOAT and ops[a] > FLOAT else _constant_minus(g, a, left[b])
        )
    if y is not None:
        a, b = b, a
    return _add_constant(g, a, b)


def _add_constant(g: Graph, c: int, x: int) -> int:
    """Return ``c + x`` for a positive constant, merged with an exact constant already in `x`."""
    if g.ops[x] in (ADD, SUB) and g.ops[c] == RATIONAL and g.ops[g.left[x]] == RATIONAL:
        total = fold_sum(_value(g, c), _value(g, g.left[x]))
        if total is not None:
            rest = g.right[x]
            return add(g, g.constant(total), rest) if g.ops[x] == ADD else sub(g, g.constant(total), rest)
    return g.node(ADD, c, x)


def _constant_minus(g: Graph, a: int, b: int) -> int:
    """Return ``a - b`` where one of the two, both unsigned, is a constant."""
    if g.ops[a] > FLOAT:
        return neg(g, _constant_minus(g, b, a))
    if g.ops[a] == RATIONAL and g.ops[b] in (ADD, SUB) and g.ops[g.left[b]] == RATIONAL:
        total = fold_sum(_value(g, a), -_value(g, g.left[b]))
        if total is not None:
            rest = g.right[b]
            return sub(g, g.constant(total), rest) if g.ops[b] == ADD else add(g, g.constant(total), rest)
    return g.node(SUB, a, b)


def _merge_terms(g: Graph, a: int, b: int, sign: int) -> int | None:
    """Return ``a + sign * b`` if the two differ by an exact factor only."""
    (p, x), (q, y) = _coefficient(g, a), _coefficient(g, b)
    if x != y:
        return None
    total = fold_sum(p, sign * q)
    return None if total is None else mul(g, g.constant(total), x)


def _coefficient(g: Graph, a: int) -> tuple[Constant, int]:
    """Split a product into exact factor and rest."""
    if g.ops[a] == MUL and g.ops[g.left[a]] == RATIONAL:
        return _value(g, g.left[a]), g.right[a]
    return 1, a


def _mul_special(g: Graph, a: int, b: int) -> int:
    """Return a product of which a factor is constant, signed or a power."""
    ops, left = g.ops, g.left
    if a == ZERO or b == ZERO:
        return ZERO
    if ops[a] == NEG:
        return mul(g, left[a], left[b]) if ops[b] == NEG else neg(g, mul(g, left[a], b))
    if ops[b] == NEG:
        return neg(g, mul(g, a, left[b]))
    if ops[a] <= FLOAT or ops[b] <= FLOAT:
        return _scale(g, a, b) if ops[a] <= FLOAT else _scale(g, b, a)
    (x, n), (y, m) = _base(g, a), _base(g, b)
    if x == y:
        return integer_power(g, x, n + m)
    return g.node(MUL, a, b) if g.hashes[a] <= g.hashes[b] else g.node(MUL, b, a)


def _scale(g: Graph, c: int, x: int) -> int:
    """Return ``c * x`` for a positive constant `c`."""
    if c == ONE or x == ONE:
        return x if c == ONE else c
    factor = _value(g, c)
    other = g.number(x)
    if other is not None and (folded := fold_product(factor, other)) is not None:
        return g.constant(folded)
    if g.ops[c] == RATIONAL and g.ops[x] == MUL and g.ops[g.left[x]] == RATIONAL:
        folded = fold_product(factor, _value(g, g.left[x]))
        if folded is not None:
            return mul(g, g.constant(folded), g.right[x])
    return g.node(MUL, c, x)


def _base(g: Graph, a: int) -> tuple[int, int]:
    """Split into base and whole exponent."""
    if g.ops[a] == POW and g.ops[g.right[a]] == RATIONAL:
        exponent = _value(g, g.right[a])
        if isinstance(exponent, int):
            return g.left[a], exponent
    return a, 1


def _value(g: Graph, node: int) -> Constant:
    return g.constants[g.left[node]]
