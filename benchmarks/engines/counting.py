"""Operations of expressions that SymPy or SymEngine hold, counted as symbody counts its own."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from symbody.expr.rewrite import multiplications

Tree = Any  # an expression with .args, of either package

_SUM: Final = "Add"
_PRODUCT: Final = "Mul"
_POWER: Final = "Pow"


def count_operations(trees: Iterable[Tree]) -> int:
    """Return the operations of `trees`, written out: + - * / and functions 1, signs 0, powers by squaring."""
    total = 0
    stack = list(trees)
    while stack:
        tree = stack.pop()
        total += _own(tree)
        stack.extend(tree.args)
    return total


def _own(tree: Tree) -> int:
    kind, operands = type(tree).__name__, tree.args
    if not operands:
        return 0
    if kind == _SUM:
        return len(operands) - 1
    if kind == _PRODUCT:
        # a factor -1 is a sign; a factor 1/x divides instead of multiplying, which costs the same,
        # and is counted as a power already
        factors = [x for x in operands if x != -1]
        return len(factors) - 1 - min(sum(map(_is_reciprocal, factors)), len(factors) - 1)
    if kind == _POWER:
        return _power(operands[1])
    return 1


def _is_reciprocal(tree: Tree) -> bool:
    return type(tree).__name__ == _POWER and tree.args[1] == -1


def _power(exponent: Tree) -> int:
    if not exponent.is_Integer or exponent == 0:
        return 1
    whole = abs(int(exponent))
    return multiplications(whole) + (1 if int(exponent) < 0 else 0)
