"""Progress of long work: a bar on the screen, or a function of the caller."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from symbody.errors import Problem, UsageError
from symbody.simulation.native.compiling import loops_watched
from symbody.simulation.native.run import Progress

COMPILING: Final = "compiling the integration loop (once)"


class StagedProgress(ABC):
    """A progress that also shows stages in which the work waits for something else."""

    @abstractmethod
    def __call__(self, share: float) -> bool | None:
        """Take note of the share that is done; False ends the work."""

    @abstractmethod
    def wait_for(self, stage: str) -> None:
        """Name what is waited for, from any thread; an empty text: it is done."""


class ProgressBar(StagedProgress):
    """A bar on standard error under the name of the work."""

    def __init__(self, bar: Bar, name: str) -> None:
        self._bar, self._name = bar, name
        self._task = bar.add_task(name, total=1.0)

    def __call__(self, share: float) -> None:
        """Show the share that is done."""
        self._bar.update(self._task, completed=share)

    def wait_for(self, stage: str) -> None:
        """Show the stage in place of the name."""
        self._bar.update(self._task, description=stage or self._name)


@contextmanager
def show_progress(progress: Progress | bool | None, name: str) -> Iterator[Progress | None]:
    """Yield the function to call with the share that is done, if any; True shows a bar under a name.

    A `StagedProgress` also shows that the integration loop is compiled, which happens once on a computer.

    Raises
    ------
    UsageError
        If it cannot be called.
    """
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise UsageError(
            Problem("simulation.progress", "progress",
                    f"progress = {progress!r} is neither a switch nor a function", "",
                    "give True for a bar, or a function of the share that is done, from 0 to 1")
        )  # fmt: skip
    if progress is None or progress is False:
        yield None
    elif progress is not True:
        with _report_compilation(progress):
            yield progress
    else:
        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        )
        with Bar(*columns, console=Console(stderr=True)) as bar:
            shown = ProgressBar(bar, name)
            with _report_compilation(shown):
                yield shown
            shown(1.0)


@contextmanager
def _report_compilation(progress: Progress) -> Iterator[None]:
    if not isinstance(progress, StagedProgress):
        yield
        return
    with loops_watched(lambda begins: progress.wait_for(COMPILING if begins else "")):
        yield
