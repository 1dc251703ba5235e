"""`NativeCallback`: a Python function that compiled loops call as they call generated code."""

from __future__ import annotations

import ctypes
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

NATIVE = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_void_p] * 8)


class NativeCallback(ABC):
    """A Python function with the signature of generated code.

    What it raises is kept in `error`, and every later call fails at once, which ends the loop.
    """

    def __init__(self) -> None:
        self.error: Exception | KeyboardInterrupt | None = None
        self._entry = NATIVE(self._call)

    @property
    def address(self) -> int:
        """Where it lies, as long as this object lives."""
        return ctypes.cast(self._entry, ctypes.c_void_p).value or 0

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let Ctrl-C end the loop from within: raised between native and Python code it would be lost."""
        usual = signal.getsignal(signal.SIGINT)
        is_main = threading.current_thread() is threading.main_thread()
        if not is_main or usual is not signal.default_int_handler:
            yield
            return
        signal.signal(signal.SIGINT, self._interrupt)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, usual)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self.error = KeyboardInterrupt()

    def _call(self, *places: int) -> int:
        if self.error is not None:
            return 1
        try:
            return self.answer(*places)
        except (Exception, KeyboardInterrupt) as error:  # nothing may pass through native code
            self.error = error
            return 1

    @abstractmethod
    def answer(self, t: int, q: int, u: int, r: int, p: int, c: int, out: int, work: int) -> int:
        """Store into the arrays at the last addresses; return 0, or what is wrong."""
