"""JAX text of a sequence: a module that needs jax alone, to be compiled, differentiated and mapped there.

Every operation is one statement, in the order of the sequence. Text like this is for other people's tools:
symbody writes it and never runs it.
"""

from __future__ import annotations

import keyword
from collections.abc import Iterator
from typing import Final

from symbody.codegen.texts.layout import Arguments, Language, TextLayout
from symbody.codegen.texts.lists import fill_lines
from symbody.codegen.texts.python_words import entry, kernel, number
from symbody.codegen.texts.saddle_jax import SADDLE_JAX
from symbody.codegen.texts.statements import Dialect, Statements
from symbody.expr import opcodes as op
from symbody.expr.sequence import Sequence

_LANGUAGE: Final = Language(
    "JAX",
    frozenset(
        {*keyword.kwlist, *keyword.softkwlist, *"jax jnp namedtuple Outputs min int t q u r p c".split()}
    ),
)

_EXPRESSIONS: Final = {
    op.NEG: "-{0}",
    op.ADD: "{0} + {1}",
    op.SUB: "{0} - {1}",
    op.MUL: "{0} * {1}",
    op.DIV: "{0} / {1}",
    op.POW: "jnp.power({0}, {1})",
    op.SIN: "jnp.sin({0})",
    op.COS: "jnp.cos({0})",
    op.TAN: "jnp.tan({0})",
    op.ASIN: "jnp.arcsin({0})",
    op.ACOS: "jnp.arccos({0})",
    op.ATAN: "jnp.arctan({0})",
    op.SINH: "jnp.sinh({0})",
    op.COSH: "jnp.cosh({0})",
    op.TANH: "jnp.tanh({0})",
    op.EXP: "jnp.exp({0})",
    op.LOG: "jnp.log({0})",
    op.SQRT: "jnp.sqrt({0})",
    op.ABS: "jnp.abs({0})",
    op.SIGN: "jnp.sign({0})",
    op.FLOOR: "jnp.floor({0})",
    op.ATAN2: "_angle({0}, {1})",
    op.MIN: "jnp.where({0} < {1}, {0}, {1})",  # the second where either is nan, as for max
    op.MAX: "jnp.where({1} < {0}, {0}, {1})",
    op.LT: "{0} < {1}",
    op.LE: "{0} <= {1}",
    op.EQ: "{0} == {1}",
    op.AND: "jnp.logical_and({0}, {1})",
    op.OR: "jnp.logical_or({0}, {1})",
    op.NOT: "jnp.logical_not({0})",
    op.SELECT: "jnp.where({0}, {1}, {2})",
    op.FMA: "{0} * {1} + {2}",  # its compiler decides about contraction
}

# The compiler drops y + 0, so a -0 is mended behind the function; the derivative stays.
_ANGLE: Final = """
def _angle(y, x):
    angle = jnp.arctan2(y, x)
    return angle + jnp.where((y == 0.0) & (angle < 0.0), 2.0 * jnp.pi, 0.0)
"""


_DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value}", number, entry, held="jnp.float64({0})", kernel=kernel
)


def generate(sequence: Sequence, name: str = "f", arguments: Arguments | None = None) -> str:
    """Return a Python module with one pure function ``name(t, q, u, r=(), p=())`` of JAX arrays.

    Parameters
    ----------
    name : str
        Name of the function.
    arguments : mapping of group to names, optional
        All arguments in order, for those that the sequence does not read.

    Raises
    ------
    CompileError
        If `name` cannot name a function, the sequence calls functions the user supplied, or a constant is
        beyond the doubles.
    """
    layout = TextLayout.for_sequence(sequence, name, _LANGUAGE, arguments)
    lines = [*_head(layout)]
    lines += [_ANGLE.rstrip("\n"), ""] if any(each.op == op.ATAN2 for each in sequence.operations) else []
    lines += [SADDLE_JAX.rstrip("\n"), ""] if layout.plan.results else []
    return "\n".join([*lines, "", *_function(layout)]) + "\n"


def _call(layout: TextLayout) -> str:
    optional = (group if group in "tqu" else f"{group}=()" for group in layout.sizes)
    return f"{layout.name}({', '.join(optional)})"


def _head(layout: TextLayout) -> Iterator[str]:
    first, *rest = layout.heading(entry, _call(layout))
    yield f'r"""{first}'
    yield ""
    yield from rest
    yield "The result is one array, or a named tuple of arrays if several outputs were asked for. The"
    yield "function is pure: jit, grad, jacobian and vmap apply. Importing it makes JAX compute in 64 bits."
    yield '"""'
    yield ""
    yield from ["from collections import namedtuple", ""] if len(layout.results) != 1 else []
    yield "import jax"
    yield "import jax.numpy as jnp"
    yield ""
    yield 'jax.config.update("jax_enable_x64", True)'
    if len(layout.results) != 1:
        yield f'Outputs = namedtuple("Outputs", {list(layout.results)!r})'
    yield ""


def _function(layout: TextLayout) -> Iterator[str]:
    yield f"def {_call(layout)}:"
    yield f'    """Return {", ".join(layout.results) or "nothing"}; see the module."""'
    yield "    t = jnp.asarray(t, dtype=jnp.float64)"
    for group in layout.sizes:
        yield from [f"    {group} = jnp.asarray({group}, dtype=jnp.float64)"] if group != "t" else []
    parts = []
    for piece in layout.plan.pieces:
        statements = Statements(layout, piece, _DIALECT, {})
        yield from statements.lines()
        for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
            values = [statements.operand(k) for k in output.values]
            parts.append((f"symbody_{word}", output.shape, values))
    for word, shape, values in parts:
        yield f"    {word} = jnp.stack(["
        yield from fill_lines([f"jnp.float64({value})" for value in values], "        ")
        yield f"    ]).reshape({shape!r})"
    words = ", ".join(word for word, _, _ in parts)
    yield f"    return {words}" if len(parts) == 1 else f"    return Outputs({words})"
