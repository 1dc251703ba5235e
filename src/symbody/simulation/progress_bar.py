"""A bar on the screen; loaded when one is shown, for it takes longer to import than most motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar


@contextmanager
def show_bar(name: str) -> Iterator[Callable[[float], None]]:
    """Show a bar under a name; yield what moves it to a share, from 0 to 1."""
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(name, total=1.0)

        def show(share: float) -> None:
            bar.update(task, completed=share)

        yield show
        show(1.0)
