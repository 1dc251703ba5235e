"""The trigonometric normal form: formulas as a textbook prints them, without a simplifier.

A root is written as a polynomial in the sines and cosines of independent angles and in everything else
that is not a sum, product or whole power (symbols, quotients, roots, other functions). With
sin**2 + cos**2 = 1 equal polynomials become the same. The coefficient of each product of the
others is then written in the shortest of the forms of `harmonics`, and the sum collected by `collecting`.
Arguments of functions, numerators and denominators are treated in the same way, each by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Final

from symbody.expr.canonical import apply, make
from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, COS, DIV, FLOAT, MUL, NEG, POW, RATIONAL, SIN, SUB
from symbody.expr.rewrite import node_cost, operation_count, tree_size
from symbody.expr.trigonometry.angles import AngleForm, Angles
from symbody.expr.trigonometry.collecting import collect
from symbody.expr.trigonometry.harmonics import Harmonics, reduce_sines, sine
from symbody.expr.trigonometry.polynomial import (
    UNIT,
    Polynomial,
    coefficients,
    names_of,
    plus,
    product,
    size,
    sum_without_noise,
    times,
    variable,
    with_unit_norm,
    without_noise,
)

_MAX_OPERATIONS: Final = 2000
_MAX_SIZE: Final = 10_000  # factors of all terms of a polynomial
_MAX_EFFORT: Final = 400_000  # factors multiplied for one root: about a second
_MAX_WRITTEN: Final = 20_000  # factors of all parts of one root that are written by themselves
_MAX_EXPONENT: Final = 16  # of what is multiplied out
_MAX_KERNEL: Final = 6  # terms of a sum that is tried as a variable

_EXPANDED: Final = frozenset({RATIONAL, NEG, ADD, SUB, MUL})


def trigonometric_form(
    graph: Graph, roots: Sequence[int], quaternions: Sequence[tuple[int, ...]] = (), noise: float = 0.0
) -> list[int]:
    """Return the `roots` written as in a textbook, each by itself, where that takes fewer operations.

    The difference of equal polynomials in sines, cosines and symbols is written as 0 if it is within the
    limits: angles of at most 16 basis angles, k1 of one, k2 of another... with (k1 + 1)(k2 + 1)... <= 256,
    exponents up to 16, polynomials of 10,000 factors, and 400,000 factors multiplied on the way. Other
    polynomials get the shortest form that a limited search finds.

    Roots of 2,000 operations or more, with rounded constants, or with too many terms stay as they are.

    Parameters
    ----------
    quaternions : sequence of four nodes
        Symbols whose squares add up to 1; with it, too, equal polynomials become the same.
    noise : float
        Terms of sums that are smaller beside the largest one are left out: what products of rounded constants
        leave of terms that cancel.
    """
    return [_form(graph, root, quaternions, noise) for root in roots]


def _form(graph: Graph, root: int, quaternions: Sequence[tuple[int, ...]], noise: float) -> int:
    nodes = graph.reachable([root])
    if operation_count(graph, [root]) >= _MAX_OPERATIONS or any(graph.ops[k] == FLOAT for k in nodes):
        return root
    form = _PolynomialWriter(graph, _sort_by_structure(graph, nodes), root, quaternions, noise).form
    return form if tree_size(graph, form) < tree_size(graph, root) else root


def _sort_by_structure(graph: Graph, nodes: Sequence[int]) -> list[int]:
    """Return the nodes, operands first, in an order that does not depend on when they were made."""
    depth: dict[int, int] = {}
    for node in nodes:
        depth[node] = 1 + max([depth[k] for k in graph.operands(node)], default=0)
    return sorted(nodes, key=lambda node: (depth[node], graph.hashes[node]))


class _PolynomialWriter:
    """One pass over the nodes of a root, operands first."""

    def __init__(
        self,
        graph: Graph,
        nodes: Sequence[int],
        root: int,
        quaternions: Sequence[tuple[int, ...]],
        noise: float,
    ) -> None:
        self._graph = graph
        self._angles = Angles(graph, nodes)
        self._harmonics = Harmonics(self._angles.size, self._angles.cost)
        self._atoms: list[int] = []  # node of each variable
        self._variables: dict[int, int] = {}  # the inverse
        self._new: dict[int, int] = {}  # what each node has become
        self._polynomials: dict[int, Polynomial | None] = {}  # None: too many terms
        self._kernels: list[Polynomial] = []
        self._noise = noise
        # Variables of each quaternion in the root.
        self._norms = [tuple(self._name(node) for node in four) for four in quaternions if four[0] in nodes]
        self._sizes: dict[int, int] = {}
        self._effort = 0
        self._written_size = 0
        parts = self._written_by_themselves(nodes)
        for node in nodes:
            plain = self._new[node] = self._plain(node)
            p = self._polynomials[node] = self._polynomial(node, plain)
            if p is None:
                continue
            if graph.ops[node] in (ADD, SUB) and 1 < len(p) <= _MAX_KERNEL:
                self._kernels.append(self._shorten(p))
            if node == root or (node in parts and self._is_affordable(p)):
                self._new[node] = self._write_polynomial(p, plain)
        self.form = self._new[root]

    def _written_by_themselves(self, nodes: Sequence[int]) -> set[int]:
        """Return the symbols in which angles are linear, and all operands but those of sums.

        Factors of a product are among them because it may be best not to multiply out.
        """
        result = set(self._angles.axes)
        for node in nodes:
            if self._graph.ops[node] not in (ADD, SUB, NEG):
                result.update(self._graph.operands(node))
        return result

    def _is_affordable(self, p: Polynomial) -> bool:
        self._written_size += size(p)
        return self._written_size <= _MAX_WRITTEN

    def _is_expanded(self, node: int) -> bool:
        return self._graph.ops[node] in _EXPANDED or self._whole_exponent(node) > 0

    def _whole_exponent(self, node: int) -> int:
        """Return the exponent of a power that may be multiplied out, else 0."""
        exponent = self._graph.number(self._graph.right[node]) if self._graph.ops[node] == POW else None
        return exponent if isinstance(exponent, int) and exponent <= _MAX_EXPONENT else 0

    def _plain(self, node: int) -> int:
        """Return `node` over what its operands have become."""
        graph = self._graph
        old = graph.operands(node)
        new = tuple([self._new[k] for k in old])
        if new == old or (graph.ops[node] == DIV and graph.number(new[1]) == 0):
            return node
        return make(graph, graph.ops[node], new, graph.datum(node))

    def _polynomial(self, node: int, plain: int) -> Polynomial | None:
        graph = self._graph
        if graph.ops[node] in (SIN, COS) and (angle := self._angles.angle_of(graph.left[node])) is not None:
            return self._circular(graph.ops[node], angle)
        if not self._is_expanded(node):
            return self._atom(plain)
        if graph.ops[node] == RATIONAL:
            return self._constant(node, 1)
        operands = [self._polynomials[k] for k in graph.operands(node)]
        known = [p for p in operands if p is not None]
        p = self._combine(node, known) if len(known) == len(operands) else None
        return p if p is not None and size(p) <= _MAX_SIZE else None

    def _combine(self, node: int, operands: list[Polynomial]) -> Polynomial | None:
        op = self._graph.ops[node]
        if op == POW:
            return self._power(operands[0], self._whole_exponent(node))
        if op == MUL:
            return self._product(*operands)
        if op == NEG:
            return plus({}, operands[0], -1)
        return sum_without_noise(operands[0], operands[1], -1 if op == SUB else 1, self._noise)

    def _power(self, p: Polynomial, exponent: int) -> Polynomial | None:
        result: Polynomial | None = p
        for _ in range(exponent - 1):
            result = None if result is None else self._product(result, p)
        return result

    def _product(self, p: Polynomial, q: Polynomial) -> Polynomial | None:
        self._effort += size(p) * len(q) + size(q) * len(p)
        if self._effort > _MAX_EFFORT:
            return None
        result = reduce_sines(times(p, q))
        for names in self._norms:
            result = with_unit_norm(result, names)
        return result

    def _circular(self, op: int, angle: AngleForm) -> Polynomial:
        """Return a sine or cosine by the addition formulas."""
        cosine: Polynomial = {UNIT: 1}
        sine_of: Polynomial = {}
        for i, count in enumerate(angle.components):
            s, c = variable(sine(i)), variable(sine(i) - 1)
            s = s if count > 0 else plus({}, s, -1)
            for _ in range(abs(count)):
                cosine, sine_of = (
                    reduce_sines(plus(times(cosine, c), times(sine_of, s), -1)),
                    reduce_sines(plus(times(sine_of, c), times(cosine, s))),
                )
        for _ in range(angle.quarter_turns % 4):
            cosine, sine_of = plus({}, sine_of, -1), cosine
        return cosine if op == COS else sine_of

    def _atom(self, node: int) -> Polynomial:
        graph = self._graph
        sign = 1
        if graph.ops[node] == NEG:
            node, sign = graph.left[node], -1
        if graph.ops[node] == RATIONAL:
            return self._constant(node, sign)
        return plus({}, variable(self._name(node)), sign)

    def _name(self, atom: int) -> int:
        """Return the variable that stands for a node."""
        if atom not in self._variables:
            self._variables[atom] = len(self._atoms)
            self._atoms.append(atom)
        return self._variables[atom]

    def _constant(self, node: int, sign: int) -> Polynomial:
        value = Fraction(self._graph.constants[self._graph.left[node]]) * sign
        exact = value.numerator if value.denominator == 1 else value  # whole numbers are much faster
        return {UNIT: exact} if exact else {}

    def _shorten(self, p: Polynomial) -> Polynomial:
        """Return `p` with the trigonometric part of each coefficient written in its shortest form."""
        result: Polynomial = {}
        for outer, inner in coefficients(p, lambda name: name < 0).items():
            for monomial, coefficient in self._harmonics.shortest(inner).items():
                result[product(monomial, outer)] = coefficient
        return result

    def _write_polynomial(self, p: Polynomial, plain: int) -> int:
        graph = self._graph
        short = without_noise(self._shorten(without_noise(p, self._noise)), self._noise)
        nodes = {name: self._node(name) for name in names_of(short)}
        weights = {name: self._size(node) for name, node in nodes.items()}
        kernels = [kernel for kernel in self._kernels if names_of(kernel) <= nodes.keys()]
        result = collect(graph, short, nodes, weights, kernels)
        return result if self._size(result) < self._size(plain) else plain

    def _size(self, root: int) -> int:
        """Return the operations of a node written out, in time proportional to what is new below it."""
        graph, sizes = self._graph, self._sizes
        stack = [root]
        while stack:
            node = stack[-1]
            missing = [k for k in graph.operands(node) if k not in sizes]
            stack.extend(missing)
            if not missing:
                sizes[node] = node_cost(graph, node) + sum(sizes[k] for k in graph.operands(node))
                stack.pop()
        return sizes[root]

    def _node(self, name: int) -> int:
        if name >= 0:
            return self._atoms[name]
        op, vector = self._harmonics.harmonic(name)
        return apply(self._graph, op, self._angles.node(vector, self._new))
