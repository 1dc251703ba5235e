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
from symbody.codegen.texts.layout import Language, TextLayout, TextWriter
from symbody.codegen.texts.lists import fill_lines
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect, entries, operation_formats
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Output

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

_EXPRESSIONS: Final = operation_formats(
    "",
    {
        op.POW: "symbody_power({0}, {1})",
        op.ASIN: "symbody_real(asin({0}))",
        op.ACOS: "symbody_real(acos({0}))",
        op.LOG: "symbody_real(log({0}))",
        op.SQRT: "symbody_real(sqrt({0}))",
        # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
        op.ATAN2: "atan2({0} + 0.0, {1})",
        op.MIN: "symbody_select({0} < {1} || {0} ~= {0}, {0}, {1})",  # nan where either is, as for max
        op.MAX: "symbody_select({1} < {0} || {0} ~= {0}, {0}, {1})",
        op.NOT: "~{0}",
        op.SELECT: "symbody_select({0}, {1}, {2})",
    },
)

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


def _kernel(name: str, n: int, m: int, operands: Items[str]) -> list[str]:
    return [f"{name} = symbody_saddle({n}, {m}, [ ...", *fill_lines(operands, "    ", " ..."), "]);"]


_DIALECT: Final = Dialect(_EXPRESSIONS, "{name} = {value};", entry="{array}({k})", first=1, kernel=_kernel)


def _text(layout: TextLayout) -> str:
    """Return a function file ``name.m`` with ``[results...] = name(t, q, u, r, p)``."""
    lines = [*_function(layout)]
    body = "\n".join(lines)
    lines += [text.rstrip("\n") for called, text in _FUNCTIONS.items() if f" {called}(" in body]
    lines += [saddle_text(MATLAB, SADDLE_CALL).rstrip("\n")] if layout.plan.results else []
    return "\n".join(lines) + "\n"


generate: Final = TextWriter(_LANGUAGE, _text)


def _function(layout: TextLayout) -> Iterator[str]:
    call = f"[{', '.join(layout.results)}] = {layout.name}({', '.join(layout.sizes)})"
    yield f"function {call}"
    yield from (f"% {line}".rstrip() for line in layout.heading(_DIALECT.entry_text, call))
    yield "% Arguments at the end that are not read may be left out."
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        yield from [f"{word} = zeros({_size(output)});"] if output.shape else []
    for piece in layout.plan.pieces:
        yield from Statements(layout, piece, _DIALECT, layout.targets(entries)).lines()
    yield "end"


def _size(output: Output) -> str:
    return ", ".join(str(size) for size in output.shape) + (", 1" if len(output.shape) == 1 else "")
