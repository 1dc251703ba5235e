"""`LazyMapping`: values by name, each computed from the value of an earlier name when it is first read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

V = TypeVar("V")

# The name that a value follows from, and the function from that value to this one.
Rule = tuple[str, Callable[[V], V]]


class LazyMapping(Mapping[str, V]):
    """Values of which each follows from an earlier one; it compares and pickles as if all were there."""

    def __init__(self, first: Mapping[str, V], rules: Mapping[str, Rule[V]]) -> None:
        self._values = dict(first)
        self._rules = rules

    def __getitem__(self, name: str) -> V:
        chain = []
        while name not in self._values:
            chain.append(name)
            name = self._rules[name][0]
        for step in reversed(chain):  # a loop, as chains are longer than Python recurses
            before, compute = self._rules[step]
            self._values.setdefault(step, compute(self._values[before]))
        return self._values[chain[0] if chain else name]

    def __iter__(self) -> Iterator[str]:
        yield from dict.fromkeys((*self._values, *self._rules))

    def __len__(self) -> int:
        return len(self._values.keys() | self._rules.keys())

    def __contains__(self, name: object) -> bool:
        return name in self._values or name in self._rules

    def __reduce__(self) -> tuple[type[dict[str, V]], tuple[dict[str, V]]]:
        return dict, ({name: self[name] for name in self},)
