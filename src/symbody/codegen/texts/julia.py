"""Julia text of a sequence: one module that needs Base and nothing else, for all kinds of real numbers.

Every operation is one statement, in the order of the sequence; long functions are cut into pieces as in C.
What Julia would raise outside a domain is nan, as in all other languages.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.julia_kernels import JULIA, SADDLE_CALL
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.pieces import PIECE_SIZE
from symbody.codegen.texts.layout import Language, TextLayout, TextWriter
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect, operation_formats
from symbody.expr import opcodes as op

_LANGUAGE: Final = Language(
    "Julia",
    frozenset(
        """
        abstract as baremodule begin break catch const continue do else elseif end export false finally for
        function global if import importall in isa let local macro module mutable outer primitive public quote
        return struct true try type using where while
        sin cos tan asin acos atan sinh cosh tanh exp log sqrt abs sign floor ifelse fma oftype pi
        NaN NaN64 Inf Inf64 Vector Array Float64 undef promote_type float eltype typeof Ref nothing missing
        ans number t q u r p c work
        """.split()
    ),
)

_EXPRESSIONS: Final = operation_formats(
    "",
    {
        op.POW: "symbody_power({0}, {1})",
        op.SIN: "symbody_finite(sin, {0})",
        op.COS: "symbody_finite(cos, {0})",
        op.TAN: "symbody_finite(tan, {0})",
        op.ASIN: "symbody_within(asin, {0})",
        op.ACOS: "symbody_within(acos, {0})",
        op.LOG: "symbody_positive(log, {0})",
        op.SQRT: "symbody_positive(sqrt, {0})",
        # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
        op.ATAN2: "atan({0} + 0.0, {1})",
        op.MIN: "ifelse(({0} < {1}) | ({0} != {0}), {0}, {1})",  # nan where either is, as for max
        op.MAX: "ifelse(({1} < {0}) | ({0} != {0}), {0}, {1})",
        op.AND: "{0} & {1}",
        op.OR: "{0} | {1}",
        op.SELECT: "ifelse({0}, {1}, {2})",
        op.FMA: "fma({0}, {1}, {2})",
    },
)

_FUNCTIONS: Final = """
symbody_finite(f, x) = isinf(x) ? oftype(x, NaN) : f(x)
symbody_within(f, x) = abs(x) > 1 ? oftype(x, NaN) : f(x)
symbody_positive(f, x) = x < 0 ? oftype(x, NaN) : f(x)
function symbody_power(x, y)
    (!(x < 0) || (isfinite(y) && y == floor(y))) && return x^y
    return isinf(x) || isinf(y) ? abs(x)^y : oftype(x, NaN)
end
"""


def _target(word: str, indices: tuple[int, ...]) -> str:
    return f"{word}[{', '.join(str(k + 1) for k in indices)}]"  # a number is a Ref


_DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value}", first=1,
    truth="ifelse({0}, 1.0, 0.0)", is_true="{0} != 0",
    kernel_call="    symbody_saddle!(work, {n}, {m}, {arguments}, {results})",
)  # fmt: skip


def _text(layout: TextLayout) -> str:
    """Return a Julia module ``symbody_name`` with one function ``name(t, q, u, r = (), p = ())``."""
    lines = [*_head(layout), *_functions(layout), *_FUNCTIONS.rstrip("\n").split("\n")]
    lines += saddle_text(JULIA, SADDLE_CALL).rstrip("\n").split("\n") if layout.plan.results else []
    return "\n".join([*lines, "", "end"]) + "\n"


generate: Final = TextWriter(_LANGUAGE, _text, PIECE_SIZE)


def _call(layout: TextLayout) -> str:
    optional = (group if group in "tqu" else f"{group} = ()" for group in layout.sizes)
    return f"{layout.name}({', '.join(optional)})"


def _head(layout: TextLayout) -> Iterator[str]:
    yield from (f"# {line}".rstrip() for line in layout.heading(_DIALECT.entry_text, _call(layout)))
    yield "# Arguments are numbers and vectors or tuples of any real type, dual numbers too. The result is"
    yield "# the array or number itself, or a named tuple if several outputs were asked for."
    yield f"module symbody_{layout.name}"
    yield ""
    yield f"export {layout.name}"


def _functions(layout: TextLayout) -> Iterator[str]:
    """Yield the function, and behind it its pieces."""
    yield ""
    yield f"function {_call(layout)}"
    kinds = ", ".join("typeof(t)" if group == "t" else f"eltype({group})" for group in layout.sizes)
    yield f"    number = float(promote_type({kinds}))"
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        size = "".join(f", {size}" for size in output.shape)
        yield f"    {word} = Array{{number}}(undef{size})" if size else f"    {word} = Ref{{number}}()"
    yield f"    work = Vector{{number}}(undef, {layout.plan.scratch})"
    inner = ", ".join([*layout.sizes, *layout.results, "work"])
    yield from (f"    symbody_piece_{k}({inner})" for k in range(len(layout.plan.pieces)))
    shown = [
        word if output.shape else f"{word}[]"
        for output, word in zip(layout.sequence.outputs, layout.results, strict=True)
    ]
    if len(shown) == 1:
        yield f"    return {shown[0]}"
    else:
        pairs = ", ".join(f"{word} = {value}" for word, value in zip(layout.results, shown, strict=True))
        yield f"    return (; {pairs})"
    yield "end"
    targets = layout.targets(_target)
    for k, piece in enumerate(layout.plan.pieces):
        yield ""
        yield f"function symbody_piece_{k}({inner})"
        yield from Statements(layout, piece, _DIALECT, targets).lines()
        yield "    return nothing"
        yield "end"
