"""One program for several items: equal operations on columns of numbers, side by side in machine code.

A program is a Sequence of one output, with inputs "p" that all items share and inputs "q" of each item. In
the graph it is a MAP node with a PICK for every result; where it is not known, it is written out.
"""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Sequence as Items
from dataclasses import replace

from symbody.expr.canonical import make
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Constant, Graph, Symbol
from symbody.expr.opcodes import FLOAT, MAP, PICK, RATIONAL, SYMBOL
from symbody.expr.sequences.sequence import Input, Operation, Output, Roots, Sequence, build_sequence

Compute = Callable[[list[Expr], list[Expr]], Items[Expr]]


def trace(shared: int, per_item: int, compute: Compute) -> tuple[Sequence, list[int], list[int]]:
    """Return the program of `compute`.

    Parameters
    ----------
    shared, per_item : int
        Number of values shared by all items, and of values of each item.
    compute : callable
        Of both as expressions; it returns the results.

    Returns
    -------
    (program, read, own_read)
        Which of the numbers are read: only they are operands.
    """
    graph = Graph()
    groups = [
        [symbol(graph, Symbol(f"{group}{k}")) for k in range(count)]
        for group, count in (("p", shared), ("q", per_item))
    ]
    results = compute(*groups)
    places = {
        x.index: Input(f"{group}{k}", group, k)
        for group, row in zip("pq", groups, strict=True)
        for k, x in enumerate(row)
    }
    roots = Roots("results", (len(results),), tuple(x.index for x in results))
    program = build_sequence(graph, [roots], places)
    read = {group: sorted(x.position for x in program.inputs if x.group == group) for group in "pq"}
    inputs = tuple(Input(x.name, x.group, read[x.group].index(x.position)) for x in program.inputs)
    return replace(program, inputs=inputs), read["p"], read["q"]


def map_program(
    graph: Graph, shared: Items[Expr], per_item: Items[Items[Expr]], compute: Compute
) -> list[list[Expr]]:
    """Return the results of `compute` for several items: one row a result, one column an item.

    Parameters
    ----------
    shared : sequence of Expr
        What all items read.
    per_item : sequence of rows
        What each item reads, one row a number, one column an item. Rows of one and the same constant become
        part of the program.
    """
    fixed = [row[0].number if len({x.index for x in row}) == 1 else None for row in per_item]
    if None not in fixed:
        fixed[0] = None
    free = [k for k, value in enumerate(fixed) if value is None]

    def compute_rest(given: list[Expr], numbers: list[Expr]) -> Items[Expr]:
        left = iter(numbers)
        inside = (*given, *numbers)[0].graph
        return compute(given, [next(left) if value is None else number(inside, value) for value in fixed])

    count = len(per_item[0])
    program, read, own_read = trace(len(shared), len(free), compute_rest)
    if not own_read:  # the same for all
        return [[x] * count for x in compute(list(shared), [row[0] for row in per_item])]
    operands = [shared[k].index for k in read] + [x.index for k in own_read for x in per_item[free[k]]]
    node = graph.many(MAP, tuple(operands), graph.program(program))
    return [
        [Expr(graph, graph.node(PICK, node, k * count + i)) for i in range(count)]
        for k in range(program.output_size)
    ]


def written_out(sequence: Sequence) -> Sequence:
    """Return the sequence with the operations of every item, one after the other; same bits."""
    if all(operation.op != MAP for operation in sequence.operations):
        return sequence
    operations: list[Operation] = []
    constants = list(sequence.constants)
    places: list[int] = []
    results: dict[int, list[int]] = {}

    def add(op: int, operands: tuple[int, ...], datum: int = 0) -> int:
        operations.append(Operation(op, operands, datum))
        return len(operations) - 1

    def constant(value: Constant) -> int:
        constants.append(value)
        return add(FLOAT if isinstance(value, float) else RATIONAL, (), len(constants) - 1)

    for k, operation in enumerate(sequence.operations):
        operands = tuple(places[j] for j in operation.operands if j not in results)
        if operation.op == MAP:
            program, count = sequence.programs[operation.datum], sequence.item_count(operation)
            results[k] = _items(program, operands, count, constant, add)
            places.append(-1)
        elif operation.op == PICK and operation.operands[0] in results:
            places.append(results[operation.operands[0]][operation.datum])
        else:
            places.append(add(operation.op, operands, operation.datum))
    outputs = tuple(
        Output(output.name, output.shape, tuple(places[k] for k in output.values))
        for output in sequence.outputs
    )
    return replace(
        sequence, operations=tuple(operations), constants=tuple(constants), outputs=outputs, programs=()
    )


def unroll(graph: Graph, roots: Items[int]) -> list[int]:
    """Return the `roots` without programs, in nodes that can be differentiated."""
    memo: dict[int, int] = {}
    results: dict[int, list[int]] = {}
    for node in graph.reachable(roots):
        old = graph.operands(node)
        op = graph.ops[node]
        if op == MAP:
            program = graph.programs[graph.datum(node)]
            assert isinstance(program, Sequence)
            operands = tuple(memo.get(k, k) for k in old)
            count = (len(operands) - program.group_size("p")) // program.group_size("q")
            results[node] = _items(
                program, operands, count, graph.constant, lambda op, given: make(graph, op, given)
            )
        elif op == PICK and old[0] in results:
            memo[node] = results[old[0]][graph.datum(node)]
        elif not memo.keys().isdisjoint(old):
            memo[node] = make(graph, op, tuple(memo.get(k, k) for k in old), graph.datum(node))
    return [memo.get(root, root) for root in roots]


def _items(
    program: Sequence,
    operands: tuple[int, ...],
    count: int,
    constant: Callable[[Constant], int],
    add: Callable[[int, tuple[int, ...]], int],
) -> list[int]:
    """Return the results of a program for `count` items, written out, in the order of its PICKs."""
    shared = program.group_size("p")
    results: list[list[int]] = []
    for item in range(count):
        values: list[int] = []
        for op, inside, datum in program.operations:
            if op == SYMBOL:
                entry = program.inputs[datum]
                place = entry.position if entry.group == "p" else shared + entry.position * count + item
                values.append(operands[place])
            elif op in (RATIONAL, FLOAT):
                values.append(constant(program.constants[datum]))
            else:
                values.append(add(op, tuple(values[k] for k in inside)))
        results.append([values[k] for k in program.outputs[0].values])
    return [value for values in zip(*results, strict=True) for value in values]
