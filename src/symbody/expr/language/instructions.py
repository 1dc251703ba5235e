"""The postfix form of an expression: its instructions, and the operations they name."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.expr.graph import Constant


class Instruction(NamedTuple):
    """One step of a stack machine.

    Attributes
    ----------
    kind : str
        ``"number"``, ``"name"`` and ``"output"`` push a value; ``"apply"`` takes `arity` values off
        the stack, first operand deepest, and pushes one.
    payload : int, Fraction, float or str
        The number, the name, the name of the output, or the name of the operation.
    column : int
        Where it stands in the text, counted from 1.
    arity : int
        Number of operands, 0 unless `kind` is ``"apply"``.
    """

    kind: str
    payload: Constant | str
    column: int
    arity: int = 0


# Operations whose result, and whose operands, are conditions. Besides, ``if`` takes one first.
COMPARISONS: Final = frozenset({"lt", "le", "gt", "ge", "eq", "ne"})
CONNECTIVES: Final = frozenset({"and", "or", "not"})

_MANY: Final = 20_000

# Function -> least and greatest number of arguments.
FUNCTIONS: Final = MappingProxyType(
    {
        **dict.fromkeys(
            ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "abs")
            + ("sign", "floor"),
            (1, 1),
        ),
        "atan2": (2, 2),
        "mod": (2, 2),
        "smoothstep": (3, 3),
        "if": (3, 3),
        "min": (2, _MANY),
        "max": (2, _MANY),
        "interp1": (5, _MANY),
    }
)
# Functions of any number of arguments that are applied to pairs.
FOLDED: Final = frozenset({"min", "max"})
