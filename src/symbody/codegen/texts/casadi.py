"""CasADi text of a sequence: a Python module that makes a ``casadi.Function`` on scalar symbols.

Every operation is one statement, in the order of the sequence. Text like this is for other people's tools:
symbody writes it and never runs it.
"""

from __future__ import annotations

import keyword
from collections.abc import Iterator
from typing import Final

from symbody.codegen.texts.layout import Language, TextLayout, TextWriter
from symbody.codegen.texts.lists import fill_lines
from symbody.codegen.texts.python_words import helpers, kernel, module_head
from symbody.codegen.texts.saddle_casadi import SADDLE_CASADI
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect, operation_formats
from symbody.expr import opcodes as op

# Names of arguments and results must differ from each other and from those of derivatives.
_LANGUAGE: Final = Language(
    "CasADi",
    frozenset(
        {
            *keyword.kwlist,
            *keyword.softkwlist,
            *"ca null jac hess grad min range sum zip list float reversed t q u r p c".split(),
        }
    ),
)

_EXPRESSIONS: Final = operation_formats(
    "ca.",
    {
        op.POW: "ca.power({0}, {1})",
        op.ABS: "ca.fabs({0})",
        op.ATAN2: "_angle({0}, {1})",
        # Nan where either is, as for max: CasADi takes x != x for false.
        op.MIN: "ca.if_else({0} < {1}, {0}, ca.if_else({1} <= {0}, {1}, {0} + {1}))",
        op.MAX: "ca.if_else({1} < {0}, {0}, ca.if_else({0} <= {1}, {1}, {0} + {1}))",
        op.AND: "ca.logic_and({0}, {1})",
        op.OR: "ca.logic_or({0}, {1})",
        op.NOT: "ca.logic_not({0})",
        op.SELECT: "ca.if_else({0}, {1}, {2})",
    },
)

# y + 0 is simplified away, so a -0 is mended behind the function; the derivative stays.
_ANGLE: Final = """
def _angle(y, x):
    angle = ca.atan2(y, x)
    return angle + ca.if_else(ca.logic_and(y == 0.0, angle < 0.0), 2.0 * ca.pi, 0.0)
"""


_DIALECT: Final = Dialect(_EXPRESSIONS, "    {name} = {value}", held="ca.SX({0})", kernel=kernel)


def _text(layout: TextLayout) -> str:
    """Return a Python module whose ``name`` is a ``casadi.Function`` of (t, q, u, r, p)."""
    lines = [*_head(layout), *helpers(layout, _ANGLE, SADDLE_CASADI)]
    return "\n".join([*lines, "", *_function(layout), "", "", f"{layout.name} = _made()"]) + "\n"


generate: Final = TextWriter(_LANGUAGE, _text)


def _head(layout: TextLayout) -> Iterator[str]:
    yield from module_head(
        layout,
        f"{layout.name}({', '.join(layout.sizes)})",
        f"{layout.name} is a casadi.Function on SX: all arguments are given, those of size 0 as [].",
        "Results of two dimensions are matrices, all others columns, the last index running fastest.",
    )
    yield "import casadi as ca"
    yield ""


def _function(layout: TextLayout) -> Iterator[str]:
    yield "def _made():"
    for group, size in layout.sizes.items():
        yield f'    {group} = ca.SX.sym("{group}"' + ("" if group == "t" else f", {size}") + ")"
    yield "    symbody_results = []"
    for piece in layout.plan.pieces:
        statements = Statements(layout, piece, _DIALECT, {})
        yield from statements.lines()
        for output in layout.sequence.outputs:
            yield "    symbody_results.append(ca.vertcat(ca.SX(0, 1),"
            yield from fill_lines([statements.operand(k) for k in output.values], "        ")
            yield "    ))"
            if len(output.shape) == 2:
                rows, columns = output.shape
                yield f"    symbody_results[-1] = ca.reshape(symbody_results[-1], {columns}, {rows}).T"
    groups = ", ".join(layout.sizes)
    yield f"    symbody_names = {list(layout.sizes)!r}, {list(layout.results)!r}"
    yield f'    return ca.Function("{layout.name}", [{groups}], symbody_results, *symbody_names)'
