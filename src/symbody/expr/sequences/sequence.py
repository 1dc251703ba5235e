"""The computational sequence: what the graph becomes when numbers are wanted.

A Sequence is a straight line of operations without branches, pruned to the outputs asked for, with
every value computed once. Nothing in it is mechanics; a language writer needs nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass, replace
from hashlib import blake2b
from typing import Final, NamedTuple

from symbody.errors import CompileError, Problem
from symbody.expr.deadline import check
from symbody.expr.fingerprints.merging import contract_products, merge_equal
from symbody.expr.graph import Constant, Graph, KernelNode, UserFunction, copy_nodes
from symbody.expr.opcodes import (
    ADD,
    CONDITIONS,
    COST,
    DIV,
    FLOAT,
    FMA,
    LEAVES,
    MAP,
    POW,
    RATIONAL,
    SADDLE,
    SYMBOL,
)
from symbody.expr.rewrite import multiplications

__all__ = ["Input", "KernelNode", "Operation", "Output", "Roots", "Sequence", "build_sequence"]

# Values that only certain operations can read: they are not handed from one sequence to another.
_NO_NUMBERS: Final = CONDITIONS | {SADDLE, MAP}


class Operation(NamedTuple):
    """One value: operation code, the numbers of earlier values, and what else defines it.

    `datum` is the place of an input, constant, kernel, program or function, or the entry of a PICK.
    """

    op: int
    operands: tuple[int, ...]
    datum: int = 0


@dataclass(frozen=True, slots=True)
class Input:
    """One number given at call time: its name, its group (t, q, u, r, p or c) and place therein."""

    name: str
    group: str
    position: int


@dataclass(frozen=True, slots=True)
class Output:
    """One result: name, shape, and the numbers of its values in row-major order."""

    name: str
    shape: tuple[int, ...]
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Roots:
    """One result before sequencing.

    Attributes
    ----------
    name : str
    shape : tuple of int
    nodes : tuple of int
        Of a graph, in row-major order.
    given : tuple of int
        What is computed on the way to `nodes`, in the way it is where it is asked for alone.
    """

    name: str
    shape: tuple[int, ...]
    nodes: tuple[int, ...]
    given: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Sequence:
    """Straight-line program; value k is defined by ``operations[k]``.

    Attributes
    ----------
    programs : tuple of Sequence
        What is done alike for several items: each has one output, inputs "p" that all items share and inputs
        "q" of each item. A MAP has as operands all "p", then "q" 0 of all items, "q" 1 of all items, ...; its
        PICKs count in the same way through the results.
    """

    inputs: tuple[Input, ...]
    constants: tuple[Constant, ...]
    kernels: tuple[KernelNode, ...]
    functions: tuple[UserFunction, ...]
    operations: tuple[Operation, ...]
    outputs: tuple[Output, ...]
    programs: tuple[Sequence, ...] = ()

    @property
    def operation_count(self) -> int:
        """Operations of one evaluation: + - * / and functions 1, negation 0, fma 2, powers by squaring."""
        return sum(self._operation_count(operation) for operation in self.operations)

    def group_size(self, group: str) -> int:
        """Return how many numbers of a group are read, counting gaps."""
        return max((entry.position + 1 for entry in self.inputs if entry.group == group), default=0)

    @property
    def output_size(self) -> int:
        """Number of all results together."""
        return sum(len(output.values) for output in self.outputs)

    @property
    def word(self) -> int:
        """A number by which other sequences differ, the same in every process."""
        content = (self.inputs, self.constants, self.kernels, self.operations, self.outputs, self.programs)
        return int.from_bytes(blake2b(repr(content).encode(), digest_size=7).digest(), "little")

    def item_count(self, operation: Operation) -> int:
        """Return for how many items a MAP does its program."""
        program = self.programs[operation.datum]
        return (len(operation.operands) - program.group_size("p")) // program.group_size("q")

    def _operation_count(self, operation: Operation) -> int:
        if operation.op == POW:
            exponent = self.constant_value(operation.operands[1])
            if isinstance(exponent, int):
                return multiplications(exponent)
        if operation.op == MAP:
            return self.item_count(operation) * self.programs[operation.datum].operation_count
        return COST[operation.op]

    def constant_value(self, value: int) -> Constant | None:
        """Return the number if `value` is a constant, else None."""
        operation = self.operations[value]
        return self.constants[operation.datum] if operation.op in (RATIONAL, FLOAT) else None

    def split(self, groups: Iterable[str]) -> tuple[Sequence, Sequence]:
        """Split into what depends on `groups` alone and the rest.

        Returns
        -------
        (head, tail)
            `head` has one output "c"; `tail` reads it as the group "c".
        """
        chosen = frozenset(groups)
        early = self._depends_only_on(chosen)
        is_read = self._read_late(early)
        whole = LEAVES - {SYMBOL} | _NO_NUMBERS
        cut = [k for k, operation in enumerate(self.operations) if is_read[k] and operation.op not in whole]
        head = self._with_outputs((Output("c", (len(cut),), tuple(cut)),))
        return head, self._reading_from(cut)

    def _read_late(self, early: Items[bool]) -> list[bool]:
        """Return which `early` values outputs and the other operations read."""
        is_read = [False] * len(self.operations)
        late = (
            entry.operands for is_early, entry in zip(early, self.operations, strict=True) if not is_early
        )
        for operands in (*late, *(output.values for output in self.outputs)):
            for k in operands:
                is_read[k] = True
        for k in range(len(self.operations) - 1, -1, -1):
            if is_read[k] and self.operations[k].op in _NO_NUMBERS:
                for operand in self.operations[k].operands:
                    is_read[operand] = True
        return [is_early and also for is_early, also in zip(early, is_read, strict=True)]

    def _depends_only_on(self, groups: frozenset[str]) -> list[bool]:
        result: list[bool] = []
        for op, operands, datum in self.operations:
            if len(operands) == 2:  # most have two
                result.append(result[operands[0]] and result[operands[1]])
            elif op == SYMBOL:
                result.append(self.inputs[datum].group in groups)
            else:
                result.append(all([result[k] for k in operands]))
        return result

    def _reading_from(self, cut: list[int]) -> Sequence:
        count = len(self.inputs)
        inputs = (*self.inputs, *(Input(f"c{k}", "c", k) for k in range(len(cut))))
        operations = list(self.operations)
        for k, value in enumerate(cut):
            operations[value] = Operation(SYMBOL, (), count + k)
        return replace(self, inputs=inputs, operations=tuple(operations))._with_outputs(self.outputs)

    def _with_outputs(self, outputs: tuple[Output, ...]) -> Sequence:
        """Return the sequence pruned to `outputs`."""
        used = [False] * len(self.operations)
        for output in outputs:
            for k in output.values:
                used[k] = True
        for k in range(len(self.operations) - 1, -1, -1):
            if used[k]:
                for operand in self.operations[k].operands:
                    used[operand] = True
        number = [0] * len(self.operations)
        operations: list[Operation] = []
        for k, operation in enumerate(self.operations):
            if not used[k]:
                continue
            number[k] = new = len(operations)
            if new < k:  # something before it is gone, so what it reads may have moved
                moved = tuple([number[j] for j in operation.operands])
                operation = Operation(operation.op, moved, operation.datum)
            operations.append(operation)
        moved_outputs = tuple(
            Output(output.name, output.shape, tuple([number[k] for k in output.values])) for output in outputs
        )
        return replace(self, operations=tuple(operations), outputs=moved_outputs)


def build_sequence(
    graph: Graph,
    outputs: Items[Roots],
    inputs: Mapping[int, Input],
    *,
    merge: bool = True,
    contract: bool = True,
) -> Sequence:
    """Return the sequence that computes `outputs`.

    Parameters
    ----------
    inputs : mapping of node to Input
        Where each symbol is found at call time.
    merge, contract : bool
        Whether equal values are merged by fingerprint, and products fused with sums.

    Raises
    ------
    CompileError
        If an output depends on symbols that `inputs` does not have, naming all of them.
    """
    target = Graph()
    finished: list[Roots] = []
    for output in outputs:  # one by one: see merging.py
        wanted = (*output.nodes, *output.given)
        if merge:
            nodes = merge_equal(graph, wanted, target, output.given)
        else:
            nodes = copy_nodes(graph, target, wanted, {})
        count = len(output.nodes)
        if contract:
            nodes = contract_products(target, nodes, nodes[count:])
        nodes = nodes[:count]
        check()
        finished.append(Roots(output.name, output.shape, tuple(nodes)))
    check()
    places = {graph.symbols[graph.left[node]]: entry for node, entry in inputs.items()}
    return _linearize_graph(target, finished, [places.get(name) for name in target.symbols])


def _linearize_graph(graph: Graph, outputs: Items[Roots], inputs: Items[Input | None]) -> Sequence:
    order = graph.reachable(node for output in outputs for node in output.nodes)
    missing = {k for k, entry in enumerate(inputs) if entry is None}
    unknown = [graph.left[n] for n in order if graph.ops[n] == SYMBOL and graph.left[n] in missing]
    if unknown:
        names = ", ".join(graph.symbols[k].label for k in unknown)
        raise CompileError(
            Problem("compile.unknown_symbol", "", f"no value is given for {names}",
                    "the outputs depend on symbols that are neither inputs nor have a number",
                    "give them in parameters=; compile and generate_code take them by free=[...]")
        )  # fmt: skip
    used: list[Input] = []
    constants: list[Constant] = []
    number = [0] * len(graph)
    operations: list[Operation] = []
    ops, left, right, tuples = graph.ops, graph.left, graph.right, graph.operand_tuples
    for place, node in enumerate(order):
        op, datum = ops[node], 0
        number[node] = place
        if ADD <= op <= DIV:  # most are these, or fused
            operations.append(Operation(op, (number[left[node]], number[right[node]])))
            continue
        if op == FMA:
            a, b, c = tuples[left[node]]
            operations.append(Operation(op, (number[a], number[b], number[c])))
            continue
        if op == SYMBOL:
            datum = len(used)
            entry = inputs[graph.left[node]]
            used.extend([entry] if entry is not None else [])
        elif op in (RATIONAL, FLOAT):
            datum = len(constants)
            constants.append(graph.constants[graph.left[node]])
        else:
            datum = graph.datum(node)
        operations.append(Operation(op, tuple([number[k] for k in graph.operands(node)]), datum))
    return Sequence(
        tuple(used), tuple(constants), tuple(graph.kernels), tuple(graph.functions), tuple(operations),
        tuple(Output(o.name, o.shape, tuple([number[node] for node in o.nodes])) for o in outputs),
        tuple(program for program in graph.programs if isinstance(program, Sequence)),
    )  # fmt: skip
