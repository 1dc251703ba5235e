"""Rows of equations between coordinates: gears, racks, belts, differentials, and what users write."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from symbody.equations.constraints.frame_constraints import time_partial
from symbody.equations.kinematics.constraint_equation import ConstraintEquation, scalar_equation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import SymbolKind
from symbody.expr.language.formula import Formula
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import substitute, symbols_of
from symbody.model.constraints.couplings import Constraint, JointCoupling, Stop


def coupling_equations(
    names: Names, kinematics: Kinematics, coupling: JointCoupling
) -> Iterator[ConstraintEquation]:
    """Return the sum of factors times coordinates less the offset."""
    where = f"constraint {coupling.name}"
    factors = [names.expression(factor, where) for factor in coupling.factors]
    row = scalar_equation(kinematics, "", coupling.name, coupling_value(names, coupling))
    shares = dict(zip(coupling.coupled, factors, strict=True))
    yield replace(row, shares=shares, driven=time_partial(names.expression(coupling.offset, where)))


def coupling_value(names: Names, coupling: JointCoupling) -> Expr:
    """Return the left-hand side of a coupling, which vanishes."""
    where = f"constraint {coupling.name}"
    value = -names.expression(coupling.offset, where)
    for factor, name in zip(coupling.factors, coupling.coupled, strict=True):
        value = value + names.expression(factor, where) * names.value(name)
    return value


def written_equations(
    names: Names, kinematics: Kinematics, constraint: Constraint
) -> Iterator[ConstraintEquation]:
    """Return the rows of equations in coordinates, or of first degree in speeds.

    Raises
    ------
    FormulationError
        If an equation is not of first degree in the speeds.
    """
    where = f"constraint {constraint.name}"
    for k, formula in enumerate(constraint.equations):
        value = names.expression(formula, where)
        by_rate = _contains_speeds(kinematics, value)
        if by_rate:
            row = velocity_equation(kinematics, constraint.name, value, f"{where}, equations[{k}]")
        else:
            row = scalar_equation(kinematics, "", constraint.name, value)
        yield _with_shares(names, row, formula, where, by_rate)


def stop_equations(names: Names, kinematics: Kinematics, stop: Stop) -> Iterator[ConstraintEquation]:
    """Return the row of a gap, whose multiplier opens it.

    Raises
    ------
    FormulationError
        If the gap depends on speeds.
    """
    where = f"constraint {stop.name}"
    gap = names.expression(stop.gap, where)
    if _contains_speeds(kinematics, gap):
        raise FormulationError(
            Problem("equations.gap_of_speeds", f"{where}, gap", "it depends on speeds",
                    "a stop limits positions", "write a formula in coordinates, parameters and t")
        )  # fmt: skip
    row = _with_shares(names, scalar_equation(kinematics, "", stop.name, gap), stop.gap, where, by_rate=False)
    restitution = names.expression(stop.restitution, where)
    yield replace(row, sense=1, restitution=None if restitution.is_zero else restitution)


def _with_shares(
    names: Names, row: ConstraintEquation, formula: Formula, where: str, by_rate: bool
) -> ConstraintEquation:
    """Return a row with the efforts along the coordinates in which it is written."""
    written = _EquationAsWritten(
        names, Names(names.graph, names.symbols, {}).expression(formula, where), by_rate
    )
    return replace(row, shares=written.shares(formula.names), driven=written.time_partial())


def velocity_equation(kinematics: Kinematics, element: str, value: Expr, where: str) -> ConstraintEquation:
    """Return the row of an equation that is affine in the speeds."""
    slopes = kinematics.speed_partials(value)
    for u, slope in slopes.items():
        if _contains_speeds(kinematics, slope):
            graph = kinematics.graph
            speed = graph.symbols[graph.left[u]].label
            raise FormulationError(
                Problem("equations.nonlinear_in_speeds", where, f"it is not linear in {speed}",
                        f"its derivative by {speed} is {to_text(graph, slope.index)}, which contains speeds",
                        "write an equation of the form a*u + b = 0 with a and b in coordinates and time")
            )  # fmt: skip
    drift = kinematics.at_zero_speeds(value)
    return ConstraintEquation(
        name="",
        element=element,
        value=Expr(kinematics.graph, 0),
        jacobian=slopes,
        drift=drift,
        gamma=-kinematics.bias(value),
        is_holonomic=False,
    )


def _contains_speeds(kinematics: Kinematics, value: Expr) -> bool:
    """Return whether an expression depends on speeds, by fingerprint."""
    graph = kinematics.graph
    slopes = gradient(graph, value.index, [u for u in kinematics.speeds if u <= value.index])
    return not all(find_zeros(graph, slopes))


@dataclass(frozen=True, slots=True)
class _EquationAsWritten:
    """An equation in the symbols it is written in, whatever these are in the equations of motion.

    Attributes
    ----------
    by_rate : bool
        Whether it is one on velocities.
    """

    names: Names
    plain: Expr
    by_rate: bool

    def shares(self, read: Iterable[str]) -> dict[str, Expr]:
        """Return the derivative by each coordinate, or rate, it is written in."""
        names, suffix = self.names, "_dot" if self.by_rate else ""
        used = [name for name in read if name in names.symbols and name.endswith(suffix)]
        by = [names.graph.symbol(names.symbols[name]) for name in used]
        partials = self._in_equations_of_motion(gradient(names.graph, self.plain.index, by))
        return {name.removesuffix(suffix): x for name, x in zip(used, partials, strict=True) if not x.is_zero}

    def time_partial(self) -> Expr:
        """Return less its derivative by time, or less what is left of it at rest."""
        graph = self.names.graph
        if not self.by_rate:
            return -self._in_equations_of_motion([time_partial(self.plain).index])[0]
        symbols = {node: graph.symbols[graph.left[node]] for node in symbols_of(graph, [self.plain.index])}
        at_zero_speeds = {node: 0 for node, x in symbols.items() if x.order or x.kind is SymbolKind.SPEED}
        return -self._in_equations_of_motion(substitute(graph, [self.plain.index], at_zero_speeds))[0]

    def _in_equations_of_motion(self, nodes: Sequence[int]) -> list[Expr]:
        """Return expressions with the symbols replaced by what they are in the equations of motion."""
        names, graph = self.names, self.names.graph
        labels = {graph.symbol(symbol): name for name, symbol in names.symbols.items()}
        here = {node: names.value(labels[node]).index for node in symbols_of(graph, nodes) if node in labels}
        return [Expr(graph, node) for node in substitute(graph, nodes, here)]
