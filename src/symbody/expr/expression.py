"""`Expr`: a node with arithmetic operators, for writing mechanics as on paper."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from symbody.errors import ExpressionError, Problem
from symbody.expr import canonical
from symbody.expr.graph import Constant, Graph, Symbol, copy_nodes
from symbody.expr.opcodes import ATAN2, COS, MAX, MIN, PICK, SADDLE, SIN, SQRT


class Expr:
    """A node of a graph. Equal means the same node; arithmetic returns canonical nodes.

    Mixing two graphs copies the smaller side's nodes into the larger graph.
    """

    __slots__ = ("graph", "index")

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph = graph
        self.index = index

    # Vectors are full of zeros: most sums and products with them need no look at the graph.
    def __add__(self, other: Expr | Constant) -> Expr:
        graph = self.graph
        if isinstance(other, Expr) and other.graph is graph:
            a, b = self.index, other.index
            if b == canonical.ZERO:
                return self
            return other if a == canonical.ZERO else Expr(graph, canonical.add(graph, a, b))
        return _binary(canonical.add, self, other)

    def __sub__(self, other: Expr | Constant) -> Expr:
        graph = self.graph
        if isinstance(other, Expr) and other.graph is graph:
            b = other.index
            return self if b == canonical.ZERO else Expr(graph, canonical.sub(graph, self.index, b))
        return _binary(canonical.sub, self, other)

    def __mul__(self, other: Expr | Constant) -> Expr:
        graph = self.graph
        if isinstance(other, Expr) and other.graph is graph:
            a, b = self.index, other.index
            if a == canonical.ZERO:
                return self
            return other if b == canonical.ZERO else Expr(graph, canonical.mul(graph, a, b))
        return _binary(canonical.mul, self, other)

    def __truediv__(self, other: Expr | Constant) -> Expr:
        return _binary(canonical.div, self, other)

    def __pow__(self, other: Expr | Constant) -> Expr:
        return _binary(canonical.power, self, other)

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Constant) -> Expr:
        return -self + other

    def __rtruediv__(self, other: Constant) -> Expr:
        return Expr(self.graph, canonical.div(self.graph, self.graph.constant(other), self.index))

    def __rpow__(self, other: Constant) -> Expr:
        return Expr(self.graph, canonical.power(self.graph, self.graph.constant(other), self.index))

    def __neg__(self) -> Expr:
        if self.index == canonical.ZERO:
            return self
        return Expr(self.graph, canonical.neg(self.graph, self.index))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expr) and self.index == other.index and self.graph is other.graph

    def __hash__(self) -> int:
        return hash((id(self.graph), self.index))

    def __bool__(self) -> bool:
        raise ExpressionError(
            Problem("expression.truth_value", "", "an expression has no truth value",
                    "it was used in 'if', 'and' or 'while'", "ask .is_zero, or use select()")
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"Expr({self.index})"

    @property
    def is_zero(self) -> bool:
        """True if the node is the exact constant 0."""
        return self.index == canonical.ZERO

    @property
    def number(self) -> Constant | None:
        """The value if this is a constant, else None."""
        return self.graph.number(self.index)

    def apply(self, op: int, *others: Expr | Constant) -> Expr:
        """Return the function with operation code `op` of this and `others`."""
        graph, nodes = common_graph((self, *others))
        return Expr(graph, canonical.apply(graph, op, *nodes))


def symbol(graph: Graph, name: Symbol) -> Expr:
    """Return a symbol as an expression of `graph`."""
    return Expr(graph, graph.symbol(name))


def number(graph: Graph, value: Constant) -> Expr:
    """Return a number as an expression of `graph`."""
    return Expr(graph, graph.constant(value))


def sin(x: Expr) -> Expr:
    """Return the sine of an angle [rad]."""
    return x.apply(SIN)


def cos(x: Expr) -> Expr:
    """Return the cosine of an angle [rad]."""
    return x.apply(COS)


def sqrt(x: Expr) -> Expr:
    """Return the square root."""
    return x.apply(SQRT)


def atan2(y: Expr, x: Expr | Constant) -> Expr:
    """Return the angle [rad] of the point (x, y) in (-pi, pi]."""
    return y.apply(ATAN2, x)


def minimum(a: Expr, b: Expr | Constant) -> Expr:
    """Return the smaller of two values."""
    return a.apply(MIN, b)


def maximum(a: Expr, b: Expr | Constant) -> Expr:
    """Return the larger of two values."""
    return a.apply(MAX, b)


def saddle_entry(graph: Graph, kernel: int, operands: tuple[int, ...], entry: int) -> Expr:
    """Return one entry of the result of `solve_saddle` (accelerations, then multipliers, then rank)."""
    return Expr(graph, graph.node(PICK, graph.many(SADDLE, operands, kernel), entry))


def common_graph(values: Iterable[Expr | Constant]) -> tuple[Graph, list[int]]:
    """Return one graph that holds all `values`, and their nodes in it."""
    items = list(values)
    graphs = [item.graph for item in items if isinstance(item, Expr)]
    graph = max(graphs, key=len)
    return graph, [_node_in(graph, item) for item in items]


def _binary(rule: Callable[[Graph, int, int], int], a: Expr, b: Expr | Constant) -> Expr:
    graph = a.graph
    if isinstance(b, Expr):
        if b.graph is graph:
            return Expr(graph, rule(graph, a.index, b.index))
        graph, (left, right) = common_graph((a, b))
        return Expr(graph, rule(graph, left, right))
    return Expr(graph, rule(graph, a.index, graph.constant(b)))


def _node_in(graph: Graph, item: Expr | Constant) -> int:
    if not isinstance(item, Expr):
        return graph.constant(item)
    if item.graph is graph:
        return item.index
    return copy_nodes(item.graph, graph, [item.index], graph.copies_of(item.graph))[0]
