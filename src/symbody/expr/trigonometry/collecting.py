"""Sums of products written shorter: common factors pulled out, sums that recur given a place of their own.

A factor is pulled out of those terms that hold it to the same power, so ``a**2 + 2*a*b*c + b**2`` stays as
it is in every book. A sum that stands in the formula already, or turns up as a cofactor, is tried as a
variable: with ``k = a + b`` the terms of ``(a + b)**2 + (a + b)*c`` become three. Both only where the
operations written out become fewer.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from symbody.expr.canonical import ONE, ZERO, add, mul, power
from symbody.expr.graph import Exact, Graph
from symbody.expr.trigonometry.polynomial import (
    Monomial,
    Polynomial,
    content,
    cost,
    divide,
    quotient,
    replace_sum,
    size,
    term_cost,
)

# Nobody reads sums longer than these (in factors, in terms), and the search grows with their square.
_MAX_SIZE_PULLED: Final = 3000
_MAX_TERMS_REPLACED: Final = 60
_MAX_KERNELS: Final = 12


def collect(
    graph: Graph, polynomial: Polynomial, nodes: dict[int, int], weights: dict[int, int],
    kernels: Sequence[Polynomial] = (),
) -> int:  # fmt: skip
    """Return the node of a polynomial, written with few operations.

    Parameters
    ----------
    nodes, weights : node of each variable, and its operations written out
    kernels : sums that are worth trying as variables
    """
    return _Collector(graph, dict(nodes), dict(weights), kernels).node(polynomial)


class _Collector:
    """Definitions of new variables, each a polynomial in variables of fewer operations than itself."""

    def __init__(
        self, graph: Graph, nodes: dict[int, int], weights: dict[int, int], kernels: Sequence[Polynomial]
    ) -> None:
        self._graph = graph
        self._nodes = nodes
        self._first = max(nodes, default=0) + 1
        self._weights = weights
        self._kernels = [kernel for kernel in kernels if 1 < len(kernel) <= _MAX_TERMS_REPLACED]
        self._definitions: dict[int, Polynomial] = {}
        self._known: dict[frozenset[tuple[Monomial, Exact]], int] = {}

    def node(self, polynomial: Polynomial) -> int:
        top = self._define(polynomial)
        finished: dict[int, Polynomial] = {}
        pending = [top]
        while pending:
            name = pending.pop()
            if name in self._definitions and name not in finished:
                finished[name] = self._shorten(self._definitions[name])
                pending.extend(factor for monomial in finished[name] for factor, _ in monomial)
        for name in sorted(finished, key=lambda name: (self._weights[name], name)):
            self._nodes[name] = self._build_sum(finished[name])
        return self._nodes[top]

    def _define(self, p: Polynomial) -> int:
        """Return the variable that stands for `p`."""
        key = frozenset(p.items())
        if key not in self._known:
            name = self._first + len(self._definitions)
            self._known[key] = name
            self._definitions[name] = p
            self._weights[name] = self._cost(p)
        return self._known[key]

    def _cost(self, p: Polynomial) -> int:
        return cost(p, self._weights.__getitem__)

    def _shorten(self, p: Polynomial) -> Polynomial:
        best = self._pull_factors(p)
        while len(p) <= _MAX_TERMS_REPLACED:
            tried = [
                (self._pull_factors(changed), changed)
                for kernel in self._candidates(best)
                if (changed := replace_sum(p, kernel, self._define(kernel))) is not None
            ]
            pulled, p = min(tried, key=lambda pair: self._cost(pair[0]), default=(best, p))
            if self._cost(pulled) >= self._cost(best):
                break
            best = pulled
        return best

    def _candidates(self, p: Polynomial) -> list[Polynomial]:
        """Return the sums to try: those of the formula, then cofactors found in `p`."""
        found = [
            self._definitions[name] for monomial in p for name, _ in monomial if name in self._definitions
        ]
        return [*self._kernels, *(q for q in found if len(q) <= _MAX_TERMS_REPLACED)][:_MAX_KERNELS]

    def _pull_factors(self, p: Polynomial) -> Polynomial:
        """Pull out factors, the one that saves most first, as long as one saves anything."""
        if len(p) < 2 or size(p) > _MAX_SIZE_PULLED:
            return p
        whole = (content(p), _common_factor(p, list(p))[1])
        if self._operations_saved(p, list(p), whole) > 0:
            return self._pull_out(p, list(p), whole)
        while (group := self._best_group(p)) is not None:
            p = self._pull_out(p, *group)
        return p

    def _pull_out(self, p: Polynomial, members: list[Monomial], factor: tuple[Monomial, Exact]) -> Polynomial:
        """Return `p` with the `factor` pulled out of `members`."""
        gone = set(members)
        inner = self._define({quotient(m, factor[0]): divide(p[m], factor[1]) for m in members})
        rest = {monomial: c for monomial, c in p.items() if monomial not in gone}
        return {**rest, tuple(sorted([*factor[0], (inner, 1)])): factor[1]}

    def _best_group(self, p: Polynomial) -> tuple[list[Monomial], tuple[Monomial, Exact]] | None:
        """Return the terms, and their factor (monomial, coefficient), that save most operations."""
        groups: dict[tuple[int, int], list[Monomial]] = {}
        for monomial in p:
            for factor in monomial:
                groups.setdefault(factor, []).append(monomial)
        best, most = None, 0
        for members in groups.values():
            if len(members) > 1:
                shared = _common_factor(p, members)
                saved = self._operations_saved_by_powers(p, members, shared)
                if saved > most:
                    best, most = (members, shared), saved
        return best

    def _operations_saved_by_powers(
        self, p: Polynomial, members: list[Monomial], factor: tuple[Monomial, Exact]
    ) -> int:
        """Return `_operations_saved` for a factor whose powers are those of the members.

        Each power then leaves a term whole, with its multiplication; a term of nothing else becomes a number,
        which costs nothing.
        """
        powers, size = factor
        weights = self._weights.__getitem__
        each = term_cost(powers, 1, weights) + 1
        saved = 0
        for monomial in members:
            if len(monomial) == len(powers):
                saved += each - 1 + (abs(p[monomial]) != 1)
            else:
                saved += each + (size != 1)
        return saved - term_cost(powers, size, weights) - 1

    def _operations_saved(
        self, p: Polynomial, members: list[Monomial], factor: tuple[Monomial, Exact]
    ) -> int:
        weights = self._weights.__getitem__
        before = sum(term_cost(m, p[m], weights) for m in members)
        after = sum(term_cost(quotient(m, factor[0]), divide(p[m], factor[1]), weights) for m in members)
        return before - after - term_cost(*factor, weights) - 1

    def _build_sum(self, p: Polynomial) -> int:
        """Return the node of `p` as it stands, in an order that depends on structure alone."""
        graph, total = self._graph, ZERO
        terms = [self._term(monomial, coefficient) for monomial, coefficient in p.items()]
        for term in sorted(terms, key=graph.hashes.__getitem__):
            total = add(graph, total, term)
        return total

    def _term(self, monomial: Monomial, coefficient: Exact) -> int:
        graph, result = self._graph, ONE
        factors = [power(graph, self._nodes[k], graph.constant(e)) for k, e in monomial]
        for factor in sorted(factors, key=graph.hashes.__getitem__):
            result = mul(graph, result, factor)
        return mul(graph, graph.constant(coefficient), result)


def _common_factor(p: Polynomial, members: list[Monomial]) -> tuple[Monomial, Exact]:
    """Return the common factor of all `members`, and their coefficient if it is the same up to sign."""
    factors = set(members[0]).intersection(*members[1:])
    first = p[members[0]]
    size = max(first, -first)
    same = all((c := p[monomial]) == size or c == -size for monomial in members)
    return tuple(sorted(factors)), size if same else 1
