"""`IndexReduction`, and that of a mechanism, whose hidden constraints follow from its structure.

``M u' = F + J^T lambda`` with ``Phi = 0`` has index 3: ``J u + b = 0`` and ``J u' = gamma`` are hidden in it,
and one more derivative of the last gives lambda' (Hairer & Wanner 1996, section VII.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.index_reduction.separation import to_readable_sympy
from symbody.equations.solving.drift_correction import velocity_residual
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import time_derivative
from symbody.expr.expression import Expr
from symbody.expr.graph import SymbolKind
from symbody.expr.sympy.sympy_bridge import SympyExpr, to_sympy


@dataclass(frozen=True, slots=True)
class IndexReduction:
    """Ordinary differential equations, and the hidden constraints that their initial values must satisfy.

    Attributes
    ----------
    unknowns : tuple of SymPy functions of time
        What the equations determine.
    ode : list of SymPy expressions
        Each equal to 0 and linear in the highest derivatives of the unknowns.
    algebraic : tuple of list of SymPy expressions
        The hidden constraints, each equal to 0, one list for each differentiation: of a mechanism those on
        positions, velocities, accelerations.
    assumed_nonzero : tuple of SymPy expressions
        Pivots: where one vanishes, the equations may mean something else.
    definitions : tuple of (symbol, expression)
        z1, z2, ... in which formulas beyond 20,000 operations are written.

    Examples
    --------
    >>> import sympy as sp
    >>> import symbody as sb
    >>> t = sp.Symbol("t")
    >>> x, y = sp.Function("x")(t), sp.Function("y")(t)
    >>> result = sb.reduce_index([x.diff(t) - y, x - sp.sin(t)], [x, y])
    >>> result.ode
    [-y(t) + Derivative(x(t), t), sin(t) + Derivative(y(t), t)]
    >>> result.algebraic
    ([x(t) - sin(t)], [y(t) - cos(t)])
    """

    unknowns: tuple[SympyExpr, ...]
    ode: list[SympyExpr]
    algebraic: tuple[list[SympyExpr], ...]
    assumed_nonzero: tuple[SympyExpr, ...] = ()
    definitions: tuple[tuple[SympyExpr, SympyExpr], ...] = field(default=(), repr=False)

    @property
    def index(self) -> int:
        """How often constraints are differentiated: 3 for constraints on positions, 0 without any."""
        return len(self.algebraic)


def reduce_mechanism(formed: EquationsOfMotion) -> IndexReduction:
    """Return the reduction of the equations of a mechanism; see `reduce_index`."""
    _check_no_friction(formed)
    graph = formed.graph
    udot = formed.expressions([u.derivative for u in formed.u])
    multipliers = formed.expressions(formed.multipliers)
    jacobian = formed.jacobian
    columns = [[row[i] for row in jacobian] for i in range(len(udot))]
    mass, forcing = formed.dynamics.mass_matrix, formed.dynamics.forcing
    balance = [
        _product(mass[i], udot, -forcing[i]) - _product(columns[i], multipliers, Expr(graph, 0))
        for i in range(len(udot))
    ]
    accelerations = [_product(row, udot, -own.gamma) for row, own in zip(jacobian, formed.rows, strict=True)]
    levels = [[row.value for row in formed.holonomic], velocity_residual(formed), accelerations]
    levels = [level for level in levels if level]
    rates = formed.variables.rates
    dynamic = [row.index for row in (*balance, *accelerations)]
    if accelerations:
        dynamic = time_derivative(graph, dynamic, rates)
    rows = [*_kinematic(formed), *dynamic]
    shown, definitions = to_readable_sympy(graph, [*rows, *(row.index for level in levels for row in level)])
    pieces = iter(shown)
    ode = [next(pieces) for _ in rows]
    algebraic = tuple([next(pieces) for _ in level] for level in levels)
    quasi = [u for u in formed.u if u.kind == SymbolKind.SPEED]
    unknowns = [*formed.expressions(formed.q), *formed.expressions(quasi), *multipliers]
    return IndexReduction(
        tuple(to_sympy(graph, [item.index for item in unknowns])), ode, algebraic, (), tuple(definitions)
    )


def _kinematic(formed: EquationsOfMotion) -> list[int]:
    """Return ``q' - N u - nu`` for coordinates whose rates are not speeds."""
    graph, rates = formed.graph, formed.variables.rates
    rows = [Expr(graph, graph.symbol(q.derivative)) - Expr(graph, rates[graph.symbol(q)]) for q in formed.q]
    return [row.index for row in rows if not row.is_zero]


def _product(row: Sequence[Expr], column: Sequence[Expr], start: Expr) -> Expr:
    for a, b in zip(row, column, strict=True):
        start = start + a * b
    return start


def _check_no_friction(formed: EquationsOfMotion) -> None:
    if formed.friction:
        names = ", ".join(dict.fromkeys(law.name for law in formed.friction))
        raise FormulationError(
            Problem("reduction.friction", f"friction of {names}",
                    "equations with friction from reactions are not reduced in closed form",
                    "the friction force depends on the reaction that it changes",
                    "define the friction as an applied force or torque in the speeds, or call simulate")
        )  # fmt: skip
