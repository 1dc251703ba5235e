"""Signals that need the equations of motion: outputs, what depends on them, and the rates of states."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from graphlib import CycleError

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.signals import Path, signal_symbol, signals_of_loads
from symbody.errors import FormulationError, Problem, SymbodyError
from symbody.expr.canonical import neg
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import LEAVES
from symbody.expr.rewrite import substitute, symbols_of
from symbody.model.checks.signals import dependence_order, loop_problem
from symbody.model.signals.signal import Signal

# Takes equations and the name of an output; returns its shape and entries in u', multipliers and signals.
RawOutput = Callable[[EquationsOfMotion, str], tuple[tuple[int, ...], Sequence[Expr]]]


def signal_rates(formed: EquationsOfMotion) -> list[Expr]:
    """Return the rates of the states of signals, as symbols that `substitute_signals` replaces."""
    return list(formed.expressions([state.derivative for state in formed.signal_states]))


def substitute_signals(
    formed: EquationsOfMotion, values: Sequence[Expr], raw_output: RawOutput
) -> list[Expr]:
    """Return expressions with signals replaced by what they stand for, in u' and the multipliers.

    Raises FormulationError if signals need each other in a ring, or an output is missing or is not a number.
    """
    signals = {signal.name: signal for signal in formed.topology.model.signals}
    if not signals:
        return list(values)
    graph, states = formed.graph, frozenset(formed.signal_states)

    def open_symbols(expression: Expr) -> list[Symbol]:
        return [s for s in _symbols(expression) if s.kind is SymbolKind.SIGNAL and s not in states]

    definitions: dict[Symbol, Expr] = {}
    waiting = [symbol for value in values for symbol in open_symbols(value)]
    while waiting:
        symbol = waiting.pop()
        if symbol not in definitions:
            definitions[symbol] = _definition(formed, signals[symbol.name], raw_output)
            waiting += open_symbols(definitions[symbol])
    if not definitions:
        return list(values)
    made = _in_order(formed, definitions, {symbol: open_symbols(x) for symbol, x in definitions.items()})
    return [Expr(graph, node) for node in substitute(graph, [value.index for value in values], made)]


def signal_equations(formed: EquationsOfMotion) -> list[tuple[Symbol, Expr]]:
    """Return what the model says of signals: rates of states, values of others, each in other signals."""
    names, states = formed.readable_names, formed.signal_states
    signals = [s for s in formed.topology.model.signals if not s.is_state or signal_symbol(s.name) in states]
    own = {signal.name for signal in signals}
    plain = replace(names, values={name: x for name, x in names.values.items() if name not in own})
    equations = []
    for signal in signals:
        symbol = signal_symbol(signal.name)
        if signal.rate is not None:
            equations.append((symbol.derivative, plain.expression(signal.rate)))
        elif signal.value is not None:
            equations.append((symbol, plain.expression(signal.value)))
    return equations


def named_signals(formed: EquationsOfMotion) -> dict[int, int]:
    """Return the values of signals that loads read, as nodes, and the symbols that are shown in their place.

    A value that is a name or a number itself, or that nothing moves, stays as it is.
    """
    graph, names = formed.graph, formed.readable_names
    shown: dict[int, int] = {}
    for name in signals_of_loads(formed.topology.model):
        value = names.values.get(name)
        if value is None or graph.ops[value.index] in LEAVES or value.graph is not graph:
            continue
        leaves = symbols_of(graph, [value.index])
        if any(graph.symbols[graph.left[leaf]].kind is not SymbolKind.PARAMETER for leaf in leaves):
            symbol = graph.symbol(signal_symbol(name))
            shown.setdefault(value.index, symbol)
            shown.setdefault(neg(graph, value.index), neg(graph, symbol))
    return shown


def explicit_outputs(
    formed: EquationsOfMotion, ways: Mapping[str, Path], raw_output: RawOutput
) -> dict[str, Expr]:
    """Return signals of outputs that loads read, in t, q, u and s.

    Raises FormulationError if one needs accelerations or reactions, or if they need each other in a ring.

    Parameters
    ----------
    formed : EquationsOfMotion
        With these signals as symbols.
    ways : mapping of signal to texts
        By which loads read each.
    """
    graph = formed.graph
    signals = {signal.name: signal for signal in formed.topology.model.signals}
    definitions, needed = {}, {}
    rates = {state.derivative for state in formed.signal_states}
    for name, way in ways.items():
        entry = _definition(formed, signals[name], raw_output)
        symbols = _symbols(entry)
        if not rates.isdisjoint(symbols):
            entry = substitute_signals(formed, [entry], raw_output)[0]
            symbols = _symbols(entry)
        accelerations = {u.derivative for u in formed.u}
        if any(s in accelerations or s.kind is SymbolKind.MULTIPLIER for s in symbols):
            raise FormulationError(_algebraic_problem(signals[name], way))
        symbol = signal_symbol(name)
        definitions[symbol] = entry
        needed[symbol] = [s for s in symbols if s.name in ways and s.kind is SymbolKind.SIGNAL]
    made = _in_order(formed, definitions, needed)
    return {symbol.name: Expr(graph, made[graph.symbol(symbol)]) for symbol in definitions}


def _symbols(entry: Expr) -> list[Symbol]:
    graph = entry.graph
    return [graph.symbols[graph.left[node]] for node in symbols_of(graph, [entry.index])]


def _definition(formed: EquationsOfMotion, signal: Signal, raw_output: RawOutput) -> Expr:
    """Return what a signal stands for; of a state, its rate."""
    if signal.rate is not None:
        return formed.readable_names.expression(signal.rate, f"signal {signal.name}, rate")
    if signal.value is not None:
        return formed.readable_names.expression(signal.value, f"signal {signal.name}, value")
    where, text = f"signal {signal.name}, output", str(signal.output)
    try:
        shape, values = raw_output(_enter_output(formed, signal.name), text)
    except SymbodyError as error:
        first = error.problems[0]
        raise FormulationError(Problem(first.code, where, first.what, first.why, first.fix)) from error
    if shape:
        what = f"{text!r} is not a number: its shape is {shape}"
        why = "a signal is one number at each time"
        fix = "name one component, such as 'reaction A Fx' or 'frame r P ground ground x'"
        raise FormulationError(Problem("signal.no_number", where, what, why, fix))
    return values[0]


def _enter_output(formed: EquationsOfMotion, name: str) -> EquationsOfMotion:
    """Return the equations as the output of a signal reads them; refuse it where that is read for itself."""
    names = formed.outer_signals
    if name in names:
        ring = (*names[names.index(name) :], name)
        raise FormulationError(loop_problem(ring[::-1]))
    return replace(formed, outer_signals=(*names, name))


def _in_order(
    formed: EquationsOfMotion, definitions: Mapping[Symbol, Expr], needed: Mapping[Symbol, Sequence[Symbol]]
) -> dict[int, int]:
    """Return nodes by which to replace symbols, each with those it needs put in."""
    graph = formed.graph
    by_label = {symbol.label: symbol for symbol in definitions}
    try:
        order = dependence_order({s.label: [other.label for other in needed[s]] for s in definitions})
    except CycleError as error:
        raise FormulationError(loop_problem(error.args[1])) from error
    made: dict[int, int] = {}
    for label in order:
        symbol = by_label[label]
        made[graph.symbol(symbol)] = substitute(graph, [definitions[symbol].index], made)[0]
    return made


def _algebraic_problem(signal: Signal, way: Path) -> Problem:
    name = signal.name
    return Problem(
        "signal.algebraic", f"signal {name}, output",
        f"{signal.output!r} needs accelerations or reactions, and a load reads it: {' -> '.join(way)}",
        "accelerations and reactions follow from the loads, which would depend on them at the same instant",
        f'put a first-order filter between: [[signal]] name = "{name}_filtered", '
        f'rate = "({name} - {name}_filtered)/T", and read {name}_filtered in the load',
    )  # fmt: skip
