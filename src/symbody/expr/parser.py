"""Text of the expression language to formulas.

The grammar: numbers, ``deg`` behind a number, names, ``+ - * / ^ **``, signs, ``if(condition, a, b)`` with
comparisons, ``and``, ``or`` and ``not`` in the condition, and the functions of
`symbody.expr.language.instructions.FUNCTIONS`. ``30 deg`` is ``30*pi/180``, with `pi` as a name.
What has no value, such as ``1/0``, is refused but in a branch that a condition of numbers alone never takes.
Names mean nothing here: whatever reads as an identifier is one, ``I``, ``lambda`` and ``max`` too.
"""

from __future__ import annotations

from symbody.expr.language.formula import Formula


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
