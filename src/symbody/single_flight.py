"""Values that are made once, whichever threads need them first: one thread makes, the others wait.

`functools.cache` lets each of several threads make a value of its own at first, and the values that lose are
dropped while somebody may still use them: fatal where a value is the memory of machine code.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable
from functools import wraps
from threading import RLock
from typing import Any, Final, Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")

# Locks of the process, which are never dropped. The class of an RLock has no public name.
_LOCKS: Final[list[Any]] = []
_FORKS: Final = [0]  # how many lie between this process and the one that imported the package


def fork_safe_lock() -> Any:
    """Return a reentrant lock that is free in a forked process, where the thread that held it is missing.

    It lives as long as the process.
    """
    lock = RLock()
    _LOCKS.append(lock)
    return lock


# Held while a lock is made.
_FIRST: Final = fork_safe_lock()


def _free_locks() -> None:
    _FORKS[0] += 1
    for lock in _LOCKS:
        if not lock._is_owned():  # by the thread that forked, which goes on in the new process
            lock._at_fork_reinit()


if os.name == "posix":
    os.register_at_fork(after_in_child=_free_locks)


class SingleFlight(Generic[Key, Value]):
    """Values by key. Copies, and what is pickled, begin without any.

    Parameters
    ----------
    most : int, optional
        How many values are kept; the oldest go.
    """

    __slots__ = ("_forks", "_lock", "_most", "_values")

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._lock: Any = None  # many of these never hold a value
        self._forks = 0
        self._values: dict[Key, Value] = {}

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """Return the value of `key`; the first thread that needs it makes it.

        Where `make` raises, nothing is kept, and the next thread tries.
        """
        try:
            return self._values[key]
        except KeyError:
            pass
        with self._lock if self._forks == _FORKS[0] and self._lock else self._make_lock():
            if key not in self._values:
                value = make()
                while self._most is not None and len(self._values) >= self._most:
                    del self._values[next(iter(self._values))]
                self._values[key] = value
            return self._values[key]

    def _make_lock(self) -> Any:
        """Return a lock, another one where a thread held it that is missing in this forked process."""
        with _FIRST:
            is_stale = self._forks != _FORKS[0] and self._lock is not None and not self._lock._is_owned()
            if self._lock is None or is_stale:
                self._lock = RLock()
            self._forks = _FORKS[0]
            return self._lock

    def peek(self, key: Key) -> Value | None:
        """Return the value of `key` if it was made."""
        return self._values.get(key)

    def __len__(self) -> int:
        return len(self._values)

    def __reduce__(self) -> tuple[type[SingleFlight[Key, Value]], tuple[int | None]]:
        return type(self), (self._most,)


def once(make: Callable[[], Value]) -> Callable[[], Value]:
    """Return a function that calls `make` once in the process and returns that value every time."""
    values: SingleFlight[None, Value] = SingleFlight()

    @wraps(make)
    def value() -> Value:
        return values.get(None, make)

    return value
