"""Ctrl-C in the middle of a run, whatever else the machine is doing."""

from __future__ import annotations

import _thread
import gc
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class CtrlC:
    """Progress of a run that is interrupted some time after its loop began.

    Counted from the first report, not from the call: on a busy machine compilation may take longer than any
    time chosen here, and an interruption before the loop is another case.
    """

    def __init__(self, after: float = 0.2) -> None:
        self._timer = threading.Timer(after, _thread.interrupt_main)

    def __call__(self, share: float) -> None:
        if self._timer.ident is None:
            self._timer.start()

    def join(self) -> None:
        self._timer.join()


@contextmanager
def ctrl_c() -> Iterator[CtrlC]:
    """What to give as progress; processes started in the background ignore Ctrl-C, so it is heard here first.

    Hypothesis leaves a function with the garbage collector. Python drops what is raised there, and after a long
    collection it is the first Python code to run: a Ctrl-C pressed meanwhile would be raised in it, and lost.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    collecting, gc.callbacks[:] = gc.callbacks[:], []
    press = CtrlC()
    try:
        yield press
        press.join()
    finally:
        signal.signal(signal.SIGINT, before)
        gc.callbacks[:] = collecting
