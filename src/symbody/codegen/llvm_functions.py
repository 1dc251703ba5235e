"""LLVM functions that compute a sequence, as text.

Text, because building and printing through llvmlite's objects takes three times as long. Every
operation becomes the one instruction IEEE 754 defines; no fast-math flag appears anywhere, so nothing
is reassociated or contracted.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from symbody.codegen.llvm_trig import SINCOS_NAME
from symbody.codegen.lowering import double_bits, power_products, whole_exponent
from symbody.codegen.pieces import Piece, Plan, argument_places
from symbody.expr import opcodes as op
from symbody.expr.sequence import Operation, Sequence

GROUPS: Final = ("t", "q", "u", "r", "p", "c")
SADDLE_NAME: Final = "symbody_solve_saddle"

# Groups may overlap each other, and `out` or `work` nothing.
_PARAMETERS: Final = ", ".join(
    [f"ptr readonly %{g}" for g in GROUPS] + ["ptr noalias %out", "ptr noalias %work"]
)
_ARGUMENTS: Final = ", ".join(f"ptr %{name}" for name in (*GROUPS, "out", "work"))
_ZERO: Final = "0x0000000000000000"
_ABI: Final = "i32 (" + ", ".join(["ptr"] * 8) + ")"

_INSTRUCTIONS: Final = {
    op.NEG: "fneg double {0}",
    op.ADD: "fadd double {0}, {1}",
    op.SUB: "fsub double {0}, {1}",
    op.MUL: "fmul double {0}, {1}",
    op.DIV: "fdiv double {0}, {1}",
    op.POW: "call double @pow(double {0}, double {1})",
    op.TAN: "call double @tan(double {0})",
    op.ASIN: "call double @asin(double {0})",
    op.ACOS: "call double @acos(double {0})",
    op.ATAN: "call double @atan(double {0})",
    op.SINH: "call double @sinh(double {0})",
    op.COSH: "call double @cosh(double {0})",
    op.TANH: "call double @tanh(double {0})",
    op.EXP: "call double @exp(double {0})",
    op.LOG: "call double @log(double {0})",
    op.SQRT: "call double @llvm.sqrt.f64(double {0})",
    op.ABS: "call double @llvm.fabs.f64(double {0})",
    op.FLOOR: "call double @llvm.floor.f64(double {0})",
    op.FMA: "call double @llvm.fma.f64(double {0}, double {1}, double {2})",
    op.LT: "fcmp olt double {0}, {1}",
    op.LE: "fcmp ole double {0}, {1}",
    op.EQ: "fcmp oeq double {0}, {1}",
    op.AND: "and i1 {0}, {1}",
    op.OR: "or i1 {0}, {1}",
    op.NOT: "xor i1 {0}, true",
    op.SELECT: "select i1 {0}, double {1}, double {2}",
}

# {0}, {1}: operands, {k}: name of the result. min(a, b) is a where a < b, else b, so b where either is nan;
# max likewise with b < a.
_COMPOSED: Final = {
    op.MIN: ("{k}.l = fcmp olt double {0}, {1}", "{k} = select i1 {k}.l, double {0}, double {1}"),
    op.MAX: ("{k}.l = fcmp olt double {1}, {0}", "{k} = select i1 {k}.l, double {0}, double {1}"),
    # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
    op.SIGN: (
        "{k}.p = fcmp ogt double {0}, 0.0",
        "{k}.n = fcmp olt double {0}, 0.0",
        "{k}.z = fadd double {0}, 0.0",
        "{k}.s = select i1 {k}.n, double -1.0, double {k}.z",
        "{k} = select i1 {k}.p, double 1.0, double {k}.s",
    ),
    # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
    op.ATAN2: ("{k}.y = fadd double {0}, 0.0", "{k} = call double @atan2(double {k}.y, double {1})"),
}

_FUNCTIONS: Final = {
    "@pow": "double @pow(double, double)",
    "@atan2": "double @atan2(double, double)",
    "@llvm.fma.f64": "double @llvm.fma.f64(double, double, double)",
    "@llvm.memset.p0.i64": "void @llvm.memset.p0.i64(ptr, i8, i64, i1)",
    f"@{SINCOS_NAME}": f"{{double, double}} @{SINCOS_NAME}(double)",
    f"@{SADDLE_NAME}": f"i32 @{SADDLE_NAME}(i32, i32, ptr, ptr, ptr, ptr, ptr, ptr)",
} | {
    f"@{name}": f"double @{name}(double)"
    for name in (
        "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log",
        "llvm.sqrt.f64", "llvm.fabs.f64", "llvm.floor.f64",
    )
}  # fmt: skip


def piece_function(sequence: Sequence, plan: Plan, piece: Piece, name: str) -> str:
    """Return the function that computes one piece."""
    writer = _PieceWriter(sequence, plan, piece)
    body = "\n".join(writer.lines())
    return f"define i32 @{name}({_PARAMETERS}) nounwind {{\n{body}\nret i32 {writer.status}\n}}\n"


def entry_function(name: str, pieces: list[str]) -> str:
    """Return the function that calls `pieces` in order and returns the first status that is not 0."""
    lines = []
    status = "0"
    for k, piece in enumerate(pieces):
        lines.append(f"%r{k} = call i32 @{piece}({_ARGUMENTS})")
        lines.extend(_first_status(status, f"%r{k}", f"%s{k}"))
        status = f"%s{k}"
    body = "\n".join(lines)
    return f"define i32 @{name}({_PARAMETERS}) nounwind {{\n{body}\nret i32 {status}\n}}\n"


def batch_function(name: str, function: str) -> str:
    """Return the function that calls `function` for many points.

    ``int name(long count, const double *t, long t_stride, ..., double *out, long out_stride, double *work)``
    with 64-bit counts; strides in doubles, 0 for what is the same at every point. It computes every point
    and returns the first status that is not 0.
    """
    arrays = (*GROUPS, "out")
    parameters = ", ".join(f"ptr %{a}, i64 %{a}.stride" for a in arrays)
    lines = [
        "start:",
        "%any = icmp sgt i64 %count, 0",
        "br i1 %any, label %loop, label %end",
        "loop:",
        "%k = phi i64 [0, %start], [%k.next, %loop]",
        "%before = phi i32 [0, %start], [%status, %loop]",
    ]
    for a in arrays:
        lines.append(f"%{a}.offset = mul i64 %k, %{a}.stride")
        lines.append(f"%{a}.k = getelementptr double, ptr %{a}, i64 %{a}.offset")
    arguments = ", ".join([f"ptr %{a}.k" for a in arrays] + ["ptr %work"])
    lines.append(f"%code = call i32 @{function}({arguments})")
    lines.extend(_first_status("%before", "%code", "%status"))
    lines += [
        "%k.next = add i64 %k, 1",
        "%more = icmp slt i64 %k.next, %count",
        "br i1 %more, label %loop, label %end",
        "end:",
        "%result = phi i32 [0, %start], [%status, %loop]",
        "ret i32 %result",
    ]
    body = "\n".join(lines)
    return f"define i32 @{name}(i64 %count, {parameters}, ptr %work) nounwind {{\n{body}\n}}\n"


def declaration(function: str) -> str:
    """Return the declaration of a piece defined in another module."""
    return f"declare {_ABI.replace('(', f'@{function}(', 1)} nounwind\n"


def library_declarations(text: str) -> str:
    """Return declarations of all library functions that `text` calls and does not define."""
    return "".join(
        f"declare {signature} nounwind\n"
        for name, signature in _FUNCTIONS.items()
        if f"{name}(" in text and f"@{signature.partition('@')[2]}" not in text
    )


def _first_status(before: str, new: str, name: str) -> Iterator[str]:
    yield f"{name}.ok = icmp eq i32 {before}, 0"
    yield f"{name} = select i1 {name}.ok, i32 {new}, i32 {before}"


class _PieceWriter:
    """Writes one piece; every value is named after its number."""

    def __init__(self, sequence: Sequence, plan: Plan, piece: Piece) -> None:
        self.status = "0"  # name of the integer to return
        self._sequence = sequence
        self._plan = plan
        self._piece = piece
        self._names: dict[int, str] = {}  # how a value is written as an operand
        self._lines: list[str] = []
        self._pairs: set[str] = set()  # those of sin and cos already written
        self._addresses: set[str] = set()

    def lines(self) -> list[str]:
        piece = self._piece
        for k in (k for k in range(piece.start, piece.stop) if self._plan.needed[k]):
            operation = self._sequence.operations[k]
            if operation.op not in op.LEAVES and operation.op != op.PICK:
                self._operation(k, operation)
            for place in self._plan.outputs.get(k, ()):
                self._store("out", place, self._operand(k))
            if k in piece.stores:
                self._leave(k, piece.stores[k])
        return self._lines

    def _operation(self, k: int, operation: Operation) -> None:
        code, operands, datum = operation
        if code == op.SADDLE:
            self._saddle(k, operands, datum)
        elif code == op.POW and (exponent := whole_exponent(self._sequence, operands[1])) is not None:
            self._power(k, self._operand(operands[0]), exponent)
        elif code in (op.SIN, op.COS):
            self._circle(k, code, operands[0])
        else:
            names = [self._operand(j) for j in operands]
            self._names[k] = f"%z{k}"
            if code in _INSTRUCTIONS:
                self._lines.append(f"%z{k} = {_INSTRUCTIONS[code].format(*names)}")
            else:
                self._lines.extend(line.format(*names, k=f"%z{k}") for line in _COMPOSED[code])

    def _operand(self, k: int) -> str:
        """Return how value k is written, reading it first if this piece has not yet."""
        name = self._names.get(k)
        if name is None:
            name = self._names[k] = self._read(k)
        return name

    def _read(self, k: int) -> str:
        code, operands, datum = self._sequence.operations[k]
        name = f"%z{k}"
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            return f"0x{double_bits(self._plan.constants[k]):016X}"
        if code == op.SYMBOL:
            source = self._sequence.inputs[datum]
            self._load(name, source.group, source.position)
        elif code == op.PICK:
            self._load(name, "work", self._plan.results[operands[0]] + datum)
        elif code in op.CONDITIONS:
            self._load(f"{name}.d", "work", self._piece.loads[k])
            self._lines.append(f"{name} = fcmp une double {name}.d, 0.0")
        else:
            self._load(name, "work", self._piece.loads[k])
        return name

    def _leave(self, k: int, slot: int) -> None:
        name = self._operand(k)
        if self._sequence.operations[k].op in op.CONDITIONS:
            self._lines.append(f"%z{k}.d = uitofp i1 {name} to double")
            name = f"%z{k}.d"
        self._store("work", slot, name)

    def _circle(self, k: int, code: int, argument: int) -> None:
        operand = self._operand(argument)
        pair = f"%p{argument}"
        if pair not in self._pairs:
            self._pairs.add(pair)
            self._lines.append(f"{pair} = call {{double, double}} @{SINCOS_NAME}(double {operand})")
        self._names[k] = f"%z{k}"
        self._lines.append(f"%z{k} = extractvalue {{double, double}} {pair}, {0 if code == op.SIN else 1}")

    def _power(self, k: int, base: str, exponent: int) -> None:
        names = [base]
        for first, second in power_products(exponent):
            names.append(f"%z{k}.{len(names)}")
            self._lines.append(f"{names[-1]} = fmul double {names[first]}, {names[second]}")
        self._names[k] = names[-1]

    def _saddle(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        plan, kernel = self._plan, self._sequence.kernels[datum]
        names = [self._operand(operand) for operand in operands]
        if cleared := 2 * names.count(_ZERO) > len(names):
            # One by one, LLVM takes longer to gather the zeros of large matrices than for all the rest.
            start = self._address("work", plan.arguments)
            self._lines.append(
                f"call void @llvm.memset.p0.i64(ptr {start}, i8 0, i64 {8 * len(names)}, i1 false)"
            )
        for place, name in enumerate(names, plan.arguments):
            if not cleared or name != _ZERO:
                self._store("work", place, name)
        arguments = [f"i32 {kernel.n}", f"i32 {kernel.m}"]
        for place in (*argument_places(kernel, plan.arguments), plan.results[k], plan.scratch):
            arguments.append(f"ptr {self._address('work', place)}")
        self._lines.append(f"%f{k} = call i32 @{SADDLE_NAME}({', '.join(arguments)})")
        self._lines.append(f"%f{k}.bad = icmp ne i32 %f{k}, 0")
        self._lines.append(f"%f{k}.code = select i1 %f{k}.bad, i32 {datum + 1}, i32 0")
        self._lines.extend(_first_status(self.status, f"%f{k}.code", f"%s{k}"))
        self.status = f"%s{k}"

    def _load(self, name: str, array: str, place: int) -> None:
        self._lines.append(f"{name} = load double, ptr {self._address(array, place)}")

    def _store(self, array: str, place: int, name: str) -> None:
        self._lines.append(f"store double {name}, ptr {self._address(array, place)}")

    def _address(self, array: str, place: int) -> str:
        if not place:
            return f"%{array}"
        name = f"%{array}.{place}"
        if name not in self._addresses:
            self._addresses.add(name)
            self._lines.append(f"{name} = getelementptr double, ptr %{array}, i64 {place}")
        return name
