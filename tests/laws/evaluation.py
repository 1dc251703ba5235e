"""Numbers from an EquationSet by plain evaluation, without LLVM; and the condition of its linear system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mpmath
import numpy as np
from scipy.linalg import qr

import symbody as sb
from symbody.expr.graph import TIME
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.precise_numbers import MPMATH
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.sequences.sequence import Sequence as Program
from symbody.graph.trees import TreeChoice
from symbody.model import resolve_parameters
from tests.laws.building import build_model
from tests.laws.consistent_states import State
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True, eq=False)
class Evaluator:
    """Roots of one EquationSet as functions of t, q, u, the inputs and the parameters.

    The graph is evaluated as it stands: nothing is merged or fused, so that each value is computed by the
    formula that the derivation gave it.
    """

    program: Program
    shapes: dict[str, tuple[int, ...]]
    parameters: tuple[float, ...]

    def __call__(
        self, t: float, q: Sequence[float], u: Sequence[float], r: Sequence[float]
    ) -> dict[str, Array]:
        groups = {"t": [t], "q": q, "u": u, "r": r, "p": self.parameters}
        return self._shaped(evaluate_sequence(self.program, groups)[0], float)

    def precise(
        self, t: object, q: Sequence[object], u: Sequence[object], r: Sequence[object]
    ) -> dict[str, Array]:
        """The same with mpmath at the precision it is set to; arrays of objects."""
        given = {"t": [t], "q": q, "u": u, "r": r, "p": self.parameters}
        groups = {name: [mpmath.mpf(x) for x in values] for name, values in given.items()}
        return self._shaped(evaluate_sequence(self.program, groups, MPMATH)[0], object)

    def _shaped(self, values: Sequence[object], kind: type) -> dict[str, Array]:
        found: dict[str, Array] = {}
        at = 0
        for name, shape in self.shapes.items():
            size = int(np.prod(shape))
            found[name] = np.array(values[at : at + size], dtype=kind).reshape(shape)
            at += size
        return found


def evaluator(eqs: sb.EquationSet, roots: Sequence[str | Roots]) -> Evaluator:
    """Plain evaluation of outputs, by name or as roots."""
    listed = [eqs.roots(root) if isinstance(root, str) else root for root in roots]
    formed = eqs.formed
    graph, names = formed.graph, formed.names
    places = {graph.symbol(TIME): Input("t", "t", 0)}
    groups = {"q": eqs.coordinate_names, "u": eqs.speed_names, "r": eqs.input_names, "p": eqs.parameter_names}
    groups["q"] += eqs.signal_state_names  # they stand behind the coordinates
    for group, words in groups.items():
        places |= {names.value(name).index: Input(name, group, k) for k, name in enumerate(words)}
    nodes = tuple(node for root in listed for node in root.nodes)
    program = build_sequence(graph, [Roots("all", (len(nodes),), nodes)], places, merge=False, contract=False)
    values = resolve_parameters(eqs.model)
    parameters = tuple(float(values[name]) for name in eqs.parameter_names)
    return Evaluator(program, {root.name: root.shape for root in listed}, parameters)


def equations(mechanism: Mechanism, tree: TreeChoice = None) -> sb.EquationSet:
    """The equations of a mechanism, without rows that are only rounding at its parameters."""
    return for_own_values(sb.form_equations(build_model(mechanism), tree=tree))


def for_own_values(eqs: sb.EquationSet) -> sb.EquationSet:
    """Equations without rows that are only rounding at the values of the model's parameters."""
    values = {name: float(value) for name, value in resolve_parameters(eqs.model).items()}
    return eqs.for_values(values) if eqs.multiplier_names else eqs


def values_at(eqs: sb.EquationSet, state: State, outputs: Sequence[str]) -> dict[str, Array]:
    """Outputs at a state."""
    return evaluator(eqs, outputs)(*arguments(eqs, state))


def arguments(eqs: sb.EquationSet, state: State) -> tuple[float, list[float], list[float], list[float]]:
    """t, q, u, r of a state."""
    return state.t, state.of(eqs.coordinate_names), state.of(eqs.speed_names), state.of(eqs.input_names)


@dataclass(frozen=True, slots=True)
class Condition:
    """How much the solution of ``M u' = F + J^T lambda, J u' = gamma`` changes with its data.

    Attributes
    ----------
    number : float
        Largest change of scaled accelerations, relative to the largest, for data changed by one eps relative:
        ``max |K^-1| (|K| |x| + |b|) / max |x|`` over the accelerations, with the diagonal of M and the rows of J
        scaled to one [Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., section 7.2].
    rank, rows : int
        Of J.
    """

    number: float
    rank: int
    rows: int


def condition(values: Mapping[str, Array]) -> Condition:
    """The condition at a state, from the outputs mass_matrix, forcing, jacobian, gamma, udot."""
    M, J = values["mass_matrix"], np.atleast_2d(values["jacobian"])
    F, gamma, udot = values["forcing"], values["gamma"], values["udot"]
    n = len(F)
    if not n:
        return Condition(1.0, 0, len(gamma))
    d = _scales(M, J)
    A = J * d
    lengths = np.linalg.norm(A, axis=1)
    A = A / np.where(lengths > 0, lengths, 1.0)[:, None]
    kept = independent_rows(A)
    A, g = A[kept], (gamma / np.where(lengths > 0, lengths, 1.0))[kept]
    m = len(A)
    B = M * np.outer(d, d)
    K = np.block([[B, -A.T], [A, np.zeros((m, m))]])
    b = np.concatenate([F * d, g])
    inverse = np.linalg.inv(K)
    x = inverse @ b
    x[:n] = udot / d
    change = np.abs(inverse) @ (np.abs(K) @ np.abs(x) + np.abs(b))
    top = np.abs(x[:n]).max(initial=0.0)
    number = float(change[:n].max(initial=1.0) / top) if top > 0 else 1.0
    return Condition(max(number, 1.0), m, len(J))


def independent_rows(A: Array) -> list[int]:
    """Rows of a matrix that span the others to nine digits."""
    if not len(A):
        return []
    _, r, order = qr(A.T, mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(r))
    return sorted(order[: len(diagonal)][diagonal > 1e-9 * max(diagonal.max(initial=0.0), 1e-300)].tolist())


def _scales(M: Array, J: Array) -> Array:
    mass = np.diag(M)
    found: Array = np.where(mass > 0, 1 / np.sqrt(np.where(mass > 0, mass, 1.0)), 1.0)
    light = np.abs(J).max(axis=0, initial=0.0)
    return np.where((mass <= 0) & (light > 0), 1 / np.where(light > 0, light, 1.0), found)
