"""The bar on the screen: which stage of the work is under way, and how far the motion has come."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from symbody.expr.deadline import watch_stages


class StageBar:
    """A bar on standard error that names the stage of the work; nothing where that is not a screen.

    Nothing may be printed during a stage: it would run through the bar.
    """

    def __init__(self) -> None:
        self._console = Console(stderr=True)
        self._bar: Progress | None = None

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Show a stage of unknown length, and beside it the part of it that is under way."""
        bar = Progress(
            console=self._console,
            transient=True,
            disable=not self._console.is_terminal,
            redirect_stdout=False,  # what is printed belongs to standard output, also beside a bar
            redirect_stderr=False,
        )
        task = bar.add_task(name, total=None)
        self._bar = bar
        with bar, watch_stages(lambda part: bar.update(task, description=f"{name}: {escape(part)}")):
            yield

    def __call__(self, share: float) -> None:
        """Show how far a motion has come: what came before it, as compilation, is over."""
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], description="integrating", total=1.0, completed=share)
