"""A process that answers step by step, and is ended when it takes too long."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from time import monotonic
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

if sys.platform == "linux":
    import resource

Floats = NDArray[np.float64]

# Trees as deep as a graph is long are walked recursively by some peers; they shall not fail by that.
_STACK: Final = 256 * 2**20
_RECURSION: Final = 50_000
_MEMORY: Final = 8 * 2**30  # bytes; a peer that wants more fails instead of bringing the machine down
_START_LIMIT: Final = 60.0  # seconds for imports


@dataclass(frozen=True, slots=True)
class Step:
    """One answer: its name, and what was measured or computed."""

    name: str
    figure: float = 0.0
    values: Floats | None = None


@dataclass(frozen=True, slots=True)
class Round:
    """The steps of one round in their order; `stopped` says why there are no more, empty if all came."""

    steps: tuple[Step, ...]
    stopped: str = ""


Task = Callable[[str], Iterator[Step]]


class Process:
    """Runs the task that ``make(*arguments)`` returns, for each word it is asked.

    Parameters
    ----------
    make : callable
        Defined at the top of a module, like its arguments: another process has to find it. It takes as
        long as it takes, within a minute, so imports belong there.
    """

    def __init__(self, make: Callable[..., Task], *arguments: object) -> None:
        context = get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._folder = tempfile.TemporaryDirectory()  # a process that is killed does not tidy up
        parts = (theirs, self._folder.name, make, arguments)
        self._process = context.Process(target=_serve, args=parts, daemon=True)
        self._process.start()
        theirs.close()
        self.stopped = self._receive(monotonic() + _START_LIMIT, _START_LIMIT)[1]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def ask(self, word: str, limit: float) -> Round:
        """Return the steps that answer `word`.

        After `limit` seconds the process is ended; from then on the answer is empty.
        """
        if self.stopped:
            return Round((), self.stopped)
        self._connection.send(word)
        steps, self.stopped = self._receive(monotonic() + limit, limit)
        return Round(tuple(steps), self.stopped)

    def _receive(self, deadline: float, limit: float) -> tuple[list[Step], str]:
        steps: list[Step] = []
        while True:
            if not self._connection.poll(max(0.0, deadline - monotonic())):
                self._end()
                return steps, f"> {limit:g} s"
            try:
                message = self._connection.recv()
            except EOFError:
                self._end()
                return steps, f"the process ended with code {self._process.exitcode}"
            if not isinstance(message, Step):
                return steps, message
            steps.append(message)

    def _end(self) -> None:
        if self._process.is_alive():
            _kill_with_children(self._process.pid or 0)
            self._process.kill()
        self._process.join()
        self._connection.close()
        self._folder.cleanup()


def _kill_with_children(leader: int) -> None:
    """Kill the group that `leader` made, for instance with a compiler it has called."""
    if sys.platform != "win32":
        try:
            os.killpg(leader, signal.SIGKILL)
        except ProcessLookupError:  # ended before it made one
            return


def _serve(
    connection: Connection, folder: str, make: Callable[..., Task], arguments: tuple[object, ...]
) -> None:
    if sys.platform != "win32":
        os.setpgid(0, 0)
    tempfile.tempdir = folder
    sys.setrecursionlimit(_RECURSION)
    threading.stack_size(_STACK)
    thread = threading.Thread(target=_answer, args=(connection, make, arguments))
    thread.start()
    thread.join()


def _answer(connection: Connection, make: Callable[..., Task], arguments: tuple[object, ...]) -> None:
    """Send steps, and after each round an empty text or what went wrong."""
    try:
        task = make(*arguments)
        if sys.platform == "linux":
            resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        connection.send("")
        while True:
            for step in task(connection.recv()):
                connection.send(step)
            connection.send("")
    except EOFError:  # nobody asks any more
        return
    except Exception as error:  # whatever a peer raises is a result
        connection.send(f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"[:120])
