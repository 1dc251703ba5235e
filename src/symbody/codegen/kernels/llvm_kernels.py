"""Kernels as LLVM text, without flags that change results; in lanes, too.

Every variable has a place on the stack; LLVM's own passes bring them into registers, put small kernels into
larger ones, and unroll loops whose length is known.

In lanes every real is a vector, entry k of an array lies at k times the width, and integers are common to
all lanes. Where lanes would go different ways (a comparison or an integer made of a real differs) a kernel
sets the flag that its last argument points to, and returns; its results mean nothing then.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from symbody.codegen.kernels.dialect import LIBRARY, PREFIX
from symbody.codegen.kernels.llvm_words import (
    INTEGER,
    INTEGER_TESTS,
    REAL,
    REAL_TESTS,
    declarations,
    intrinsic_name,
    real_type,
    width_of,
)
from symbody.codegen.kernels.tree import (
    Apply,
    ArrayEntry,
    Assign,
    Call,
    Choose,
    Count,
    Expression,
    KernelTree,
    Leave,
    Literal,
    Part,
    Perform,
    Repeat,
    Return,
    Statement,
    StoreEntry,
    Type,
    Variable,
    always_returns,
)


def llvm_text(
    kernels: Mapping[str, KernelTree], public: Sequence[str], width: int = 1, lanes: int = 1
) -> str:
    """Return a module with kernels, of which those named can be called from elsewhere.

    Integers are 64 bits wide; arrays are pointers that do not overlap. In lanes names end in ``_in_lanes``,
    and a pointer to the flag follows the arguments. Values of the type `Lanes` have `lanes` entries.
    """
    written = (
        "\n".join(_FunctionWriter(tree, tree.name in public, width, lanes).lines())
        for tree in kernels.values()
    )
    return "\n".join([*declarations(width, lanes), "", *written, ""])


def kernel_name(kernel: str, width: int = 1) -> str:
    """Return the name of a kernel in machine code."""
    return f"{PREFIX}{kernel}" + ("_in_lanes" if width > 1 else "")


def entry_name(kernel: str) -> str:
    """Return the name in machine code of a kernel that is called as functions of generated code are."""
    return f"{kernel_name(kernel)}_entry"


def entry_text(tree: KernelTree) -> str:
    """Return an entry to a kernel with the signature of generated code: t, q, u, r, p, c, out, work.

    Parameters of the kernel with these names are these; the addresses of all others, in order, are in p.
    """
    loads: list[str] = []
    arguments: list[str] = []
    for parameter in tree.parameters:
        name = parameter.name
        if name not in _ENTRY_ARGUMENTS:
            place = f"%.{len(loads)}"
            loads.append(f"  {place} = getelementptr inbounds i64, ptr %p, i64 {len(loads) // 2}")
            name = f".{len(loads)}"
            loads.append(f"  %{name} = load ptr, ptr {place}")
        arguments.append(f"ptr %{name}")
    given = ", ".join(f"ptr %{name}" for name in _ENTRY_ARGUMENTS)
    lines = [
        f"define i32 @{entry_name(tree.name)}({given}) {{", *loads,
        f"  %status = call i64 @{kernel_name(tree.name)}({', '.join(arguments)})",
        "  %short = trunc i64 %status to i32", "  ret i32 %short", "}", "",
    ]  # fmt: skip
    return "\n".join(lines)


_ENTRY_ARGUMENTS: Final = ("t", "q", "u", "r", "p", "c", "out", "work")


class _FunctionWriter:
    """Writes one kernel."""

    def __init__(self, tree: KernelTree, is_public: bool, width: int, lanes: int) -> None:
        self._tree = tree
        self._linkage = "" if is_public else "internal "
        self._width = width
        self._lanes = lanes
        self._types = {
            Type.REAL: real_type(width), Type.INTEGER: "i64", Type.ARRAY: "ptr", Type.FUNCTION: "ptr",
            Type.LANES: real_type(lanes), Type.MASK: f"<{lanes} x i1>",
        }  # fmt: skip
        self._parameters = {p.name for p in tree.parameters}
        self._count = 0
        self._lines: list[str] = []
        self._exits: list[str] = []  # labels behind the loops around

    def lines(self) -> Iterator[str]:
        """Yield the lines of the function."""
        tree, types = self._tree, self._types
        parameters = [
            f"{types[p.type]}{' noalias' * (p.type == Type.ARRAY)} %{p.name}" for p in tree.parameters
        ]
        parameters += ["ptr %mixed"] if self._width > 1 else []
        result = types[tree.result] if tree.result else "void"
        name = kernel_name(tree.name, self._width)
        yield f"define {self._linkage}{result} @{name}({', '.join(parameters)}) {{"
        yield ".entry:"
        for name, kind in tree.variables.items():
            yield f"  %{name} = alloca {types[kind]}"
        self._block(tree.body)
        if not always_returns(tree.body):
            self._write("ret void")
        if self._width > 1:
            self._begin(".give_up")
            self._write("store i8 1, ptr %mixed")
            self._write(f"ret {result} zeroinitializer" if tree.result else "ret void")
        yield from self._lines
        yield "}"

    def _write(self, line: str) -> None:
        self._lines.append(f"  {line}")

    def _value(self, line: str) -> str:
        """Write an instruction and return the name of its value."""
        self._count += 1
        self._write(f"%.{self._count} = {line}")
        return f"%.{self._count}"

    def _labels(self, *names: str) -> list[str]:
        self._count += 1
        return [f"{name}.{self._count}" for name in names]

    def _begin(self, label: str) -> None:
        self._lines.append(f"{label}:")

    def _give_up_if(self, condition: str) -> None:
        (on,) = self._labels("on")
        self._write(f"br i1 {condition}, label %.give_up, label %{on}")
        self._begin(on)

    def _type(self, expression: Expression) -> str:
        if expression.type is None or expression.type == Type.TRUTH:
            raise AssertionError(expression)
        return f"<{self._width} x i64>" if self._is_of_lanes(expression) else self._types[expression.type]

    def _is_of_lanes(self, expression: Expression) -> bool:
        """Return whether an integer is one of each lane: an exponent, and what is made of it."""
        if self._width == 1 or expression.type != Type.INTEGER or not isinstance(expression, Apply):
            return False
        return expression.operator == "exponent" or (
            expression.operator in {"neg", "half"} and self._is_of_lanes(expression.operands[0])
        )

    # Statements

    def _block(self, body: tuple[Statement, ...]) -> bool:
        """Write statements; return whether what follows them is reached."""
        return all(self._statement(statement) for statement in body)

    def _statement(self, statement: Statement) -> bool:
        match statement:
            case Assign(name, value):
                self._write(f"store {self._type(value)} {self._text(value)}, ptr %{name}")
            case StoreEntry(array, index, value):
                text = self._text(value)
                self._write(f"store {self._type(value)} {text}, ptr {self._address(array, index)}, align 8")
            case Perform(call):
                self._call(call)
            case Return(value):
                self._write("ret void" if value is None else f"ret {self._type(value)} {self._text(value)}")
                return False
            case Leave():
                self._write(f"br label %{self._exits[-1]}")
                return False
            case Count():
                self._loop(statement)
            case Repeat(condition, body):
                self._repeat(condition, body)
            case Choose():
                return self._choose(statement)
        return True

    def _loop(self, loop: Count) -> None:
        start, stop = self._text(loop.start), self._text(loop.stop)
        head, body, after = self._labels("head", "body", "after")
        place = f"%{loop.name}"
        self._write(f"store i64 {start}, ptr {place}")
        self._write(f"br label %{head}")
        self._begin(head)
        now = self._value(f"load i64, ptr {place}")
        goes_on = self._value(f"icmp {'sgt' if loop.is_downwards else 'slt'} i64 {now}, {stop}")
        self._write(f"br i1 {goes_on}, label %{body}, label %{after}")
        self._begin(body)
        self._exits.append(after)
        if self._block(loop.body):
            last = self._value(f"load i64, ptr {place}")
            following = self._value(f"add nsw i64 {last}, {-1 if loop.is_downwards else 1}")
            self._write(f"store i64 {following}, ptr {place}")
            self._write(f"br label %{head}")
        self._exits.pop()
        self._begin(after)

    def _repeat(self, condition: Expression, body: tuple[Statement, ...]) -> None:
        head, inside, after = self._labels("head", "body", "after")
        self._write(f"br label %{head}")
        self._begin(head)
        self._write(f"br i1 {self._text(condition)}, label %{inside}, label %{after}")
        self._begin(inside)
        self._exits.append(after)
        if self._block(body):
            self._write(f"br label %{head}")
        self._exits.pop()
        self._begin(after)

    def _choose(self, choice: Choose) -> bool:
        then, otherwise, after = self._labels("then", "else", "after")
        self._write(f"br i1 {self._text(choice.condition)}, label %{then}, label %{otherwise}")
        is_reached = False
        for label, body in ((then, choice.body), (otherwise, choice.otherwise)):
            self._begin(label)
            if self._block(body):
                self._write(f"br label %{after}")
                is_reached = True
        if is_reached:
            self._begin(after)
        return is_reached

    # Expressions

    def _address(self, array: Expression, index: Expression) -> str:
        base, offset = self._text(array), self._text(index)
        return self._value(f"getelementptr inbounds {self._types[Type.REAL]}, ptr {base}, i64 {offset}")

    def _call(self, call: Call) -> str:
        arguments = [f"{self._type(a)} {self._text(a)}" for a in call.arguments]
        if call.is_parameter:
            status = self._value(f"call i32 %{call.kernel}({', '.join(arguments)})")
            return self._value(f"sext i32 {status} to i64")
        arguments += ["ptr %mixed"] if self._width > 1 else []
        line = f"@{kernel_name(call.kernel, self._width)}({', '.join(arguments)})"
        result = ""
        if call.type is None:
            self._write(f"call void {line}")
        else:
            result = self._value(f"call {self._types[call.type]} {line}")
        if self._width > 1:
            self._give_up_if(self._value(f"trunc i8 {self._value('load i8, ptr %mixed')} to i1"))
        return result

    def _text(self, expression: Expression) -> str:
        """Return the operand that holds an expression, computed before if necessary."""
        match expression:
            case Literal(value, kind):
                return str(value) if kind == Type.INTEGER else self._constant(value)
            case Variable(name):
                if name in self._parameters:
                    return f"%{name}"
                return self._value(f"load {self._type(expression)}, ptr %{name}")
            case ArrayEntry(array, index):
                address = self._address(array, index)
                return self._value(f"load {self._type(expression)}, ptr {address}, align 8")
            case Part(array, offset, _):
                return self._address(array, offset)
            case Call():
                return self._call(expression)
            case Apply(operator, operands):
                return self._apply(operator, [self._text(operand) for operand in operands], expression)

    def _constant(self, value: float) -> str:
        bits = f"0x{struct.pack('>d', value).hex().upper()}"
        return bits if self._width == 1 else f"<{', '.join([f'double {bits}'] * self._width)}>"

    def _apply(self, operator: str, texts: list[str], expression: Apply) -> str:
        if operator == "lanes":
            return str(self._lanes)
        operand = expression.operands[0]
        if operator in {"and", "or"}:
            result = texts[0]
            for text in texts[1:]:
                result = self._value(f"{operator} i1 {result}, {text}")
            return result
        if operator == "not":
            return self._value(f"xor i1 {texts[0]}, true")
        kind, is_real = self._type(operand), operand.type in {Type.REAL, Type.LANES}
        if operator in REAL:
            word = (REAL if is_real else INTEGER)[operator]
            return self._value(f"{word} {kind} {', '.join(texts)}")
        if operator in REAL_TESTS:
            word = f"fcmp {REAL_TESTS[operator]}" if is_real else f"icmp {INTEGER_TESTS[operator]}"
            truth = self._value(f"{word} {kind} {', '.join(texts)}")
            return self._common(truth) if operand.type == Type.REAL else truth
        if operator in LIBRARY:
            return self._value(f"call double @{operator}({', '.join(f'double {text}' for text in texts)})")
        return _WORDS[operator](self, kind, *texts)

    def _common(self, mask: str) -> str:
        """Return the truth that all lanes have in common; where they have none, give up."""
        width = self._width
        if width == 1:
            return mask
        bits = self._value(f"bitcast <{width} x i1> {mask} to i{width}")
        is_true = self._value(f"icmp eq i{width} {bits}, -1")
        is_any = self._value(f"icmp ne i{width} {bits}, 0")
        self._give_up_if(self._value(f"xor i1 {is_true}, {is_any}"))
        return is_true

    def _spread(self, value: str, kind: str) -> str:
        """Return a double in every lane of a type."""
        if kind == "double":
            return value
        first = self._value(f"insertelement {kind} poison, double {value}, i64 0")
        zeros = f"<{width_of(kind)} x i32> zeroinitializer"
        return self._value(f"shufflevector {kind} {first}, {kind} poison, {zeros}")

    def _mask(self, kind: str) -> str:
        return f"<{width_of(kind)} x i1>" if kind.startswith("<") else "i1"

    def _integers(self) -> str:
        return "i64" if self._width == 1 else f"<{self._width} x i64>"

    def _numbers(self, value: int) -> str:
        """Return a constant integer of each lane."""
        return str(value) if self._width == 1 else f"<{', '.join([f'i64 {value}'] * self._width)}>"

    # Words

    def _extremum(self, kind: str, a: str, b: str, test: str) -> str:
        word = f"fcmp o{test}" if "double" in kind else f"icmp s{test}"
        is_other = self._value(f"{word} {kind} {b}, {a}")
        return self._value(f"select {self._mask(kind)} {is_other}, {kind} {b}, {kind} {a}")

    def _negative(self, kind: str, a: str) -> str:
        if "double" in kind:
            return self._value(f"fneg {kind} {a}")
        return self._value(f"sub nsw {kind} {'zeroinitializer' if kind.startswith('<') else '0'}, {a}")

    def _absolute(self, kind: str, a: str) -> str:
        return (
            self._intrinsic("fabs", kind, a)
            if "double" in kind
            else self._extremum(kind, a, self._negative(kind, a), "gt")
        )

    def _intrinsic(self, word: str, kind: str, a: str) -> str:
        return self._value(f"call {kind} @{intrinsic_name(word, kind)}({kind} {a})")

    def _exponent(self, kind: str, a: str) -> str:
        """Return the exponent from the bits of a double; subnormal numbers have the least."""
        integers, mask = self._integers(), self._mask(kind)
        bits = self._value(
            f"lshr {integers} {self._value(f'bitcast {kind} {a} to {integers}')}, {self._numbers(52)}"
        )
        e = self._value(f"sub nsw {integers} {bits}, {self._numbers(1022)}")
        e = self._extremum(integers, e, self._numbers(-1022), "gt")
        positive = self._value(f"fcmp ogt {kind} {a}, {self._constant(0.0)}")
        finite = self._value(f"fcmp olt {kind} {a}, {self._constant(float('inf'))}")
        is_normal = self._value(f"and {mask} {positive}, {finite}")
        return self._value(f"select {mask} {is_normal}, {integers} {e}, {integers} {self._numbers(0)}")

    def _power_of_two(self, kind: str, e: str) -> str:
        integers = self._integers()
        if kind != integers:
            raise AssertionError("a power of two of an integer common to all lanes")
        biased = self._value(f"add nsw {integers} {e}, {self._numbers(1023)}")
        bits = self._value(f"shl {integers} {biased}, {self._numbers(52)}")
        return self._value(f"bitcast {integers} {bits} to {self._types[Type.REAL]}")

    def _half(self, kind: str, a: str) -> str:
        return self._value(f"ashr {kind} {a}, {self._numbers(1) if kind.startswith('<') else 1}")

    def _finite(self, kind: str, a: str) -> str:
        size = self._absolute(kind, a)
        return self._common(self._value(f"fcmp olt {kind} {size}, {self._constant(float('inf'))}"))

    def _to_real(self, kind: str, a: str) -> str:
        if kind == "i64":
            return self._spread(self._value(f"sitofp i64 {a} to double"), self._types[Type.REAL])
        return self._value(f"sitofp {kind} {a} to {self._types[Type.REAL]}")

    def _where(self, mask: str, which: str, a: str, b: str) -> str:
        kind = self._types[Type.LANES]
        return self._value(f"select {mask} {which}, {kind} {a}, {kind} {b}")

    def _to_integer(self, kind: str, a: str) -> str:
        first = a
        if self._width > 1:
            first = self._value(f"extractelement {kind} {a}, i64 0")
            self._common(self._value(f"fcmp oeq {kind} {a}, {self._spread(first, kind)}"))
        return self._value(f"fptosi double {first} to i64")


_WORDS: Final[Mapping[str, Callable[..., str]]] = {
    "neg": _FunctionWriter._negative,
    "abs": _FunctionWriter._absolute,
    "min": lambda writer, kind, a, b: writer._extremum(kind, a, b, "lt"),
    "max": lambda writer, kind, a, b: writer._extremum(kind, a, b, "gt"),
    "sqrt": lambda writer, kind, a: writer._intrinsic("sqrt", kind, a),
    "is_finite": _FunctionWriter._finite,
    "exponent": _FunctionWriter._exponent,
    "power_of_two": _FunctionWriter._power_of_two,
    "half": _FunctionWriter._half,
    "real": _FunctionWriter._to_real,
    "spread": lambda writer, _, a: writer._spread(a, writer._types[Type.LANES]),
    "where": _FunctionWriter._where,
    "integer": _FunctionWriter._to_integer,
}
