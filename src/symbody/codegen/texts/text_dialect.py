"""How a language writes numbers, entries of arrays and operations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass
from typing import Final

from symbody.expr import opcodes as op

_OPERATORS: Final = {
    op.NEG: "-{0}",
    op.ADD: "{0} + {1}",
    op.SUB: "{0} - {1}",
    op.MUL: "{0} * {1}",
    op.DIV: "{0} / {1}",
    op.LT: "{0} < {1}",
    op.LE: "{0} <= {1}",
    op.EQ: "{0} == {1}",
    op.AND: "{0} && {1}",
    op.OR: "{0} || {1}",
    op.NOT: "!{0}",
    op.FMA: "{0} * {1} + {2}",  # where a language has none
}

_FUNCTIONS: Final = {
    op.SIN: "sin",
    op.COS: "cos",
    op.TAN: "tan",
    op.ASIN: "asin",
    op.ACOS: "acos",
    op.ATAN: "atan",
    op.SINH: "sinh",
    op.COSH: "cosh",
    op.TANH: "tanh",
    op.EXP: "exp",
    op.LOG: "log",
    op.SQRT: "sqrt",
    op.ABS: "abs",
    op.SIGN: "sign",
    op.FLOOR: "floor",
}


def operation_formats(prefix: str, others: Mapping[int, str]) -> dict[int, str]:
    """Return the format of every operation, with operands ``{0}``, ``{1}``, ``{2}``.

    Parameters
    ----------
    prefix : str
        What stands before the name of a function of one number.
    others : mapping of operation code to format
        What the language writes otherwise than C's operators and functions, and what is nowhere alike.
    """
    functions = {code: f"{prefix}{name}({{0}})" for code, name in _FUNCTIONS.items()}
    return {**_OPERATORS, **functions, **others}


def number_text(value: float, form: str = "{0}") -> str:
    """Return a double as the shortest text that reads back as the same, in parentheses if negative.

    >>> number_text(-0.5)
    '(-0.5)'
    """
    text = form.format(repr(value))
    return f"({text})" if text.startswith("-") else text


def entries(word: str, indices: tuple[int, ...]) -> str:
    """Return an entry of an array in a language that counts from 1, or the number itself.

    >>> entries("M", (0, 2)), entries("E", ())
    ('M(1, 3)', 'E')
    """
    return f"{word}({', '.join(str(k + 1) for k in indices)})" if indices else word


@dataclass(frozen=True, slots=True)
class Dialect:
    """How one language writes things.

    Attributes
    ----------
    expressions : mapping of operation code to format
    assignment : str
        Format of a statement, with ``name`` and ``value``, indented.
    definition, condition : str
        The same for a new variable, and for one that holds a condition, where they are written otherwise.
    number : str
        Format of a double.
    entry : str
        Format of an entry of an ``array``, with its index ``k``.
    first : int
        Index of the first entry of an array.
    has_time_array : bool
        Whether the time comes as the entry of an array, too.
    held : str
        Format of a constant that is the operand of an operation without variables.
    is_held : bool
        Whether such a constant becomes a variable, because compilers refuse what they can compute.
    truth, is_true : str
        Formats that make a number of a condition, for the work array, and a condition of that number.
    kernel : callable, optional
        Lines that define a name as the list udot, lambda, rank: name, n, m, operands. Without it a kernel
        reads and writes the work array.
    kernel_call : str
        Format of that call, with ``n``, ``m``, indices in ``work`` where ``M``, ``J``, ``F``, ``gamma`` and
        ``solution`` begin, how many numbers lie before the ``arguments``, ``results`` and ``scratch``, and
        ``count``, the place of the kernel in the sequence from 1.
    is_interleaved : bool
        Whether each operand of a kernel is read when it is stored, and not all of them before.
    """

    expressions: Mapping[int, str]
    assignment: str
    definition: str = ""
    condition: str = ""
    number: str = "{0}"
    entry: str = "{array}[{k}]"
    first: int = 0
    has_time_array: bool = False
    held: str = "{0}"
    is_held: bool = False
    truth: str = ""
    is_true: str = ""
    kernel: Callable[[str, int, int, Items[str]], Items[str]] | None = None
    kernel_call: str = ""
    is_interleaved: bool = False

    def entry_text(self, array: str, k: int) -> str:
        """Return entry `k` of an array, counted from 0; the time is a number in most languages."""
        if array == "t" and not self.has_time_array:
            return array
        return self.entry.format(array=array, k=k + self.first)

    def define(self, name: str, value: str, *, is_condition: bool) -> str:
        """Return the statement that makes a new variable."""
        form = (self.condition if is_condition else "") or self.definition or self.assignment
        return form.format(name=name, value=value)
