"""`FormulaValues`: formulas in parameters as numbers, for one set of values after the other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import input_places
from symbody.codegen.signature import Signature
from symbody.equations.equation_set import EquationSet
from symbody.expr.graph import TIME
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Roots, Sequence, build_sequence
from symbody.model.numbers import as_float


class FormulaValues:
    """Formulas in parameters and t; ``numbers(values)`` gives their values at t = 0.

    Parameters
    ----------
    formulas : iterable of number or formula

    timed : bool
        Whether they may read t.

    Raises
    ------
    CompileError, ExpressionError
        If a formula reads something else than parameters and time.
    """

    def __init__(self, eqs: EquationSet, formulas: Iterable[Value], *, timed: bool = False) -> None:
        self._formulas = [Formula.from_value(value) for value in formulas]
        plain = [formula.constant() for formula in self._formulas]
        self._numbers = [0.0 if number is None else as_float(number) for number in plain]
        self._places = [k for k, number in enumerate(plain) if number is None]
        self._read: tuple[str, ...] = ()
        self._sequence: Sequence | None = None
        if self._places:
            graph, names = eqs.formed.graph, eqs.formed.names
            nodes = tuple(
                names.expression(self._formulas[k], self._formulas[k].text).index for k in self._places
            )
            read = symbols_of(graph, nodes)
            names_read = {graph.symbols[graph.left[node]].name for node in read}
            self._read = tuple(name for name in eqs.model.parameters if name in names_read)
            places = input_places(eqs, Signature((), (), (), self._read), graph)
            if not timed:
                del places[graph.symbol(TIME)]
            self._sequence = build_sequence(graph, [Roots("values", (len(nodes),), nodes)], places)
            if not self._read:
                self._numbers, self._sequence = self.numbers({}), None

    def numbers(self, values: Mapping[str, float]) -> list[float]:
        """Return the value of each formula, with those of all parameters."""
        if self._sequence is None:
            return self._numbers
        given = {"t": [0.0], "p": [values.get(name, math.nan) for name in self._read]}
        result = list(self._numbers)
        for k, value in zip(self._places, evaluate_sequence(self._sequence, given)[0], strict=True):
            result[k] = float(value)
        return result
