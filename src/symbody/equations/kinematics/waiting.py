"""`Waiting`: values by name of which each follows from an earlier one, and is found when it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

V = TypeVar("V")


class Waiting(dict[str, V]):
    """A mapping in which a value may wait: `find` enters it, and those it follows from are entered before.

    It looks as if all values were there.
    """

    def __init__(self, first: dict[str, V]) -> None:
        super().__init__(first)
        self._finds: dict[str, tuple[str, Callable[[], None]]] = {}

    def wait(self, name: str, before: str, find: Callable[[], None]) -> None:
        """Let a value wait until it is needed; it follows from the one called `before`."""
        self._finds[name] = (before, find)

    def __missing__(self, name: str) -> V:
        if name not in self._finds:
            raise KeyError(name)
        steps = []
        while not dict.__contains__(self, name):
            steps.append(name)
            name = self._finds[name][0]
        for step in reversed(steps):
            if not dict.__contains__(self, step):
                self._finds[step][1]()
        return dict.__getitem__(self, steps[0])

    def __reduce__(self) -> tuple[type[Waiting[V]], tuple[dict[str, V]]]:
        return type(self), ({name: self[name] for name in self},)

    def __contains__(self, name: object) -> bool:
        return dict.__contains__(self, name) or name in self._finds

    def __iter__(self) -> Iterator[str]:
        yield from dict.fromkeys((*dict.__iter__(self), *self._finds))
