"""How the compiled loops are kept on the disk, and who wants to know when numba compiles them.

numba reads what it has kept without looking whether it is whole: a file cut short stops every later process,
and one wrong bit crashes it. Here each file is checked before. One that is wrong or cannot be written is done
without.
"""

from __future__ import annotations

import os
import pickle
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

import llvmlite
import numba
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.serialize import dumps

# Its hook for forks has to be there first: later ones act earlier, and numba takes its lock before LLVM's.
import symbody.codegen.llvm.machine  # noqa: F401
from symbody.storage import read_sealed, write_sealed

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


class LoopCache(FunctionCache):
    """What numba keeps of a function: one sealed file for each kind of arguments, where numba would put it.

    Raises
    ------
    RuntimeError
        If there is no folder for it.
    """

    def __init__(self, function: Callable[..., object]) -> None:
        super().__init__(function)
        self._cache_file = _LoopFiles(
            Path(self.cache_path),
            self._impl.filename_base,
            Path(function.__code__.co_filename),
            self._impl.locator.get_source_stamp(),
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the function for some types of arguments as it was kept, else None."""
        with suppress(Exception):  # pickles, and the object code in them, fail in every way there is
            return super().load_overload(sig, target_context)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a function, if that can be done."""
        with suppress(OSError):
            super().save_overload(sig, data)


class _LoopFiles:
    """Files of one function, as numba's caches use them."""

    def __init__(self, folder: Path, base: str, source: Path, source_stamp: object) -> None:
        self._folder, self._base = folder, base
        self._source = sha256(repr(source_stamp).encode()).hexdigest()[:8]
        self._versions = repr((numba.__version__, llvmlite.__version__, str(source), source_stamp))
        owners = {os.geteuid()} if os.name == "posix" else set()
        with suppress(OSError):  # who owns the program may do what it does
            owners.add(os.stat(source).st_uid)
        self._owners = frozenset(owners)

    def load(self, key: object) -> Any:
        """Return what was kept under `key`, else None."""
        path, words = self._place(key)
        content = read_sealed(path, words, self._owners)
        return None if content is None else pickle.loads(content)

    def save(self, key: object, data: Any) -> None:
        """Keep `data` under `key`."""
        write_sealed(*self._place(key), dumps(data))
        for path in self._folder.iterdir():  # of sources as they were before
            name = path.name
            if name.startswith(f"{self._base}.") and not name.startswith(f"{self._base}.{self._source}."):
                path.unlink()

    def _place(self, key: object) -> tuple[Path, bytes]:
        words = f"{self._versions} {key!r}".encode()
        digest = sha256(words).hexdigest()[:16]
        return self._folder / f"{self._base}.{self._source}.{digest}.loop", words


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
