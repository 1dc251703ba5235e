"""Values of SymPy expressions in functions of time, at given and at random numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from random import Random

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.physics.vector import dynamicsymbols

t = dynamicsymbols._t
POINTS = 20


def value(expression: object, numbers: Mapping[object, float]) -> float:
    """The value of an expression; a derivative is replaced as a whole, not the function inside it."""
    return values([expression], numbers)[0]


def values(expressions: Iterable[object], numbers: Mapping[object, float]) -> list[float]:
    """The values of expressions at numbers."""
    dummies = {key: sp.Dummy() for key in numbers}
    plain = [sp.sympify(expression).xreplace(dummies) for expression in expressions]
    return list(sp.lambdify(list(dummies.values()), plain, "math")(*map(float, numbers.values())))


def variables(*expressions: object) -> list[sp.Basic]:
    """Functions of time, their derivatives and symbols in expressions, in order of their text."""
    found: set[sp.Basic] = set()
    for expression in map(sp.sympify, expressions):
        found |= expression.atoms(AppliedUndef, sp.Derivative, sp.Symbol) - {t}
        found |= {part.expr for part in expression.atoms(sp.Derivative)}
    return sorted(found, key=str)


def same(left: object, right: object, seed: int = 0) -> bool:
    """Whether two expressions are equal at random points; 1e-10 is 1e6 roundings of numbers near 1."""
    names = variables(left, right)
    dummies = {name: sp.Dummy() for name in names}
    both = sp.lambdify(
        list(dummies.values()), [sp.sympify(e).xreplace(dummies) for e in (left, right)], "math"
    )
    random = Random(seed)
    for _ in range(POINTS):
        a, b = both(*(random.uniform(0.3, 1.7) for _ in names))
        if abs(a - b) > 1e-10 * (1 + abs(a)):
            return False
    return True


def all_same(left: Iterable[object], right: Iterable[object]) -> bool:
    return all(same(a, b) for a, b in zip(left, right, strict=True))
