"""Names in formulas: which node of the graph a word in a model stands for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from symbody.errors import ExpressionError, nearest
from symbody.expr.expression import Expr
from symbody.expr.graph import TIME, Graph, Symbol, SymbolKind
from symbody.expr.language.formula import Formula, build


@dataclass(frozen=True, slots=True)
class Names:
    """The symbols of a model by name: parameters, inputs, ``t``, coordinates, speeds, ``<coordinate>_dot``.

    Attributes
    ----------
    values : mapping of name to Expr
        Names that stand for expressions: prescribed motions, rates in quasi-speeds, measured coordinates.
    """

    graph: Graph
    symbols: Mapping[str, Symbol]
    values: Mapping[str, Expr]

    def node(self, name: str) -> int | None:
        """Return the node of a name, or None if nothing has this name."""
        if name in self.values:
            return self.values[name].index
        if name == "pi":
            return self.graph.pi()
        symbol = self.symbols.get(name)
        return None if symbol is None else self.graph.symbol(symbol)

    def value(self, name: str) -> Expr:
        """Return what a name that exists stands for."""
        value = self.values.get(name)
        return Expr(self.graph, self.graph.symbol(self.symbols[name])) if value is None else value

    def with_values(self, values: Mapping[str, Expr]) -> Names:
        """Return the names with more of them standing for expressions."""
        return Names(self.graph, self.symbols, {**self.values, **values})

    def expression(
        self, formula: Formula, where: str = "", outputs: Callable[[str, int], int] | None = None
    ) -> Expr:
        """Return a formula as an expression of the graph.

        Parameters
        ----------
        outputs : callable, optional
            Takes the name of an output that stands in quotes and its column, returns its node.

        Raises
        ------
        ExpressionError
            If it names a symbol that does not exist, with the nearest names.
        """

        def look_up(name: str, column: int) -> int:
            node = self.node(name)
            if node is None:
                cure = nearest(name, [*self.symbols, *self.values, "pi"])
                what = f"there is no symbol {name!r}"
                raise ExpressionError(
                    formula.problem("equations.unknown_name", column, what, "", cure, where)
                )
            return node

        return Expr(self.graph, build(formula, self.graph, look_up, where=where, outputs=outputs))

    def triple(self, formulas: Iterable[Formula], where: str = "") -> tuple[Expr, Expr, Expr]:
        """Return three formulas as expressions."""
        x, y, z = (self.expression(formula, where) for formula in formulas)
        return (x, y, z)


def model_names(
    graph: Graph,
    parameters: Iterable[str],
    inputs: Iterable[str],
    coordinates: Iterable[str],
    speeds: Iterable[str] = (),
    signals: Iterable[str] = (),
) -> Names:
    """Return the names of a model; `speeds` are quasi-speeds, which are not rates."""
    symbols = {"t": TIME}
    symbols.update((name, Symbol(name, SymbolKind.PARAMETER)) for name in parameters)
    symbols.update((name, Symbol(name, SymbolKind.INPUT)) for name in inputs)
    for name in coordinates:
        coordinate = Symbol(name, SymbolKind.COORDINATE)
        for symbol in (coordinate, coordinate.derivative, coordinate.derivative.derivative):
            symbols[symbol.label] = symbol
    for name in speeds:
        speed = Symbol(name, SymbolKind.SPEED)
        symbols.update((symbol.label, symbol) for symbol in (speed, speed.derivative))
    for name in signals:
        signal = Symbol(name, SymbolKind.SIGNAL)
        symbols.update((symbol.label, symbol) for symbol in (signal, signal.derivative))
    return Names(graph, symbols, {})
