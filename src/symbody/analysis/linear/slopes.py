"""Derivatives at a state, of rates, outputs and constraints, as numbers: exact, from the graph."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.derivatives import laws_key, partial_derivatives, with_laws, with_outputs
from symbody.analysis.linear.directional_slopes import (
    DirectionalSlopes,
    directional_slopes,
    is_large,
    with_slopes_along,
)
from symbody.analysis.scales import Scales
from symbody.analysis.state import State
from symbody.codegen.formation.bound_function import bound_function, evaluate_once
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.input_formulas import input_law_nodes
from symbody.equations.solving.unilateral import element_words
from symbody.errors import AssemblyError, ExpressionError, Problem
from symbody.expr.canonical import sub
from symbody.expr.graph import TIME, Graph, Symbol, SymbolKind
from symbody.expr.opcodes import ABS, EQ, LE, LT, MAX, MIN, NAMES, SIGN
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.sequence import Roots
from symbody.tolerances import ASSEMBLED

Floats = NDArray[np.float64]

_BY_STATE: Final = "linear slopes by states"
_BY_INPUT: Final = "linear slopes by inputs"
_KINKS: Final = "linear kinks"
_READABLE: Final = 300  # letters of a formula in a note
Switch = tuple[str, int]


@dataclass(frozen=True, slots=True, eq=False)
class Slopes:
    """Derivatives at a state.

    Attributes
    ----------
    rates : (n_u + n_q + n_s,) array
        x', speeds first.
    by_state, by_input : arrays
        Of x', the outputs and the conditions on velocities by (u, q, s), and by the inputs.
    outputs : int
        Number of scalars among the outputs.
    jacobian, position_jacobian, mass_matrix : arrays
        J, dPhi/dq, M.
    constraints, velocity_constraints : arrays
        Phi, J u + b.
    switches : (n,) array
        Values of what changes over at 0.
    """

    rates: Floats
    by_state: Floats
    by_input: Floats
    outputs: int
    jacobian: Floats
    position_jacobian: Floats
    mass_matrix: Floats
    constraints: Floats
    velocity_constraints: Floats
    switches: Floats

    @property
    def of_rates(self) -> Floats:
        """Derivatives of x' by (u, q, s)."""
        return self.by_state[: len(self.rates)]

    @property
    def of_outputs(self) -> Floats:
        """Derivatives of the outputs by (u, q, s)."""
        return self.by_state[len(self.rates) : len(self.rates) + self.outputs]

    @property
    def of_velocity_rows(self) -> Floats:
        """Derivatives of J u + b by (u, q, s)."""
        return self.by_state[len(self.rates) + self.outputs :]


SlopeProgram = CompiledFunction | DirectionalSlopes


@dataclass(frozen=True, slots=True, eq=False)
class SlopeFunction:
    """Derivatives as a function of states, at one time and with values of parameters and inputs.

    Attributes
    ----------
    outputs : tuple of str
        Names of the scalars among the outputs.
    inputs : tuple of str
        Names of the inputs; those given as laws in states are not inputs.
    timed : bool
        Whether anything depends on time explicitly.
    nodes : tuple of int
        x', outputs, and conditions on velocities and positions, with the laws of inputs.
    switches : tuple of (what, node)
        Expressions at whose zeros derivatives jump.
    beside : (n,) array
        Values of these at a state as far away as the mechanism is large.
    signals : (n_s,) array
        States of signals, which stay what they are.
    """

    eqs: EquationSet
    t: float
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    timed: bool
    nodes: tuple[int, ...]
    switches: tuple[Switch, ...]
    beside: Floats
    function: SlopeProgram
    signals: Floats

    def evaluate(self, q: Floats, u: Floats) -> Slopes:
        """Return the derivatives at a state."""
        rates, states, loads, *others = self.function(self.t, q, u, s=self.signals)
        return Slopes(rates, states, loads, len(self.outputs), *others)

    def evaluate_finite(self, q: Floats, u: Floats) -> Slopes:
        """Return the derivatives at a state.

        Raises
        ------
        AssemblyError
            If one of them is infinite or does not exist.
        """
        slopes = self.evaluate(q, u)
        _check_finite(self.eqs, slopes.rates, slopes.by_state, slopes.by_input, self.inputs)
        return slopes

    def nonsmooth_notes(self, slopes: Slopes) -> tuple[str, ...]:
        """Return notes on whatever is not differentiable at a state."""
        return nonsmooth_notes(self.eqs, self.switches, slopes.switches, self.beside)


def slope_function(
    eqs: EquationSet, state: State, outputs: Sequence[str], mechanism: Scales
) -> SlopeFunction:
    """Return the derivatives with the parameters, inputs and time of a state."""
    parameters = state.parameters
    eqs = parameter_set(eqs, parameters).eqs
    laws = _laws(eqs, state.inputs)
    key = "slopes", tuple(outputs), laws_key(laws)
    plan: _SlopePlan = eqs.variants.get(key, lambda: _plan_slopes(eqs, outputs, laws))
    words = ("xdot", _BY_STATE, _BY_INPUT, "jacobian", "position_jacobian", "mass_matrix", "constraints",
             "velocity_constraints", _KINKS)  # fmt: skip
    given = dict.fromkeys(eqs.input_names, 0) | dict(state.inputs)
    function: SlopeProgram
    if is_large(eqs):
        counts = len(eqs.state_names), len(plan.inputs)
        function = directional_slopes(plan.wider, counts, _KINKS, parameters, given)
    else:
        function = bound_function(plan.wider, words, parameters, (), given)
    # Without the accelerations, as far as it goes: there need be none at a place that fits no constraint.
    far = {"t": [state.t], "r": [], **_far_state(eqs, mechanism, state)}
    beside = np.array(evaluate_once(plan.wider, _KINKS, parameters, given, far)[0], dtype=np.float64)
    return SlopeFunction(
        eqs, state.t, plan.outputs, plan.inputs, plan.timed, plan.nodes, plan.switches, beside, function,
        np.array(list(state.s.values()), dtype=np.float64),
    )  # fmt: skip


class _SlopePlan(NamedTuple):
    """Equations with their derivatives, and what belongs to `SlopeFunction`, for laws of inputs."""

    wider: EquationSet
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    timed: bool
    nodes: tuple[int, ...]
    switches: tuple[Switch, ...]


def _plan_slopes(eqs: EquationSet, outputs: Sequence[str], laws: Mapping[str, Value]) -> _SlopePlan:
    shown = [eqs.roots(name) for name in outputs]
    rates_and_outputs = [*eqs.roots("xdot").nodes, *(node for roots in shown for node in roots.nodes)]
    nodes = with_laws(eqs, [*rates_and_outputs, *eqs.roots("velocity_constraints").nodes], laws)
    inputs = tuple(symbol for symbol in eqs.formed.inputs if symbol.name not in laws)
    states = (*eqs.formed.u, *eqs.formed.q, *eqs.formed.signal_states)
    between = switches(eqs, nodes)
    kinks = Roots(_KINKS, (len(between),), tuple(node for _, node in between))
    graph, every = eqs.formed.graph, (*nodes, *eqs.roots("constraints").nodes)
    return _SlopePlan(
        _with_slopes(eqs, nodes, (states, inputs), kinks),
        _scalars(shown),
        tuple(symbol.name for symbol in inputs),
        graph.symbol(TIME) in symbols_of(graph, every),
        every,
        between,
    )


def _with_slopes(
    eqs: EquationSet, nodes: Sequence[int], by: tuple[Sequence[Symbol], Sequence[Symbol]], kinks: Roots
) -> EquationSet:
    """Return the equations with the derivatives of nodes by states and by inputs."""
    states, inputs = by
    if is_large(eqs):
        return with_slopes_along(eqs, nodes, (*states, *inputs), [kinks])
    by_state = partial_derivatives(eqs, _BY_STATE, nodes, states)
    by_input = partial_derivatives(eqs, _BY_INPUT, nodes, inputs)
    return with_outputs(eqs, [by_state, by_input, kinks])


def _far_state(eqs: EquationSet, scales: Scales, state: State) -> dict[str, list[float]]:
    """Return a state that differs by what counts as large, without symmetry; signals behind coordinates."""
    q, u = np.array(list(state.q.values())), np.array(list(state.u.values()))
    shares = np.cos(np.arange(1.0, 1.0 + q.size + u.size))
    fast = scales.displacements(eqs) / scales.time
    far = q + shares[: q.size] * scales.coordinates(eqs), u + shares[q.size :] * fast
    signals = [x + (abs(x) or 1.0) * math.cos(k) for k, x in enumerate(state.s.values(), q.size + u.size + 1)]
    return {"q": [*far[0].tolist(), *signals], "u": far[1].tolist()}


def _check_finite(
    eqs: EquationSet, rates: Floats, states: Floats, loads: Floats, inputs: tuple[str, ...]
) -> None:
    """Refuse derivatives that are not finite, as that of a root where it is 0."""
    values = np.column_stack([rates, states[: rates.size], loads[: rates.size]])
    bad = np.argwhere(~np.isfinite(values))
    if not bad.size:
        return
    # Infinite ones come first: along other directions, 0 times an infinite slope is not a number.
    row, column = min(bad.tolist(), key=lambda place: (place[1] > 0, not np.isinf(values[*place])))
    names = eqs.state_names
    by = ("", *names, *inputs)[column]
    what = f"{names[row]}' has no finite {f'derivative by {by}' if by else 'value'} here"
    raise AssemblyError(
        Problem("linearize.infinite", f"state {by or names[row]}", what,
                "a force is not differentiable, such as a square root at 0, or it is infinite",
                "linearize near this state, or define the force by a smooth formula")
    )  # fmt: skip


def _laws(eqs: EquationSet, inputs: Mapping[str, Value]) -> dict[str, Value]:
    """Return the inputs that depend on states or time; values in parameters are points to deviate from."""
    graph = eqs.formed.graph
    laws = {}
    for name, node in input_law_nodes(eqs.formed, inputs).items():
        if any(graph.symbols[graph.left[s]].kind != SymbolKind.PARAMETER for s in symbols_of(graph, [node])):
            laws[name] = inputs[name]
    return laws


def _scalars(shown: Sequence[Roots]) -> tuple[str, ...]:
    names: list[str] = []
    for roots in shown:
        if not roots.shape:
            names.append(roots.name)
        else:
            places = np.ndindex(*roots.shape)
            names += [f"{roots.name}[{','.join(str(k) for k in place)}]" for place in places]
    return tuple(names)


def switches(eqs: EquationSet, nodes: Sequence[int]) -> tuple[Switch, ...]:
    """Return functions whose derivatives jump, and the nodes that are zero there."""
    first: dict[int, str] = {}
    for what, node in _switches(eqs, nodes):
        first.setdefault(node, what)
    return tuple((what, node) for node, what in first.items())


def _switches(eqs: EquationSet, nodes: Sequence[int]) -> Iterator[Switch]:
    for law in eqs.formed.friction:
        if law.switches:
            kind, name = element_words(eqs.formed, law.element)
            yield f"the friction of {kind} {name}", law.rate.index
    graph = eqs.formed.graph
    for node in _valued_nodes(graph, nodes):
        op, a, b = graph.ops[node], graph.left[node], graph.right[node]
        if op in (ABS, SIGN) and symbols_of(graph, [a]):
            yield NAMES[op], a
        elif op in (MIN, MAX, LT, LE, EQ) and symbols_of(graph, [a, b]):
            yield NAMES[op], sub(graph, a, b)


def _valued_nodes(graph: Graph, nodes: Sequence[int]) -> list[int]:
    """Return the nodes that others are computed from, without those that only conditions read."""
    seen = set(nodes)
    valued = list(seen)
    for node in valued:  # it grows meanwhile
        if graph.ops[node] not in (LT, LE, EQ):
            new = set(graph.operands(node)) - seen
            seen |= new
            valued += new
    return sorted(valued)


def nonsmooth_notes(
    eqs: EquationSet,
    listed: Sequence[Switch],
    values: NDArray[np.float64],
    beside: NDArray[np.float64],
) -> tuple[str, ...]:
    """Return notes on the derivatives at a state, where switches have `values`.

    `beside` are their values at a state as far away as the mechanism is large.
    """
    changes = np.abs(np.asarray(beside) - values)
    is_zero = np.abs(values) <= ASSEMBLED * np.where(np.isfinite(changes), changes, 1.0)
    here = [switch for switch, yes in zip(listed, is_zero, strict=True) if yes]
    return tuple(
        f"{what} switches at this state, where {_text(eqs.formed.graph, node)} = 0: the matrices are valid "
        f"on one side of it at most; a smooth law, such as friction with v0, is valid on both"
        for what, node in here
    )


def _text(graph: Graph, node: int) -> str:
    """Return a formula, as far as it can be read."""
    try:
        text = to_text(graph, node)
    except ExpressionError:
        return "a long formula"
    return text if len(text) <= _READABLE else f"{text[:_READABLE]} ..."
