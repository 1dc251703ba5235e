"""Who wants to know when numba compiles the loops, which it does once on a computer."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from numba.core import event
from numba.core.compiler_lock import global_compiler_lock

# Its hook for forks has to be there first: later ones act earlier, and numba takes its lock before LLVM's.
import symbody.codegen.llvm.machine  # noqa: F401

# What numba tells of each function that it does not find on the disk, around its compilation.
_EVENT: Final = "numba:compile"
_LOOPS: Final = f"{__package__}."

if os.name == "posix":  # a fork waits for a compilation, whose lock would stay held in the copy for ever
    os.register_at_fork(
        before=global_compiler_lock.acquire,
        after_in_parent=global_compiler_lock.release,
        after_in_child=global_compiler_lock.release,
    )


@contextmanager
def loops_watched(told: Callable[[bool], None]) -> Iterator[None]:
    """Tell that compiling begins, with True, and that it ends, with False; from any thread."""
    with event.install_listener(_EVENT, _Listener(told)):
        yield


class _Listener(event.Listener):
    """Hears of the outermost function of ours that numba compiles, and of its end."""

    def __init__(self, told: Callable[[bool], None]) -> None:
        self._told = told
        self._depth = 0
        self._lock = threading.Lock()

    def on_start(self, event: event.Event) -> None:
        """Begin a function, perhaps inside another."""
        self._go(event, 1)

    def on_end(self, event: event.Event) -> None:
        """End a function, compiled or given up."""
        self._go(event, -1)

    def _go(self, event: event.Event, way: int) -> None:
        if not event.data["dispatcher"].py_func.__module__.startswith(_LOOPS):
            return
        with self._lock:
            before, self._depth = self._depth, self._depth + way
        if 0 in (before, self._depth):
            self._told(self._depth > 0)
