"""How LLVM writes numbers of one lane or several: types, constants, instructions.

Every operation becomes the one instruction IEEE 754 defines; no fast-math flag appears anywhere, so nothing
is reassociated or contracted, and lanes have the bits of scalars.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from symbody.codegen.lowering import double_bits
from symbody.expr import opcodes as op

# {0}, {1}, {2}: operands, {T}: doubles, {B}: conditions, {I}: how intrinsics call the type, {L}: the prefix
# of functions of the C library. Conditions are i1, one for each lane.
INSTRUCTIONS: Final = {
    op.NEG: "fneg {T} {0}",
    op.ADD: "fadd {T} {0}, {1}",
    op.SUB: "fsub {T} {0}, {1}",
    op.MUL: "fmul {T} {0}, {1}",
    op.DIV: "fdiv {T} {0}, {1}",
    op.POW: "call {T} @{L}pow({T} {0}, {T} {1})",
    op.TAN: "call {T} @{L}tan({T} {0})",
    op.ASIN: "call {T} @{L}asin({T} {0})",
    op.ACOS: "call {T} @{L}acos({T} {0})",
    op.ATAN: "call {T} @{L}atan({T} {0})",
    op.SINH: "call {T} @{L}sinh({T} {0})",
    op.COSH: "call {T} @{L}cosh({T} {0})",
    op.TANH: "call {T} @{L}tanh({T} {0})",
    op.EXP: "call {T} @{L}exp({T} {0})",
    op.LOG: "call {T} @{L}log({T} {0})",
    op.SQRT: "call {T} @llvm.sqrt.{I}({T} {0})",
    op.ABS: "call {T} @llvm.fabs.{I}({T} {0})",
    op.FLOOR: "call {T} @llvm.floor.{I}({T} {0})",
    op.FMA: "call {T} @llvm.fma.{I}({T} {0}, {T} {1}, {T} {2})",
    op.LT: "fcmp olt {T} {0}, {1}",
    op.LE: "fcmp ole {T} {0}, {1}",
    op.EQ: "fcmp oeq {T} {0}, {1}",
    op.AND: "and {B} {0}, {1}",
    op.OR: "or {B} {0}, {1}",
    op.NOT: "xor {B} {0}, {true}",
    op.SELECT: "select {B} {0}, {T} {1}, {T} {2}",
}

# {k}: name of the result. min(a, b) is a where a < b or a is nan, else b: nan where either is.
COMPOSED: Final = {
    op.MIN: (
        "{k}.l = fcmp olt {T} {0}, {1}",
        "{k}.m = select {B} {k}.l, {T} {0}, {T} {1}",
        "{k}.u = fcmp uno {T} {0}, {0}",
        "{k} = select {B} {k}.u, {T} {0}, {T} {k}.m",
    ),
    op.MAX: (
        "{k}.l = fcmp olt {T} {1}, {0}",
        "{k}.m = select {B} {k}.l, {T} {0}, {T} {1}",
        "{k}.u = fcmp uno {T} {0}, {0}",
        "{k} = select {B} {k}.u, {T} {0}, {T} {k}.m",
    ),
    # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
    op.SIGN: (
        "{k}.p = fcmp ogt {T} {0}, {zero}",
        "{k}.n = fcmp olt {T} {0}, {zero}",
        "{k}.z = fadd {T} {0}, {zero}",
        "{k}.s = select {B} {k}.n, {T} {minus}, {T} {k}.z",
        "{k} = select {B} {k}.p, {T} {one}, {T} {k}.s",
    ),
    # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
    op.ATAN2: ("{k}.y = fadd {T} {0}, {zero}", "{k} = call {T} @{L}atan2({T} {k}.y, {T} {1})"),
}

LIBRARY: Final = {
    "pow": 2, "atan2": 2, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1,
    "exp": 1, "log": 1,
}  # fmt: skip
_WIDTHS: Final = (1, 2, 4, 8)
_INTRINSICS: Final = {"llvm.fma": 3, "llvm.sqrt": 1, "llvm.fabs": 1, "llvm.floor": 1}


@dataclass(frozen=True, slots=True)
class Words:
    """The words of one number of lanes.

    Attributes
    ----------
    real, truth : str
        Types of numbers and of conditions.
    instructions, composed : dict of operation code to text
        With the words put in; operands, and the name of the result, are left.
    """

    width: int
    real: str
    truth: str
    instructions: dict[int, str]
    composed: dict[int, tuple[str, ...]]

    def constant(self, value: float) -> str:
        """Return a constant, the same in every lane."""
        return _constant(self.width, f"0x{double_bits(value):016X}")


def words(width: int) -> Words:
    """Return the words for `width` lanes; 1 is a scalar."""
    vector = "<{} x {}>".format
    real, truth = ("double", "i1") if width == 1 else (vector(width, "double"), vector(width, "i1"))
    put = {
        "T": real,
        "B": truth,
        "I": _suffix(width),
        "L": _prefix(width),
        "true": "true" if width == 1 else "splat (i1 true)",
        "zero": _constant(width, "0.0"),
        "one": _constant(width, "1.0"),
        "minus": _constant(width, "-1.0"),
    }

    def fill_template(template: str) -> str:
        for name, text in put.items():
            template = template.replace("{" + name + "}", text)
        return template

    return Words(
        width,
        real,
        truth,
        {code: fill_template(text) for code, text in INSTRUCTIONS.items()},
        {code: tuple(map(fill_template, texts)) for code, texts in COMPOSED.items()},
    )


def declarations(text: str) -> str:
    """Return the functions of the C library and of LLVM that `text` calls, as vectors where it uses lanes."""
    lines = [
        f"declare {_signature(words(width).real, f'{name}.{_suffix(width)}', count)} nounwind\n"
        for name, count in _INTRINSICS.items()
        for width in _WIDTHS
        if f"@{name}.{_suffix(width)}(" in text
    ]
    for name, count in LIBRARY.items():
        called = [width for width in _WIDTHS if f"@{_prefix(width)}{name}(" in text]
        if called:
            lines.append(f"declare {_signature(words(1).real, name, count)} nounwind\n")
            lines.extend(_lane_by_lane(name, count, width) for width in called if width > 1)
    return "".join(lines)


def _signature(kind: str, name: str, count: int) -> str:
    return f"{kind} @{name}({', '.join([kind] * count)})"


def _lane_by_lane(name: str, count: int, width: int) -> str:
    """Return a function in lanes that calls one of the C library for each."""
    kind = words(width).real
    lines, before = [], "undef"
    for lane in range(width):
        arguments = []
        for k in range(count):
            lines.append(f"%x{k}.{lane} = extractelement {kind} %a{k}, i32 {lane}")
            arguments.append(f"double %x{k}.{lane}")
        lines.append(f"%y{lane} = call double @{name}({', '.join(arguments)})")
        lines.append(f"%v{lane} = insertelement {kind} {before}, double %y{lane}, i32 {lane}")
        before = f"%v{lane}"
    given = ", ".join(f"{kind} %a{k}" for k in range(count))
    body = "\n".join([*lines, f"ret {kind} {before}"])
    return f"define private {kind} @{_prefix(width)}{name}({given}) nounwind {{\n{body}\n}}\n"


def _constant(width: int, text: str) -> str:
    return text if width == 1 else f"splat (double {text})"


def _suffix(width: int) -> str:
    return "f64" if width == 1 else f"v{width}f64"


def _prefix(width: int) -> str:
    return "" if width == 1 else f"symbody_{width}_"
