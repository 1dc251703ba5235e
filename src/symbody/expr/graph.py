"""The arena: an append-only list of nodes in which equal structure is one node.

A node is an index; its operation and operands lie in parallel lists, children before parents,
so every traversal is a loop over ascending indices. Folding is not done here but in `canonical`,
which is the only caller of `Graph.node`.

Node hashes depend on structure alone (never on object identity, build order or PYTHONHASHSEED),
because the canonical form orders operands by them.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Container, Iterable, Mapping
from copy import copy
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from hashlib import blake2b
from numbers import Integral
from typing import Final, Protocol
from weakref import WeakKeyDictionary

from symbody.errors import ExpressionError, Problem
from symbody.expr.deadline import TICK, check
from symbody.expr.opcodes import ARITY, CALL, FLOAT, MAP, NEG, PI, PICK, RATIONAL, SADDLE, SYMBOL
from symbody.single_flight import fork_safe_lock

# int is used for whole numbers: arithmetic on it is several times faster than on Fraction.
Exact = int | Fraction
Constant = int | Fraction | float


class SymbolKind(StrEnum):
    """What a symbol stands for."""

    TIME = "time"
    COORDINATE = "coordinate"
    SPEED = "speed"
    PARAMETER = "parameter"
    INPUT = "input"
    MULTIPLIER = "multiplier"
    SIGNAL = "signal"


@dataclass(frozen=True, slots=True)
class Symbol:
    """A named quantity.

    Attributes
    ----------
    name : str
        Any text; it is never interpreted.
    kind : SymbolKind
        What it stands for; two kinds with one name are two symbols.
    order : int
        Number of time derivatives taken.
    """

    name: str
    kind: SymbolKind = SymbolKind.PARAMETER
    order: int = 0

    @property
    def label(self) -> str:
        """The name in files and results: ``x``, ``x_dot``, ``x_ddot``."""
        return self.name if self.order == 0 else f"{self.name}_{'d' * self.order}ot"

    @property
    def derivative(self) -> Symbol:
        """The symbol of the time derivative."""
        return Symbol(self.name, self.kind, self.order + 1)


TIME = Symbol("t", SymbolKind.TIME)


class UserFunction(Protocol):
    """A function the user supplies: a table or a Python callable with a declared derivative."""

    @property
    def name(self) -> str:
        """Display name."""

    def __call__(self, *arguments: float) -> float:
        """Return the value."""

    def derivative(self, position: int) -> UserFunction:
        """Return the partial derivative by the argument at `position`."""


class Program(Protocol):
    """Operations that are done alike for several items; see `program`."""

    @property
    def word(self) -> int:
        """A number by which other programs differ, the same in every process."""


@dataclass(frozen=True, slots=True)
class KernelNode:
    """Sizes of one `solve_saddle`: `n` unknown accelerations, `m` constraint rows."""

    n: int
    m: int


# All of a graph but its lock, and what was copied from other living graphs.
_PICKLED: Final = (
    "_index", "_symbol_index", "_whole", "constants", "functions", "hashes", "kernels", "left",
    "operand_tuples", "ops", "programs", "right", "symbols",
)  # fmt: skip


class Graph:
    """Append-only arena of hash-consed nodes, owned by one derivation.

    Reading is free in threads; appending takes the graph's lock.
    """

    __slots__ = (
        "__weakref__", "_copies", "_index", "_lock", "_symbol_index", "_whole", "constants", "functions",
        "hashes", "kernels", "left", "operand_tuples", "ops", "programs", "right", "symbols",
    )  # fmt: skip

    def __init__(self) -> None:
        self.ops: list[int] = []
        self.left: list[int] = []
        self.right: list[int] = []
        self.hashes: list[int] = []
        self.constants: list[Constant] = []
        self.symbols: list[Symbol] = []
        self.operand_tuples: list[tuple[int, ...]] = []
        self.functions: list[UserFunction] = []
        self.kernels: list[KernelNode] = []
        self.programs: list[Program] = []
        self._index: dict[object, int] = {}
        self._symbol_index: dict[Symbol, int] = {}
        self._whole: dict[int, int] = {}  # nodes of whole numbers, the constants most asked for
        self._copies: WeakKeyDictionary[Graph, dict[int, int]] = WeakKeyDictionary()
        self._lock = fork_safe_lock()
        for value in (0, 1, 2):  # so that node i is the constant i: the folding rules rely on it
            self.constant(value)

    def __getstate__(self) -> dict[str, object]:
        with self._lock:
            return {name: copy(getattr(self, name)) for name in _PICKLED}

    def __setstate__(self, state: Mapping[str, object]) -> None:
        for name, value in state.items():
            setattr(self, name, value)
        self._copies = WeakKeyDictionary()
        self._lock = fork_safe_lock()

    def __len__(self) -> int:
        return len(self.ops)

    def __repr__(self) -> str:
        return f"Graph({len(self.ops)} nodes)"

    def node(self, op: int, a: int, b: int = 0) -> int:
        """Return the node `op` of the operands `a` and `b`, making it if it is new. No folding."""
        key = (a << 38) | (b << 6) | op
        found = self._index.get(key)
        if found is not None:
            return found
        hashes = self.hashes
        # CPython hashes tuples of int by a fixed function, so this is the same in every process.
        fingerprint = hash((op, hashes[a], hashes[b])) if ARITY[op] == 2 else hash((op, hashes[a], b))
        return self._append(key, op, a, b, fingerprint)

    def many(self, op: int, operands: tuple[int, ...], datum: int = 0) -> int:
        """Return the node `op` with any number of `operands`; `datum` selects a function or kernel."""
        key = (op, operands, datum)
        found = self._index.get(key)
        if found is not None:
            return found
        word = datum
        if op == CALL:
            word = _text_hash(self.functions[datum].name)
        elif op == SADDLE:
            word = self.kernels[datum].n
        elif op == MAP:
            word = self.programs[datum].word
        fingerprint = hash((op, word, *[self.hashes[k] for k in operands]))
        with self._lock:
            self.operand_tuples.append(operands)
            return self._append(key, op, len(self.operand_tuples) - 1, datum, fingerprint)

    def constant(self, value: Constant) -> int:
        """Return the node of a number; negative ones are NEG of the positive.

        Raises
        ------
        ExpressionError
            For bool, complex, NaN, infinity, or anything that is not a number.
        """
        if type(value) is not int:  # bool is another type, and refused
            return self._constant(value)
        known = self._whole.get(value)
        if known is None:
            known = self._whole[value] = self._constant(value)
        return known

    def _constant(self, value: Constant) -> int:
        kind, number = _classify_constant(value)
        if number < 0 or (kind == FLOAT and math.copysign(1.0, number) < 0):
            return self.node(NEG, self.constant(-number))
        key: object
        if isinstance(number, float):
            key = (FLOAT, bits := struct.unpack("<q", struct.pack("<d", number))[0])
            fingerprint = hash((FLOAT, bits))
        else:
            key = (RATIONAL, number.numerator, number.denominator)
            fingerprint = hash(key)
        found = self._index.get(key)
        if found is not None:
            return found
        with self._lock:
            self.constants.append(number)
            return self._append(key, kind, len(self.constants) - 1, 0, fingerprint)

    def symbol(self, symbol: Symbol) -> int:
        """Return the node of a symbol."""
        found = self._symbol_index.get(symbol)
        if found is not None:
            return found
        with self._lock:
            self.symbols.append(symbol)
            word = _text_hash(f"{symbol.kind.value}/{symbol.order}/{symbol.name}")
            node = self._append(symbol, SYMBOL, len(self.symbols) - 1, 0, hash((SYMBOL, word)))
            self._symbol_index[symbol] = node
            return node

    def pi(self) -> int:
        """Return the node of the circle constant, which stays a symbol until numbers are needed."""
        found = self._index.get(PI)
        return self._append(PI, PI, 0, 0, hash((PI, 0))) if found is None else found

    def function(self, function: UserFunction) -> int:
        """Return the place of a user function, for `many(CALL, operands, place)`."""
        with self._lock:
            if function not in self.functions:
                self.functions.append(function)
            return self.functions.index(function)

    def kernel(self, kernel: KernelNode) -> int:
        """Return the place of a kernel, for `many(SADDLE, operands, place)`."""
        with self._lock:
            if kernel not in self.kernels:
                self.kernels.append(kernel)
            return self.kernels.index(kernel)

    def program(self, program: Program) -> int:
        """Return the place of a program, for `many(MAP, operands, place)`."""
        with self._lock:
            if program not in self.programs:
                self.programs.append(program)
            return self.programs.index(program)

    def operands(self, node: int) -> tuple[int, ...]:
        """Return the nodes that `node` is computed from."""
        arity = ARITY[self.ops[node]]
        if arity == 2:
            return (self.left[node], self.right[node])
        if arity == 1:
            return (self.left[node],)
        return () if arity == 0 else self.operand_tuples[self.left[node]]

    def number(self, node: int) -> Constant | None:
        """Return the value of a constant node, or None."""
        op = self.ops[node]
        if op <= FLOAT:
            return self.constants[self.left[node]]
        if op == NEG and self.ops[self.left[node]] <= FLOAT:
            return -self.constants[self.left[self.left[node]]]
        return None

    def reachable(self, roots: Iterable[int], reached: Container[int] = frozenset()) -> list[int]:
        """Return all nodes the `roots` are computed from, ascending, but `reached` ones and those behind."""
        ops, left, right, tuples = self.ops, self.left, self.right, self.operand_tuples
        seen = {node for node in roots if node not in reached}
        nodes = list(seen)
        for node in nodes:  # it grows meanwhile
            arity = ARITY[ops[node]]
            if arity == 2:
                a, b = left[node], right[node]
                if a not in seen and a not in reached:
                    seen.add(a)
                    nodes.append(a)
                if b not in seen and b not in reached:
                    seen.add(b)
                    nodes.append(b)
            elif arity:
                for a in (left[node],) if arity == 1 else tuples[left[node]]:
                    if a not in seen and a not in reached:
                        seen.add(a)
                        nodes.append(a)
        nodes.sort()
        return nodes

    def datum(self, node: int) -> int:
        """Return the datum of `node`: entry of a PICK, place of a function, kernel or program."""
        return self.right[node] if self.ops[node] in (PICK, CALL, SADDLE, MAP) else 0

    def copies_of(self, other: Graph) -> dict[int, int]:
        """Return the copies made from another living graph: its nodes to nodes of this one."""
        with self._lock:
            return self._copies.setdefault(other, {})

    def _append(self, key: object, op: int, a: int, b: int, fingerprint: int) -> int:
        with self._lock:
            found = self._index.get(key)
            if found is not None:
                return found
            node = len(self.ops)
            if not node & TICK:
                check()
            if len(self.hashes) != node:  # Ctrl-C came between two of the lines below
                for half in (self.hashes, self.left, self.right):
                    del half[node:]
            self.hashes.append(fingerprint)
            self.left.append(a)
            self.right.append(b)
            self.ops.append(op)
            self._index[key] = node
            return node


def copy_nodes(source: Graph, target: Graph, roots: Iterable[int], memo: dict[int, int]) -> list[int]:
    """Copy the `roots` of one graph into another; `memo` (source node to target node) is extended."""
    wanted = list(roots)
    for node in source.reachable(wanted):
        if node not in memo:
            memo[node] = copy_node(source, target, node, memo)
    return [memo[root] for root in wanted]


def copy_node(source: Graph, target: Graph, node: int, memo: Mapping[int, int]) -> int:
    """Copy one node whose operands `memo` has."""
    op = source.ops[node]
    arity = ARITY[op]
    if arity == 2:
        return target.node(op, memo[source.left[node]], memo[source.right[node]])
    if arity == 1:
        return target.node(op, memo[source.left[node]], source.right[node])
    if op <= FLOAT:
        return target.constant(source.constants[source.left[node]])
    if op == SYMBOL:
        return target.symbol(source.symbols[source.left[node]])
    if op == PI:
        return target.pi()
    operands = tuple(memo[k] for k in source.operands(node))
    return target.many(op, operands, copied_datum(source, target, node))


def copied_datum(source: Graph, target: Graph, node: int) -> int:
    """Return the content of `datum` of a node, for a node of the same kind in another graph."""
    op, datum = source.ops[node], source.datum(node)
    if op == CALL:
        return target.function(source.functions[datum])
    if op == SADDLE:
        return target.kernel(source.kernels[datum])
    return target.program(source.programs[datum]) if op == MAP else datum


def _text_hash(text: str) -> int:
    return int.from_bytes(blake2b(text.encode("utf-8", "surrogatepass"), digest_size=7).digest(), "little")


def _classify_constant(value: Constant) -> tuple[int, Constant]:
    if isinstance(value, Integral) and not isinstance(value, bool):
        return RATIONAL, int(value)
    if isinstance(value, Fraction):
        return RATIONAL, value.numerator if value.denominator == 1 else value
    if isinstance(value, float) and math.isfinite(value):
        return FLOAT, float(value)
    raise ExpressionError(
        Problem(
            "expression.not_a_number",
            "",
            f"{value!r} of type {type(value).__name__} cannot appear in an expression",
            "only finite real numbers can: no bool, complex, NaN, infinity or text",
            "give an int, a Fraction or a finite float; pass text through symbody's parser",
        )
    )
