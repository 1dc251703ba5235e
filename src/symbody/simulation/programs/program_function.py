"""`ProgramFunction`: a function of a program as kernels, with the numbers that it takes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.kernels.sequence_kernel import sequence_kernels
from symbody.codegen.kernels.tree import KernelTree
from symbody.equations.equation_set import EquationSet
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Output, Sequence
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.description import Floats, RightHandSide
from symbody.simulation.programs.motion_request import PosedMotion

RIGHT_HAND_SIDE: Final = "right_hand_side"
PROJECTION: Final = "projection"
# What implicit methods call, too: rates of coordinates, and derivatives of all rates by states.
TURN: Final = "coordinate_rates"
DERIVATIVES: Final = "rate_derivatives"
_NOWHERE: Final = 1  # the address of a function that lies nowhere yet


@dataclass(frozen=True, slots=True, eq=False)
class ProgramFunction:
    """A function of a program as kernels, with the numbers that it takes.

    Attributes
    ----------
    kernels : mapping of name to KernelTree
        The function, what computes its numbers c from parameters that may change, and those that they call.
    outputs : tuple of Output
    numbers : RightHandSide
        Inputs, parameters that may change, and c at their first values.
    values : str
        Name of the kernel that computes c, empty where none does.
    values_size : int
        Doubles of scratch that it needs.
    sequence : Sequence
        What is computed.
    """

    kernels: Mapping[str, KernelTree]
    outputs: tuple[Output, ...]
    numbers: RightHandSide
    values: str
    values_size: int
    sequence: Sequence

    @property
    def address(self) -> int:
        """A place that is not 0."""
        return _NOWHERE

    @property
    def work_size(self) -> int:
        """Doubles of scratch that it needs."""
        return self.numbers.work_size

    @property
    def sizes(self) -> tuple[int, ...]:
        """How many numbers each output has."""
        return tuple(len(output.values) for output in self.outputs)

    @property
    def size(self) -> int:
        """How many numbers it computes."""
        return sum(self.sizes)

    @property
    def array(self) -> Floats:
        """The numbers of a call, as a block holds them."""
        return function_numbers(self.numbers)

    def constants(self) -> Floats:
        """Return the numbers c."""
        return self.numbers.constants


def program_function(
    motion: PosedMotion, outputs: Iterable[str], name: str, closing: EquationSet | None = None
) -> ProgramFunction:
    """Return a function of a motion, whose parameters are numbers unless they may change.

    Its equations are those of the motion, or those in which its states are closed.
    """
    eqs = motion.eqs if closing is None else closing
    return make_function(
        eqs, outputs, name, motion.fixed_values, motion.tunable,
        np.array(motion.tunable_values, dtype=np.float64), len(motion.input_names), motion.formulas,
    )  # fmt: skip


def make_function(
    eqs: EquationSet, outputs: Iterable[str], name: str, parameters: Mapping[str, Value],
    tunable: tuple[str, ...], values: Floats, input_count: int, formulas: Mapping[str, Value] | None = None,
    freeze: Callable[[Sequence], Sequence] | None = None,
) -> ProgramFunction:  # fmt: skip
    """Return a function of outputs.

    Parameters
    ----------
    parameters : mapping
        What is given for parameters that are no arguments.
    tunable : tuple of str
        Parameters that are arguments.
    values : (n,) array
        Their first values, and those of what follows them in p.
    input_count : int
        How many inputs are arguments.
    formulas : mapping, optional
        Laws of other inputs.
    freeze : callable, optional
        Makes of a sequence what is written; which arguments results depend on is asked before.
    """
    sequence, _ = form_sequence(eqs, tuple(outputs), parameters, tunable, formulas or {})
    sequence = fold_constants(written_out(sequence))
    head, tail = (sequence if freeze is None else freeze(sequence)).split("p")
    kernels, work_size = sequence_kernels(tail, name)
    values_name, values_size, constants = "", 0, np.zeros(0)
    if head.output_size:
        values_name = f"{name}_values"
        more, values_size = sequence_kernels(head, values_name)
        kernels = {**kernels, **more}
        parts = evaluate_sequence(head, {"p": values.tolist()})
        constants = np.concatenate([np.ravel(np.asarray(part, dtype=np.float64)) for part in parts])
    numbers = RightHandSide(
        _NOWHERE, len(eqs.speed_names), np.zeros(input_count), values, constants, work_size
    )
    return ProgramFunction(kernels, sequence.outputs, numbers, values_name, values_size, sequence)
