"""MATLAB and Octave text of a sequence: one function file that needs no toolbox.

Every operation is one statement, in the order of the sequence. What would become complex outside its domain
is nan, as in all other languages.
"""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Sequence as Items
from typing import Final

from symbody.codegen.kernels.matlab_kernels import MATLAB, SADDLE_CALL
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.texts.layout import Arguments, Language, TextLayout
from symbody.codegen.texts.lists import fill_lines
from symbody.codegen.texts.statements import Dialect, Statements
from symbody.expr import opcodes as op
from symbody.expr.sequence import Output, Sequence

_LANGUAGE: Final = Language(
    "MATLAB",
    frozenset(
        """
        arguments break case catch classdef continue else elseif end enumeration events for function global if
        methods otherwise parfor persistent properties return spmd switch try while
        do endif endfor endfunction endwhile endswitch endparfor end_try_catch end_unwind_protect endclassdef
        endenumeration endevents endmethods endproperties endspmd endarguments unwind_protect
        unwind_protect_cleanup until __FILE__ __LINE__
        sin cos tan asin acos atan sinh cosh tanh exp log sqrt abs sign floor atan2 zeros nan NaN inf Inf
        true false ans pi
        t q u r p c
        """.split()
    ),
)

_EXPRESSIONS: Final = {
    op.NEG: "-{0}",
    op.ADD: "{0} + {1}",
    op.SUB: "{0} - {1}",
    op.MUL: "{0} * {1}",
    op.DIV: "{0} / {1}",
    op.POW: "symbody_power({0}, {1})",
    op.SIN: "sin({0})",
    op.COS: "cos({0})",
    op.TAN: "tan({0})",
    op.ASIN: "symbody_real(asin({0}))",
    op.ACOS: "symbody_real(acos({0}))",
    op.ATAN: "atan({0})",
    op.SINH: "sinh({0})",
    op.COSH: "cosh({0})",
    op.TANH: "tanh({0})",
    op.EXP: "exp({0})",
    op.LOG: "symbody_real(log({0}))",
    op.SQRT: "symbody_real(sqrt({0}))",
    op.ABS: "abs({0})",
    op.SIGN: "sign({0})",
    op.FLOOR: "floor({0})",
    # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
    op.ATAN2: "atan2({0} + 0.0, {1})",
    op.MIN: "symbody_select({0} < {1}, {0}, {1})",  # the second where either is nan, as for max
    op.MAX: "symbody_select({1} < {0}, {0}, {1})",
    op.LT: "{0} < {1}",
    op.LE: "{0} <= {1}",
    op.EQ: "{0} == {1}",
    op.AND: "{0} && {1}",
    op.OR: "{0} || {1}",
    op.NOT: "~{0}",
    op.SELECT: "symbody_select({0}, {1}, {2})",
    op.FMA: "{0} * {1} + {2}",  # there is none
}

# What the statements call, and the function that goes with it.
_FUNCTIONS: Final = {
    "symbody_select": """
function x = symbody_select(condition, first, second)
if condition
    x = first;
else
    x = second;
end
end
""",
    "symbody_real": """
function x = symbody_real(x)
if ~isreal(x)
    x = NaN;
end
end
""",
    "symbody_power": """
function x = symbody_power(base, exponent)
if ~(base < 0) || (exponent == floor(exponent) && ~isinf(exponent))
    x = base ^ exponent;
elseif isinf(base) || isinf(exponent)
    x = abs(base) ^ exponent;
else
    x = NaN;
end
end
""",
}


def _number(value: float) -> str:
    text = repr(value)  # the shortest that reads back as the same double
    return f"({text})" if text.startswith("-") else text


def _entry(array: str, k: int) -> str:
    return "t" if array == "t" else f"{array}({k + 1})"


def _target(word: str, indices: tuple[int, ...]) -> str:
    return f"{word}({', '.join(str(k + 1) for k in indices)})" if indices else word


def _kernel(name: str, n: int, m: int, operands: Items[str]) -> list[str]:
    return [f"{name} = symbody_saddle({n}, {m}, [ ...", *fill_lines(operands, "    ", " ..."), "]);"]


_DIALECT: Final = Dialect(_EXPRESSIONS, "{name} = {value};", _number, _entry, kernel=_kernel)


def generate(sequence: Sequence, name: str = "f", arguments: Arguments | None = None) -> str:
    """Return a function file ``name.m`` with ``[results...] = name(t, q, u, r, p)``.

    Parameters
    ----------
    name : str
        Name of the function, and of its file.
    arguments : mapping of group to names, optional
        All arguments in order, for those that the sequence does not read.

    Raises
    ------
    CompileError
        If `name` cannot name a function, the sequence calls functions the user supplied, or a constant is
        beyond the doubles.
    """
    layout = TextLayout.for_sequence(sequence, name, _LANGUAGE, arguments)
    lines = [*_function(layout)]
    body = "\n".join(lines)
    lines += [text.rstrip("\n") for called, text in _FUNCTIONS.items() if f" {called}(" in body]
    lines += [saddle_text(MATLAB, SADDLE_CALL).rstrip("\n")] if layout.plan.results else []
    return "\n".join(lines) + "\n"


def _function(layout: TextLayout) -> Iterator[str]:
    call = f"[{', '.join(layout.results)}] = {layout.name}({', '.join(layout.sizes)})"
    yield f"function {call}"
    yield from (f"% {line}".rstrip() for line in layout.heading(_entry, call))
    yield "% Arguments at the end that are not read may be left out."
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        yield from [f"{word} = zeros({_size(output)});"] if output.shape else []
    for piece in layout.plan.pieces:
        yield from Statements(layout, piece, _DIALECT, layout.targets(_target)).lines()
    yield "end"


def _size(output: Output) -> str:
    return ", ".join(str(size) for size in output.shape) + (", 1" if len(output.shape) == 1 else "")
