"""Which joints shift along a curve: those close no loop, since their rows hold for straight ways alone."""

from __future__ import annotations

from functools import lru_cache

from symbody.expr.calculus import derivative
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.language.formula import build
from symbody.expr.rewrite import symbols_of
from symbody.model.declarations.formula_site import Triple
from symbody.model.joint import Joint


def is_curved(joint: Joint) -> bool:
    """Return whether the shift of a joint is not linear in the coordinates that only shift its end."""
    sliding = [name for name in joint.translation_coordinates if name not in joint.coupled_coordinates]
    return bool(sliding) and _has_slopes_in(joint.shift(), tuple(sliding))


@lru_cache(maxsize=1024)
def _has_slopes_in(shift: Triple, names: tuple[str, ...]) -> bool:
    """Return whether the derivatives of a shift by some coordinates depend on one of these."""
    graph = Graph()

    def look_up(name: str, column: int) -> int:
        return graph.pi() if name == "pi" else graph.symbol(Symbol(name, SymbolKind.PARAMETER))

    nodes = [build(component, graph, look_up) for component in shift]
    slopes = [slope for name in names for slope in derivative(graph, nodes, look_up(name, 0))]
    inside = {graph.symbols[graph.left[place]].name for place in symbols_of(graph, slopes)}
    return not inside.isdisjoint(names)
