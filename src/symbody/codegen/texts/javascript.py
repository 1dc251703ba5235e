"""JavaScript text of a sequence: one ES module for browsers and Node, arrays are Float64Arrays.

Every operation is one statement, in the order of the sequence; long functions are cut into pieces as in C.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import prod
from typing import Final

from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT, POWER, SADDLE_CALL
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.pieces import PIECE_SIZE
from symbody.codegen.texts.layout import Language, TextLayout, TextWriter
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect, operation_formats
from symbody.expr import opcodes as op

LANGUAGE: Final = Language(
    "JavaScript",
    frozenset(
        """
        arguments async await break case catch class const continue debugger default delete do else enum eval
        export extends false finally for function if implements import in instanceof interface let new null
        package private protected public return static super switch this throw true try typeof undefined var
        void while with yield
        Math Number Float64Array Uint32Array Infinity NaN constructor prototype __proto__ then
        t q u r p c out outputs work
        """.split()
    ),
)

_EXPRESSIONS: Final = operation_formats(
    "Math.",
    {
        op.POW: "symbody_pow({0}, {1})",
        # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
        op.SIGN: "{0} > 0 ? 1 : {0} < 0 ? -1 : {0} + 0",
        # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
        op.ATAN2: "Math.atan2({0} + 0, {1})",
        op.MIN: "{0} < {1} || {0} !== {0} ? {0} : {1}",  # nan where either is, as for max
        op.MAX: "{1} < {0} || {0} !== {0} ? {0} : {1}",
        op.EQ: "{0} === {1}",
        op.SELECT: "{0} ? {1} : {2}",
    },
)

DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value};",
    truth="{0} ? 1 : 0", is_true="{0} !== 0",
    kernel_call="    symbody_saddle(work, {n}, {m}, {arguments}, {results}, {scratch});",
    definition="    const {name} = {value};",
)  # fmt: skip


def _text(layout: TextLayout) -> str:
    """Return an ES module with ``name(t, q, u, r, p, out)`` and ``outputs()``."""
    lines = [*_head(layout), *_function(layout), *_pieces(layout)]
    if " symbody_pow(" in "\n".join(lines):
        lines += ["", POWER.rstrip("\n")]
    kernel = saddle_text(JAVASCRIPT, SADDLE_CALL).rstrip("\n").split("\n") if layout.plan.results else []
    return "\n".join([*lines, *([""] if kernel else []), *kernel]) + "\n"


generate: Final = TextWriter(LANGUAGE, _text, PIECE_SIZE)


def _call(layout: TextLayout) -> str:
    optional = (group if group in "tqu" else f"{group} = []" for group in layout.sizes)
    return f"{layout.name}({', '.join(optional)}, out = outputs())"


def _head(layout: TextLayout) -> Iterator[str]:
    yield from (f"// {line}".rstrip() for line in layout.heading(DIALECT.entry_text, _call(layout)))
    yield "// Arguments are arrays of any kind. The result has one property for each output: a number, or a"
    yield "// Float64Array, matrices by rows. A result given as out is filled again instead of a new one."
    yield ""
    yield "export function outputs() {"
    yield "    return {"
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        value = f"new Float64Array({prod(output.shape)})" if output.shape else "0"
        yield f"        {word}: {value},"
    yield "    };"
    yield "}"


def _function(layout: TextLayout) -> Iterator[str]:
    given = ", ".join([*layout.sizes, "out"])
    yield ""
    yield f"const work = new Float64Array({layout.plan.work_size});"
    yield ""
    yield f"export function {_call(layout)} {{"
    yield from (f"    symbody_piece_{k}({given});" for k in range(len(layout.plan.pieces)))
    yield "    return out;"
    yield "}"


def _pieces(layout: TextLayout) -> Iterator[str]:
    targets = _targets(layout)
    for k, piece in enumerate(layout.plan.pieces):
        yield ""
        yield f"function symbody_piece_{k}({', '.join([*layout.sizes, 'out'])}) {{"
        yield from Statements(layout, piece, DIALECT, targets).lines()
        yield "}"


def _targets(layout: TextLayout) -> dict[int, str]:
    """Return what each number of the output is assigned to; matrices are flat."""
    places: list[str] = []
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        size = len(output.values)
        places += [f"out.{word}[{k}]" for k in range(size)] if output.shape else [f"out.{word}"]
    return dict(enumerate(places))
