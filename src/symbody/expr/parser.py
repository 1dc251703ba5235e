"""Text of the expression language to formulas.

The grammar: numbers, names, ``+ - * / ^ **``, signs, ``if(condition, a, b)`` with comparisons, ``and``,
``or`` and ``not`` in the condition, and the functions of `symbody.expr.language.instructions.FUNCTIONS`.
What has no value, such as ``1/0``, is refused but in a branch that a condition of numbers alone never takes.
Names mean nothing here: whatever reads as an identifier is one, ``I``, ``lambda`` and ``max`` too.
"""

from __future__ import annotations

import re
from typing import Final

from symbody.expr.language.caret import Source
from symbody.expr.language.formula import Formula, FormulaLike
from symbody.expr.language.grammar import read_program
from symbody.expr.language.instructions import Instruction
from symbody.expr.language.tokens import normalize

# Digits are bounded so that a text that is not an angle costs one pass.
_DEGREES: Final = re.compile(r"([ \t]*[-+]?[ \t]*[0-9.]{1,400}(?:[eE][-+]?[0-9]{1,3})?)[ \t]*deg[ \t]*")


def parse(text: str, *, where: str = "") -> Formula:
    """Return the formula of a text.

    Parameters
    ----------
    where : str
        Object path or file that messages begin with, such as ``"joint slider, motion"``.

    Raises
    ------
    ExpressionError
        With all problems found, each with line, column and a caret below the text.

    Examples
    --------
    >>> parse("-m*g*sin(theta) + if(x < 0, k*x, 0)").names
    ('m', 'g', 'theta', 'x', 'k')
    """
    return Formula.from_value(text, where=where)


def parse_angle(value: FormulaLike, *, where: str = "") -> Formula:
    """Return the formula of an angle [rad]: anything `parse` takes, where ``deg`` may follow numbers.

    ``"30 deg"`` keeps its text; its program is ``30*pi/180`` with `pi` as a name.
    """
    text = normalize(value) if isinstance(value, str) else ""
    degrees = _DEGREES.fullmatch(text)
    if degrees is None:
        if "deg" in text:
            return Formula(text, read_program(Source(text, where, is_angle=True)))
        return Formula.from_value(value, where=where)
    number = read_program(Source(degrees[1], where))
    column = degrees.end(1) + 1
    conversion = (
        Instruction("name", "pi", column),
        Instruction("apply", "mul", column, 2),
        Instruction("number", 180, column),
        Instruction("apply", "div", column, 2),
    )
    return Formula(text, number + conversion)
