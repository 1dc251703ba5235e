"""`EquationSet`: the hinge between how equations are formed and what is done with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from symbody.equations.formed import Formed
from symbody.equations.outputs import output_roots
from symbody.expr.closed_form import ClosedForms, closed_forms, readable
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol
from symbody.expr.printing.definitions import EXPAND_LIMIT
from symbody.expr.rewrite import operation_count
from symbody.expr.sequence import Roots
from symbody.expr.sympy_bridge import SympyEquation, SympyExpr, SympyMatrix, to_sympy
from symbody.model.model import Model

# The outputs that properties show as formulas.
_SHOWN: Final = (
    "mass_matrix", "forcing", "constraints", "jacobian", "kinetic_energy", "potential_energy", "qdot",
)  # fmt: skip


@dataclass(frozen=True, eq=False, slots=True)
class EquationSet:
    """Equations of motion ``M u' = F``, ``q' = N u + nu`` of a model.

    Every property that shows formulas returns SymPy objects in dynamicsymbols; the numbers come from
    the expression graph behind them, through `compile` and `simulate`.

    Attributes
    ----------
    model : Model
        What the equations belong to.
    formed : Formed
        The equations in the expression graph.
    notes : tuple of str
        Every choice that was made, with its reason.
    """

    model: Model
    formed: Formed
    notes: tuple[str, ...] = ()
    # Roots already made; a pure function of `formed`, so it cannot go stale.
    _roots: dict[str, Roots] = field(default_factory=dict, repr=False)
    _forms: dict[str, ClosedForms] = field(default_factory=dict, repr=False)

    def __repr__(self) -> str:
        return f"EquationSet of {self.model.name!r}: {self.degrees_of_freedom} degrees of freedom"

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of q in order."""
        return tuple(symbol.label for symbol in self.formed.q)

    @property
    def speed_names(self) -> tuple[str, ...]:
        """Names of u in order."""
        return tuple(symbol.label for symbol in self.formed.u)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states: speeds, then coordinates."""
        return self.speed_names + self.coordinate_names

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs r in order."""
        return tuple(symbol.name for symbol in self.formed.inputs)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of all parameters of the model."""
        return tuple(symbol.name for symbol in self.formed.parameters)

    @property
    def multiplier_names(self) -> tuple[str, ...]:
        """Names of the multipliers; none in a tree."""
        return ()

    @property
    def units(self) -> dict[str, str]:
        """SI units of coordinates, speeds and energies, as far as the joints tell."""
        units = {
            "t": "s",
            "kinetic_energy": "J",
            "potential_energy": "J",
            "energy": "J",
            "work": "J",
            "power": "W",
        }
        for joint in self.model.joints:
            for name in joint.coordinates:
                unit = "rad" if name in joint.rotation_coordinates else "m"
                units |= {name: unit, f"{name}_dot": f"{unit}/s"}
        return units

    @property
    def coordinates(self) -> tuple[SympyExpr, ...]:
        """Coordinates q as dynamicsymbols."""
        return self._symbols(self.formed.q)

    @property
    def speeds(self) -> tuple[SympyExpr, ...]:
        """Speeds u; those that are rates are derivatives of the coordinates."""
        return self._symbols(self.formed.u)

    @property
    def states(self) -> tuple[SympyExpr, ...]:
        """Speeds, then coordinates."""
        return self.speeds + self.coordinates

    @property
    def inputs(self) -> tuple[SympyExpr, ...]:
        """Inputs r as dynamicsymbols."""
        return self._symbols(self.formed.inputs)

    @property
    def parameters(self) -> tuple[SympyExpr, ...]:
        """Parameters as symbols."""
        return self._symbols(self.formed.parameters)

    @property
    def multipliers(self) -> tuple[SympyExpr, ...]:
        """Multipliers lambda; none in a tree."""
        return ()

    @property
    def mass_matrix(self) -> SympyMatrix:
        """M, (n_u, n_u), symmetric."""
        return self._closed.matrices["mass_matrix"].copy()

    @property
    def forcing(self) -> SympyMatrix:
        """F, (n_u, 1): everything but ``M u'``, on the right-hand side."""
        return self._closed.matrices["forcing"].copy()

    @property
    def constraints(self) -> SympyMatrix:
        """Position constraints Phi, (n_h, 1); none in a tree."""
        return self._closed.matrices["constraints"].copy()

    @property
    def constraint_jacobian(self) -> SympyMatrix:
        """J in the speeds, (n_c, n_u); no rows in a tree."""
        return self._closed.matrices["jacobian"].copy()

    @property
    def kinetic_energy(self) -> SympyExpr:
        """Kinetic energy relative to ground [J]."""
        return self._closed.matrices["kinetic_energy"][0]

    @property
    def potential_energy(self) -> SympyExpr:
        """Potential energy of gravity and springs [J], zero at the origin and at the free lengths."""
        return self._closed.matrices["potential_energy"][0]

    @property
    def kinematic_equations(self) -> list[SympyEquation]:
        """``q' = N u + nu``, one equation a coordinate."""
        return self._closed.equations("rates", "qdot")

    def dynamic_equations(self) -> list[SympyEquation]:
        """Return ``M u' = F``, one equation a speed, in the order of `speeds`."""
        return self._closed.equations("inertial", "forcing")

    @property
    def definitions(self) -> tuple[tuple[SympyExpr, SympyExpr], ...]:
        """Pairs (z1, expression), ... that all formulas of this set are written in, each by earlier ones.

        Empty while no entry exceeds 20,000 operations written out.
        """
        return self._closed.definitions

    @property
    def degrees_of_freedom(self) -> int:
        """Independent speeds at a generic configuration."""
        return len(self.formed.u)

    def operation_count(self, *outputs: str) -> int:
        """Return the operations of a shared evaluation of `outputs`, parameters as symbols."""
        nodes = [node for name in outputs for node in self.roots(name).nodes]
        return operation_count(self.formed.graph, nodes)

    def roots(self, name: str) -> Roots:
        """Return the roots of an output in the expression graph; see `output_roots`."""
        found = self._roots.get(name)
        if found is None:
            found = output_roots(self.formed, name)
            self._roots[name] = found
        return found

    @property
    def _closed(self) -> ClosedForms:
        """All closed forms together, so that they share one list of definitions."""
        found = self._forms.get("closed")
        if found is None:
            graph = self.formed.graph
            shown = [self.readable(name) for name in _SHOWN]
            rates = tuple(graph.symbol(symbol.derivative) for symbol in self.formed.q)
            sides = [self.inertial, Roots("rates", (len(rates),), rates)]
            found = closed_forms(graph, [*shown, *sides], EXPAND_LIMIT)
            self._forms["closed"] = found
        return found

    def readable(self, name: str) -> Roots:
        """Return the roots of an output in the form in which people read it; the same values."""
        key = f"readable {name}"
        found = self._roots.get(key)
        if found is None:
            roots = self.roots(name)
            found = Roots(name, roots.shape, tuple(readable(self.formed.graph, roots.nodes)))
            self._roots[key] = found
        return found

    @property
    def inertial(self) -> Roots:
        """``M u'`` in the expression graph, one root a speed."""
        graph, n = self.formed.graph, len(self.formed.u)
        accelerations = self.formed.expressions(tuple(symbol.derivative for symbol in self.formed.u))
        mass = [Expr(graph, node) for node in self.readable("mass_matrix").nodes]
        rows = [_sum_of_products(mass[i * n : i * n + n], accelerations).index for i in range(n)]
        return Roots("inertial", (n,), tuple(rows))

    def _symbols(self, symbols: tuple[Symbol, ...]) -> tuple[SympyExpr, ...]:
        graph = self.formed.graph
        return tuple(to_sympy(graph, [graph.symbol(symbol) for symbol in symbols]))


def _sum_of_products(row: Sequence[Expr], column: Sequence[Expr]) -> Expr:
    total = Expr(column[0].graph, 0)
    for a, b in zip(row, column, strict=True):
        total = total + a * b
    return total
