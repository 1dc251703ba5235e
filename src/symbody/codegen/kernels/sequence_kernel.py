"""A sequence as a kernel: one text for all languages of kernels, the same bits in each.

It takes what all generated code takes and returns 0, or k + 1 if the linear system of kernel k has no
solution. No operation is fused; sine and cosine are kernels, too. What the C library computes elsewhere
(``exp``, ``atan2``, ...) each language takes from its own. Compilers take long for one long kernel, so a long
sequence becomes several, see `symbody.codegen.pieces`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.tree import (
    Apply,
    ArrayEntry,
    Assign,
    Call,
    Choose,
    Expression,
    KernelTree,
    Literal,
    Parameter,
    Part,
    Perform,
    Return,
    Statement,
    StoreEntry,
    Type,
    Variable,
)
from symbody.codegen.lowering import integer_exponent, power_products
from symbody.codegen.pieces import PIECE_SIZE, Piece, Plan, argument_places, plan_pieces
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation, Sequence

GROUPS: Final = ("t", "q", "u", "r", "p", "c", "out", "work")
_OPERATORS: Final = {
    op.NEG: "neg", op.ADD: "+", op.SUB: "-", op.MUL: "*", op.DIV: "/", op.SQRT: "sqrt", op.ABS: "abs",
    op.LT: "<", op.LE: "<=", op.EQ: "==", op.AND: "and", op.OR: "or", op.NOT: "not",
    op.TAN: "tan", op.ASIN: "asin", op.ACOS: "acos", op.ATAN: "atan", op.SINH: "sinh", op.COSH: "cosh",
    op.TANH: "tanh", op.EXP: "exp", op.LOG: "log", op.POW: "pow",
}  # fmt: skip
# Read where they are needed, again in every piece.
_REREAD: Final = op.LEAVES | {op.PICK}
_STATUS: Final = Variable("status", Type.INTEGER)
_FAULT: Final = Variable("fault", Type.INTEGER)


def sequence_kernels(
    sequence: Sequence, name: str, piece_size: int = PIECE_SIZE
) -> tuple[Mapping[str, KernelTree], int]:
    """Return a sequence as the kernel `name`, behind those that it calls, and its doubles of scratch.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    plan = plan_pieces(sequence, piece_size)
    writers = [_PieceWriter(sequence, plan, piece) for piece in plan.pieces]
    bodies = [writer.body() for writer in writers]
    called = set().union(*(writer.called for writer in writers))
    kernels: dict[str, KernelTree] = {}
    if "solve_saddle" in called:
        kernels |= read_kernels("solve_saddle")
    if roots := sorted(called - {"solve_saddle"}):
        kernels |= read_kernels("circular", *roots)
    parameters = [Parameter(group, Type.ARRAY, group in {"out", "work"}) for group in GROUPS]
    names = [name] if len(bodies) == 1 else [f"{name}_{k}" for k in range(len(bodies))]
    summary = f"Compute {sequence.output_size} numbers in {sequence.operation_count} operations"
    for k, (piece, writer, body) in enumerate(zip(names, writers, bodies, strict=True)):
        part = f"{summary}." if piece == name else f"Piece {k + 1} of {len(names)} of {name}."
        kernels[piece] = KernelTree(piece, parameters, Type.INTEGER, writer.variables, body, part)
    if name not in kernels:
        kernels[name] = KernelTree(
            name, parameters, Type.INTEGER, dict.fromkeys(("fault", "status"), Type.INTEGER),
            tuple(_calls(names)), f"{summary}, in {len(names)} pieces.",
        )  # fmt: skip
    return kernels, plan.work_size + 2


def _calls(pieces: Iterable[str]) -> Iterator[Statement]:
    """Yield the calls of all pieces; the first fault is returned."""
    yield Assign("fault", _whole(0))
    for piece in pieces:
        yield from _keep_fault(Call(piece, tuple(map(_array, GROUPS)), Type.INTEGER), _STATUS)
    yield Return(_FAULT)


def _keep_fault(call: Call, fault: Expression) -> Iterator[Statement]:
    """Yield a call, and what keeps `fault` if it fails and none failed before."""
    failed = Apply("!=", (_STATUS, _whole(0)), Type.TRUTH)
    is_first = Apply("==", (_FAULT, _whole(0)), Type.TRUTH)
    yield Assign("status", call)
    yield Choose(Apply("and", (failed, is_first), Type.TRUTH), (Assign("fault", fault),), ())


class _PieceWriter:
    """Writes one piece of a sequence."""

    def __init__(self, sequence: Sequence, plan: Plan, piece: Piece) -> None:
        self.variables: dict[str, Type] = {}
        self.called: set[str] = set()
        self._sequence = sequence
        self._plan = plan
        self._piece = piece
        self._pair = plan.work_size  # where a sine and cosine go
        self._values: dict[int, Expression] = {}
        self._circles: dict[int, tuple[Expression, Expression]] = {}  # of an argument
        self._body: list[Statement] = []

    def body(self) -> tuple[Statement, ...]:
        """Return the statements."""
        piece = self._piece
        needed = [k for k in range(piece.start, piece.stop) if self._plan.needed[k]]
        has_kernels = any(k in self._plan.results for k in needed)
        if has_kernels:
            self.variables["fault"] = self.variables["status"] = Type.INTEGER
            self._body.append(Assign("fault", _whole(0)))
        for k in needed:
            operation = self._sequence.operations[k]
            if operation.op not in _REREAD:
                self._operation(k, operation)
            for place in self._plan.outputs.get(k, ()):
                self._body.append(StoreEntry(_array("out"), _whole(place), self._value(k)))
            if k in piece.stores:
                self._store(k, _whole(piece.stores[k]))
        return (*self._body, Return(_FAULT if has_kernels else _whole(0)))

    def _value(self, k: int) -> Expression:
        """Return a value, read again if another piece computes it."""
        if k not in self._values:
            self._values[k] = self._read(k)
        return self._values[k]

    def _read(self, k: int) -> Expression:
        code, operands, datum = self._sequence.operations[k]
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            return Literal(self._plan.constants[k], Type.REAL)
        if code == op.SYMBOL:
            source = self._sequence.inputs[datum]
            entry = ArrayEntry(_array(source.group), _whole(source.position))
        elif code == op.PICK:
            entry = ArrayEntry(_array("work"), _whole(self._plan.results[operands[0]] + datum))
        else:
            entry = ArrayEntry(_array("work"), _whole(self._piece.loads[k]))
        value = self._define(f"z{k}", entry)
        if code in op.CONDITIONS:
            return Apply("!=", (value, Literal(0.0, Type.REAL)), Type.TRUTH)
        return value

    def _store(self, k: int, place: Expression) -> None:
        """Leave a value to other pieces, a condition as 1 or 0."""
        value = self._value(k)
        if self._sequence.operations[k].op in op.CONDITIONS:
            true, false = (StoreEntry(_array("work"), place, Literal(x, Type.REAL)) for x in (1.0, 0.0))
            self._body.append(Choose(value, (true,), (false,)))
        else:
            self._body.append(StoreEntry(_array("work"), place, value))

    def _operation(self, k: int, operation: Operation) -> None:
        code, operands, datum = operation
        if code == op.SADDLE:
            self._saddle(k, operands, datum)
        elif code in (op.SIN, op.COS):
            self._values[k] = self._circle(operands[0])[code == op.COS]
        else:
            self._function(k, code, [self._value(j) for j in operands])

    def _function(self, k: int, code: int, values: list[Expression]) -> None:
        exponent = None
        if code == op.POW:
            exponent = integer_exponent(self._sequence, self._sequence.operations[k].operands[1])
        if code in op.CONDITIONS:  # read by choices alone, which write them out
            self._values[k] = Apply(_OPERATORS[code], tuple(values), Type.TRUTH)
        elif exponent is not None:
            names = values[:1]
            for first, second in power_products(exponent):
                product = _apply("*", names[first], names[second])
                names.append(self._define(f"z{k}_{len(names)}", product))
            self._values[k] = names[-1]
        elif code == op.SELECT:
            self._choose(k, values[0], values[1], values[2])
        elif code in (op.MIN, op.MAX):
            self._extremum(k, code, values[0], values[1])
        elif code == op.SIGN:
            self._sign(k, values[0])
        else:
            self._values[k] = self._define(f"z{k}", self._formula(code, values))

    def _formula(self, code: int, values: list[Expression]) -> Expression:
        match code:
            case op.FMA:
                return _apply("+", _apply("*", values[0], values[1]), values[2])
            case op.ATAN2:
                return _apply("atan2", _apply("+", values[0], Literal(0.0, Type.REAL)), values[1])
            case op.FLOOR:
                self.called.add("round_down")
                return Call("round_down", tuple(values), Type.REAL)
        return _apply(_OPERATORS[code], *values)

    def _define(self, name: str, value: Expression) -> Expression:
        self.variables[name] = Type.REAL
        self._body.append(Assign(name, value))
        return Variable(name, Type.REAL)

    def _choose(self, k: int, condition: Expression, then: Expression, otherwise: Expression) -> None:
        name = f"z{k}"
        self.variables[name] = Type.REAL
        self._body.append(Choose(condition, (Assign(name, then),), (Assign(name, otherwise),)))
        self._values[k] = Variable(name, Type.REAL)

    def _extremum(self, k: int, code: int, a: Expression, b: Expression) -> None:
        """Set the smaller or larger of two numbers, nan where either is."""
        pair = (a, b) if code == op.MIN else (b, a)
        first = Apply("<", pair, Type.TRUTH)
        is_number = Apply("==", (a, a), Type.TRUTH)
        is_chosen = Apply("or", (first, Apply("not", (is_number,), Type.TRUTH)), Type.TRUTH)
        self._choose(k, is_chosen, a, b)

    def _sign(self, k: int, value: Expression) -> None:
        zero = Literal(0.0, Type.REAL)
        self._values[k] = self._define(f"z{k}", _apply("+", value, zero))
        for test, sign in ((">", 1.0), ("<", -1.0)):
            condition = Apply(test, (value, zero), Type.TRUTH)
            self._body.append(Choose(condition, (Assign(f"z{k}", Literal(sign, Type.REAL)),), ()))

    def _circle(self, j: int) -> tuple[Expression, Expression]:
        if j not in self._circles:
            self.called.add("sine_cosine")
            pair = Part(_array("work"), _whole(self._pair), _whole(2))
            self._body.append(Perform(Call("sine_cosine", (self._value(j), pair), None)))
            sine, cosine = (
                self._define(f"{letter}{j}", ArrayEntry(_array("work"), _whole(self._pair + k)))
                for k, letter in enumerate("sc")
            )
            self._circles[j] = sine, cosine
        return self._circles[j]

    def _saddle(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        self.called.add("solve_saddle")
        plan, kernel = self._plan, self._sequence.kernels[datum]
        for place, operand in enumerate(operands, plan.arguments):
            self._body.append(StoreEntry(_array("work"), _whole(place), self._value(operand)))
        n, m = kernel.n, kernel.m
        places = (*argument_places(kernel, plan.arguments), plan.results[k], plan.scratch)
        sizes = (n * n, m * n, n, m, n + m + 1, plan.work_size - plan.scratch)
        parts = (
            Part(_array("work"), _whole(place), _whole(size))
            for place, size in zip(places, sizes, strict=True)
        )
        call = Call("solve_saddle", (_whole(n), _whole(m), *parts), Type.INTEGER)
        self._body += _keep_fault(call, _whole(datum + 1))


def _whole(value: int) -> Literal:
    return Literal(value, Type.INTEGER)


def _array(name: str) -> Variable:
    return Variable(name, Type.ARRAY)


def _apply(operator: str, *operands: Expression) -> Apply:
    return Apply(operator, operands, Type.REAL)
