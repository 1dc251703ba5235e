"""Progress of long work: a bar on the screen, or a function of the caller."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import symbody.simulation as simulation
from symbody.errors import Problem, UsageError
from symbody.simulation.native.run import Progress


@contextmanager
def show_progress(progress: Progress | bool | None, name: str) -> Iterator[Progress | None]:
    """Yield the function to call with the share that is done, if any; True shows a bar under a name.

    Raises
    ------
    UsageError
        If it cannot be called.
    """
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise UsageError(
            Problem("simulation.progress", "progress",
                    f"progress = {progress!r} is neither True, False nor a function", "",
                    "give True for a progress bar, or a function that takes the completed fraction, from 0 "
                    "to 1")
        )  # fmt: skip
    if progress is None or progress is False:
        yield None
    elif progress is not True:
        yield progress
    else:
        with simulation.progress_bar.show_bar(name) as show:
            yield show
