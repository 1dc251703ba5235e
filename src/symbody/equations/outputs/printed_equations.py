"""Equations that print themselves; what they are printed by is loaded by the first that does."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import symbody.equations.outputs as outputs
from symbody.arguments import checked_arguments
from symbody.errors import Problem, UsageError
from symbody.expr.printing.latex_rows import WIDTH
from symbody.expr.printing.wrapping import text_width
from symbody.notebook import Displayed

if TYPE_CHECKING:
    from symbody.equations.outputs.textbook import Textbook

# Operations of one equation that somebody will read without names for its parts.
LONG: Final = 400


class PrintedEquations(Displayed):
    """Equations of motion that print themselves as text and as LaTeX."""

    __slots__ = ()

    @property
    def textbook(self) -> Textbook:
        """The same equations as formulas."""
        raise NotImplementedError

    def __str__(self) -> str:
        """Return the equations as text; of more than 8 speeds, what `repr` returns and where they are."""
        if len(self.textbook.formed.u) > outputs.textbook.MOST_SPEEDS:
            return f"{self!r}; text() returns its equations"
        return self.text()

    @checked_arguments
    def text(
        self,
        limit: int = LONG,
        greek: bool = False,
        width: int | None = None,
        digits: int | None = None,
    ) -> str:
        """Return the equations of motion as text, with the constraints there are.

        Primes are time derivatives, blanks are products. ``symbody equations`` prints the same.

        Parameters
        ----------
        limit : int
            If an equation has more operations, shared parts are named z1, z2, ... and defined at the end.
        greek : bool
            Whether names of Greek letters become letters: ``theta1`` is written ``θ1``.
        width : int, optional
            Letters of a line; longer equations take several, broken in front of their signs. By default
            those of the terminal, within 80 and 100; 0 is a line an equation.
        digits : int, optional
            Significant digits of computed numbers, all by default. Numbers that the model is written with
            are printed in full.
        """
        return outputs.equation_lines.equation_text(
            self.textbook, limit, greek, text_width() if width is None else width, checked_digits(digits)
        )

    @checked_arguments
    def latex(self, limit: int = LONG, width: int = WIDTH, digits: int | None = None) -> str:
        r"""Return the equations of motion as LaTeX, an ``aligned`` environment without delimiters.

        Parameters
        ----------
        limit : int
            As in `text`.
        width : int
            Letters of a row; longer sides take several, broken in front of the signs of their terms.
        digits : int, optional
            As in `text`.
        """
        return outputs.equation_lines.equation_latex(self.textbook, limit, width, checked_digits(digits))


def checked_digits(digits: int | None) -> int | None:
    """Return a number of digits; a UsageError if it is not from 1 to 17."""
    if digits is not None and not 1 <= digits <= 17:
        what = f"{digits} significant digits cannot be printed"
        fix = "give a whole number from 1 to 17, or None for all digits"
        raise UsageError(Problem("call.argument", "digits", what, fix=fix))
    return digits
