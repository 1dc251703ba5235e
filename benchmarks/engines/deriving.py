"""Derivation of a mechanism's equations step by step, by symbody and by sympy.physics.mechanics.

Seconds are those of the processor: other work on it counts little.
"""

from __future__ import annotations

import gc
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from time import process_time
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import sympy
import sympy.physics.mechanics as me
from sympy.core.cache import clear_cache

import symbody as sb
from benchmarks.engines.counting import count_operations
from benchmarks.mechanisms import Mechanism
from benchmarks.process import Floats, Step, Task
from symbody.codegen.formation.sequences import form_sequence
from symbody.expr.sequences.evaluate import evaluate_sequence

# What an engine is asked: to derive and count, to compute accelerations, to compile.
DERIVE: Final = "derive"
VALUES: Final = "values"
COMPILE: Final = "compile"

_POINTS: Final = 3


class Ours:
    """Derives with symbody, to symbolic accelerations."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._formed: list[sb.EquationSet] = []
        sb.form_equations(mechanism.model())  # loads what is loaded on first use

    def __call__(self, word: str) -> Iterator[Step]:
        """Yield each step when it is done."""
        if word == DERIVE:
            yield from self._derive()
        elif word == COMPILE:
            start = process_time()
            sb.compile(self._formed[-1], "udot")
            yield Step("compile", process_time() - start)
        else:
            yield Step("values", values=np.array([self._accelerations(k) for k in range(_POINTS)]))

    def _derive(self) -> Iterator[Step]:
        self._formed.clear()
        gc.collect()
        start = process_time()
        eqs = sb.form_equations(self._mechanism.model())
        eqs.roots("udot")
        yield Step("form", process_time() - start)
        start = process_time()
        udot = form_sequence(eqs, "udot", free=eqs.parameter_names)[0].operation_count
        yield Step("count", process_time() - start)
        both = form_sequence(eqs, ("mass_matrix", "forcing"), free=eqs.parameter_names)[0].operation_count
        yield Step("M and F", both)
        yield Step("udot", udot)
        self._formed.append(eqs)

    def _accelerations(self, number: int) -> list[float]:
        eqs = self._formed[-1]
        sequence, names = form_sequence(eqs, "udot", free=eqs.parameter_names)
        value = partial(_value, number)
        groups = {group: [value(name) for name in names.names(group)] for group in "qurp"}
        found = evaluate_sequence(sequence, {"t": [0.0]} | groups)[0]
        return [float(found[k]) for k in _order(eqs.coordinate_names)]


class Kane:
    """Derives with KanesMethod, to mass matrix and forcing, and shares subexpressions by `cse`."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._found: list[tuple[list[str], Any, Any]] = []

    def __call__(self, word: str) -> Iterator[Step]:
        """Yield each step when it is done."""
        if word == DERIVE:
            yield from self._derive()
        elif word == VALUES:
            yield Step("values", values=np.array([self._accelerations(k) for k in range(_POINTS)]))

    def _derive(self) -> Iterator[Step]:
        clear_cache()
        self._found.clear()
        gc.collect()
        start = process_time()
        kane = self._mechanism.kane()
        M, F = kane.mass_matrix, kane.forcing
        yield Step("form", process_time() - start)
        start = process_time()
        shared, reduced = sympy.cse([*M, *F])
        yield Step("count", process_time() - start)
        reduced = [sympy.S(x) for x in reduced]
        yield Step("M and F", count_operations([*(value for _, value in shared), *reduced]))
        self._found.append(([str(x.func) for x in kane.q], shared, reduced))

    def _accelerations(self, number: int) -> Floats:
        names, shared, reduced = self._found[-1]
        n = len(names)
        formulas = [*(value for _, value in shared), *reduced]
        constants = set[Any]().union(*(formula.free_symbols for formula in formulas))
        constants -= {name for name, _ in shared} | {me.dynamicsymbols._t}
        moving = set[Any]().union(*map(me.find_dynamicsymbols, formulas))
        arguments = [*moving, *constants]
        function = sympy.lambdify(arguments, reduced, "math", cse=lambda _: (shared, reduced))
        values = np.array(function(*(_value(number, _our_name(x)) for x in arguments)))
        found: Floats = np.linalg.solve(values[: n * n].reshape(n, n), values[n * n :])
        return found[_order(names)]


def _our_name(symbol: Any) -> str:
    """Return the name that symbody has for a symbol of SymPy's side: speeds are rates there."""
    name = str(symbol.func if symbol.args else symbol)
    if name[0] != "u":
        return name
    return f"{name[2:]}_dot" if name[1] == "_" else f"q{name[1:]}_dot"


def _order(names: Sequence[str]) -> list[int]:
    """Return an order of coordinates that depends on their names alone, shorter ones first."""
    return sorted(range(len(names)), key=lambda k: (len(names[k]), names[k]))


def _value(number: int, name: str) -> float:
    """Return a value between 0.5 and 1.5, the same in every process."""
    return 0.5 + random.Random(f"{name} {number}").random()


OURS: Final = "symbody"
ENGINES: Final[Mapping[str, Callable[[Mechanism], Task]]] = MappingProxyType({OURS: Ours, "SymPy": Kane})
