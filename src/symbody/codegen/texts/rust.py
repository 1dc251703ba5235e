"""Rust text of a sequence: one module that needs the standard library and nothing else.

Every operation is one statement, in the order of the sequence; long functions are cut into pieces as in C.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.rust_kernels import RUST, SADDLE_CALL
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.pieces import PIECE_SIZE
from symbody.codegen.texts.layout import Language, TextLayout, TextWriter
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect, operation_formats
from symbody.expr import opcodes as op

_LANGUAGE: Final = Language(
    "Rust",
    frozenset(
        """
        abstract as async await become box break const continue crate do dyn else enum extern false
        final fn for gen if impl in let loop macro match mod move mut override priv pub ref return
        self Self static struct super trait true try type typeof union unsafe unsized use virtual
        where while yield Outputs bool f64 isize main out std t q u r p c usize vec work
        """.split()
    ),
)

_EXPRESSIONS: Final = operation_formats(
    "f64::",
    {
        op.POW: "f64::powf({0}, {1})",
        op.LOG: "f64::ln({0})",
        # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
        op.SIGN: "if {0} > 0.0 {{ 1.0 }} else if {0} < 0.0 {{ -1.0 }} else {{ {0} + 0.0 }}",
        # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
        op.ATAN2: "f64::atan2({0} + 0.0, {1})",
        op.MIN: "if {0} < {1} || {0} != {0} {{ {0} }} else {{ {1} }}",  # nan where either is, as for max
        op.MAX: "if {1} < {0} || {0} != {0} {{ {0} }} else {{ {1} }}",
        op.SELECT: "if {0} {{ {1} }} else {{ {2} }}",
        op.FMA: "f64::mul_add({0}, {1}, {2})",
    },
)

# Of names and choices that come from models, and of entries that one text needs and another does not.
_ALLOWED: Final = "#[allow(non_snake_case, unused_variables, unused_mut, unused_parens, clippy::all)]"
_ON_THE_STACK: Final = 4096  # numbers of scratch


def _target(word: str, indices: tuple[int, ...]) -> str:
    return f"out.{word}" + "".join(f"[{k}]" for k in indices)


_DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value};",
    truth="if {0} {{ 1.0 }} else {{ 0.0 }}", is_true="{0} != 0.0",
    kernel_call="    symbody_saddle(work, {n}, {m}, {arguments}, {results}, {scratch});",
    definition="    let {name} = {value};",
)  # fmt: skip


def _text(layout: TextLayout) -> str:
    """Return a Rust module with ``struct Outputs`` and ``fn name(t, q, u, r, p) -> Outputs``."""
    lines = [*_head(layout), *_function(layout), *_pieces(layout)]
    kernel = saddle_text(RUST, SADDLE_CALL).rstrip("\n").split("\n") if layout.plan.results else []
    return "\n".join([*lines, *([""] if kernel else []), *kernel]) + "\n"


generate: Final = TextWriter(_LANGUAGE, _text, PIECE_SIZE)


def _head(layout: TextLayout) -> Iterator[str]:
    call = f"{layout.name}({', '.join(layout.sizes)})"
    yield from (f"// {line}".rstrip() for line in layout.heading(_DIALECT.entry_text, call))
    yield ""
    yield "/// The results; a matrix is an array of its rows."
    yield _ALLOWED
    yield "#[derive(Clone, Debug)]"
    yield "pub struct Outputs {"
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        yield f"    pub {word}: {_array('f64', output.shape)},"
    yield "}"


def _array(entry: str, shape: tuple[int, ...]) -> str:
    """Return the type of an array, or its value if all entries are the same."""
    for size in reversed(shape):
        entry = f"[{entry}; {size}]"
    return entry


def _parameters(layout: TextLayout) -> str:
    kinds = (f"{g}: f64" if g == "t" else f"{g}: &[f64; {size}]" for g, size in layout.sizes.items())
    return ", ".join(kinds)


def _function(layout: TextLayout) -> Iterator[str]:
    size = layout.plan.work_size
    yield ""
    yield _ALLOWED
    yield f"pub fn {layout.name}({_parameters(layout)}) -> Outputs {{"
    yield "    let mut out = Outputs {"
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        yield f"        {word}: {_array('0.0', output.shape)},"
    yield "    };"
    yield f"    let mut work = {'' if size <= _ON_THE_STACK else 'vec!'}[0.0_f64; {size}];"
    given = ", ".join([*layout.sizes, "&mut out", "&mut work"])
    yield from (f"    symbody_piece_{k}({given});" for k in range(len(layout.plan.pieces)))
    yield "    out"
    yield "}"


def _pieces(layout: TextLayout) -> Iterator[str]:
    targets = layout.targets(_target)
    for k, piece in enumerate(layout.plan.pieces):
        yield ""
        yield _ALLOWED
        yield f"fn symbody_piece_{k}({_parameters(layout)}, out: &mut Outputs, work: &mut [f64]) {{"
        yield from Statements(layout, piece, _DIALECT, targets).lines()
        yield "}"
