"""What equations compute from time and parameters alone, evaluated at many times at once.

A sequence of operations is cut where states enter: what lies before is evaluated by NumPy at any times, so
that inputs, prescribed motions and conditions can be looked at before a mechanism moves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation
from symbody.expr.sequences.sequence import Sequence as Program
from symbody.simulation.inputs.tables import Table

Floats = NDArray[np.float64]
Places = NDArray[np.intp]
Flags = NDArray[np.bool_]


def _select(condition: Floats, then: Floats, otherwise: Floats) -> Floats:
    found: Floats = np.where(condition != 0.0, then, otherwise)
    return found


# What any other operation computes counts as unknown before the motion.
FUNCTIONS: Final[Mapping[int, Callable[..., Floats]]] = MappingProxyType(
    {
        op.NEG: np.negative, op.ADD: np.add, op.SUB: np.subtract, op.MUL: np.multiply, op.DIV: np.divide,
        op.POW: np.power, op.SIN: np.sin, op.COS: np.cos, op.TAN: np.tan, op.ASIN: np.arcsin,
        op.ACOS: np.arccos, op.ATAN: np.arctan, op.SINH: np.sinh, op.COSH: np.cosh, op.TANH: np.tanh,
        op.EXP: np.exp, op.LOG: np.log, op.SQRT: np.sqrt, op.ABS: np.abs, op.SIGN: np.sign,
        op.FLOOR: np.floor, op.MIN: np.minimum, op.MAX: np.maximum,
        op.ATAN2: lambda y, x: np.arctan2(y + 0.0, x),
        op.LT: lambda a, b: np.less(a, b) * 1.0, op.LE: lambda a, b: np.less_equal(a, b) * 1.0,
        op.EQ: lambda a, b: np.equal(a, b) * 1.0, op.AND: np.minimum, op.OR: np.maximum,
        op.NOT: lambda a: 1.0 - a, op.SELECT: _select,
        op.FMA: lambda a, b, c: a * b + c,
    }
)  # fmt: skip

# These change their formula at zeros of the difference of their operands, or of their (first) operand.
_OF_TWO: Final = frozenset({op.LT, op.LE, op.EQ, op.MIN, op.MAX})
_OF_ONE: Final = frozenset({op.ABS, op.SIGN, op.ATAN2, op.FLOOR})


@dataclass(frozen=True, slots=True, eq=False)
class TimeFunctions:
    """Values that depend on time, and perhaps on parameters and tables, and on nothing else.

    Attributes
    ----------
    operations : tuple of Operation
        As in a sequence: value k is defined by ``operations[k]``.
    numbers : (n,) array
        The values of constants.
    names : tuple of (group, place)
        What each SYMBOL stands for: time "t", a free parameter "p", an input "r" that is a table.
    tables : mapping of place to Table
        The inputs that are tables.
    shown : (k,) array
        The values that are results, or read by what depends on the state.
    moves, is_affine : (n,) arrays of bool
        Which values depend on time, and which are affine functions of it.
    known_switches, open_switches : arrays
        The values whose formula changes at certain times, with affine operands and with others.
    before_open : array
        What the operands of the open switches are computed from, ascending.
    steep : array
        The values that may be anything between samples of their operands.
    steps : tuple of StepFunction
        What the operations `STEPS` are, by their data.
    """

    operations: tuple[Operation, ...]
    numbers: Floats
    names: tuple[tuple[str, int], ...]
    tables: Mapping[int, Table]
    shown: Places
    moves: Flags
    is_affine: Flags
    known_switches: Places
    open_switches: Places
    before_open: Places
    steep: Places
    steps: tuple[StepFunction, ...] = ()

    @property
    def are_straight(self) -> bool:
        """Whether all values are affine functions of time, so that nothing changes on the way."""
        return bool(self.is_affine.all()) and not self.known_switches.size

    def values(self, t: Floats, p: Floats, only: Places | None = None) -> Floats:
        """Return all values (n, N), or some, at times (N,) with free parameters (n_p, N)."""
        rows = np.zeros((len(self.operations), t.size))
        with np.errstate(all="ignore"):
            for k in range(len(self.operations)) if only is None else only.tolist():
                code, operands, datum = self.operations[k]
                if code == op.SYMBOL:
                    group, place = self.names[datum]
                    rows[k] = t if group == "t" else p[place] if group == "p" else self.tables[place].at(t)
                elif code in op.LEAVES:
                    rows[k] = self.numbers[k]
                elif code == STEPS:
                    rows[k] = self.steps[datum].evaluate(rows[operands[0]])
                else:
                    rows[k] = FUNCTIONS[code](*[rows[place] for place in operands])
        return rows

    def differences(self, values: Floats, switches: Places) -> Floats:
        """Return what is zero where switches change their formula, from all values (n, ...): (s, ...)."""
        found = np.empty((switches.size, *values.shape[1:]))
        for row, k in enumerate(switches):
            code, operands, _ = self.operations[k]
            first = values[operands[0]]
            found[row] = first - values[operands[1]] if code in _OF_TWO else first
        return found

    def counts(self, switches: Places) -> Flags:
        """Return which switches change their formula wherever their operand passes a whole number."""
        return np.array([self.operations[k].op == op.FLOOR for k in switches], dtype=np.bool_)

    def exact_zeros(self, k: int, values: Floats) -> Floats | None:
        """Return when a switch changes that compares time itself with a constant; None: it does not."""
        code, operands, _ = self.operations[k]
        if code in _OF_TWO:
            for mine, other in (operands, operands[::-1]):
                is_time = self.operations[mine].op == op.SYMBOL and self.moves[mine]
                if is_time and not self.moves[other]:
                    return np.asarray(values[other], dtype=np.float64)
        return None

    def needs_parameters(self) -> bool:
        """Return whether free parameters enter in other ways than as factors and summands."""
        varies = np.zeros(len(self.operations), dtype=np.bool_)
        for k, (code, operands, datum) in enumerate(self.operations):
            varies[k] = code == op.SYMBOL and self.names[datum][0] == "p"
            varies[k] |= any(varies[place] for place in operands)
            if self.moves[k] and any(varies[place] for place in self._decisive(code, operands)):
                return True
        return False

    def _decisive(self, code: int, operands: tuple[int, ...]) -> tuple[int, ...]:
        """Return the operands by which an operation that depends on time is not merely scaled or shifted."""
        if code in _LINEAR:
            return ()
        if code == op.DIV:
            return operands[1:] if self.moves[operands[1]] else ()
        return operands[:1] if code == op.SELECT else operands


# DIV is as well, and a SYMBOL that is a table; small powers and the sine show themselves in their samples.
_STEEP: Final = frozenset(
    {op.POW, op.EXP, op.SINH, op.COSH, op.TANH, op.TAN, op.ATAN, op.ASIN, op.ACOS, op.LOG, op.SQRT, op.ATAN2}
)
_LINEAR: Final = frozenset({op.NEG, op.ADD, op.SUB, op.MUL, op.FMA})


def time_functions(
    sequence: Program, tables: Mapping[int, Table], *, with_parameters: bool = False
) -> TimeFunctions | None:
    """Return what a sequence computes from time alone, None if nothing depends on it.

    Parameters
    ----------
    tables : mapping of place to Table
        The inputs "r" that are tables.
    with_parameters : bool
        Whether free parameters "p" count as known, too.
    """
    given: dict[str, Callable[[int], bool]] = {
        "t": lambda place: True,
        "r": lambda place: place in tables,
        "p": lambda place: with_parameters,
    }
    early, moves = _early(sequence, given)
    shown = [place for place in _results(sequence, early) if moves[place]]
    if not shown:
        return None
    groups = [entry.group for entry in sequence.inputs]
    numbers = np.zeros(len(sequence.operations))
    for place in _ancestors(sequence.operations, shown):
        numbers[place] = _number(sequence, place)
    is_affine = _affine(sequence.operations, moves, groups) & early
    whole, steps = fold_choices(sequence.operations, numbers, is_affine)
    kept = _ancestors(whole, shown)
    number = {place: k for k, place in enumerate(kept)}
    operations = tuple(
        Operation(code, tuple(number[place] for place in operands), datum)
        for code, operands, datum in (whole[place] for place in kept)
    )
    moving = moves[kept]
    affine = _affine(operations, moving, groups)
    switches = [k for k, (code, _, _) in enumerate(operations) if code in _OF_ONE | _OF_TWO and moving[k]]
    affine_switches = [k for k in switches if affine[list(operations[k].operands)].all()]
    unknown = [k for k in switches if k not in affine_switches]
    steep = [
        k
        for k, operation in enumerate(operations)
        if moving[k] and _is_steep(operation, moving, bool(affine[k]))
    ]
    return TimeFunctions(
        operations,
        numbers[kept],
        tuple((entry.group, entry.position) for entry in sequence.inputs),
        tables,
        np.array([number[place] for place in shown], dtype=np.intp),
        moving,
        affine,
        np.array(affine_switches, dtype=np.intp),
        np.array(unknown, dtype=np.intp),
        np.array(
            _ancestors(operations, [k for place in unknown for k in operations[place].operands]),
            dtype=np.intp,
        ),
        np.array(steep, dtype=np.intp),
        tuple(replace(step, argument=number.get(step.argument, -1)) for step in steps),
    )


def function_of_time(function: CompiledFunction, tables: Mapping[int, Table]) -> TimeFunctions | None:
    """Return what a function computes from time and its parameters alone, None if nothing depends on it.

    The parameters are those of its code, `CompiledFunction.bound_values`.
    """
    places = tuple(tables)

    def make() -> TimeFunctions | None:
        return time_functions(function.shared_sequence, tables, with_parameters=True)

    functions: TimeFunctions | None = function.kept_with_code(("functions of time", places), make)
    return functions if functions is None or not places else replace(functions, tables=tables)


def _is_steep(operation: Operation, moves: Flags, affine: bool) -> bool:
    """Return whether an operation may make much of a small part of the values of its operands."""
    code, operands, _ = operation
    if code == op.DIV:
        return bool(moves[operands[1]])
    return code in _STEEP or (code == op.SYMBOL and not affine)


def _results(sequence: Program, early: Flags) -> list[int]:
    """Return the early values that are results, or read by others that are not early."""
    read = {place for k, step in enumerate(sequence.operations) if not early[k] for place in step.operands}
    read |= {place for output in sequence.outputs for place in output.values}
    return sorted(place for place in read if early[place])


def _early(sequence: Program, known: Mapping[str, Callable[[int], bool]]) -> tuple[Flags, Flags]:
    """Return which values depend on nothing that is unknown, and which of these on time."""
    early = np.zeros(len(sequence.operations), dtype=np.bool_)
    moves = np.zeros(len(sequence.operations), dtype=np.bool_)
    for k, (code, operands, datum) in enumerate(sequence.operations):
        if code == op.SYMBOL:
            entry = sequence.inputs[datum]
            early[k] = entry.group in known and known[entry.group](entry.position)
            moves[k] = early[k] and entry.group in "tr"
        elif code in op.LEAVES:
            early[k] = True
        elif code in FUNCTIONS:
            early[k] = all([early[place] for place in operands])
            moves[k] = early[k] and any([moves[place] for place in operands])
    return early, moves


def _ancestors(operations: Sequence[Operation], some: list[int]) -> list[int]:
    """Return all values that some are computed from, and these, ascending."""
    wanted, found = list(some), set(some)
    while wanted:
        for place in operations[wanted.pop()].operands:
            if place not in found:
                found.add(place)
                wanted.append(place)
    return sorted(found)


def _number(sequence: Program, place: int) -> float:
    value = np.pi if sequence.operations[place].op == op.PI else sequence.constant_value(place)
    return 0.0 if value is None else float(value)


def _affine(operations: Sequence[Operation], moves: Flags, groups: list[str]) -> Flags:
    """Return which values are constant in time, or affine in it."""
    is_affine = ~moves
    for k, (code, operands, datum) in enumerate(operations):
        moving = [place for place in operands if moves[place]]
        if not moves[k]:
            continue
        if code == op.SYMBOL:
            is_affine[k] = groups[datum] == "t"
        elif code in (op.NEG, op.ADD, op.SUB):
            is_affine[k] = is_affine[moving].all()
        elif code == op.MUL or (code == op.DIV and not moves[operands[1]]):
            is_affine[k] = len(moving) == 1 and is_affine[moving[0]]
        elif code == op.FMA:
            is_affine[k] = is_affine[moving].all() and not (moves[operands[0]] and moves[operands[1]])
    return is_affine


# The code of a step function among operations: no operation of the graph.
STEPS: Final = -1
# Fewer choices than this stay as they are.
_FEWEST: Final = 16


@dataclass(frozen=True, slots=True, eq=False)
class StepFunction:
    """A function that is constant between bounds.

    Attributes
    ----------
    argument : int
        The value it is a function of.
    bounds : (n,) array
        Ascending; from each on the next value holds.
    values : (n + 1,) array
    """

    argument: int
    bounds: Floats
    values: Floats

    def evaluate(self, x: Floats) -> Floats:
        """Return the values at x; at NaN the last, as comparisons choose."""
        found: Floats = self.values[np.searchsorted(self.bounds, x, side="right")]
        return found


def fold_choices(
    operations: Sequence[Operation], numbers: Floats, is_affine: Flags
) -> tuple[list[Operation], tuple[StepFunction, ...]]:
    """Return operations with step functions in the place of trees of choices, and these functions.

    Parameters
    ----------
    numbers : (n,) array
        The values of constants.
    is_affine : (n,) array of bool
        Values that are affine in time; only choices by these are known before a motion.
    """
    constants: dict[int, float] = {}
    trees: dict[int, StepFunction] = {}
    for k, (code, operands, _) in enumerate(operations):
        if code in op.LEAVES and code != op.SYMBOL:
            constants[k] = float(numbers[k])
        elif code == op.NEG and operands[0] in constants:
            constants[k] = -constants[operands[0]]
        elif code == op.SELECT and operations[operands[0]].op == op.LT:
            argument, bound = operations[operands[0]].operands
            branches = [_branch(constants, trees, place, argument) for place in operands[1:]]
            if is_affine[argument] and bound in constants and None not in branches:
                left, right = (branch for branch in branches if branch is not None)
                trees[k] = _join(left, constants[bound], right)
    large = {k: tree for k, tree in trees.items() if tree.bounds.size >= _FEWEST}
    folded = list(operations)
    for number, (k, tree) in enumerate(large.items()):
        folded[k] = Operation(STEPS, (tree.argument,), number)
    return folded, tuple(large.values())


def _branch(
    constants: Mapping[int, float], trees: Mapping[int, StepFunction], place: int, argument: int
) -> StepFunction | None:
    """Return a branch of a choice by an argument, if it is a constant or a choice by the same."""
    if place in constants:
        return StepFunction(argument, np.zeros(0), np.array([constants[place]]))
    tree = trees.get(place)
    return tree if tree is not None and tree.argument == argument else None


def _join(left: StepFunction, bound: float, right: StepFunction) -> StepFunction:
    """Return what is the left function below a bound, and the right one from it on."""
    below = int(np.searchsorted(left.bounds, bound, side="left"))
    above = int(np.searchsorted(right.bounds, bound, side="right"))
    return StepFunction(
        left.argument,
        np.concatenate([left.bounds[:below], [bound], right.bounds[above:]]),
        np.concatenate([left.values[: below + 1], right.values[above:]]),
    )
