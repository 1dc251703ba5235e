"""`bound_function`: compiled outputs with values of parameters and inputs, whose code serves all values."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from symbody.codegen.formation.names import Value, unknown_name
from symbody.codegen.formation.parameter_set import ParameterSet, parameter_set
from symbody.codegen.formation.sequences import form_sequence, outputs_sequence
from symbody.codegen.function import CompiledFunction, Signature
from symbody.codegen.shared_code import SharedCode
from symbody.codegen.stored_sequence import read_sequence, sequence_key, store_sequence
from symbody.equations.cache_key import store_notes
from symbody.equations.equation_set import EquationSet
from symbody.errors import CompileError, ExpressionError
from symbody.expr.graph import Graph
from symbody.expr.language.formula import Formula
from symbody.expr.sequence import Sequence
from symbody.model.arguments import plain_value
from symbody.model.content import content_bytes
from symbody.model.numbers import as_float

Choices = tuple[bool, bool | None]
_SharedSequence = tuple[SharedCode, Signature]


def bound_function(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    parameters: Mapping[str, Value] | None = None,
    free: Iterable[str] = (),
    inputs: Mapping[str, Value] | None = None,
    *,
    quick: bool = False,
    lanes: bool | None = None,
) -> CompiledFunction:
    """Return a compiled function of `outputs`; other values of parameters and inputs share its code.

    `inputs` are numbers, or expressions in time, states and parameters; those not named stay arguments.

    Raises
    ------
    CompileError, ExpressionError, FormulationError
        If names are unknown, parameters have no value, or values are impossible.
    """
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    chosen = parameter_set(eqs, parameters, tuple(free))
    formulas, numbers = _split_inputs(eqs, inputs or {})
    key = names, tuple(formulas.items()), tuple(numbers.items()), quick, lanes
    request = _Request(chosen, names, formulas, numbers, (quick, lanes))
    return chosen.functions.get(key, request.function)


class _Request:
    """Outputs of equations with values, and how they are to be compiled."""

    __slots__ = ("_choices", "_chosen", "_formulas", "_numbers", "_outputs")

    def __init__(
        self,
        chosen: ParameterSet,
        outputs: tuple[str, ...],
        formulas: Mapping[str, Value],
        numbers: Mapping[str, float],
        choices: Choices,
    ) -> None:
        self._chosen = chosen
        self._outputs = outputs
        self._formulas = formulas
        self._numbers = numbers
        self._choices = choices

    def function(self) -> CompiledFunction:
        """Return the function.

        Where numbers have no finite values in the code for all of them, as a quotient of two that are 0, the
        function has code of its own, in which such formulas are simplified.
        """
        chosen = self._chosen
        try:
            code, signature = self._shared_sequence()
        except ExpressionError:
            return self._specialized_function()
        hidden = signature.p[len(chosen.free) :]
        known = {**chosen.values, **self._numbers}
        values = np.array([as_float(known[name]) for name in hidden], dtype=np.float64)
        function = CompiledFunction.from_code(
            code, replace(signature, p=chosen.free), values, self._specialized_sequence
        )
        if not chosen.free and not np.isfinite(function.bound_constants).all():
            return self._specialized_function()
        return function

    def _shared_sequence(self) -> _SharedSequence:
        """Return the code for all values of this kind, and its arguments."""
        chosen, plans = self._chosen, self._chosen.original.plans
        asked = self._outputs, tuple(self._formulas.items()), tuple(self._numbers), self._choices
        key: Hashable
        if not chosen.original.are_formed:  # an earlier process may have put the sequence on the disk
            key = "code as stored", self._choices, self._stored_key()
            stored: _SharedSequence | None = plans.peek(key)
            if stored is None and (read := read_sequence(self._stored_key())) is not None:
                stored = plans.get(key, lambda: self._compile(*read))
            if stored is not None:
                return stored
        key = "code", *asked, chosen.pattern
        shared: _SharedSequence = plans.get(key, lambda: self._compile(*self._form_sequence()))
        return shared

    def _compile(self, sequence: Sequence, signature: Signature) -> _SharedSequence:
        quick, lanes = self._choices
        return SharedCode(sequence, quick=quick, lanes=lanes), signature

    def _form_sequence(self) -> tuple[Sequence, Signature]:
        chosen, key = self._chosen, self._stored_key()
        known = read_sequence(key)
        if known is None:
            replacements = chosen.replacements()
            graph = Graph() if replacements or self._formulas else chosen.eqs.formed.graph
            arguments = (*chosen.free, *chosen.numbers, *(name for name, x in self._numbers.items() if x))
            silent: dict[str, Value] = {name: 0 for name, x in self._numbers.items() if not x}
            known = outputs_sequence(
                chosen.eqs, self._outputs, replacements, arguments, {**self._formulas, **silent}, graph
            )
            if store_sequence(key, *known):
                store_notes(chosen.original.identity, chosen.original.notes)
        return known

    def _stored_key(self) -> bytes:
        """Return the key of the sequence on the disk: that of these values, which need not be looked at."""
        chosen, identity = self._chosen, self._chosen.original.identity
        if not identity:
            return b""
        inputs = dict(self._formulas), {name: str(x) for name, x in self._numbers.items()}
        return sequence_key(
            identity, content_bytes("arguments", self._outputs, dict(chosen.given), chosen.free, *inputs)
        )

    def _specialized_sequence(self) -> Sequence:
        return self._form_specialized()[0]

    def _form_specialized(self) -> tuple[Sequence, Signature]:
        chosen = self._chosen
        inputs: dict[str, Value] = {**self._formulas, **self._numbers}
        return form_sequence(chosen.original, self._outputs, chosen.given, chosen.free, inputs)

    def _specialized_function(self) -> CompiledFunction:
        quick, lanes = self._choices
        return CompiledFunction(*self._form_specialized(), quick=quick, lanes=lanes)


def _split_inputs(
    eqs: EquationSet, inputs: Mapping[str, Value]
) -> tuple[dict[str, Formula], dict[str, float]]:
    """Return inputs that are formulas, and those that are numbers."""
    if not inputs:
        return {}, {}
    problems = [unknown_name("input", x, eqs.input_names) for x in inputs if x not in eqs.input_names]
    if problems:
        raise CompileError(*problems)
    formulas, numbers = {}, {}
    for name, value in inputs.items():
        formula = Formula.from_value(plain_value(value), where=f"input {name}")
        number = formula.constant()
        if number is None:
            formulas[name] = formula
        else:
            numbers[name] = as_float(number)
    return formulas, numbers
