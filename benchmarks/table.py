"""Tables of figures, and how a figure is written beside the one it is compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))


@dataclass(frozen=True, slots=True)
class Table:
    """A result: the first column names what each row is about; `notes` stand below."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()


def show(table: Table, console: Console) -> None:
    """Print `table`."""
    drawn = RichTable(title=table.title, title_justify="left", title_style="bold")
    for k, column in enumerate(table.columns):
        drawn.add_column(column, justify="right" if k else "left", no_wrap=True)
    for row in table.rows:
        drawn.add_row(*map(Text, row))  # as text: brackets are not markup
    console.print(drawn)
    for note in table.notes:
        console.print(f"  {note}", markup=False, highlight=False)
    console.print()


def seconds_text(seconds: float) -> str:
    """Return a duration to three digits in a fitting unit.

    >>> seconds_text(0.00025)
    '250 us'
    """
    unit, name = next((pair for pair in _UNITS if seconds >= pair[0]), _UNITS[-1])
    return f"{_three_digits(seconds / unit)} {name}"


def ratio_text(value: float, reference: float | None) -> str:
    """Return `value` divided by `reference` as it stands in brackets; empty if there is no reference.

    >>> ratio_text(8.2, 2.0)
    ' (4.1x)'
    """
    if not reference:
        return ""
    ratio = value / reference
    places = 0 if ratio >= 9.95 else 1 if ratio >= 0.995 else 2
    return f" ({ratio:.{places}f}x)"


def difference_text(value: float) -> str:
    """Return a relative difference; what is not a number is shown as such."""
    return f"{value:.0e}" if value else "0"


def _three_digits(value: float) -> str:
    places = max(0, 2 - math.floor(math.log10(value))) if value > 0 else 0
    return f"{value:.{min(places, 2)}f}"
