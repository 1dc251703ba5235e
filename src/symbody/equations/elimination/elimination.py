"""Constraints on velocities eliminated: dependent speeds as functions of the others.

With the rows ``J_d u_d + J_i u_i + b = 0`` the speeds are ``u_d = T u_i + c`` and ``u_d' = T u_i' + s``, with
``T = -J_d^-1 J_i``, ``c = -J_d^-1 b`` and ``s = J_d^-1 gamma``. Velocities in the independent speeds have
Kane's nonholonomic partial velocities (Kane & Levinson 1985, section 2.14); projected on them the forces of
the rows vanish. What the rows carry follows from the equations of the dependent speeds,
``lambda = J_d^-T (M u' - F - J_h^T lambda_h)_d``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from symbody.equations.elimination.dependent_block import DependentBlock
from symbody.equations.formulations.formulation import Dynamics
from symbody.equations.formulations.projection import projected_dynamics
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.placements import fold_zeros
from symbody.equations.kinematics.variables import Variables
from symbody.equations.kinematics.velocity import Velocity
from symbody.equations.system import MultibodySystem
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import substitute


@dataclass(frozen=True, slots=True)
class SpeedElimination:
    """Dependent speeds as functions of the others.

    Attributes
    ----------
    speeds, dependent : tuple of Symbol
        All speeds, and the dependent ones in the order of the columns of J_d.
    rows : tuple of ConstraintEquation
        The rows eliminated, in all speeds.
    given : mapping of multiplier to (mapping of node to Expr, Expr)
        Slopes and rests, in all speeds, of all rows and of those that hold joints with friction.
    slopes : mapping of node to mapping of node to Expr
        T: of each dependent speed by independent ones, zeros left out.
    rest, bias : mapping of node to Expr
        c and s of each dependent speed.
    inverse : (m, m) Expr
        J_d^-1, a row a dependent speed.
    block : Block
        J_d and how it is solved.
    pivots : mapping of name to Expr
        ``<speed>_pivot``, from -1 to 1: where it is 0, this dependent speed does not follow from the others.
    full : Dynamics
        Mass matrix and forcing in all speeds.
    """

    graph: Graph
    speeds: tuple[Symbol, ...]
    dependent: tuple[Symbol, ...]
    rows: tuple[ConstraintEquation, ...]
    given: Mapping[str, tuple[Mapping[int, Expr], Expr]]
    slopes: Mapping[int, Mapping[int, Expr]]
    rest: Mapping[int, Expr]
    bias: Mapping[int, Expr]
    inverse: tuple[tuple[Expr, ...], ...]
    block: DependentBlock
    pivots: Mapping[str, Expr]
    full: Dynamics

    def with_bias(self, gamma: Sequence[Expr]) -> SpeedElimination:
        """Return the elimination with s, from the right-hand sides of the rows eliminated."""
        moved = self.substitute([x.index for x in gamma])
        found = self.block.solve([Expr(self.graph, node) for node in moved])
        return replace(self, bias=dict(zip(self.bias, found, strict=True)))

    @property
    def independent(self) -> tuple[Symbol, ...]:
        """The speeds that are left."""
        return tuple(u for u in self.speeds if u not in self.dependent)

    @property
    def values(self) -> dict[str, Expr]:
        """The dependent speeds and their rates by name."""
        found = {}
        for u in self.dependent:
            for own, rest in ((u, self.rest), (u.derivative, self.bias)):
                found[own.label] = self._value_of_dependent(u, rest, rates=own is not u)
        return found

    def substitute(self, nodes: Sequence[int]) -> list[int]:
        """Return nodes with dependent speeds and their rates replaced."""
        values = self.values
        symbols = [own for u in self.dependent for own in (u, u.derivative)]
        return substitute(
            self.graph, nodes, {self.graph.symbol(own): values[own.label].index for own in symbols}
        )

    def substitute_names(self, names: Names) -> Names:
        """Return the names with the values of the dependent speeds."""
        found = self.substitute([value.index for value in names.values.values()])
        moved = {key: Expr(self.graph, node) for key, node in zip(names.values, found, strict=True)}
        return Names(names.graph, names.symbols, {**moved, **self.values})

    def reduce_variables(self, variables: Variables) -> Variables:
        """Return the variables without dependent speeds."""
        rates = dict(zip(variables.rates, self.substitute(list(variables.rates.values())), strict=True))
        return replace(variables, u=self.independent, rates=rates)

    def reduce_kinematics(self, kinematics: Kinematics, rates: Mapping[int, int]) -> Kinematics:
        """Return the same frames, moved by the independent speeds."""
        both = (kinematics.velocities, kinematics.angular_velocities)
        vectors = [a for group in both for v in group.values() for a in (v.value, v.bias)]
        nodes = list({x.index: None for a in vectors for triple in a.terms.values() for x in triple})
        moved = dict(zip(nodes, self.substitute(nodes), strict=True))
        velocities, angular = (
            {frame: self._velocity(velocity, moved) for frame, velocity in group.items()} for group in both
        )
        return replace(
            kinematics,
            rates=rates,
            speeds=tuple(self.graph.symbol(u) for u in self.independent),
            velocities=velocities,
            angular_velocities=angular,
        )

    def reduce_rows(self, rows: Iterable[ConstraintEquation]) -> list[ConstraintEquation]:
        """Return rows in all speeds as rows in the independent ones; slopes that vanish are left out."""
        rows = list(rows)
        found = [self._row(row) for row in rows]
        kept = iter(fold_zeros(self.graph, [x for row in found for x in row.jacobian.values()]))
        moved = self.substitute([row.gamma.index for row in found])
        result = []
        for row, node in zip(found, moved, strict=True):
            pairs = {u: next(kept) for u in row.jacobian}
            slopes = {u: slope for u, slope in pairs.items() if not slope.is_zero}
            result.append(replace(row, jacobian=slopes, gamma=Expr(self.graph, node)))
        return result

    def reduce_dynamics(self, system: MultibodySystem) -> Dynamics:
        """Return ``T^T M T`` and ``T^T (F - M s)`` for a system that moves with the independent speeds."""
        n = len(self.speeds)
        zero = number(self.graph, 0)
        nodes = [self.graph.symbol(u) for u in self.speeds]
        independent = [self.graph.symbol(u) for u in self.independent]
        T = [self._combination(u) for u in nodes]
        s = [self.bias.get(u, zero) for u in nodes]
        mass = self.full.mass_matrix
        moved = self.substitute([force.index for force in self.full.forcing])
        forcing = [
            Expr(self.graph, moved[i]) - _total((mass[i][j] * s[j] for j in range(n)), zero) for i in range(n)
        ]
        columns = [
            [_total((mass[i][j] * T[j].get(u, zero) for j in range(n)), zero) for i in range(n)]
            for u in independent
        ]

        def project(column: Sequence[Expr], u: int) -> Expr:
            return _total((T[i].get(u, zero) * column[i] for i in range(n)), zero)

        matrix = [[zero] * len(independent) for _ in independent]
        for i, u in enumerate(independent):
            for j in range(i + 1):
                matrix[i][j] = matrix[j][i] = project(columns[j], u)
        return projected_dynamics(system, matrix, [project(forcing, u) for u in independent])

    def multipliers(self, others: Sequence[str]) -> dict[str, Expr]:
        """Return the multipliers of the rows eliminated, in u', the other multipliers and friction efforts.

        Parameters
        ----------
        others : sequence of str
            Names of the multipliers of the rows that are left.
        """
        graph, zero = self.graph, number(self.graph, 0)
        values = self.values
        rates = [values.get(u.derivative.label, symbol(graph, u.derivative)) for u in self.speeds]
        left = []
        for u in self.dependent:
            k, node = self.speeds.index(u), graph.symbol(u)
            (force,) = self.substitute([self.full.forcing[k].index])
            mass = self.full.mass_matrix[k]
            total = _total((a * rate for a, rate in zip(mass, rates, strict=True)), zero) - Expr(graph, force)
            for name in others:
                slope = self.given[name][0].get(node, zero)
                total = total - slope * symbol(graph, Symbol(name, SymbolKind.MULTIPLIER))
            left.append(total)
        return {
            row.name: _total((line[k] * x for line, x in zip(self.inverse, left, strict=True)), zero)
            for k, row in enumerate(self.rows)
            if not row.is_balance
        }

    def _value_of_dependent(self, u: Symbol, rest: Mapping[int, Expr], *, rates: bool) -> Expr:
        """Return T times the independent speeds, or their rates, plus a rest."""
        node = self.graph.symbol(u)
        total = rest[node]
        for other in self.independent:
            slope = self.slopes[node].get(self.graph.symbol(other))
            if slope is not None:
                total = total + slope * symbol(self.graph, other.derivative if rates else other)
        return total

    def _combination(self, u: int) -> Mapping[int, Expr]:
        """Return the slopes of any speed by the independent ones."""
        return self.slopes.get(u, {u: number(self.graph, 1)})

    def _velocity(self, velocity: Velocity, moved: Mapping[int, int]) -> Velocity:
        partials = {u: a for u, a in velocity.partials.items() if u not in self.slopes}
        offset, value, bias = (
            velocity.drift,
            *(a.map(lambda x: Expr(self.graph, moved[x.index])) for a in (velocity.value, velocity.bias)),
        )
        for u, partial in velocity.partials.items():
            if u not in self.slopes:
                continue
            for other, slope in self.slopes[u].items():
                share = partial * slope
                partials[other] = partials[other] + share if other in partials else share
            offset, bias = offset + partial * self.rest[u], bias + partial * self.bias[u]
        return Velocity({u: a for u, a in partials.items() if not a.is_zero}, offset, value, bias)

    def _row(self, row: ConstraintEquation) -> ConstraintEquation:
        zero = number(self.graph, 0)
        slopes = {u: slope for u, slope in row.jacobian.items() if u not in self.slopes}
        rest, gamma = row.drift, row.gamma
        for u, slope in row.jacobian.items():
            if u not in self.slopes:
                continue
            for other, share in self.slopes[u].items():
                slopes[other] = slopes.get(other, zero) + slope * share
            rest, gamma = rest + slope * self.rest[u], gamma - slope * self.bias[u]
        return replace(row, jacobian=slopes, drift=rest, gamma=gamma)


def _total(values: Iterable[Expr], zero: Expr) -> Expr:
    return sum(values, zero)
