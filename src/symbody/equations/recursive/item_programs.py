"""One program for several items, each a nested tuple of expressions: twists, wrenches, inertias, bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.expr.sequences.program import map_program

T = TypeVar("T")
U = TypeVar("U")
W = TypeVar("W")


def map_items(graph: Graph, shared: T, items: Sequence[U], compute: Callable[[T, U], W]) -> list[W]:
    """Return ``compute(shared, item)`` for every item, the same operations for all of them side by side.

    Items are alike: the first shows how the numbers of each are put together.
    """
    example: list[W] = []

    def program(given: list[Expr], numbers: list[Expr]) -> list[Expr]:
        result = compute(unflatten(shared, given), unflatten(items[0], numbers))
        example.append(result)
        return flatten(result)

    rows = map_program(graph, flatten(shared), list(zip(*map(flatten, items), strict=True)), program)
    return [unflatten(example[0], column) for column in zip(*rows, strict=True)]


def flatten(value: Any) -> list[Expr]:
    """Return the expressions of a nested tuple, in order."""
    if isinstance(value, Expr):
        return [value]
    return [x for part in value for x in flatten(part)] if isinstance(value, tuple) else []


def unflatten(like: T, numbers: Iterable[Expr]) -> T:
    """Return a nested tuple of the same kinds as `like`, with other expressions."""
    left = iter(numbers)

    def build(part: Any) -> Any:
        if isinstance(part, Expr):
            return next(left)
        if not isinstance(part, tuple):
            return part
        kind = type(part)
        return getattr(kind, "_make", kind)(build(inner) for inner in part)

    result: T = build(like)
    return result
