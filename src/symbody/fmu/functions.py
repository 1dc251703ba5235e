"""Functions of a mechanism as C, with the numbers that they are called with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.texts.c import function_text
from symbody.equations.equation_set import EquationSet
from symbody.expr import opcodes as op
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Output, Sequence
from symbody.fmu.freezing import Branches
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.description import RightHandSide

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ModelFunction:
    """A function of time, state, inputs and parameters.

    Attributes
    ----------
    name : str
        Of the function in C.
    text : str
        It, and ``<name>_values``, which computes what depends on parameters alone.
    sequence : Sequence
        What is computed, with the branches that are taken live.
    numbers : RightHandSide
        Sizes and first values of its numbers.
    values_work : int
        Doubles of scratch of ``<name>_values``; 0 where nothing depends on parameters alone.
    sizes : tuple of int
        Of the outputs.
    """

    name: str
    text: str
    sequence: Sequence
    numbers: RightHandSide
    values_work: int
    sizes: tuple[int, ...]

    @property
    def array(self) -> Floats:
        """The numbers of a call, as a block holds them."""
        return function_numbers(self.numbers)

    @property
    def address(self) -> int:
        """A place that is not 0."""
        return self.numbers.address

    @property
    def work_size(self) -> int:
        """Doubles of scratch that it needs."""
        return self.numbers.work_size

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it computes."""
        return self.sequence.outputs

    def constants(self) -> Floats:
        """Return the numbers c that it takes."""
        return self.numbers.constants

    @property
    def size(self) -> int:
        """How many numbers it computes."""
        return sum(self.sizes)


def make_function(
    eqs: EquationSet,
    name: str,
    outputs: Iterable[str],
    parameters: Mapping[str, Value],
    tunable: tuple[str, ...],
    values: Floats,
    branches: Branches | None = None,
) -> ModelFunction:
    """Return a function of outputs.

    Parameters
    ----------
    parameters : mapping
        What is given for parameters that are no arguments.
    tunable : tuple of str
        Parameters that are arguments.
    values : (n,) array
        Their first values, and those of what follows them in p.
    branches : Branches, optional
        Branches that are arguments.
    """
    sequence, _ = form_sequence(eqs, tuple(outputs), parameters, tunable)
    sequence = fold_constants(written_out(sequence))
    head, tail = (sequence if branches is None else branches.freeze(sequence)).split("p")
    text, work = function_text(tail, name)
    values_work = 0
    if head.output_size:
        more, values_work = function_text(head, f"{name}_values")
        text += more
    n_u = len(eqs.speed_names)
    constants = np.zeros(head.output_size)
    arguments = RightHandSide(1, n_u, np.zeros(len(eqs.input_names)), values, constants, work)
    sizes = tuple(len(output.values) for output in sequence.outputs)
    return ModelFunction(name, text, sequence, arguments, max(values_work, int(head.output_size > 0)), sizes)


def are_symbols(sequence: Sequence) -> tuple[bool, ...]:
    """Return whether each result is an argument itself."""
    return tuple(sequence.operations[k].op == op.SYMBOL for output in sequence.outputs for k in output.values)
