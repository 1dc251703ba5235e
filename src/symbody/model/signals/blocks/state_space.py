"""`StateSpace`: a linear block given by matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import list_of, optional
from symbody.model.declarations.fields import Formulas, OptionalQuantity, Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import SAMPLE_TIME
from symbody.model.signals.block import FormulaRows, Rows, SignalBlock, block, in_brackets
from symbody.model.signals.signal import Signal


@final
@block
class StateSpace(SignalBlock):
    """A linear block ``x' = A x + B u``, ``y = C x + D u`` with any numbers of inputs and outputs.

    Sampled, ``A x + B u`` is the state at the next sample. Its output bears its name; several outputs are
    ``name_1``, ``name_2``, and so on.

    Examples
    --------
    >>> import symbody as sb
    >>> filter = sb.StateSpace("y", ["F"], A=[[0, 1], [-4, -0.4]], B=[[0], [1]], C=[[1, 0]])
    >>> [signal.name for signal in filter.signals]
    ['y_x1', 'y_x2', 'y']
    """

    equation: ClassVar[str] = "x' = A x + B u, y = C x + D u; if sampled, A x + B u is the next x"
    states: ClassVar[str] = "`y_x1`, `y_x2`, .."

    inputs: Formulas = list_of(Quantity("The inputs u.", scope=Scope.LOAD))
    A: FormulaRows = list_of(list_of(Quantity("(n, n), row by row.")))
    B: FormulaRows = list_of(list_of(Quantity("(n, inputs), row by row.")))
    C: FormulaRows = list_of(list_of(Quantity("(outputs, n), row by row.")))
    D: FormulaRows = list_of(list_of(Quantity("(outputs, inputs), row by row; by default 0.")), default=())
    initial: Formulas = list_of(Quantity("Initial states, by default 0."), default=())
    sample: OptionalQuantity = optional(
        Quantity(
            "Time between samples; x' is then the next x, without it the rate of x.",
            unit="s",
            fits=SAMPLE_TIME,
        )
    )

    def check(self, arguments: Arguments) -> None:
        """Note matrices that do not fit each other."""
        SignalBlock.check(self, arguments)
        n, m, p = len(self.A), len(self.inputs), len(self.C)
        for name, rows, height, width in (
            ("A", self.A, n, n), ("B", self.B, n, m), ("C", self.C, p, n), ("D", self.D or ((),) * p, p, m),
        ):  # fmt: skip
            fits = len(rows) == height and all(len(row) == width for row in rows)
            if not fits and not (name == "D" and not self.D):
                why = f"A is {n} by {n}, and there are {m} inputs and {p} outputs"
                cure = f"give {height} rows of {width}"
                arguments.add("block.matrix", name, f"{name} is not {height} by {width}", why, cure)
        if self.initial and len(self.initial) != n:
            what = f"there are {len(self.initial)} initial values"
            arguments.add("block.matrix", "initial", what, f"there are {n} states", f"give {n}")

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The states, and the outputs."""
        states = [f"{self.name}_x{k + 1}" for k in range(len(self.A))]
        given = [in_brackets(formula) for formula in self.inputs]
        starts: Sequence[Formula | int] = self.initial or (0,) * len(states)
        rates = [_row_sum(a, states, b, given) for a, b in zip(self.A, self.B, strict=True)]
        direct: Rows = self.D or ((),) * len(self.C)
        values = [_row_sum(c, states, d, given if d else ()) for c, d in zip(self.C, direct, strict=True)]
        alone = len(values) == 1
        names = [self.name if alone else f"{self.name}_{k + 1}" for k in range(len(values))]
        pairs = zip(names, values, strict=True)
        outputs = [Signal(name, value, sample=self.sample) for name, value in pairs]
        if self.sample is None:
            rows = zip(states, rates, starts, strict=True)
            return (*(Signal(x, rate=rate, initial=x0) for x, rate, x0 in rows), *outputs)
        following = [f"{self.name}_next{k + 1}" for k in range(len(states))]
        nexts = zip(following, rates, strict=True)
        computed = [Signal(x, rate, sample=self.sample) for x, rate in nexts]
        moves = zip(states, following, starts, strict=True)
        moved = [Signal(x, value, initial=x0, sample=self.sample) for x, value, x0 in moves]
        return (*outputs, *computed, *moved)

    @property
    def continuous(self) -> None:
        """None: give the matrices of the continuous block."""
        return


def _row_sum(
    first: Sequence[Formula], states: Sequence[str], second: Sequence[Formula], given: Sequence[str]
) -> str:
    """Return a row of ``first x + second u``."""
    factors = [*zip(first, states, strict=True), *zip(second, given, strict=True)]
    terms = [f"{in_brackets(factor)}*{x}" for factor, x in factors if factor.constant() != 0]
    return " + ".join(terms) or "0"
