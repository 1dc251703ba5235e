"""`bound_function`: compiled outputs with values of parameters and inputs, whose code serves all values."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping
from collections.abc import Sequence as Items
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value, unknown_name
from symbody.codegen.formation.parameter_set import ParameterSet, parameter_set
from symbody.codegen.formation.sequences import form_sequence, outputs_sequence
from symbody.codegen.function import CompiledFunction
from symbody.codegen.shared_code import SharedCode
from symbody.codegen.signature import Signature
from symbody.codegen.stored_sequence import read_sequence, sequence_key, store_sequence
from symbody.collection import without_collection
from symbody.equations.cache_key import store_notes
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.input_formulas import input_formula
from symbody.errors import CompileError, ExpressionError
from symbody.expr.graph import Graph
from symbody.expr.language.formula import Formula
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Sequence
from symbody.model.content import content_bytes
from symbody.model.declarations.arguments import plain_value
from symbody.model.numbers import as_float

Floats = NDArray[np.float64]
Choices = tuple[bool, bool | None]
_Formed = tuple[Sequence, Signature]


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
    choices = quick, lanes
    request = _request(eqs, outputs, parameters, tuple(free), inputs)
    key = choices, *request.key
    return request.chosen.functions.get(key, lambda: request.function(choices))


def evaluate_once(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value],
    point: Mapping[str, Items[float]],
) -> list[list[float]]:
    """Return the values of outputs at a point, row-major, without compiling for it.

    Parameters
    ----------
    point : mapping of group to numbers
        t, q, u and r, the inputs that `inputs` does not name.

    Raises
    ------
    CompileError, ExpressionError, FormulationError
        As `bound_function`.
    """
    request = _request(eqs, outputs, parameters, (), inputs)
    try:
        sequence, signature = request.shared_sequence(request.sequence_key())
    except ExpressionError:
        return evaluate_sequence(request.specialized_sequence(), point)
    values = request.values(signature.p).tolist()
    return evaluate_sequence(sequence, {**point, "p": values})


def _request(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    parameters: Mapping[str, Value] | None,
    free: tuple[str, ...],
    inputs: Mapping[str, Value] | None,
) -> _Request:
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    chosen = parameter_set(eqs, parameters, free)
    chosen.require_possible()
    return _Request(chosen, names, *_split_inputs(eqs, inputs or {}))


class _Code(NamedTuple):
    """Code for all values of some parameters, what functions of it take, and the arguments they keep."""

    code: SharedCode
    signature: Signature
    names: tuple[str, ...]


class _Request:
    """Outputs of equations with values, and how they are to be compiled."""

    __slots__ = ("_formulas", "_numbers", "_outputs", "chosen")

    def __init__(
        self,
        chosen: ParameterSet,
        outputs: tuple[str, ...],
        formulas: Mapping[str, Value],
        numbers: Mapping[str, float],
    ) -> None:
        self.chosen = chosen
        self._outputs = outputs
        self._formulas = formulas
        self._numbers = numbers

    @property
    def key(self) -> tuple[Hashable, ...]:
        """What tells this from other requests with the same parameters."""
        return self._outputs, tuple(self._formulas.items()), tuple(self._numbers.items())

    def function(self, choices: Choices) -> CompiledFunction:
        """Return the function.

        Where numbers have no finite values in the code for all of them, as a quotient of two that are 0, the
        function has code of its own, in which such formulas are simplified.
        """
        chosen = self.chosen
        key = self.sequence_key()
        try:
            made: _Code = chosen.original.plans.get(("code", choices, *key), lambda: self._code(key, choices))
        except ExpressionError:
            return self._specialized_function(choices)
        code, signature, names = made
        values = self.values(names)
        constants = None if chosen.free else code.constants(values)
        if constants is not None and _is_without_value(code, constants):
            return self._specialized_function(choices)
        return CompiledFunction.from_code(code, signature, values, self.specialized_sequence, constants)

    @without_collection()
    def _code(self, key: Items[Hashable], choices: Choices) -> _Code:
        sequence, signature = self.shared_sequence(key)
        quick, lanes = choices
        code = SharedCode(sequence, quick=quick, lanes=lanes)
        free = self.chosen.free
        return _Code(code, replace(signature, p=free), signature.p[len(free) :])

    def values(self, names: Items[str]) -> Floats:
        """Return the values of arguments p that are not free."""
        floats, numbers = self.chosen.floats, self._numbers
        return np.array([numbers[name] if name in numbers else floats[name] for name in names])

    def shared_sequence(self, key: Items[Hashable]) -> _Formed:
        """Return the sequence for all values of this kind, and its arguments; `key` is `sequence_key`."""
        formed: _Formed = self.chosen.original.plans.get(tuple(key), self._form_sequence)
        return formed

    def sequence_key(self) -> tuple[Hashable, ...]:
        """Return what the sequence depends on."""
        chosen = self.chosen
        if not chosen.original.are_formed:  # an earlier process may have put the sequence on the disk
            key = "stored sequence", self._stored_key()
            plans = chosen.original.plans
            if plans.peek(key) is not None:
                return key
            read = read_sequence(self._stored_key())
            if read is not None:
                plans.get(key, lambda: read)
                return key
        numbers = tuple((name, x == 0.0) for name, x in self._numbers.items())
        return "sequence", self._outputs, tuple(self._formulas.items()), numbers, chosen.pattern

    def _form_sequence(self) -> _Formed:
        chosen, key = self.chosen, self._stored_key()
        formed = read_sequence(key)
        if formed is None:
            replacements = chosen.replacements()
            graph = Graph() if replacements or self._formulas else chosen.eqs.formed.graph
            arguments = (*chosen.free, *chosen.numbers, *(name for name, x in self._numbers.items() if x))
            silent: dict[str, Value] = {name: 0 for name, x in self._numbers.items() if not x}
            formed = outputs_sequence(
                chosen.eqs, self._outputs, replacements, arguments, {**self._formulas, **silent}, graph
            )
            if store_sequence(key, *formed):
                store_notes(chosen.original.identity, chosen.original.notes)
        return formed

    def _stored_key(self) -> bytes:
        """Return the key of the sequence on the disk: that of these values, which need not be looked at."""
        chosen, identity = self.chosen, self.chosen.original.identity
        if not identity:
            return b""
        inputs = dict(self._formulas), {name: str(x) for name, x in self._numbers.items()}
        return sequence_key(
            identity, content_bytes("arguments", self._outputs, dict(chosen.given), chosen.free, *inputs)
        )

    def specialized_sequence(self) -> Sequence:
        """Return the sequence with all values put in."""
        return self._form_specialized()[0]

    def _form_specialized(self) -> _Formed:
        chosen = self.chosen
        inputs: dict[str, Value] = {**self._formulas, **self._numbers}
        return form_sequence(chosen.original, self._outputs, chosen.given, chosen.free, inputs)

    def _specialized_function(self, choices: Choices) -> CompiledFunction:
        quick, lanes = choices
        return CompiledFunction(*self._form_specialized(), quick=quick, lanes=lanes)


def _is_without_value(code: SharedCode, constants: Floats) -> bool:
    """Return whether the code divides by 0 with these constants, before it is called or then."""
    if np.count_nonzero(np.isfinite(constants)) < constants.size:
        return True
    return bool(np.count_nonzero(constants.take(code.divisors)) < code.divisors.size)


def _split_inputs(
    eqs: EquationSet, inputs: Mapping[str, Value]
) -> tuple[dict[str, Formula], dict[str, float]]:
    """Return inputs that are formulas, and those that are numbers."""
    if not inputs:
        return {}, {}
    problems = [unknown_name("input", x, eqs.input_names) for x in inputs if x not in eqs.input_names]
    if problems:
        raise CompileError(*problems)
    formulas: dict[str, Formula] = {}
    numbers: dict[str, float] = {}
    for name, value in inputs.items():
        if type(value) is int or (type(value) is float and math.isfinite(value)):
            numbers[name] = float(value)
            continue
        formula = input_formula(plain_value(value), name)
        number = formula.constant()
        if number is None:
            formulas[name] = formula
        else:
            numbers[name] = as_float(number)
    return formulas, numbers
