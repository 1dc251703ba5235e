"""What a node of the graph costs: time and memory while it is made, time of the passes over it.

No peer does the same, so figures stand beside the house's own bars, and beside a yardstick that belongs to
the machine: putting as many keys into a dictionary and as many numbers into four lists as the graph does.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Final

from benchmarks.engines.ours import Engine
from benchmarks.problems import Step, random_program, serial_chain
from benchmarks.table import Table
from benchmarks.timing import Settings, in_turns, medians, seconds
from symbody.expr.canonical import add, apply, mul, sub
from symbody.expr.fingerprint import fingerprints
from symbody.expr.graph import Graph, Symbol
from symbody.expr.opcodes import COS, SIN
from symbody.expr.sequence import Input, Roots, build_sequence

_COUNT: Final = 1_000_000
_MOST_ROUNDS: Final = 3  # a round takes a minute
_INPUTS: Final = 8
_LANES: Final = 60
_NODES_OF_A_LINK: Final = 89

BUILD_BAR: Final = 4.0  # us a node, folding included
MEMORY_BAR: Final = 250.0  # bytes a node


@dataclass(frozen=True, slots=True)
class Grown:
    """A graph and what is to be computed with it."""

    graph: Graph
    roots: tuple[int, ...]
    inputs: Mapping[int, Input]


def tables(settings: Settings, count: int = _COUNT) -> Iterator[Table]:
    """Yield the table for graphs of about `count` nodes."""
    rounds = min(settings.rounds, _MOST_ROUNDS)
    steps = random_program(count, _INPUTS, _LANES)
    yardstick = (
        medians(in_turns({"": partial(seconds, partial(fill_plain_lists, count))}, rounds))[""] / count * 1e6
    )
    rows = [("yardstick: a dictionary and four lists", f"{yardstick:.2f} us", "", "", "1")]
    notes = []
    for name, grow in (
        ("random operations", partial(grow_random, steps)),
        ("4x4 products, by operators", partial(grow_chain, count)),
    ):
        figures, size = _measured(grow, rounds)
        notes.append(f"{name}: {size} nodes; medians of {rounds} rounds")
        for what, figure in figures.items():
            bar = BUILD_BAR if what == "build" else None
            rows.append(
                (
                    f"{name}: {what}",
                    f"{figure:.2f} us",
                    *_judged(figure, bar, "us"),
                    f"{figure / yardstick:.1f}",
                )
            )
        memory = bytes_per_node(grow)
        rows.append((f"{name}: memory", f"{memory:.0f} bytes", *_judged(memory, MEMORY_BAR, "bytes"), ""))
    columns = ("per node", "measured", "bar", "of the bar", "of the yardstick")
    yield Table("the expression graph", columns, tuple(rows), tuple(notes))


def _judged(figure: float, bar: float | None, unit: str) -> tuple[str, str]:
    return ("", "") if bar is None else (f"{bar:g} {unit}", f"{100 * figure / bar:.0f} %")


def _measured(grow: Callable[[], Grown], rounds: int) -> tuple[dict[str, float], int]:
    """Return microseconds a node by what was done, and the number of nodes."""
    grown = grow()
    nodes = grown.graph.reachable(grown.roots)
    roots = [Roots("all", (len(grown.roots),), grown.roots)]
    tasks: dict[str, Callable[[], float]] = {
        "build": partial(_seconds_to_grow, grow),
        "fingerprints": partial(seconds, lambda: fingerprints(grown.graph, nodes)),
        "build_sequence": partial(seconds, lambda: build_sequence(grown.graph, roots, grown.inputs)),
    }
    size = len(grown.graph)
    per = {"build": size, "fingerprints": len(nodes), "build_sequence": len(nodes)}
    found = medians(in_turns(tasks, rounds))
    return {name: figure / per[name] * 1e6 for name, figure in found.items()}, size


def _seconds_to_grow(grow: Callable[[], Grown]) -> float:
    start = perf_counter()
    grown = grow()
    spent = perf_counter() - start
    del grown  # to free a graph takes time too, which belongs to nobody here
    return spent


def bytes_per_node(grow: Callable[[], Grown]) -> float:
    """Return the memory that a graph keeps, divided by its nodes."""
    tracemalloc.start()
    try:
        graph = grow().graph
        return tracemalloc.get_traced_memory()[0] / len(graph)
    finally:
        tracemalloc.stop()


def grow_random(steps: Sequence[Step]) -> Grown:
    """Return the graph of a random program, all ends of its lanes being roots."""
    graph = Graph()
    values = [graph.symbol(Symbol(f"x{k}")) for k in range(_INPUTS)]
    inputs = {node: Input(f"x{k}", "q", k) for k, node in enumerate(values)}
    half = graph.constant(0.5)
    binary = {"add": add, "sub": sub, "mul": mul}
    functions = {"sin": SIN, "cos": COS}
    for step in steps:
        rule = binary.get(step.operation)
        if rule is not None:
            values.append(rule(graph, values[step.a], values[step.b]))
        elif step.operation in functions:
            values.append(apply(graph, functions[step.operation], values[step.a]))
        else:
            values.append(mul(graph, half, values[step.a]))
    return Grown(graph, tuple(values[-_LANES:]), inputs)


def grow_chain(count: int) -> Grown:
    """Return the graph of the transform of a chain so long that it has about `count` nodes."""
    links = count // _NODES_OF_A_LINK + 1
    engine = Engine()
    chain = serial_chain(links)
    entries = chain.build(engine, engine.inputs(chain.inputs))
    return Grown(engine.graph, tuple(entry.index for entry in entries), engine.places)


def fill_plain_lists(count: int) -> object:
    """Store `count` entries as the graph does, without asking anything about them."""
    index: dict[int, int] = {}
    lists: tuple[list[int], ...] = ([], [], [], [])
    first, second, third, fourth = lists
    for k in range(count):
        index[(k << 38) | (k << 6) | 6] = k
        first.append(k)
        second.append(k)
        third.append(k)
        fourth.append(k)
    return index, lists
