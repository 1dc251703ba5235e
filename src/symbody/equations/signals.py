"""Signals on the graph: values are put in place of their names, in the order of their dependence.

Names of states stay symbols. So do, until the equations are formed, names of outputs, and of values that
depend on these; `outputs.signal_outputs` replaces them by what they stand for.
"""

from __future__ import annotations

from collections.abc import Mapping

from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.tables import tables_of_states
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol, SymbolKind
from symbody.model.checks.signals import dependence_order
from symbody.model.declarations.formula_site import Scope
from symbody.model.model import Model
from symbody.model.signals.signal import Signal

# Loads and what they read, as a path to a signal.
Path = tuple[str, ...]


def signal_symbol(name: str) -> Symbol:
    """Return the symbol of a signal."""
    return Symbol(name, SymbolKind.SIGNAL)


def substitute_values(names: Names, model: Model, outputs: Mapping[str, Expr]) -> Names:
    """Return the names with signals standing for their values.

    Parameters
    ----------
    outputs : mapping of signal to Expr
        Signals of outputs that are known; those that depend on others stay symbols.
    """
    names = names.with_values(tables_of_states(names, model))
    if not model.signals:
        return names
    names = names.with_values(outputs)
    unknown = {s.name for s in model.signals if s.output is not None and s.name not in outputs}
    for signal in _values_in_order(model):
        formula = signal.value
        assert formula is not None
        if unknown.isdisjoint(formula.names):
            where = f"signal {signal.name}, value"
            names = names.with_values({signal.name: names.expression(formula, where)})
        else:
            unknown.add(signal.name)
    return names


def signals_of_loads(model: Model) -> list[str]:
    """Return the signals that loads read themselves, in the order in which they are read."""
    signals = {signal.name for signal in model.signals}
    loads = [element for element in model.elements if element.kind not in ("signal", "block")]
    read = [
        name
        for element in loads
        for site in element.formula_sites()
        if site.scope is Scope.LOAD
        for name in site.formula.names
    ]
    read += [signal.name for element in loads for signal in element.signals]  # of bristles
    return [name for name in dict.fromkeys(read) if name in signals]


def outputs_of_loads(model: Model) -> dict[str, Path]:
    """Return the signals of outputs that loads read, directly or through values, each with the way."""
    signals = {signal.name: signal for signal in model.signals}
    waiting: list[tuple[str, Path]] = [
        (name, (f"{element.kind} {element.name}",))
        for element in model.elements
        if element.kind not in ("signal", "block")
        for site in element.formula_sites()
        if site.scope is Scope.LOAD
        for name in site.formula.names
        if name in signals
    ]
    ways: dict[str, Path] = {}
    while waiting:
        name, way = waiting.pop(0)
        signal = signals[name]
        if name not in ways and not signal.is_state:
            ways[name] = (*way, name)
            read = () if signal.value is None else signal.value.names
            waiting += [(other, ways[name]) for other in read if other in signals]
    return {name: way for name, way in ways.items() if signals[name].output is not None}


def _values_in_order(model: Model) -> list[Signal]:
    values = {signal.name: signal for signal in model.signals if signal.value is not None}
    needed = {
        name: [word for word in signal.value.names if word in values]
        for name, signal in values.items()
        if signal.value is not None
    }
    return [values[name] for name in dependence_order(needed)]
