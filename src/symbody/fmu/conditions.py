"""Conditions in the formulas of a model: the branches that stay as they are between events of model exchange.

``if(x > 0, a, b)``, min, max, abs, sign and floor have branches. Each is decided by one number that passes
zero, or by the whole number below a value. An FMU decides in event mode, and keeps to it until the next.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass, replace
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import ModalEquations
from symbody.expr import canonical
from symbody.expr import opcodes as op
from symbody.expr.graph import TIME, Graph
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Operation, Output, Sequence

Point = Mapping[str, list[float]]

OUTPUT: Final = "sides of conditions"
_COMPARISONS: Final = frozenset({op.LT, op.LE, op.MIN, op.MAX})
_BRANCHED: Final = _COMPARISONS | {op.ABS, op.SIGN, op.FLOOR}
# A value that is compared with more numbers than this is looked up in a table, which is continuous.
_MOST_BOUNDS: Final = 4
_ROUNDING: Final = 1e-9  # of both numbers that are compared


@dataclass(frozen=True, slots=True)
class Condition:
    """What decides a branch.

    Attributes
    ----------
    node : int
        Of the graph: a number whose sign decides, or of which the whole number below does.
    is_floor : bool
        Which of both.
    reads : tuple of str
        The quantities that it depends on, but parameters.
    """

    node: int
    is_floor: bool
    reads: tuple[str, ...]


def find_conditions(modal: ModalEquations) -> tuple[Condition, ...]:
    """Return the conditions in forces, constraints and signals that depend on the state or on inputs.

    Those in time alone are breakpoints of the motion; those that depend on accelerations are left out, and
    modes, which have events of their own.
    """
    eqs, formed = modal.eqs, modal.eqs.formed
    graph = formed.graph
    inputs = {symbol for symbol in formed.inputs if symbol.name not in modal.modes}
    moving = {*formed.u, *formed.q, *formed.signal_states, *inputs}
    usable = moving | {TIME, *formed.parameters}
    nodes = [node for node in graph.reachable(_formula_nodes(eqs)) if graph.ops[node] in _BRANCHED]
    bounds = Counter(graph.operands(node)[0] for node in nodes if _has_bound(graph, node))
    made: dict[tuple[int, bool], Condition] = {}
    for node in nodes:
        decisive, is_floor = _decisive(graph, node), graph.ops[node] == op.FLOOR
        symbols = {graph.symbols[graph.left[k]] for k in symbols_of(graph, [decisive])}
        is_table = _has_bound(graph, node) and bounds[graph.operands(node)[0]] > _MOST_BOUNDS
        if (
            is_table
            or symbols.isdisjoint(moving)
            or not symbols <= usable
            or any(graph.ops[k] == op.SADDLE for k in graph.reachable([decisive]))
        ):
            continue
        if (canonical.neg(graph, decisive), is_floor) not in made:
            reads = tuple(sorted(symbol.label for symbol in symbols.intersection(moving)))
            made.setdefault((decisive, is_floor), Condition(decisive, is_floor, reads))
    return tuple(made.values())


def _formula_nodes(eqs: EquationSet) -> Iterator[int]:
    formed = eqs.formed
    for force in formed.dynamics.forcing:
        yield force.index
    for row in formed.rows:
        for part in (row.value, row.drift, row.gamma, *row.jacobian.values()):
            yield part.index
    if formed.signal_states:
        yield from eqs.roots("signal_rates").nodes


def _has_bound(graph: Graph, node: int) -> bool:
    return graph.ops[node] in (op.LT, op.LE) and graph.number(graph.operands(node)[1]) is not None


def _decisive(graph: Graph, node: int) -> int:
    """Return the number whose sign, or whose whole part, decides."""
    operands = graph.operands(node)
    return canonical.sub(graph, *operands) if graph.ops[node] in _COMPARISONS else operands[0]


@dataclass(frozen=True, slots=True)
class Branches:
    """Numbers that decide, at some points, by which they are recognized in any sequence.

    Attributes
    ----------
    points : tuple of mapping of group to numbers
        Arguments of all sequences.
    values : tuple of tuple of float
        What decides: a tuple a point.
    are_floors : tuple of bool
        Whether the whole number below decides, not the sign.
    first : int
        Place of the first argument in p: a sign, -1, 0 or 1, or a whole number.
    """

    points: tuple[Point, ...]
    values: tuple[tuple[float, ...], ...]
    are_floors: tuple[bool, ...]
    first: int

    def freeze(self, sequence: Sequence) -> Sequence:
        """Return a sequence that takes branches by its arguments."""
        places = [k for k, operation in enumerate(sequence.operations) if operation.op in _BRANCHED]
        if not places or not self.are_floors:
            return sequence
        decided = self._recognize(sequence, places)
        return _rewrite(sequence, decided, self.first) if decided else sequence

    def _recognize(self, sequence: Sequence, places: Items[int]) -> dict[int, tuple[int, int]]:
        """Return the branch and the sign of what decides each operation, of those that are known."""
        pairs = [_comparison(sequence, k) for k in places]
        shown = [k for pair in pairs for k in pair if k >= 0]
        wider = replace(sequence, outputs=(Output("compared", (len(shown),), tuple(shown)),))
        rows = [evaluate_sequence(wider, point)[0] for point in self.points]
        decided: dict[int, tuple[int, int]] = {}
        place = 0
        for operation, pair in zip(places, pairs, strict=True):
            count = sum(k >= 0 for k in pair)
            numbers = [(row[place], row[place + 1] if count == 2 else 0.0) for row in rows]
            place += count
            is_floor = sequence.operations[operation].op == op.FLOOR
            match = self._match(numbers, is_floor)
            if match is not None:
                decided[operation] = match
        return decided

    def _match(self, numbers: Items[tuple[float, float]], is_floor: bool) -> tuple[int, int] | None:
        for k, kind in enumerate(self.are_floors):
            for sign in (1,) if is_floor else (1, -1):
                if kind == is_floor and all(
                    abs((a - b) - sign * row[k]) <= _ROUNDING * (abs(a) + abs(b)) and math.isfinite(row[k])
                    for (a, b), row in zip(numbers, self.values, strict=True)
                ):
                    return k, sign
        return None


def _comparison(sequence: Sequence, place: int) -> tuple[int, int]:
    """Return the two values that are compared; -1 stands for 0."""
    operation = sequence.operations[place]
    a, *others = operation.operands
    return a, others[0] if operation.op in _COMPARISONS else -1


def _rewrite(sequence: Sequence, decided: Mapping[int, tuple[int, int]], first: int) -> Sequence:
    """Return the sequence with the operations decided replaced; new ones stand before what reads them."""
    inputs, constants = list(sequence.inputs), list(sequence.constants)
    operations: list[Operation] = []
    moved: list[int] = []
    sides: dict[int, int] = {}

    def add(code: int, operands: tuple[int, ...] = (), datum: int = 0) -> int:
        operations.append(Operation(code, operands, datum))
        return len(operations) - 1

    constants.append(0)
    zero = add(op.RATIONAL, (), len(constants) - 1)
    for branch in sorted({branch for branch, _ in decided.values()}):
        inputs.append(Input(f"side {branch}", "p", first + branch))
        sides[branch] = add(op.SYMBOL, (), len(inputs) - 1)
    for k, operation in enumerate(sequence.operations):
        operands = tuple(moved[j] for j in operation.operands)
        if k not in decided:
            moved.append(add(operation.op, operands, operation.datum))
            continue
        branch, sign = decided[k]
        side = sides[branch]
        below = (side, zero) if sign > 0 else (zero, side)
        if operation.op == op.FLOOR:
            moved.append(side)
        elif operation.op == op.SIGN:
            moved.append(side if sign > 0 else add(op.NEG, (side,)))
        elif operation.op in (op.LT, op.LE):
            moved.append(add(operation.op, below))
        elif operation.op == op.ABS:
            opposite = add(op.NEG, operands)
            moved.append(add(op.SELECT, (add(op.LT, below), opposite, operands[0])))
        else:  # the smaller is the first where the difference is below 0
            order = operands if operation.op == op.MIN else operands[::-1]
            chosen = add(op.LT, below)
            moved.append(add(op.SELECT, (chosen, *order)))
    outputs = tuple(replace(o, values=tuple(moved[k] for k in o.values)) for o in sequence.outputs)
    return replace(
        sequence,
        inputs=tuple(inputs),
        constants=tuple(constants),
        operations=tuple(operations),
        outputs=outputs,
    )
