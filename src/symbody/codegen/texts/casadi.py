"""CasADi text of a sequence: a Python module that makes a ``casadi.Function`` on scalar symbols.

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
from symbody.codegen.texts.saddle_casadi import SADDLE_CASADI
from symbody.codegen.texts.statements import Dialect, Statements
from symbody.expr import opcodes as op
from symbody.expr.sequence import Sequence

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

_EXPRESSIONS: Final = {
    op.NEG: "-{0}",
    op.ADD: "{0} + {1}",
    op.SUB: "{0} - {1}",
    op.MUL: "{0} * {1}",
    op.DIV: "{0} / {1}",
    op.POW: "ca.power({0}, {1})",
    op.SIN: "ca.sin({0})",
    op.COS: "ca.cos({0})",
    op.TAN: "ca.tan({0})",
    op.ASIN: "ca.asin({0})",
    op.ACOS: "ca.acos({0})",
    op.ATAN: "ca.atan({0})",
    op.SINH: "ca.sinh({0})",
    op.COSH: "ca.cosh({0})",
    op.TANH: "ca.tanh({0})",
    op.EXP: "ca.exp({0})",
    op.LOG: "ca.log({0})",
    op.SQRT: "ca.sqrt({0})",
    op.ABS: "ca.fabs({0})",
    op.SIGN: "ca.sign({0})",
    op.FLOOR: "ca.floor({0})",
    op.ATAN2: "_angle({0}, {1})",
    op.MIN: "ca.if_else({0} < {1}, {0}, {1})",  # the second where either is nan, as for max
    op.MAX: "ca.if_else({1} < {0}, {0}, {1})",
    op.LT: "{0} < {1}",
    op.LE: "{0} <= {1}",
    op.EQ: "{0} == {1}",
    op.AND: "ca.logic_and({0}, {1})",
    op.OR: "ca.logic_or({0}, {1})",
    op.NOT: "ca.logic_not({0})",
    op.SELECT: "ca.if_else({0}, {1}, {2})",
    op.FMA: "{0} * {1} + {2}",  # there is none
}

# y + 0 is simplified away, so a -0 is mended behind the function; the derivative stays.
_ANGLE: Final = """
def _angle(y, x):
    angle = ca.atan2(y, x)
    return angle + ca.if_else(ca.logic_and(y == 0.0, angle < 0.0), 2.0 * ca.pi, 0.0)
"""


_DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value}", number, entry, held="ca.SX({0})", kernel=kernel
)


def generate(sequence: Sequence, name: str = "f", arguments: Arguments | None = None) -> str:
    """Return a Python module whose ``name`` is a ``casadi.Function`` of (t, q, u, r, p).

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
    lines += [SADDLE_CASADI.rstrip("\n"), ""] if layout.plan.results else []
    return "\n".join([*lines, "", *_function(layout), "", "", f"{name} = _made()"]) + "\n"


def _head(layout: TextLayout) -> Iterator[str]:
    first, *rest = layout.heading(entry, f"{layout.name}({', '.join(layout.sizes)})")
    yield f'r"""{first}'
    yield ""
    yield from rest
    yield f"{layout.name} is a casadi.Function on SX: all arguments are given, those of size 0 as []."
    yield "Results of two dimensions are matrices, all others columns, the last index running fastest."
    yield '"""'
    yield ""
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
