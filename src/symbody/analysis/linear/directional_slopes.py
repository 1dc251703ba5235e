"""Derivatives of large systems, column by column, by one program that is linear in a direction.

A matrix of derivatives has as many entries as states squared, and a formula for each of them would have to be
derived and compiled. The derivative along one direction has no more operations than a few evaluations
(Griewank & Walther, Evaluating Derivatives (2008), chapter 3): it is compiled once, and called for the unit
vectors of all states and inputs. The columns are exact as the formulas are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.derivatives import with_outputs
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.expr.calculus import forward
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.sequences.sequence import Roots

Floats = NDArray[np.float64]

# States from which on columns are computed one by one: a chain of 40 bodies takes a twentieth of the time.
MANY_STATES: Final = 40
ALONG: Final = "linear slopes along a direction"
_OTHERS: Final = ("jacobian", "position_jacobian", "constraints", "velocity_constraints")


def is_large(eqs: EquationSet) -> bool:
    """Return whether derivatives are computed column by column."""
    return len(eqs.state_names) >= MANY_STATES and eqs.formed.elimination is None


def with_slopes_along(
    eqs: EquationSet, nodes: Sequence[int], by: Sequence[Symbol], others: Sequence[Roots]
) -> EquationSet:
    """Return the equations with the derivatives of nodes along a direction that further inputs form."""
    graph = eqs.formed.graph
    directions = {symbol: Symbol(f"along {symbol.label}", SymbolKind.INPUT) for symbol in by}
    tangents = {graph.symbol(symbol): graph.symbol(part) for symbol, part in directions.items()}
    along = Roots(ALONG, (len(nodes),), tuple(forward(graph, nodes, tangents)))
    return with_outputs(eqs, [along, *others], {part.name: part for part in directions.values()})


@dataclass(frozen=True, slots=True, eq=False)
class DirectionalSlopes:
    """The function of `SlopeFunction`, from products of the derivatives with unit vectors.

    Attributes
    ----------
    states, inputs : int
        Number of states, and of inputs that are deviated from.
    along : CompiledFunction
        x', and the derivatives along the direction that its inputs r form.
    others : CompiledFunction
        J, dPhi/dq, Phi, J u + b, and what changes over at 0.
    forces : CompiledFunction
        ``M u' - F`` for the accelerations r; M itself where friction depends on these.
    """

    states: int
    inputs: int
    along: CompiledFunction
    others: CompiledFunction
    forces: CompiledFunction

    def __call__(self, t: float, q: Floats, u: Floats, *, s: Floats) -> tuple[Floats, ...]:
        """Return x', its derivatives by states and by inputs, J, dPhi/dq, M, Phi, J u + b, and switches."""
        rates, columns = self.along(t, q, u, np.eye(self.states + self.inputs), s=s)
        jacobian, slopes, constraints, velocity_constraints, kinks = self.others(t, q, u, s=s)
        return (
            rates[0], columns[: self.states].T, columns[self.states :].T, jacobian, slopes,
            self._mass_matrix(t, q, u, s), constraints, velocity_constraints, kinks,
        )  # fmt: skip

    def _mass_matrix(self, t: float, q: Floats, u: Floats, s: Floats) -> Floats:
        """Return M: the forces for one acceleration after the other, less those for none."""
        if not self.forces.signature.r:
            return np.asarray(self.forces(t, q, u, s=s))
        needed: Floats = np.asarray(self.forces(t, q, u, np.vstack([np.zeros(u.size), np.eye(u.size)]), s=s))
        with np.errstate(invalid="ignore"):  # infinite forces are refused with the rates
            return np.asarray((needed[1:] - needed[0]).T)


def directional_slopes(
    wider: EquationSet,
    counts: tuple[int, int],
    kinks: str,
    parameters: Mapping[str, Value],
    inputs: Mapping[str, Value],
) -> DirectionalSlopes:
    """Return the derivatives at a state of equations made by `with_slopes_along`.

    Parameters
    ----------
    counts : pair of int
        Number of states and of inputs that are deviated from.
    kinks : str
        The output that has the switches.
    """
    still = dict.fromkeys(wider.input_names, 0) | dict(inputs)
    along = bound_function(wider, ("xdot", ALONG), parameters, (), inputs, quick=True)
    others, forces = (
        bound_function(wider, words, parameters, (), still, quick=True)
        for words in ((*_OTHERS, kinks), "mass_matrix" if wider.formed.friction else "inverse_dynamics")
    )
    return DirectionalSlopes(*counts, along, others, forces)
