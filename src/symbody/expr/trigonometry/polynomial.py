"""Sparse polynomials with exact coefficients, for writing formulas in another way.

A variable is an integer, a monomial a tuple of (variable, exponent) in ascending order, a polynomial a
mapping of monomial to coefficient without zeros. They are dictionaries and not a class because nothing
holds them longer than one rewriting, and their insertion order is part of what makes it deterministic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Final

from symbody.expr.graph import Exact
from symbody.expr.language.literals import EXACT_DIGITS
from symbody.expr.rewrite import multiplications

Monomial = tuple[tuple[int, int], ...]
Polynomial = dict[Monomial, Exact]
Weights = Callable[[int], int]  # operations of each variable

UNIT: Final[Monomial] = ()
_LONG: Final = 10**EXACT_DIGITS  # such numerators have products of rounded constants


def variable(name: int) -> Polynomial:
    """Return the polynomial that is one variable."""
    return {((name, 1),): 1}


def plus(p: Polynomial, q: Mapping[Monomial, Exact], factor: Exact = 1) -> Polynomial:
    """Return ``p + factor q``."""
    result = dict(p)
    accumulate(result, q, factor)
    return result


def accumulate(p: Polynomial, q: Mapping[Monomial, Exact], factor: Exact = 1) -> None:
    """Add ``factor q`` to `p` in place."""
    for monomial, coefficient in q.items():
        total = p.get(monomial, 0) + factor * coefficient
        if total:
            p[monomial] = total
        else:
            del p[monomial]


def times(p: Polynomial, q: Polynomial) -> Polynomial:
    """Return ``p q``."""
    result: Polynomial = {}
    for a, x in p.items():
        for b, y in q.items():
            monomial = product(a, b)
            result[monomial] = result.get(monomial, 0) + x * y
    return {monomial: coefficient for monomial, coefficient in result.items() if coefficient}


def power(p: Polynomial, exponent: int) -> Polynomial:
    """Return ``p ** exponent`` for a small whole exponent."""
    result: Polynomial = {UNIT: 1}
    for _ in range(exponent):
        result = times(result, p)
    return result


def with_unit_norm(p: Polynomial, names: tuple[int, ...]) -> Polynomial:
    """Return `p` with the square of the first variable written as 1 less those of the others."""
    first, *others = names
    square: Polynomial = {UNIT: 1, **{((name, 2),): -1 for name in others}}
    result: Polynomial = {}
    for monomial, coefficient in p.items():
        exponent = dict(monomial).get(first, 0)
        if exponent < 2:
            accumulate(result, {monomial: coefficient})
            continue
        left = quotient(monomial, ((first, exponent - exponent % 2),))
        accumulate(result, times({left: coefficient}, power(square, exponent // 2)))
    return result


def without_noise(p: Polynomial, noise: float) -> Polynomial:
    """Return `p` without the terms that are smaller than `noise` of the largest; those of few digits stay."""
    if not noise or not p:
        return p
    sizes = {monomial: abs(Fraction(coefficient)) for monomial, coefficient in p.items()}
    least = Fraction(noise) * max(sizes.values())
    return {
        monomial: coefficient
        for monomial, coefficient in p.items()
        if sizes[monomial] >= least or sizes[monomial].numerator < _LONG
    }


def sum_without_noise(p: Polynomial, q: Polynomial, factor: Exact, noise: float) -> Polynomial:
    """Return ``p + factor q``; what is left of terms that cancel is dropped if it is below `noise` of them.

    Terms of few digits are exact, so that nothing of what they leave is dropped.
    """
    result = plus(p, q, factor)
    if noise:
        for monomial in p.keys() & q.keys() & result.keys():
            terms = abs(Fraction(p[monomial])), abs(Fraction(q[monomial]))
            is_rounded = max(term.numerator for term in terms) >= _LONG
            if is_rounded and abs(Fraction(result[monomial])) < Fraction(noise) * max(terms):
                del result[monomial]
    return result


def product(a: Monomial, b: Monomial) -> Monomial:
    """Return the product of two monomials."""
    if not a or not b:
        return a or b
    exponents = dict(a)
    for name, exponent in b:
        exponents[name] = exponents.get(name, 0) + exponent
    return tuple(sorted(exponents.items()))


def quotient(a: Monomial, b: Monomial) -> Monomial:
    """Return ``a / b`` of monomials where `b` divides `a`."""
    exponents = dict(a)
    for name, exponent in b:
        exponents[name] -= exponent
    return tuple([(name, exponent) for name, exponent in exponents.items() if exponent])


def divide(a: Exact, b: Exact) -> Exact:
    """Return ``a / b``, as an integer where it is one: arithmetic with those is much faster."""
    if b == 1:
        return a
    if isinstance(a, int) and isinstance(b, int):
        whole, rest = divmod(a, b)
        return Fraction(a, b) if rest else whole
    share = Fraction(a) / b
    return share.numerator if share.denominator == 1 else share


def multiplicity(a: Monomial, b: Monomial) -> int:
    """Return how often the monomial `b`, which is not 1, divides `a`."""
    exponents = dict(a)
    return min(exponents.get(name, 0) // exponent for name, exponent in b)


def content(monomials: Iterable[Monomial]) -> Monomial:
    """Return the largest monomial that divides all."""
    common: dict[int, int] | None = None
    for monomial in monomials:
        exponents = dict(monomial)
        if common is None:
            common = exponents
        else:
            common = {k: min(e, exponents[k]) for k, e in common.items() if k in exponents}
    return tuple((common or {}).items())


def size(p: Polynomial) -> int:
    """Return the number of factors of all terms, at least one each."""
    return sum(map(len, p)) + len(p)


def names_of(p: Polynomial) -> set[int]:
    """Return the variables of a polynomial."""
    return {name for monomial in p for name, _ in monomial}


def coefficients(p: Polynomial, chosen: Callable[[int], bool]) -> dict[Monomial, Polynomial]:
    """Write `p` as a polynomial in the other variables whose coefficients are in the `chosen` ones."""
    result: dict[Monomial, Polynomial] = {}
    for monomial, coefficient in p.items():
        inner = tuple([factor for factor in monomial if chosen(factor[0])])
        outer = tuple([factor for factor in monomial if not chosen(factor[0])])
        result.setdefault(outer, {})[inner] = coefficient
    return result


def replace_sum(p: Polynomial, kernel: Polynomial, name: int) -> Polynomial | None:
    """Write `p` with the variable `name` for the sum `kernel`, or None if `p` holds no multiple of it.

    Multiples are taken out only where all their terms are there, so no term is added to be subtracted.
    """
    result: Polynomial = {}
    factor: Monomial = UNIT
    rest, multiple = _divide(p, kernel)
    while multiple:  # a multiple may hold the kernel again
        result = plus(result, times(rest, {factor: 1}))
        factor = product(factor, ((name, 1),))
        rest, multiple = _divide(multiple, kernel)
    return plus(result, times(rest, {factor: 1})) if factor else None


def _divide(p: Polynomial, kernel: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Return a remainder and a multiplier of `kernel`; their terms have the signs that they have in `p`."""
    lead = max(kernel, key=_order)
    remainder = dict(p)
    multiplier: Polynomial = {}
    multiples = [monomial for monomial in p if multiplicity(monomial, lead)]  # mostly none
    for monomial in sorted(multiples, key=_order, reverse=True):
        if monomial in remainder:
            cofactor = quotient(monomial, lead)
            share = divide(remainder[monomial], kernel[lead])
            part: Polynomial = {product(cofactor, term): share * c for term, c in kernel.items()}
            if _contains(remainder, part):
                remainder = plus(remainder, part, -1)
                multiplier[cofactor] = share
    return remainder, multiplier


def _contains(p: Polynomial, part: Polynomial) -> bool:
    """Tell whether `p` has all terms of `part`, with the same signs and at least as large."""
    return all(term in p and (0 < c <= p[term] or p[term] <= c < 0) for term, c in part.items())


def _order(monomial: Monomial) -> tuple[int, Monomial]:
    return sum(exponent for _, exponent in monomial), monomial


def term_cost(monomial: Monomial, coefficient: Exact, weights: Weights) -> int:
    """Return the operations of one term; a sign is free."""
    if not monomial:
        return 0
    total = len(monomial) - 1 + (coefficient != 1 and coefficient != -1)
    for name, exponent in monomial:
        total += weights(name) + (multiplications(exponent) if exponent > 1 else 0)
    return total


def cost(p: Polynomial, weights: Weights) -> int:
    """Return the operations of the sum of all terms."""
    total = max(len(p) - 1, 0)
    for monomial, coefficient in p.items():
        total += term_cost(monomial, coefficient, weights)
    return total
