"""C99 text of a sequence: one file that needs math.h and nothing else.

Every operation is one statement, in the order of the sequence, so the compiled text gives what IEEE
754 defines, bit for bit what `llvm` gives except for sin and cos, which come from the C library here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final

from symbody.codegen.identifiers import assign_identifiers, quote_name
from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.lowering import integer_exponent, power_products
from symbody.codegen.pieces import PIECE_SIZE, Piece, Plan, argument_places, plan_pieces
from symbody.errors import CompileError, Problem
from symbody.expr import opcodes as op
from symbody.expr.sequence import Input, Operation, Sequence

GROUPS: Final = ("t", "q", "u", "r", "p", "c")

_PARAMETERS: Final = ", ".join(
    [f"const double *{g}" for g in GROUPS] + ["double *restrict out", "double *restrict work"]
)
_ARGUMENTS: Final = ", ".join((*GROUPS, "out", "work"))

_EXPRESSIONS: Final = {
    op.NEG: "-{0}",
    op.ADD: "{0} + {1}",
    op.SUB: "{0} - {1}",
    op.MUL: "{0} * {1}",
    op.DIV: "{0} / {1}",
    op.POW: "pow({0}, {1})",
    op.SIN: "sin({0})",
    op.COS: "cos({0})",
    op.TAN: "tan({0})",
    op.ASIN: "asin({0})",
    op.ACOS: "acos({0})",
    op.ATAN: "atan({0})",
    op.SINH: "sinh({0})",
    op.COSH: "cosh({0})",
    op.TANH: "tanh({0})",
    op.EXP: "exp({0})",
    op.LOG: "log({0})",
    op.SQRT: "sqrt({0})",
    op.ABS: "fabs({0})",
    # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
    op.SIGN: "{0} > 0.0 ? 1.0 : {0} < 0.0 ? -1.0 : {0} + 0.0",
    op.FLOOR: "floor({0})",
    # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
    op.ATAN2: "atan2({0} + 0.0, {1})",
    op.MIN: "{0} < {1} ? {0} : {1}",  # the second where either is nan, as for max
    op.MAX: "{1} < {0} ? {0} : {1}",
    op.LT: "{0} < {1}",
    op.LE: "{0} <= {1}",
    op.EQ: "{0} == {1}",
    op.AND: "{0} && {1}",
    op.OR: "{0} || {1}",
    op.NOT: "!{0}",
    op.SELECT: "{0} ? {1} : {2}",
    op.FMA: "fma({0}, {1}, {2})",
}

# Keywords up to C23, functions called here, macros of math.h and of compilers, and what the text itself
# declares. Other functions of math.h may be hidden by a local variable.
_RESERVED: Final = frozenset(
    """
    alignas alignof asm auto bool break case char complex const constexpr continue default do double else enum
    extern false far float for fortran goto huge if imaginary inline int long main near nullptr register
    restrict return short signed sizeof static struct switch true typedef typeof union unsigned void volatile
    while errno i386 linux unix vax
    pow sin cos tan asin acos atan sinh cosh tanh exp log sqrt fabs floor atan2 fma
    NULL NAN INFINITY HUGE HUGE_VAL HUGE_VALF HUGE_VALL MAXFLOAT DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS
    X_TLOSS CONST FAR NEAR PASCAL TRUE FALSE IN OUT VOID
    t q u r p c out work status
    """.split()
)
_RESERVED_FORM: Final = re.compile(r"z\d+(_\d+)?|(FP|M|MATH|SVID|symbody)_.*")


def generate(
    sequence: Sequence,
    name: str = "f",
    names: Mapping[str, str] | None = None,
    *,
    piece_size: int = PIECE_SIZE,
) -> str:
    """Return a C99 file with one function ``int name(t, q, u, r, p, c, out, work)``.

    Parameters
    ----------
    name : str
        Name of the function, and the beginning of all other names in the file.
    names : mapping of str to str, optional
        What inputs and outputs are to be called in the text instead of their own names.
    piece_size : int
        About how many operations go into one C function; results do not depend on it.

    Raises
    ------
    CompileError
        If `name` is not a C identifier, the sequence calls functions the user supplied, or a constant is
        beyond the doubles.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,40}", name) or _is_reserved(name):
        raise CompileError(
            Problem("compile.name", "", f"{quote_name(name)} cannot be the name of a C function",
                    "not an identifier, longer than 41 letters, or taken", "choose another, such as 'f'")
        )  # fmt: skip
    plan = plan_pieces(sequence, piece_size)
    shown = {entry.name: entry.name for entry in sequence.inputs}
    shown |= {entry.name: entry.name for entry in sequence.outputs}
    shown |= names or {}
    labels = [shown[entry.name] for entry in sequence.inputs]
    words = assign_identifiers(labels, lambda word: _is_reserved(word) or word == f"{name}_WORK_SIZE")
    kernel = saddle_text(C).split("\n") if plan.results else []
    head = [*_header(sequence, plan, name, shown, words), PREAMBLE, *kernel, *_interface(plan, name)]
    return "\n".join([*head, *_functions(sequence, plan, name, words)]) + "\n"


def _is_reserved(word: str) -> bool:
    return word in _RESERVED or _RESERVED_FORM.fullmatch(word) is not None


def _header(
    sequence: Sequence, plan: Plan, name: str, shown: Mapping[str, str], words: list[str]
) -> Iterator[str]:
    yield "/*"
    yield f" * int {name}({', '.join(GROUPS)}, out, work) computes {sequence.output_size} numbers"
    yield f" * in {sequence.operation_count} operations. Written by symbody."
    yield " *"
    yield " * Inputs: place, identifier, name; of t, q, u, r and p what is not listed is not read"
    listed = sorted(zip(sequence.inputs, words, strict=True), key=lambda pair: _place(pair[0]))
    for entry, word in listed:
        yield f" *   {entry.group}[{entry.position}]  {word}  {quote_name(shown[entry.name])}"
    if all(entry.group != "c" for entry, _ in listed):
        yield " *   c is not read: it is for symbody's own calls; pass NULL"
    yield " * Outputs: first place, shape, name; row-major"
    place = 0
    for output in sequence.outputs:
        shape = " x ".join(str(size) for size in output.shape) or "scalar"
        yield f" *   out[{place}...]  {shape}  {quote_name(shown[output.name])}"
        place += len(output.values)
    yield " *"
    yield f" * work: {plan.work_size} doubles of the caller; out and work overlap nothing. Groups that are"
    yield " * not read may be NULL. Returns 0, or k + 1 if the linear system of kernel k has no solution;"
    yield " * what depends on it is NaN then."
    yield " */"


def _place(entry: Input) -> tuple[int, int]:
    """Return what inputs are listed by: t, q, u, r, p, c, and the places in each."""
    return GROUPS.index(entry.group), entry.position


def _interface(plan: Plan, name: str) -> Iterator[str]:
    yield f"#define {name}_WORK_SIZE {plan.work_size}"
    yield f"int {name}_work_size(void);"
    yield f"int {name}({_PARAMETERS});"
    yield ""
    yield f"int {name}_work_size(void)"
    yield "{"
    yield f"    return {name}_WORK_SIZE;"
    yield "}"


def _functions(sequence: Sequence, plan: Plan, name: str, words: list[str]) -> Iterator[str]:
    if len(plan.pieces) == 1:
        yield from _piece_function(sequence, plan, plan.pieces[0], words, f"int {name}")
        return
    for k, piece in enumerate(plan.pieces):
        yield from _piece_function(sequence, plan, piece, words, f"static int {name}_{k}")
    yield ""
    yield f"int {name}({_PARAMETERS})"
    yield "{"
    yield "    int status = 0, next;"
    for k in range(len(plan.pieces)):
        yield f"    next = {name}_{k}({_ARGUMENTS});"
        yield "    if (!status) status = next;"
    yield "    return status;"
    yield "}"


def _piece_function(
    sequence: Sequence, plan: Plan, piece: Piece, words: list[str], head: str
) -> Iterator[str]:
    writer = _CPieceWriter(sequence, plan, piece, words)
    body = writer.lines()
    yield ""
    yield f"{head}({_PARAMETERS})"
    yield "{"
    if writer.has_kernel:
        yield "    int status = 0;"
    yield from body
    for array in (*GROUPS, "out", "work"):
        if array not in writer.arrays:
            yield f"    (void){array};"
    yield f"    return {'status' if writer.has_kernel else '0'};"
    yield "}"


class _CPieceWriter:
    """Writes the statements of one piece."""

    def __init__(self, sequence: Sequence, plan: Plan, piece: Piece, words: list[str]) -> None:
        self.arrays: set[str] = set()  # those read or written
        self.has_kernel = False
        self._sequence = sequence
        self._plan = plan
        self._piece = piece
        self._words = words
        self._names: dict[int, str] = {}  # how a value is written as an operand
        self._lines: list[str] = []

    def lines(self) -> list[str]:
        piece = self._piece
        for k in (k for k in range(piece.start, piece.stop) if self._plan.needed[k]):
            operation = self._sequence.operations[k]
            if operation.op not in op.LEAVES and operation.op != op.PICK:
                self._operation(k, operation)
            for place in self._plan.outputs.get(k, ()):
                self._store("out", place, self._operand(k))
            if k in piece.stores:
                self._store("work", piece.stores[k], self._operand(k))
        return self._lines

    def _operation(self, k: int, operation: Operation) -> None:
        code, operands, datum = operation
        if code == op.SADDLE:
            self._saddle(k, operands, datum)
            return
        if code == op.POW and (exponent := integer_exponent(self._sequence, operands[1])) is not None:
            self._power(k, self._operand(operands[0]), exponent)
            return
        expression = _EXPRESSIONS[code].format(*[self._operand(j) for j in operands])
        self._define(k, "int" if code in op.CONDITIONS else "double", expression)

    def _define(self, k: int, kind: str, expression: str, name: str = "") -> None:
        self._names[k] = name or f"z{k}"
        self._lines.append(f"    const {kind} {self._names[k]} = {expression};")

    def _operand(self, k: int) -> str:
        """Return how value k is written, reading it first if this piece has not yet."""
        if k not in self._names:
            self._read_value(k)
        return self._names[k]

    def _read_value(self, k: int) -> None:
        code, operands, datum = self._sequence.operations[k]
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            text = repr(self._plan.constants[k])  # the shortest that reads back as the same double
            self._names[k] = f"({text})" if text.startswith("-") else text
        elif code == op.SYMBOL:
            source = self._sequence.inputs[datum]
            self._define(k, "double", self._element(source.group, source.position), self._words[datum])
        elif code == op.PICK:
            self._define(k, "double", self._element("work", self._plan.results[operands[0]] + datum))
        elif code in op.CONDITIONS:
            self._define(k, "int", f"{self._element('work', self._piece.loads[k])} != 0.0")
        else:
            self._define(k, "double", self._element("work", self._piece.loads[k]))

    def _power(self, k: int, base: str, exponent: int) -> None:
        names = [base]
        for first, second in power_products(exponent):
            self._define(k, "double", f"{names[first]} * {names[second]}", f"z{k}_{len(names)}")
            names.append(self._names[k])
        self._names[k] = names[-1]

    def _saddle(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        plan, kernel = self._plan, self._sequence.kernels[datum]
        for place, operand in enumerate(operands, plan.arguments):
            self._store("work", place, self._operand(operand))
        places = (*argument_places(kernel, plan.arguments), plan.results[k], plan.scratch)
        arguments = ", ".join([str(kernel.n), str(kernel.m), *(f"work + {place}" for place in places)])
        self._lines.append(f"    if (symbody_solve_saddle({arguments}) && !status) status = {datum + 1};")
        self.arrays.add("work")
        self.has_kernel = True

    def _store(self, array: str, place: int, text: str) -> None:
        self._lines.append(f"    {self._element(array, place)} = {text};")

    def _element(self, array: str, place: int) -> str:
        self.arrays.add(array)
        return f"{array}[{place}]"
