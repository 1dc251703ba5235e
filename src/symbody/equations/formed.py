"""What a formulation delivers: the equations of a model as roots in one graph."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symbody.equations.kinematics import Kinematics
from symbody.equations.naming import Names
from symbody.equations.virtual_work import Projection
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Symbol


@dataclass(frozen=True, slots=True)
class Formed:
    """Equations ``M u' = F``, ``q' = u`` with their energies, all in one graph.

    Attributes
    ----------
    q, u : tuple of Symbol
        Coordinates and speeds, in the order of the tree.
    projection : Projection
        Mass matrix and forcing.
    kinetic_energy, potential_energy, power : Expr
        ``d(T + V)/dt = power``, the power of everything that has no potential [W].
    efforts : mapping of name to Expr
        Effort of each driven joint along its positive coordinate.
    """

    graph: Graph
    names: Names
    q: tuple[Symbol, ...]
    u: tuple[Symbol, ...]
    inputs: tuple[Symbol, ...]
    parameters: tuple[Symbol, ...]
    kinematics: Kinematics
    projection: Projection
    kinetic_energy: Expr
    potential_energy: Expr
    power: Expr
    efforts: Mapping[str, Expr]

    def expressions(self, symbols: tuple[Symbol, ...]) -> tuple[Expr, ...]:
        """Return symbols as expressions of the graph."""
        return tuple(Expr(self.graph, self.graph.symbol(symbol)) for symbol in symbols)
