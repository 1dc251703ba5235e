"""What a node of the graph costs: time and memory while it is made, time of the passes over it.

No peer does the same, so figures stand beside the house's own bars, and beside a yardstick that belongs to
the machine: putting as many keys into a dictionary and as many numbers into four lists as the graph does.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from benchmarks.engines.ours import Engine
from benchmarks.problems import Step, random_program, serial_chain
from benchmarks.table import Table
from benchmarks.timing import Settings, in_turns, medians, processor_seconds
from symbody.expr.canonical import add, apply, mul, sub
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.graph import Graph, Symbol
from symbody.expr.opcodes import COS, SIN
from symbody.expr.sequences.sequence import Input, Roots, build_sequence

_COUNT: Final = 1_000_000
_INPUTS: Final = 8
_LANES: Final = 60
_NODES_OF_A_STEP: Final = 1.44  # differences bring signs with them
_NODES_OF_A_LINK: Final = 68

BUILD_BAR: Final = 4.0  # us a node, folding included
MEMORY_BAR: Final = 250.0  # bytes a node


@dataclass(frozen=True, slots=True)
class Grown:
    """A graph and what is to be computed with it."""

    graph: Graph
    roots: tuple[int, ...]
    inputs: Mapping[int, Input]


Grower = Callable[[], Grown]


def tables(settings: Settings, count: int = _COUNT) -> Iterator[Table]:
    """Yield the table for graphs of about `count` nodes; the passes run over a fifth of that."""
    yardstick = _microseconds({"": partial(fill_plain_lists, count)}, settings.rounds)[""] / count
    rows = [("yardstick: a dictionary and four lists", f"{yardstick:.2f} us", "", "", "1")]
    notes = [
        f"processor time, medians of {settings.rounds} rounds",
        "4x4 products: of 224 sums and products by operators, 68 become nodes; the rest folds away",
    ]
    for name, grow in (("random operations", grow_random), ("4x4 products by operators", grow_chain)):
        prepared, smaller = grow(count), grow(count // 5)
        size, nodes = len(prepared().graph), _nodes_of(smaller())
        notes.append(f"{name}: {size} nodes made, passes over {nodes}")
        for what, figure in _figures(prepared, smaller, settings.rounds).items():
            bar = BUILD_BAR if what == "build" else None
            cells = (f"{figure:.2f} us", *_judged(figure, bar, "us"), f"{figure / yardstick:.1f}")
            rows.append((f"{name}: {what}", *cells))
        memory = bytes_per_node(prepared)
        rows.append((f"{name}: memory", f"{memory:.0f} bytes", *_judged(memory, MEMORY_BAR, "bytes"), ""))
    columns = ("per node", "measured", "bar", "of the bar", "of the yardstick")
    yield Table("the expression graph", columns, tuple(rows), tuple(notes))


def _judged(figure: float, bar: float | None, unit: str) -> tuple[str, str]:
    return ("", "") if bar is None else (f"{bar:g} {unit}", f"{100 * figure / bar:.0f} %")


def _figures(grow: Grower, grow_smaller: Grower, rounds: int) -> dict[str, float]:
    """Return microseconds a node by what was done."""
    small = grow_smaller()
    nodes = small.graph.reachable(small.roots)
    roots = [Roots("all", (len(small.roots),), small.roots)]
    found = _microseconds(
        {
            "build": grow,
            "fingerprints": lambda: fingerprints(small.graph, nodes),
            "build_sequence": lambda: build_sequence(small.graph, roots, small.inputs),
        },
        rounds,
    )
    size = len(grow().graph)
    return {name: figure / (size if name == "build" else len(nodes)) for name, figure in found.items()}


def _microseconds(tasks: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    timed = {name: partial(processor_seconds, task) for name, task in tasks.items()}
    return {name: 1e6 * figure for name, figure in medians(in_turns(timed, rounds)).items()}


def _nodes_of(grown: Grown) -> int:
    return len(grown.graph.reachable(grown.roots))


def bytes_per_node(grow: Grower) -> float:
    """Return the memory that a graph keeps, divided by its nodes."""
    tracemalloc.start()
    try:
        graph = grow().graph
        return tracemalloc.get_traced_memory()[0] / len(graph)
    finally:
        tracemalloc.stop()


def grow_random(count: int) -> Grower:
    """Return what makes the graph of a random program, about `count` nodes; lanes end in roots."""
    return partial(_run, random_program(round(count / _NODES_OF_A_STEP), _INPUTS, _LANES))


def _run(steps: Sequence[Step]) -> Grown:
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


def grow_chain(count: int) -> Grower:
    """Return what makes the graph of a chain's transform, about `count` nodes."""
    return partial(_multiply, count // _NODES_OF_A_LINK + 1)


def _multiply(links: int) -> Grown:
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
