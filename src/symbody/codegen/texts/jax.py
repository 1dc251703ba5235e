"""JAX text of a sequence: a module that needs jax alone, to be compiled, differentiated and mapped there.

Every operation is one statement, in the order of the sequence. Text like this is for other people's tools:
symbody writes it and never runs it.
"""

from __future__ import annotations

import keyword
from collections.abc import Iterator
from typing import Final

from symbody.codegen.texts.layout import Language, TextLayout, TextWriter
from symbody.codegen.texts.lists import fill_lines
from symbody.codegen.texts.python_words import helpers, kernel, module_head, numpy_formats
from symbody.codegen.texts.saddle_jax import SADDLE_JAX
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect

_LANGUAGE: Final = Language(
    "JAX",
    frozenset(
        {*keyword.kwlist, *keyword.softkwlist, *"jax jnp namedtuple Outputs min int t q u r p c".split()}
    ),
)

# The compiler drops y + 0, so a -0 is mended behind the function; the derivative stays.
_ANGLE: Final = """
def _angle(y, x):
    angle = jnp.arctan2(y, x)
    return angle + jnp.where((y == 0.0) & (angle < 0.0), 2.0 * jnp.pi, 0.0)
"""


_DIALECT: Final = Dialect(
    # Its compiler decides about contraction.
    numpy_formats("jnp.", "_angle({0}, {1})"), "    {name} = {value}",
    held="jnp.float64({0})", kernel=kernel,
)  # fmt: skip


def _text(layout: TextLayout) -> str:
    """Return a Python module with one pure function ``name(t, q, u, r=(), p=())`` of JAX arrays."""
    lines = [*_head(layout), *helpers(layout, _ANGLE, SADDLE_JAX)]
    return "\n".join([*lines, "", *_function(layout)]) + "\n"


generate: Final = TextWriter(_LANGUAGE, _text)


def _call(layout: TextLayout) -> str:
    optional = (group if group in "tqu" else f"{group}=()" for group in layout.sizes)
    return f"{layout.name}({', '.join(optional)})"


def _head(layout: TextLayout) -> Iterator[str]:
    yield from module_head(
        layout,
        _call(layout),
        "The result is one array, or a named tuple of arrays if several outputs were asked for. The",
        "function is pure: jit, grad, jacobian and vmap apply. Importing it makes JAX compute in 64 bits.",
    )
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
