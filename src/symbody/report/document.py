"""A document by its parts, before it is HTML, LaTeX, Markdown or a notebook.

Sections say what there is to read, writers how it looks. Formulas stay nodes of the expression graph until
they are written, so that every kind of file prints them in its own notation.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

from symbody.expr.graph import Graph
from symbody.expr.language.formula import Formula
from symbody.expr.printing.numerals import ALL_DIGITS, Numerals
from symbody.expr.printing.relation import Relation

# An equation of more operations is written in shared parts with names, and folded where pages can fold.
LONG: Final = 400
# A block whose graph has more operations than this is counted, not printed: nobody reads it.
MOST_OPERATIONS: Final = 4000

_MULTIPLIER: Final = re.compile(r"\b(lambda_\w+)")

PictureKind: TypeAlias = Literal["svg", "png", "pdf"]


@dataclass(frozen=True, slots=True)
class Name:
    """A name of the model, shown as in formulas: Greek letters, indices, dots for ``_dot``."""

    text: str


@dataclass(frozen=True, slots=True)
class NameList:
    """Several names, separated by commas."""

    texts: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as symbody writes it: ``kg m^2``."""

    text: str


@dataclass(frozen=True, slots=True)
class FormulaList:
    """Components in parentheses."""

    entries: tuple[Formula | str, ...]


Cell: TypeAlias = str | float | Formula | Name | NameList | FormulaList | Unit


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Plain text."""

    text: str


@dataclass(frozen=True, slots=True)
class Notes:
    """A list of sentences; those that end in a list of some of the names have these typeset."""

    texts: tuple[str, ...]
    names: frozenset[str] = frozenset()


def split_names(text: str, names: frozenset[str] = frozenset()) -> list[Cell]:
    """Return a sentence in pieces: names that are typeset, and what stands between them.

    They are multipliers anywhere, and what a list at the end holds, which no word of the sentence can be
    mistaken for: ``"inputs without a value are set to 0: T"``.
    """
    head, colon, tail = text.rpartition(": ")
    listed = tuple(tail.split(", "))
    if colon and names.issuperset(listed):
        return [*split_names(head + colon), NameList(listed)]
    return [Name(piece) if _MULTIPLIER.fullmatch(piece) else piece for piece in _MULTIPLIER.split(text)]


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table."""

    heading: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True, slots=True)
class EquationBlock:
    """Equations ``left = right`` below each other.

    Attributes
    ----------
    graph : Graph
        Where the nodes are.
    sides : tuple of (int, int)
        The nodes of both sides of each.
    numerals : Numerals
        How many digits numbers have.
    leading : mapping of node to node
        The acceleration that comes first in a left side.
    remarks : mapping of int to str
        What is said behind an equation, by its place.
    relations : mapping of int to Relation
        What stands between sides where that is no equality, by their place.
    """

    graph: Graph
    sides: tuple[tuple[int, int], ...]
    numerals: Numerals = ALL_DIGITS
    leading: Mapping[int, int] = field(default_factory=dict)
    remarks: Mapping[int, str] = field(default_factory=dict)
    relations: Mapping[int, Relation] = field(default_factory=dict)

    @property
    def nodes(self) -> tuple[int, ...]:
        """Both sides of each equation, one after the other."""
        return tuple(node for pair in self.sides for node in pair)


@dataclass(frozen=True, slots=True)
class Matrix:
    """``symbol = [entries]``.

    Attributes
    ----------
    symbol : str
        A name, shown as in formulas, in bold type: names of parameters are not.
    shape : (int, int)
        Rows and columns.
    nodes : tuple of int
        Entries, row by row.
    numerals : Numerals
        How many digits numbers have.
    """

    symbol: str
    graph: Graph
    shape: tuple[int, int]
    nodes: tuple[int, ...]
    numerals: Numerals = ALL_DIGITS


@dataclass(frozen=True, slots=True)
class Figure:
    """A picture.

    Attributes
    ----------
    name : str
        Of its file, where pictures are files of their own: letters, digits and ``-``.
    caption : str
        What it shows; also what readers hear who do not see it.
    draw : callable
        Returns the content of a file of a kind.
    """

    name: str
    caption: str
    draw: Callable[[PictureKind], bytes]


@dataclass(frozen=True, slots=True)
class MatrixRow:
    """Matrices that stand beside each other."""

    matrices: tuple[Matrix, ...]


@dataclass(frozen=True, slots=True)
class GoverningEquations:
    """The equations of motion as matrices, and the names that stand in their vectors.

    Attributes
    ----------
    speeds, multipliers : tuple of str
        In the order of rows; none where they are too many to be listed.
    has_constraints : bool
        Whether multipliers and the rows of J belong to them.
    """

    speeds: tuple[str, ...]
    multipliers: tuple[str, ...]
    has_constraints: bool


Block: TypeAlias = (
    Paragraph | Notes | TextTable | EquationBlock | Matrix | MatrixRow | Figure | GoverningEquations
)


@dataclass(frozen=True, slots=True)
class ReportSection:
    """A heading and what stands under it.

    Attributes
    ----------
    key : str
        What callers choose it by.
    """

    key: str
    title: str
    blocks: Sequence[Block] = field(default=())


@dataclass(frozen=True, slots=True)
class ReportContent:
    """A title and sections."""

    title: str
    sections: tuple[ReportSection, ...]
