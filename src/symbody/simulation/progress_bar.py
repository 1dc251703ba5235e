"""A bar on the screen; loaded when one is shown, for it takes longer to import than most motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from symbody.expr.deadline import watch_stages


@contextmanager
def show_bar(name: str) -> Iterator[Callable[[float], None]]:
    """Show a bar under a name; yield what moves it to a share, from 0 to 1.

    Stages that begin before the first share, as those of compiling, stand beside the name.
    """
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(name, total=None)

        def show(share: float) -> None:
            bar.update(task, description=name, total=1.0, completed=share)

        with watch_stages(lambda stage: bar.update(task, description=f"{name}: {stage}")):
            yield show
        show(1.0)
