"""`OutputTable`: what can be read of equations or of a motion, to look through and to search."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final, NamedTuple

from symbody.arguments import checked_arguments
from symbody.model.output_arguments import OutputScope
from symbody.model.output_names import (
    ACCELERATIONS,
    FRAME_OUTPUT,
    INPUTS,
    MOTION_UNITS,
    MOTION_WORDS,
    MULTIPLIERS,
    POSITIONS,
    SIGNALS,
    SPEEDS,
    ListedOutput,
    read_output,
)
from symbody.notebook import Displayed

# What the names are that have no kind, by their heading.
_MEANINGS: Final[Mapping[str, str]] = {
    POSITIONS: "coordinate",
    SPEEDS: "speed",
    ACCELERATIONS: "acceleration",
    INPUTS: "input, given from outside",
    SIGNALS: "signal, or the rate of its state",
    MULTIPLIERS: "multiplier of a constraint",
}


class OutputInfo(NamedTuple):
    """An output that `compile`, `generate_code`, results, events and formulas know by its name.

    Attributes
    ----------
    name : str
        What to write: ``run[name]``, ``compile(eqs, name)``.
    shape : tuple of int or str
        () of a number; a size that is known only when it is computed is a letter, as in docs/outputs.md.
    unit : str
        SI unit; "" of a pure number, and where it is not known or entries differ.
    meaning : str
        What it is.
    title : str
        The heading under which lists show it.

    Examples
    --------
    >>> OutputInfo("energy", (), "J", "kinetic plus potential energy, T + V", "Energies").unit
    'J'
    """

    name: str
    shape: tuple[int | str, ...]
    unit: str
    meaning: str
    title: str

    @property
    def shape_text(self) -> str:
        """The shape as ``"3 x 3"``, "" of a number."""
        return " x ".join(map(str, self.shape))


class OutputTable(tuple[OutputInfo, ...], Displayed):
    """Outputs in the order of their headings; notebooks and `print` show a table.

    Examples
    --------
    >>> rows = [OutputInfo("energy", (), "J", "T + V", "Energies"), OutputInfo("x", (), "m", "", "Positions")]
    >>> table = OutputTable(rows)
    >>> table.search("t + v").names
    ('energy',)
    """

    __slots__ = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names alone."""
        return tuple(each.name for each in self)

    @checked_arguments
    def search(self, words: str) -> OutputTable:
        """Return the outputs whose name, meaning, unit and heading together contain all of some words.

        Parameters
        ----------
        words : str
            Parts of words, separated by blanks; capitals do not count.

        Returns
        -------
        OutputTable
            Those that fit, in the same order.

        Examples
        --------
        >>> OutputTable([OutputInfo("energy", (), "J", "T + V", "Energies")]).search("power").names
        ()
        """
        wanted = words.casefold().split()
        return OutputTable(
            each
            for each in self
            if all(word in " ".join((each.name, *each[2:])).casefold() for word in wanted)
        )

    def __repr__(self) -> str:
        return f"<{len(self)} outputs: print shows them, .search('reaction') finds some>"

    def __str__(self) -> str:
        """Return the table as text, a line an output, under their headings."""
        width = max((len(each.name) for each in self), default=0)
        shapes = max((len(each.shape_text) for each in self), default=0)
        units = max((len(each.unit) for each in self), default=0)
        lines: list[str] = []
        title = ""
        for each in self:
            if each.title != title:
                title = each.title
                lines.append(title)
            cells = f"{each.name:<{width}}  {each.shape_text:<{shapes}}  {each.unit:<{units}}  {each.meaning}"
            lines.append(f"  {cells}".rstrip())
        return "\n".join(lines)


def output_table(
    listed: Iterable[ListedOutput], scope: OutputScope, units: Mapping[str, str], sizes: Mapping[str, int]
) -> OutputTable:
    """Return a table of listed outputs.

    Parameters
    ----------
    sizes : mapping of letter to int
        Those of ``n_u``, ``n_q``, ... that are known.
    """
    return OutputTable(_output_info(each, scope, units, sizes) for each in listed)


def _output_info(
    listed: ListedOutput, scope: OutputScope, units: Mapping[str, str], sizes: Mapping[str, int]
) -> OutputInfo:
    asked, unit = read_output(listed.name, scope), units.get(listed.name, "")
    if asked is None:
        return OutputInfo(listed.name, (), unit, _MEANINGS.get(listed.title, ""), listed.title)
    if asked.is_number:
        return OutputInfo(listed.name, (), unit, asked.kind.meaning, listed.title)
    shape, unit, meaning = asked.kind.shape, "", asked.kind.meaning
    if asked.kind.word == FRAME_OUTPUT:
        motion, end = asked.words[:2]
        shape, unit = "3 x 3" if motion == "R" else "3", MOTION_UNITS[motion]
        meaning = f"{MOTION_WORDS[motion][0]} of {end} relative to ground"
    known = tuple(int(word) if word.isdigit() else sizes.get(word, word) for word in shape.split(" x "))
    return OutputInfo(listed.name, known, unit, meaning, listed.title)
